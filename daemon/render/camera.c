// camera.c - the camera of a job as kernels and as other programs want it.
#include "render/internal.h"

#include <math.h>
#include <string.h>

struct axes {
    double right[3], up[3], forward[3], position[3];
};

static void unit(const double *column, double sign, double out[3])
{
    const double length =
        sqrt(column[0] * column[0] + column[1] * column[1] + column[2] * column[2]);
    for (int k = 0; k < 3; k++)
        out[k] = sign * column[k] / length;
}

// The axes of a transform to the world.
static void axes_of(const double m[16], struct axes *a)
{
    unit(m, 1.0, a->right);
    unit(m + 4, 1.0, a->up);
    unit(m + 8, -1.0, a->forward);
    memcpy(a->position, m + 12, sizeof a->position);
}

static void axes_at(const struct glint_view *v, uint32_t key, struct axes *a)
{
    double m[16];
    if (v->camera_index == GLINT_NONE)
        for (int k = 0; k < 16; k++)
            m[k] = v->camera.transform[k];
    else
        glint_pose_camera_at(v->pose, glint_resident_scene(v->scene), v->camera_index, key, m);
    axes_of(m, a);
}

bool glint_render_camera_moves(const struct glint_view *v)
{
    return v->pose && v->camera_index != GLINT_NONE && v->pose->camera[v->camera_index].moves;
}

// Metres, or tangents on the plane at distance 1, that a pixel is wide.
static double pixel_size(const struct glint_view *v)
{
    const bool flat = v->camera.projection == GLINT_ORTHOGRAPHIC;
    return 2.0 * (flat ? (double)v->camera.ymag : tan(0.5 * v->camera.yfov)) / v->job.height;
}

// origin, right, down, corner, forward of gk_frame.
static void fill_vectors(const struct glint_view *v, const struct axes *a, float out[15])
{
    const double pixel = pixel_size(v);
    const double across = 0.5 * pixel * v->job.width, along = 0.5 * pixel * v->job.height;
    const double ahead = v->camera.projection == GLINT_ORTHOGRAPHIC ? 0.0 : 1.0;
    double centre[3];
    glint_resident_centre(v->scene, centre);
    for (int k = 0; k < 3; k++) {
        out[k] = (float)(a->position[k] - centre[k]);
        out[3 + k] = (float)(a->right[k] * pixel);
        out[6 + k] = (float)(-a->up[k] * pixel);
        out[9 + k] = (float)(a->forward[k] * ahead - a->right[k] * across + a->up[k] * along);
        out[12 + k] = (float)a->forward[k];
    }
}

static void fill_camera(const struct glint_view *v, struct gk_frame *f)
{
    struct axes a;
    const uint32_t keys = v->pose ? v->pose->keys : 1;
    for (uint32_t k = GK_CAMERA_KEYS; k-- > 0;) {
        axes_at(v, k < keys ? k : keys - 1, &a);
        fill_vectors(v, &a, f->camera_key[k]);
    }
    memcpy(f->origin, f->camera_key[0], sizeof f->origin);
    memcpy(f->right, f->camera_key[0] + 3, sizeof f->right);
    memcpy(f->down, f->camera_key[0] + 6, sizeof f->down);
    memcpy(f->corner, f->camera_key[0] + 9, sizeof f->corner);
    memcpy(f->forward, f->camera_key[0] + 12, sizeof f->forward);
    for (int k = 0; k < 3; k++) {
        f->lens_right[k] = (float)(a.right[k] * v->camera.lens_radius);
        f->lens_up[k] = (float)(a.up[k] * v->camera.lens_radius);
    }
    f->focus = v->camera.focus_distance;
    f->has_lens = v->camera.lens_radius > 0.0f;
    f->is_orthographic = v->camera.projection == GLINT_ORTHOGRAPHIC;
    f->motion_segments = keys - 1;
}

