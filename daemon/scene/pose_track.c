// pose_track.c - the transforms of one thing over the moments: compared, counted and kept at the keys.
#include "scene/pose_work.h"

#include <string.h>

static bool same(const double *a, const double *b)
{
    for (int i = 0; i < 16; i++)
        if (a[i] != b[i])
            return false;
    return true;
}

void glint_pose_track_compare(struct glint_pose_track *t, const struct glint_pose_nodes *n)
{
    for (uint32_t m = 1; m < n->moments; m++)
        if (!same(t->m[m], t->m[0]))
            *(m < n->shutter ? &t->moves : &t->flows) = true;
}

static bool stores_flow(const struct glint_pose_track *t, const struct glint_pose_nodes *n)
{
    return n->moments > n->shutter && (t->moves || t->flows);
}

void glint_pose_track_count(const struct glint_pose_track *t, struct glint_pose_work *w)
{
    *(t->moves ? &w->key_bytes : &w->still_bytes) += sizeof(glint_pose_matrix);
    w->still_bytes += stores_flow(t, &w->nodes) ? 2 * sizeof(glint_pose_matrix) : 0;
}

bool glint_pose_track_store(const struct glint_pose_track *t, struct glint_pose_work *w,
                            double **transform, double **flow)
{
    const uint32_t keys = t->moves ? w->pose->keys : 1;
    *transform = glint_arena_array(&w->pose->arena, keys, sizeof(glint_pose_matrix));
    if (!*transform)
        return false;
    for (uint32_t k = 0; k < keys; k++)
        memcpy(*transform + 16 * k, t->m[glint_pose_moment_of(k, keys)], sizeof t->m[0]);
    if (!stores_flow(t, &w->nodes))
        return true;
    *flow = glint_arena_array(&w->pose->arena, 2, sizeof(glint_pose_matrix));
    if (*flow)
        memcpy(*flow, t->m[w->nodes.shutter], 2 * sizeof t->m[0]);
    return *flow;
}
