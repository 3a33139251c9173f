// scene_complete.c - the camera and the light that a scene must have.
#include "protocol/scene_parts.h"

#include <math.h>
#include <string.h>

#define NEAREST_FOCUS 1e-9 // metres, within what a camera may have

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

static void include_corners(struct box *b, const float bounds[6], const double m[16])
{
    for (int corner = 0; corner < 8; corner++) {
        double world[3];
        for (int k = 0; k < 3; k++) {
            world[k] = m[12 + k];
            for (int i = 0; i < 3; i++)
                world[k] += m[4 * i + k] * bounds[corner >> i & 1 ? 3 + i : i];
        }
        include(b, world);
    }
}

// What all joints make of the box holds what any mixture of them makes of it.
static void include_skinned(struct box *b, const float bounds[6], const struct glint_skin *skin,
                            double (*node)[16], const float after[16])
{
    for (uint32_t j = 0; j < skin->joints; j++) {
        double joint[16], world[16], wide[16];
        for (int k = 0; k < 16; k++)
            wide[k] = after[k];
        glint_transform_product(joint, node[skin->joint[j]], skin->inverse_bind + 16 * (size_t)j);
        glint_transform_chain(world, wide, joint);
        include_corners(b, bounds, world);
    }
}

static void include_instance(struct box *b, const struct glint_scene *s, double (*node)[16],
                             const float bounds[6], const struct glint_instance *in)
{
    static const double none[16] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1};
    double world[16];
    if (in->skin != GLINT_NONE) {
        include_skinned(b, bounds, &s->skin[in->skin], node, in->transform);
        return;
    }
    glint_transform_product(world, in->node == GLINT_NONE ? none : node[in->node], in->transform);
    include_corners(b, bounds, world);
}

static void mesh_bounds(const struct glint_mesh *m, float bounds[6])
{
    if (m->checked) {
        memcpy(bounds, m->low, sizeof m->low);
        memcpy(bounds + 3, m->high, sizeof m->high);
    } else {
        glint_mesh_box(m, bounds, bounds + 3);
    }
}

static bool scene_box(const struct glint_scene *s, struct box *b, struct glint_arena *scratch)
{
    float(*bounds)[6] = glint_arena_array(scratch, s->meshes, sizeof *bounds);
    double(*node)[16] = glint_nodes_world(s, scratch);
    if (!bounds || !node)
        return false;
    for (uint32_t i = 0; i < s->meshes; i++)
        mesh_bounds(&s->mesh[i], bounds[i]);
    for (uint32_t i = 0; i < s->instances; i++)
        if (s->instance[i].visible)
            include_instance(b, s, node, bounds[s->instance[i].mesh], &s->instance[i]);
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
    const double distance = (radius > 0 ? radius : 1) / sin(0.5 * GLINT_DEFAULT_YFOV);
    for (int k = 0; k < 3; k++) {
        for (int i = 0; i < 3; i++)
            c->transform[4 * i + k] = (float)axis[i][k];
        c->transform[12 + k] = (float)(middle[k] + distance * back[k]);
    }
    c->focus_distance = (float)fmax(distance, NEAREST_FOCUS);
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
    glint_camera_init(c);
    c->id = c->name = glint_arena_string(&s->arena, "camera");
    frame_box(c, &b);
    if (!c->id)
        return false;
    s->camera = c;
    s->cameras = 1;
    glint_scene_warn(s, "the scene has no camera: \"camera\" was added, it frames what is visible");
    return true;
}

// The largest radiance that a visible surface gives off, without its texture.
static float brightest(const struct glint_scene *s)
{
    float most = 0;
    for (uint32_t i = 0; i < s->instances; i++) {
        const float *emission = s->material[s->instance[i].material].emission;
        for (int k = 0; s->instance[i].visible && k < 3; k++)
            most = fmaxf(most, emission[k]);
    }
    return most;
}

static void add_environment(struct glint_scene *s, const char *why)
{
    s->has_environment = true;
    s->environment = (struct glint_environment){{1, 1, 1}, GLINT_NONE, 0};
    glint_scene_warn(s, "%s: a constant environment of radiance 1 was added", why);
}

glint_status glint_scene_complete(struct glint_scene *scene, struct glint_error *err)
{
    if (!scene->cameras && !add_camera(scene))
        return glint_fail(err, GLINT_E_NOMEM, "/cameras", "no memory for a camera");
    if (!scene->lights && !scene->has_environment && !(brightest(scene) > 0))
        add_environment(scene, "nothing in the scene emits");
    return GLINT_OK;
}

glint_status glint_scene_complete_file(struct glint_scene *scene, struct glint_error *err)
{
    const float most = brightest(scene);
    if (!scene->lights && !scene->has_environment && most > 0) {
        if (!scene->cameras)
            add_environment(scene, "the file has neither lights nor cameras, and surfaces that "
                                   "emit light nothing but themselves as a rule");
        else if (most <= 1)
            add_environment(scene, "the file has no lights, and surfaces that emit radiance of at "
                                   "most 1 light nothing but themselves as a rule");
    }
    return glint_scene_complete(scene, err);
}