// Homogeneous pixel coordinates of points relative to the scene's centre, for axes `a`.
static void fill_to_pixel(const struct glint_view *v, const struct axes *a, float out[12])
{
    const double pixel = pixel_size(v), w = 0.5 * v->job.width, h = 0.5 * v->job.height;
    const bool flat = v->camera.projection == GLINT_ORTHOGRAPHIC;
    double centre[3], row[12] = {0};
    glint_resident_centre(v->scene, centre);
    for (int k = 0; k < 3; k++) {
        const double ahead = flat ? 0.0 : a->forward[k];
        const double from = centre[k] - a->position[k];
        row[k] = a->right[k] / pixel + w * ahead;
        row[4 + k] = -a->up[k] / pixel + h * ahead;
        row[8 + k] = ahead;
        for (int i = 0; i < 3; i++)
            row[4 * i + 3] += row[4 * i + k] * from;
    }
    if (flat) {
        row[3] += w;
        row[7] += h;
        row[11] = 1.0;
    }
    for (int i = 0; i < 12; i++)
        out[i] = (float)row[i];
}

// The camera a frame later and a frame earlier.
static void fill_flow(const struct glint_view *v, struct gk_frame *f)
{
    struct axes later, earlier;
    axes_at(v, 0, &later);
    earlier = later;
    const bool named = v->pose && v->camera_index != GLINT_NONE;
    const double *m = named ? v->pose->camera[v->camera_index].flow_transform : NULL;
    if (m) {
        axes_of(m, &earlier);
        axes_of(m + 16, &later);
    }
    fill_to_pixel(v, &later, f->to_after);
    fill_to_pixel(v, &earlier, f->to_before);
}

static void fill_medium(const struct glint_view *v, struct gk_frame *f)
{
    const struct glint_scene *s = glint_resident_scene(v->scene);
    double centre[3];
    glint_resident_centre(v->scene, centre);
    const struct glint_medium *m = s->media ? s->medium : NULL;
    for (int k = 0; k < 3; k++) {
        f->medium_low[k] = m && m->bounded ? (float)(m->box[k] - centre[k]) : -INFINITY;
        f->medium_high[k] = m && m->bounded ? (float)(m->box[3 + k] - centre[k]) : INFINITY;
        f->medium_albedo[k] = m ? m->albedo[k] : 0.0f;
    }
    f->medium_density = m ? m->density : 0.0f;
    f->medium_g = m ? m->g : 0.0f;
}

static void fill_lighting(const struct glint_view *r, struct gk_frame *f)
{
    const struct glint_scene_lighting *l = glint_resident_lighting(r->scene);
    f->lights = l->lights;
    f->light_stride = l->light_stride;
    memcpy(f->environment, l->environment, sizeof f->environment);
    f->env_width = l->env_width;
    f->env_height = l->env_height;
    f->env_cell_width = l->env_cell_width;
    f->env_cell_height = l->env_cell_height;
    f->env_cos = cosf(l->env_rotation);
    f->env_sin = sinf(l->env_rotation);
    f->env_choice = l->env_choice;
    f->has_env_image = glint_resident_facts(r->scene)->environment_image;
    memcpy(f->grid_origin, l->grid_origin, sizeof f->grid_origin);
    memcpy(f->grid_scale, l->grid_scale, sizeof f->grid_scale);
    memcpy(f->grid_size, l->grid_size, sizeof f->grid_size);
    f->grid_clusters = l->grid_clusters;
    f->grid_many = l->grid_many;
    f->grid_members = l->grid_members;
    f->grid_owners = l->grid_owners;
}

// Bounces before roulette: the first ones carry most of a picture, but where surfaces are dark the second
// is left with little of it. A whole scene that starts at the second bounce gains on dark ones what it
// loses on glossy and white ones (tests/bench/history.csv).
#define ROULETTE_START 3u
#define ROULETTE_LITTLE 1u

static void fill_roulette(const struct glint_job *job, struct gk_frame *f)
{
    const bool plays = job->dial[GLINT_DIAL_ROULETTE] != 0;
    f->roulette_start = plays ? ROULETTE_START : UINT32_MAX;
    f->roulette_little = plays ? ROULETTE_LITTLE : UINT32_MAX;
}

