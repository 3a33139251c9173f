// camera.c - the camera of a job as kernels and as other programs want it.
#include "render/internal.h"

#include <math.h>
#include <string.h>

struct axes {
    double right[3], up[3], forward[3], position[3];
};

static void unit(const float *column, double sign, double out[3])
{
    const double length = sqrt((double)column[0] * column[0] + (double)column[1] * column[1] +
                               (double)column[2] * column[2]);
    for (int k = 0; k < 3; k++)
        out[k] = sign * column[k] / length;
}

static void axes_of(const struct glint_camera *c, struct axes *a)
{
    unit(c->transform, 1.0, a->right);
    unit(c->transform + 4, 1.0, a->up);
    unit(c->transform + 8, -1.0, a->forward);
    for (int k = 0; k < 3; k++)
        a->position[k] = c->transform[12 + k];
}

static void fill_camera(const struct glint_view *r, struct gk_frame *f)
{
    struct axes a;
    double centre[3];
    axes_of(&r->camera, &a);
    glint_resident_centre(r->scene, centre);
    const double pixel = 2.0 * tan(0.5 * r->camera.yfov) / r->job.height;
    const double half_width = 0.5 * pixel * r->job.width, half_height = 0.5 * pixel * r->job.height;
    for (int k = 0; k < 3; k++) {
        f->origin[k] = (float)(a.position[k] - centre[k]);
        f->right[k] = (float)(a.right[k] * pixel);
        f->down[k] = (float)(-a.up[k] * pixel);
        f->corner[k] = (float)(a.forward[k] - a.right[k] * half_width + a.up[k] * half_height);
        f->forward[k] = (float)a.forward[k];
        f->lens_right[k] = (float)(a.right[k] * r->camera.lens_radius);
        f->lens_up[k] = (float)(a.up[k] * r->camera.lens_radius);
    }
    f->focus = r->camera.focus_distance;
    f->has_lens = r->camera.lens_radius > 0.0f;
}

static void fill_lighting(const struct glint_view *r, struct gk_frame *f)
{
    const struct glint_scene_lighting *l = glint_resident_lighting(r->scene);
    f->lights = l->lights;
    memcpy(f->environment, l->environment, sizeof f->environment);
    f->env_width = l->env_width;
    f->env_height = l->env_height;
    f->env_cell_width = l->env_cell_width;
    f->env_cell_height = l->env_cell_height;
    f->env_cos = cosf(l->env_rotation);
    f->env_sin = sinf(l->env_rotation);
    f->env_choice = l->env_choice;
    f->has_env_image = glint_resident_facts(r->scene)->environment_image;
}

// Bounces before roulette: the first ones carry most of a picture.
#define ROULETTE_START 3u

void glint_render_constants(const struct glint_view *r, struct gk_frame *out)
{
    memset(out, 0, sizeof *out);
    fill_camera(r, out);
    fill_lighting(r, out);
    out->seed = r->job.seed;
    out->frame = r->job.frame;
    out->filter_width = r->job.filter_width;
    out->has_blackman_harris = r->job.filter == GLINT_FILTER_BLACKMAN_HARRIS;
    out->max_bounces = r->job.max_bounces;
    if (r->job.dial[GLINT_DIAL_GI] == 1 && out->max_bounces > 1)
        out->max_bounces = 1; // gi none: direct light only
    out->roulette_start = r->job.dial[GLINT_DIAL_ROULETTE] == 0 ? UINT32_MAX : ROULETTE_START;
}

void glint_render_matrices(const struct glint_view *r, float world_to_camera[16],
                           float world_to_ndc[16])
{
    struct axes a;
    axes_of(&r->camera, &a);
    const double *axis[3] = {a.right, a.up, a.forward};
    double m[16] = {0};
    for (int j = 0; j < 3; j++)
        for (int i = 0; i < 3; i++) {
            m[4 * i + j] = axis[j][i];
            m[12 + j] -= a.position[i] * axis[j][i];
        }
    m[15] = 1.0;
    const double ty = tan(0.5 * r->camera.yfov), tx = ty * r->job.width / r->job.height;
    // x/(2 tx z) + 1/2, 1/2 - y/(2 ty z); depth 1 - near/z with near 1 mm.
    const double p[16] = {0.5 / tx, 0,   0,   0,   0, -0.5 / ty, 0,     0,
                          0.5,      0.5, 1.0, 1.0, 0, 0,         -1e-3, 0};
    for (int i = 0; i < 4; i++)
        for (int j = 0; j < 4; j++) {
            double sum = 0.0;
            for (int k = 0; k < 4; k++)
                sum += m[4 * i + k] * p[4 * k + j];
            world_to_ndc[4 * i + j] = (float)sum;
            world_to_camera[4 * i + j] = (float)m[4 * i + j];
        }
}
