// pose_placements.c - lights and cameras on nodes.
#include "scene/pose_work.h"

#include <math.h>
#include <string.h>

static glint_status no_memory(struct glint_error *err)
{
    return glint_fail(err, GLINT_E_NOMEM, "", "no memory for the lights and cameras of a pose");
}

struct item {
    uint32_t node;
    const float *transform;
    const float *size; // of an area light, or NULL: rigid
};

static struct item light_item(const struct glint_light *l)
{
    return (struct item){l->node, l->transform, l->kind == GLINT_LIGHT_AREA ? l->size : NULL};
}

static struct item camera_item(const struct glint_camera *c)
{
    return (struct item){c->node, c->transform, NULL};
}

// The directions of `otherwise`, at the place of m if that can be.
static void replace_directions(double m[16], const double otherwise[16])
{
    double out[16];
    memcpy(out, otherwise, sizeof out);
    for (int k = 12; k < 15; k++)
        out[k] = fabs(m[k]) <= (double)GLINT_MAX_COORDINATE ? m[k] : otherwise[k];
    memcpy(m, out, sizeof out);
}

// Leaves rotations and translations. A moment that has no directions takes them from the moment
// before it, the first from the item itself.
static uint32_t make_rigid(glint_pose_matrix *m, uint32_t moments, const float *own)
{
    static const double identity[16] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1};
    double last[16];
    uint32_t bad = 0;
    glint_matrix_widen(last, own);
    if (!glint_pose_rigid(last, last))
        memcpy(last, identity, sizeof last);
    for (uint32_t i = 0; i < moments; i++) {
        if (!glint_pose_rigid(m[i], m[i])) {
            replace_directions(m[i], last);
            bad++;
        }
        memcpy(last, m[i], sizeof last);
    }
    return bad;
}

// False: has no extent in the shutter.
static bool make_drawable(struct glint_pose_track *t, const struct glint_pose_nodes *n,
                          uint32_t moments, const float size[2], bool *mended)
{
    const double reach = fmax(size[0], size[1]);
    const uint32_t shutter = moments > 1 ? n->shutter : 1;
    const uint32_t bad = glint_pose_repair(t->m, shutter, reach);
    for (uint32_t m = shutter; m < moments; m++)
        if (!glint_pose_drawable(t->m[m], reach))
            memcpy(t->m[m], t->m[0], sizeof t->m[m]);
    *mended = bad;
    return bad < shutter;
}

static bool track_of(const struct glint_pose_work *w, const struct item *item,
                     struct glint_pose_track *t, bool *mended)
{
    const struct glint_pose_nodes *n = &w->nodes;
    const uint32_t moments = glint_pose_touches(n, item->node) ? n->moments : 1;
    t->moves = t->flows = *mended = false;
    for (uint32_t m = 0; m < moments; m++)
        glint_pose_multiply_float(t->m[m], glint_pose_world(n, item->node, m), item->transform);
    bool seen = true;
    if (item->size)
        seen = make_drawable(t, n, moments, item->size, mended);
    else
        *mended = make_rigid(t->m, moments, item->transform);
    if (moments > 1)
        glint_pose_track_compare(t, n);
    return seen;
}

static void measure(struct glint_pose_work *w, struct item item)
{
    struct glint_pose_track t;
    bool mended;
    if (item.node == GLINT_NONE)
        return;
    const bool seen = track_of(w, &item, &t, &mended);
    w->pose->collapsed += mended;
    glint_pose_track_count(&t, w);
    if (!seen || !t.moves)
        return;
    uint32_t keys;
    if (item.size) {
        const double hi[3] = {item.size[0] / 2, item.size[1] / 2, 0};
        keys = glint_pose_box_keys(t.m, (const double[3]){-hi[0], -hi[1], 0}, hi, w->keys);
    } else {
        keys = glint_pose_frame_keys(t.m);
    }
    w->keys = keys > w->keys ? keys : w->keys;
}

void glint_pose_placements_measure(struct glint_pose_work *w)
{
    for (uint32_t i = 0; i < w->scene->lights; i++)
        measure(w, light_item(&w->scene->light[i]));
    for (uint32_t i = 0; i < w->scene->cameras; i++)
        measure(w, camera_item(&w->scene->camera[i]));
}

static bool fill(struct glint_pose_work *w, struct item item, struct glint_pose_placement *out)
{
    struct glint_pose_track t;
    bool mended;
    if (item.node == GLINT_NONE)
        return true;
    out->hidden = !track_of(w, &item, &t, &mended);
    if (out->hidden)
        return true;
    out->moves = t.moves && w->pose->keys > 1;
    return glint_pose_track_store(&t, w, &out->transform, &out->flow_transform);
}

glint_status glint_pose_placements_fill(struct glint_pose_work *w, struct glint_error *err)
{
    bool fine = true;
    for (uint32_t i = 0; fine && i < w->scene->lights; i++)
        fine = fill(w, light_item(&w->scene->light[i]), &w->pose->light[i]);
    for (uint32_t i = 0; fine && i < w->scene->cameras; i++)
        fine = fill(w, camera_item(&w->scene->camera[i]), &w->pose->camera[i]);
    return fine ? GLINT_OK : no_memory(err);
}
