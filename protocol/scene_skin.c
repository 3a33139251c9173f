// scene_skin.c - joints and the matrices that take vertices to them.
#include "protocol/scene_parts.h"

#include <math.h>
#include <string.h>

#define MAX_JOINTS 65535u

static bool read_joints(struct glint_scene_reader *r, const struct glint_json *at,
                        struct glint_skin *out)
{
    size_t count, i = 0;
    if (!glint_json_require(at) || !glint_json_length(at, &count))
        return false;
    if (count < 1 || count > MAX_JOINTS)
        return glint_json_fault(at, "1 to %u joints are expected, not %zu", MAX_JOINTS, count);
    out->joint = glint_arena_array(&r->scene->arena, count, sizeof *out->joint);
    if (!out->joint)
        return glint_scene_no_memory(r);
    out->joints = (uint32_t)count;
    bool fine = true;
    for (const cJSON *c = at->value->child; c; c = c->next, i++) {
        const struct glint_json item = glint_json_item(at, c, i);
        out->joint[i] = glint_scene_reference(&item, &r->nodes, "node");
        fine &= out->joint[i] != GLINT_NONE;
    }
    return fine;
}

static bool check_matrices(const struct glint_json *at, float *m, uint32_t count)
{
    for (size_t i = 0; i < (size_t)count * 16; i++)
        if (!(fabsf(m[i]) <= GLINT_MAX_COORDINATE))
            return glint_json_fault(at, "number %zu is %g: not finite or larger than %g", i, m[i],
                                    GLINT_MAX_COORDINATE);
    for (uint32_t j = 0; j < count; j++)
        if (!glint_transform_affine(m + 16 * (size_t)j))
            return glint_json_fault(at, "matrix %u is not affine: its last row is not 0 0 0 1", j);
    return true;
}

// The matrices are copied: rounding is taken out of their last rows.
static bool read_matrices(struct glint_scene_reader *r, const struct glint_json *at,
                          struct glint_skin *out, float *m)
{
    const struct glint_json asset = glint_json_member(at, "asset");
    const struct glint_json list = glint_json_member(at, "inverse_bind");
    const size_t count = (size_t)out->joints * 16;
    if (asset.value && list.value)
        return glint_json_fault(&asset, "a skin has either inverse_bind or an asset");
    if (asset.value) {
        const void *bytes = glint_scene_asset(r, &asset, count * sizeof *m, out->asset);
        if (bytes)
            memcpy(m, bytes, count * sizeof *m);
        return bytes && check_matrices(&asset, m, out->joints);
    }
    const float far = GLINT_MAX_COORDINATE;
    return !list.value ||
           (glint_json_floats(&list, count, -far, far, m) && check_matrices(&list, m, out->joints));
}

void glint_skin_read(struct glint_scene_reader *r, const struct glint_json *at,
                     struct glint_skin *out)
{
    const struct glint_json joints = glint_json_member(at, "joints");
    glint_fields_read(at, glint_skin_fields, &r->scene->arena, out);
    if (!read_joints(r, &joints, out)) {
        out->joints = 0;
        return;
    }
    float *m = glint_arena_array(&r->scene->arena, out->joints, sizeof glint_identity);
    if (!m) {
        glint_scene_no_memory(r);
        return;
    }
    for (uint32_t j = 0; j < out->joints; j++)
        memcpy(m + 16 * (size_t)j, glint_identity, sizeof glint_identity);
    out->inverse_bind = m;
    read_matrices(r, at, out, m);
}
