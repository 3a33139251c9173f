// gltf_instancing.c - EXT_mesh_gpu_instancing: one mesh shown many times below one node.
#include "scene/gltf_file.h"

#include <math.h>

struct copies {
    struct glint_gltf_accessor translation, rotation, scale; // count 0: absent
    uint32_t count;
};

static bool read_part(struct glint_gltf *g, const struct glint_json *attributes, const char *name,
                      uint32_t components, struct copies *c, struct glint_gltf_accessor *out)
{
    const struct glint_json at = glint_json_member(attributes, name);
    const uint32_t index = glint_gltf_index(g, attributes, name, GLTF_ACCESSORS);
    if (index == GLINT_NONE)
        return !at.value;
    if (!glint_gltf_accessor_read(g, index, out))
        return false;
    const bool fraction = components == 4 && out->normalized && out->type != GLTF_U32;
    if (out->components != components || (out->type != GLTF_F32 && !fraction))
        return glint_json_fault(&at, "accessor %u has the wrong type for it", index);
    if (out->view == GLINT_NONE) // or a few bytes would make millions
        return glint_json_fault(&at, "accessor %u has no buffer view", index);
    if (c->count && out->count != c->count)
        return glint_json_fault(&at, "accessor %u has %u elements, another attribute has %u", index,
                                out->count, c->count);
    c->count = out->count;
    return true;
}

static bool read_parts(struct glint_gltf *g, const struct glint_json *node, struct copies *c)
{
    struct glint_json hold[2];
    *c = (struct copies){.count = 0};
    if (!glint_gltf_extension(node, "EXT_mesh_gpu_instancing", hold))
        return false;
    const struct glint_json a = glint_gltf_object(&hold[1], "attributes");
    return glint_json_require(&a) && read_part(g, &a, "TRANSLATION", 3, c, &c->translation) &&
           read_part(g, &a, "ROTATION", 4, c, &c->rotation) &&
           read_part(g, &a, "SCALE", 3, c, &c->scale);
}

uint32_t glint_gltf_copies(struct glint_gltf *g, const struct glint_json *node)
{
    struct copies c;
    return read_parts(g, node, &c) ? c.count : 0;
}

// The accessor's floats, or none where it is absent. False after a fault.
static bool read_floats(struct glint_gltf *g, const struct glint_gltf_accessor *a, float **out)
{
    *out = NULL;
    if (!a->count)
        return true;
    float *f = glint_arena_array(&g->scratch, a->count, a->components * sizeof *f);
    if (!f)
        return glint_gltf_nomem(g);
    *out = f;
    if (!glint_gltf_accessor_floats(g, a, f))
        return false;
    for (size_t i = 0; i < (size_t)a->count * a->components; i++)
        if (!(fabsf(f[i]) <= GLINT_MAX_COORDINATE))
            return glint_gltf_accessor_fault(g, a, "element %zu has the number %g",
                                             i / a->components, (double)f[i]);
    return true;
}

static bool compose(double out[16], const float *t, const float *q, const float *s)
{
    double translation[3] = {0}, rotation[4] = {0, 0, 0, 1}, scale[3] = {1, 1, 1}, square = 0;
    for (int i = 0; i < 4; i++) {
        rotation[i] = q ? (double)q[i] : rotation[i];
        square += rotation[i] * rotation[i];
    }
    for (int i = 0; i < 3; i++) {
        translation[i] = t ? (double)t[i] : 0;
        scale[i] = s ? (double)s[i] : 1;
    }
    for (int i = 0; i < 4; i++)
        rotation[i] /= sqrt(square);
    glint_matrix_compose(out, translation, rotation, scale);
    return square > 1e-12;
}

double (*glint_gltf_read_copies(struct glint_gltf *g, const struct glint_json *node))[16]
{
    struct copies c;
    float *t, *q, *s;
    if (!read_parts(g, node, &c) || !read_floats(g, &c.translation, &t) ||
        !read_floats(g, &c.rotation, &q) || !read_floats(g, &c.scale, &s))
        return NULL;
    double(*out)[16] = glint_arena_array(&g->scratch, c.count, sizeof *out);
    if (!out)
        glint_gltf_nomem(g);
    for (size_t i = 0; out && i < c.count; i++)
        if (!compose(out[i], t ? t + 3 * i : NULL, q ? q + 4 * i : NULL, s ? s + 3 * i : NULL)) {
            glint_gltf_accessor_fault(g, &c.rotation,
                                      "the quaternion of element %zu is no rotation", i);
            return NULL;
        }
    return out;
}