static uint32_t matte_flags(const struct glint_job *job)
{
    return (job->dial[GLINT_DIAL_THROUGH] == GLINT_THROUGH_GLOSSY ? GK_MATTES_GLOSSY : 0u) |
           (job->matte_clamp ? GK_MATTES_CLAMP : 0u) |
           (job->dial[GLINT_DIAL_VARIANCE] != 0 ? GK_MATTES_EQ3 : 0u) |
           (job->matte_diffuse_cut ? GK_MATTES_CUT : 0u) |
           (job->matte_env_id ? GK_MATTES_ENVIRONMENT : 0u) |
           (job->matte_classes ? GK_MATTES_CLASSES : 0u) |
           (job->dial[GLINT_DIAL_COVERAGE] != 0 ? GK_MATTES_OPAQUE : 0u);
}

// The cone of a camera sample is a pixel wide: tan(fov_x/2)/width on either side of it. The pixel may be
// of the same view in a frame of another width.
static void fill_mattes(const struct glint_view *r, struct gk_frame *f)
{
    const uint32_t width = r->job.width, as = r->job.matte_cone_width;
    const float half_pixel = (float)(0.5 * pixel_size(r) * (as > 0 ? (double)width / as : 1.0));
    const bool flat = r->camera.projection == GLINT_ORTHOGRAPHIC;
    f->matte_alpha = r->job.matte_alpha;
    f->matte_slope = flat ? 0.0f : half_pixel;
    f->matte_radius = flat ? half_pixel : 0.0f;
    f->matte_bins = r->job.matte_depth_bins;
    f->matte_flags = matte_flags(&r->job);
}

void glint_render_constants(const struct glint_view *r, struct gk_frame *out)
{
    memset(out, 0, sizeof *out);
    fill_camera(r, out);
    out->weight = 1.0f;
    fill_flow(r, out);
    fill_medium(r, out);
    fill_lighting(r, out);
    fill_mattes(r, out);
    out->seed = r->job.seed;
    out->frame = r->job.frame;
    out->filter_width = r->job.filter_width;
    out->has_blackman_harris = r->job.filter == GLINT_FILTER_BLACKMAN_HARRIS;
    out->max_bounces = r->job.max_bounces;
    if (r->job.dial[GLINT_DIAL_GI] == 1 && out->max_bounces > 1)
        out->max_bounces = 1; // gi none: direct light only
    fill_roulette(&r->job, out);
}

void glint_render_matrices(const struct glint_view *r, float world_to_camera[16],
                           float world_to_ndc[16])
{
    struct axes a;
    axes_at(r, 0, &a);
    const double *axis[3] = {a.right, a.up, a.forward};
    double m[16] = {0};
    for (int j = 0; j < 3; j++)
        for (int i = 0; i < 3; i++) {
            m[4 * i + j] = axis[j][i];
            m[12 + j] -= a.position[i] * axis[j][i];
        }
    m[15] = 1.0;
    const double ty = 0.5 * pixel_size(r) * r->job.height, tx = ty * r->job.width / r->job.height;
    const bool flat = r->camera.projection == GLINT_ORTHOGRAPHIC;
    // x/(2 tx z) + 1/2, 1/2 - y/(2 ty z), depth 1 - near/z with near 1 mm; not over z where rays
    // are parallel.
    const double p[16] = {0.5 / tx,
                          0,
                          0,
                          0,
                          0,
                          -0.5 / ty,
                          0,
                          0,
                          flat ? 0.0 : 0.5,
                          flat ? 0.0 : 0.5,
                          1.0,
                          flat ? 0.0 : 1.0,
                          flat ? 0.5 : 0.0,
                          flat ? 0.5 : 0.0,
                          -1e-3,
                          flat ? 1.0 : 0.0};
    for (int i = 0; i < 4; i++)
        for (int j = 0; j < 4; j++) {
            double sum = 0.0;
            for (int k = 0; k < 4; k++)
                sum += m[4 * i + k] * p[4 * k + j];
            world_to_ndc[4 * i + j] = (float)sum;
            world_to_camera[4 * i + j] = (float)m[4 * i + j];
        }
}
