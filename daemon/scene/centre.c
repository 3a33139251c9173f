// centre.c - where a scene's centre lies and how large it is, as a function of the scene at rest: a
// pose or an edit inside the bounds moves no record.
#include "scene/internal.h"

#include <math.h>
#include <string.h>

struct bounds {
    double low[3], high[3];
    bool any;
};

static void include(struct bounds *b, const double p[3])
{
    for (int k = 0; k < 3; k++) {
        b->low[k] = b->any ? fmin(b->low[k], p[k]) : p[k];
        b->high[k] = b->any ? fmax(b->high[k], p[k]) : p[k];
    }
    b->any = true;
}

static void include_corners(struct bounds *b, const double t[16], const float low[3],
                            const float high[3])
{
    for (int corner = 0; corner < 8; corner++) {
        double p[3];
        for (int i = 0; i < 3; i++) {
            p[i] = t[12 + i];
            for (int k = 0; k < 3; k++)
                p[i] += t[4 * k + i] * (double)(corner >> k & 1 ? high[k] : low[k]);
        }
        include(b, p);
    }
}

static void box_of(const float *position, uint32_t vertices, float low[3], float high[3])
{
    for (uint32_t i = 0; i < vertices; i++)
        for (int k = 0; k < 3; k++) {
            const float x = position[3 * (size_t)i + k];
            low[k] = i == 0 || x < low[k] ? x : low[k];
            high[k] = i == 0 || x > high[k] ? x : high[k];
        }
}

static void include_instance(struct bounds *b, const struct glint_resident *r,
                             const struct glint_pose *rest, uint32_t i)
{
    const struct glint_mesh *m = &r->scene->mesh[r->scene->instance[i].mesh];
    const struct glint_shape *shape = r->kept[r->scene->instance[i].mesh].shape;
    const bool deforms = rest && rest->instance[i].deforms;
    float low[3], high[3];
    if (deforms || !shape)
        box_of(deforms ? rest->instance[i].position : m->position, m->vertices, low, high);
    double t[16];
    glint_pose_instance_at(rest, r->scene, i, 0, t);
    include_corners(b, t, deforms || !shape ? low : shape->low,
                    deforms || !shape ? high : shape->high);
}

static void include_light(struct bounds *b, const struct glint_resident *r,
                          const struct glint_pose *rest, uint32_t i)
{
    const float *size = r->scene->light[i].size;
    const float low[3] = {-0.5f * size[0], -0.5f * size[1], 0.0f};
    const float high[3] = {0.5f * size[0], 0.5f * size[1], 0.0f};
    double t[16];
    glint_pose_light_at(rest, r->scene, i, 0, t);
    include_corners(b, t, low, high);
}

static struct bounds bounds_at_rest(const struct glint_resident *r, const struct glint_pose *rest)
{
    const struct glint_scene *s = r->scene;
    struct bounds b = {0};
    for (uint32_t i = 0; i < s->instances; i++)
        if (s->instance[i].visible && !(rest && rest->instance[i].hidden))
            include_instance(&b, r, rest, i);
    for (uint32_t i = 0; i < s->lights; i++)
        if (s->light[i].kind == GLINT_LIGHT_AREA && !(rest && rest->light[i].hidden))
            include_light(&b, r, rest, i);
    return b;
}

// Floats are finest around zero. On a grid of a sixteenth to an eighth of the radius, so that most
// edits leave it where it was.
static void set_centre(struct glint_resident *r, const struct bounds *b)
{
    double half[3] = {0.0, 0.0, 0.0}, square = 0.0, off = 0.0;
    for (int k = 0; b->any && k < 3; k++) {
        half[k] = 0.5 * (b->high[k] - b->low[k]);
        square += half[k] * half[k];
    }
    const double step = square > 0.0 ? ldexp(1.0, ilogb(sqrt(square)) - 3) : 0.0;
    for (int k = 0; k < 3; k++) {
        const double middle = b->any ? 0.5 * (b->low[k] + b->high[k]) : 0.0;
        r->centre[k] = step > 0.0 ? step * rint(middle / step) : middle;
        const double apart = fabs(middle - r->centre[k]);
        off += apart * apart;
        r->half[k] = step > 0.0 ? step * ceil((half[k] + apart) / step) : 0.0;
    }
    r->radius = step > 0.0 ? step * ceil((sqrt(square) + sqrt(off)) / step) : 0.0;
}

glint_status glint_resident_find_centre(struct glint_resident *r, struct glint_error *err)
{
    struct glint_pose *rest = NULL;
    if (r->owner) {
        memcpy(r->centre, r->from->centre, sizeof r->centre);
        memcpy(r->half, r->from->half, sizeof r->half);
        r->radius = r->from->radius;
        return GLINT_OK;
    }
    const bool moved = r->pose && r->pose->request.animation != GLINT_NONE;
    const struct glint_pose_request request = glint_pose_rest();
    if (moved && glint_pose_create(&rest, r->scene, &request, err))
        return err->status;
    const struct bounds b = bounds_at_rest(r, moved ? rest : r->pose);
    glint_pose_release(&rest);
    set_centre(r, &b);
    return GLINT_OK;
}
