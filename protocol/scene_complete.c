// scene_complete.c - the camera and the light that a scene must have.
#include "protocol/scene_parts.h"

#include <math.h>
#include <string.h>

#define DEFAULT_YFOV 0.7f // radians, about 40 degrees

struct box {
    double low[3], high[3];
    bool any;
};

static void include(struct box *b, const double p[3])
{
    for (int k = 0; k < 3; k++) {
        b->low[k] = b->any ? fmin(b->low[k], p[k]) : p[k];
        b->high[k] = b->any ? fmax(b->high[k], p[k]) : p[k];
    }
    b->any = true;
}

static void mesh_box(const struct glint_mesh *m, float low[3], float high[3])
{
    memcpy(low, m->position, 3 * sizeof *low);
    memcpy(high, m->position, 3 * sizeof *high);
    for (size_t i = 1; i < m->vertices; i++)
        for (int k = 0; k < 3; k++) {
            low[k] = fminf(low[k], m->position[3 * i + k]);
            high[k] = fmaxf(high[k], m->position[3 * i + k]);
        }
}

static void include_corners(struct box *b, const float low[3], const float high[3],
                            const float m[16])
{
    for (int corner = 0; corner < 8; corner++) {
        double world[3];
        for (int k = 0; k < 3; k++) {
            world[k] = m[12 + k];
            for (int i = 0; i < 3; i++)
                world[k] += (double)m[4 * i + k] * (corner >> i & 1 ? high[i] : low[i]);
        }
        include(b, world);
    }
}

static bool scene_box(const struct glint_scene *s, struct box *b, struct glint_arena *scratch)
{
    float(*bounds)[6] = glint_arena_array(scratch, s->meshes, sizeof *bounds);
    if (!bounds)
        return false;
    for (uint32_t i = 0; i < s->meshes; i++)
        mesh_box(&s->mesh[i], bounds[i], bounds[i] + 3);
    for (uint32_t i = 0; i < s->instances; i++) {
        const struct glint_instance *in = &s->instance[i];
        if (in->visible)
            include_corners(b, bounds[in->mesh], bounds[in->mesh] + 3, in->transform);
    }
    return true;
}

// Looks at the middle from the front, a little from above and the right; the sphere around the box
// just fits into the field of view. The rows of `axis` are right, up and back.
static void frame_box(struct glint_camera *c, const struct box *b)
{
    static const double back[3] = {0.4, 0.3, 0.8660254037844386}; // unit
    const double flat = hypot(back[0], back[2]);
    const double axis[3][3] = {
        {back[2] / flat, 0, -back[0] / flat},
        {-back[0] * back[1] / flat, flat, -back[2] * back[1] / flat},
        {back[0], back[1], back[2]},
    };
    double middle[3] = {0, 0, 0}, radius = 0;
    for (int k = 0; b->any && k < 3; k++) {
        middle[k] = 0.5 * (b->low[k] + b->high[k]);
        radius = hypot(radius, 0.5 * (b->high[k] - b->low[k]));
    }
    const double distance = (radius > 0 ? radius : 1) / sin(0.5 * DEFAULT_YFOV);
    memcpy(c->transform, glint_identity, sizeof c->transform);
    for (int k = 0; k < 3; k++) {
        for (int i = 0; i < 3; i++)
            c->transform[4 * i + k] = (float)axis[i][k];
        c->transform[12 + k] = (float)(middle[k] + distance * back[k]);
    }
    c->focus_distance = (float)distance;
}

static bool add_camera(struct glint_scene *s)
{
    struct box b = {.any = false};
    struct glint_arena scratch = {0};
    struct glint_camera *c = glint_arena_alloc(&s->arena, sizeof *c);
    const bool fine = c && scene_box(s, &b, &scratch);
    glint_arena_finish(&scratch);
    if (!fine)
        return false;
    c->id = glint_arena_string(&s->arena, "camera");
    c->name = c->id;
    c->yfov = DEFAULT_YFOV;
    frame_box(c, &b);
    if (!c->id)
        return false;
    s->camera = c;
    s->cameras = 1;
    glint_scene_warn(s, "the scene has no camera: \"camera\" was added, it frames what is visible");
    return true;
}

static bool emits(const struct glint_material *m)
{
    return m->emission[0] > 0 || m->emission[1] > 0 || m->emission[2] > 0;
}

static bool has_emitter(const struct glint_scene *s)
{
    if (s->lights || s->has_environment)
        return true;
    for (uint32_t i = 0; i < s->instances; i++)
        if (s->instance[i].visible && emits(&s->material[s->instance[i].material]))
            return true;
    return false;
}

glint_status glint_scene_complete(struct glint_scene *scene, struct glint_error *err)
{
    if (!scene->cameras && !add_camera(scene))
        return glint_fail(err, GLINT_E_NOMEM, "/cameras", "no memory for a camera");
    if (!has_emitter(scene)) {
        scene->has_environment = true;
        scene->environment = (struct glint_environment){{1, 1, 1}, GLINT_NONE, 0};
        glint_scene_warn(scene, "nothing in the scene emits: a constant environment of radiance 1 "
                                "was added");
    }
    return GLINT_OK;
}
