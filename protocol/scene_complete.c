// scene_complete.c - the camera and the light that a scene must have.
#include "protocol/scene_parts.h"

#include <math.h>

#define NEAREST_FOCUS 1e-9 // metres, within what a camera may have

// Looks at the middle from the front, a little from above and the right; the sphere around the box
// just fits into the field of view. The rows of `axis` are right, up and back.
static void frame_box(struct glint_camera *c, const double low[3], const double high[3])
{
    static const double back[3] = {0.4, 0.3, 0.8660254037844386}; // unit
    const double flat = hypot(back[0], back[2]);
    const double axis[3][3] = {
        {back[2] / flat, 0, -back[0] / flat},
        {-back[0] * back[1] / flat, flat, -back[2] * back[1] / flat},
        {back[0], back[1], back[2]},
    };
    double middle[3] = {0, 0, 0}, radius = 0;
    for (int k = 0; k < 3; k++) {
        middle[k] = 0.5 * (low[k] + high[k]);
        radius = hypot(radius, 0.5 * (high[k] - low[k]));
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
    double low[3] = {0, 0, 0}, high[3] = {0, 0, 0};
    bool any;
    struct glint_camera *c = glint_arena_alloc(&s->arena, sizeof *c);
    if (!c || !glint_scene_box(s, low, high, &any))
        return false;
    glint_camera_init(c);
    c->id = c->name = glint_arena_string(&s->arena, "camera");
    frame_box(c, low, high);
    if (!c->id)
        return false;
    s->camera = c;
    s->cameras = 1;
    glint_scene_warn(s,
                     "the scene has no camera: " GLINT_CAMERA_ADDED ", it frames what is visible");
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
    glint_scene_warn(s, "%s: " GLINT_ENVIRONMENT_ADDED, why);
}

static void warn_of_endless_medium(struct glint_scene *s)
{
    bool afar = s->has_environment;
    for (uint32_t i = 0; i < s->lights; i++)
        afar |= s->light[i].kind == GLINT_LIGHT_SUN;
    if (s->media && s->medium[0].density > 0 && !s->medium[0].bounded && afar)
        glint_scene_warn(s,
                         "medium \"%s\" has no box, so it has no end: nothing of the environment "
                         "and of suns comes through",
                         s->medium[0].id);
}

glint_status glint_scene_complete(struct glint_scene *scene, struct glint_error *err)
{
    if (!scene->cameras && !add_camera(scene))
        return glint_fail(err, GLINT_E_NOMEM, "/cameras", "no memory for a camera");
    if (!scene->lights && !scene->has_environment && !(brightest(scene) > 0))
        add_environment(scene, "nothing in the scene emits");
    warn_of_endless_medium(scene);
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
