// gltf_attributes.c - what vertices have besides place and direction: texture coordinates, colours,
// joints, displacements of morph targets.
#include "scene/gltf_file.h"

#include <math.h>

// The accessor's numbers in the scene's arena; NULL where it is absent or after a fault.
static float *read_floats(struct glint_gltf *g, const struct glint_gltf_accessor *a)
{
    if (!a->count)
        return NULL;
    float *f = glint_arena_array(&g->scene->arena, a->count, a->components * sizeof *f);
    if (!f)
        glint_gltf_nomem(g);
    return f && glint_gltf_accessor_floats(g, a, f) ? f : NULL;
}

static float *read_uv(struct glint_gltf *g, const struct glint_gltf_geometry *geometry,
                      enum glint_gltf_part part)
{
    float *uv = read_floats(g, &geometry->part[part]);
    bool bad = false;
    for (size_t i = 0; uv && i < (size_t)geometry->part[part].count * 2; i++)
        if (!(fabsf(uv[i]) <= GLINT_MAX_COORDINATE)) {
            uv[i] = 0;
            bad = true;
        }
    if (bad)
        glint_gltf_note(g, "texture coordinates without a value",
                        "some texture coordinates of mesh \"%.200s\" are not finite; 0 is used",
                        geometry->name);
    return uv;
}

// Clamped to 0..1, as glTF asks for; opacity 1 where there is none.
static float *read_colors(struct glint_gltf *g, const struct glint_gltf_accessor *a)
{
    const float *from = read_floats(g, a);
    float *out = from ? glint_arena_array(&g->scene->arena, a->count, 4 * sizeof *out) : NULL;
    if (from && !out)
        glint_gltf_nomem(g);
    for (size_t i = 0; out && i < a->count; i++)
        for (uint32_t k = 0; k < 4; k++) {
            const float value = k < a->components ? from[i * a->components + k] : 1;
            out[4 * i + k] = value > 0 ? fminf(value, 1) : 0; // NaN is 0
        }
    return out;
}

// --- joints

// Weights of sum 1, joints without weight 0. False where no weight can be used: joint 0 has it all.
static bool settle(float weight[4], uint16_t joint[4])
{
    double sum = 0;
    for (int k = 0; k < 4; k++) {
        if (!(weight[k] > 0 && weight[k] <= GLINT_MAX_COORDINATE))
            weight[k] = 0;
        sum += (double)weight[k];
    }
    for (int k = 0; k < 4; k++) {
        weight[k] = sum > 0 ? (float)((double)weight[k] / sum) : (float)(k == 0);
        joint[k] = sum > 0 && weight[k] > 0 ? joint[k] : 0;
    }
    return sum > 0;
}

static void read_joints(struct glint_gltf *g, const struct glint_gltf_geometry *geometry,
                        uint32_t mesh)
{
    struct glint_mesh *m = &g->scene->mesh[mesh];
    const float *from = read_floats(g, &geometry->part[GLTF_JOINTS]);
    float *weight = read_floats(g, &geometry->part[GLTF_WEIGHTS]);
    if (!from || !weight)
        return;
    uint16_t *joint = glint_arena_array(&g->scene->arena, m->vertices, 4 * sizeof *joint);
    if (!joint) {
        glint_gltf_nomem(g);
        return;
    }
    uint32_t bad = 0, most = 0;
    for (size_t i = 0; i < m->vertices; i++) {
        for (int k = 0; k < 4; k++)
            joint[4 * i + k] = (uint16_t)from[4 * i + k];
        bad += !settle(weight + 4 * i, joint + 4 * i);
        for (int k = 0; k < 4; k++)
            most = joint[4 * i + k] > most ? joint[4 * i + k] : most;
    }
    if (bad)
        glint_gltf_note(g, "vertices without weight",
                        "%u vertices of mesh \"%.200s\" follow no joint; they are bound to the "
                        "skin's first",
                        bad, geometry->name);
    m->joint = joint;
    m->weight = weight;
    g->joints[mesh] = most + 1;
}

// --- morph targets

static const struct glint_gltf_accessor *part_of(const struct glint_gltf_target *t, int k)
{
    return k == 0 ? &t->position : k == 1 ? &t->normal : &t->tangent;
}

static bool check(struct glint_gltf *g, const struct glint_gltf_accessor *a, const float *f)
{
    for (size_t i = 0; i < (size_t)a->count * 3; i++)
        if (!(fabsf(f[i]) <= GLINT_MAX_COORDINATE))
            return glint_gltf_accessor_fault(g, a, "element %zu has the number %g", i / 3,
                                             (double)f[i]);
    return true;
}

// Displacements of one kind, by all targets: zero where a target has none, NULL where none has.
static const float *read_displacements(struct glint_gltf *g,
                                       const struct glint_gltf_geometry *geometry, int kind)
{
    const size_t each = (size_t)geometry->part[GLTF_POSITION].count * 3;
    bool any = kind == 0;
    for (uint32_t t = 0; t < geometry->targets; t++)
        any = any || part_of(&geometry->target[t], kind)->count;
    if (!any)
        return NULL;
    float *out = glint_arena_array(&g->scene->arena, geometry->targets, each * sizeof *out);
    if (!out)
        glint_gltf_nomem(g);
    for (uint32_t t = 0; out && t < geometry->targets; t++) {
        const struct glint_gltf_accessor *a = part_of(&geometry->target[t], kind);
        if (a->count &&
            (!glint_gltf_accessor_floats(g, a, out + t * each) || !check(g, a, out + t * each)))
            return NULL;
    }
    return out;
}

static void read_targets(struct glint_gltf *g, const struct glint_gltf_geometry *geometry,
                         struct glint_mesh *m)
{
    m->target_position = read_displacements(g, geometry, 0);
    if (!m->target_position)
        return;
    m->targets = geometry->targets;
    m->target_normal = m->normal ? read_displacements(g, geometry, 1) : NULL;
    m->target_tangent = m->tangent ? read_displacements(g, geometry, 2) : NULL;
    m->target_weight = geometry->weight;
}

void glint_gltf_read_attributes(struct glint_gltf *g, uint32_t mesh,
                                const struct glint_gltf_geometry *geometry)
{
    struct glint_mesh *m = &g->scene->mesh[mesh];
    m->uv = read_uv(g, geometry, GLTF_UV);
    m->uv1 = read_uv(g, geometry, GLTF_UV1);
    m->color = read_colors(g, &geometry->part[GLTF_COLOR]);
    read_joints(g, geometry, mesh);
    if (geometry->targets)
        read_targets(g, geometry, m);
}
