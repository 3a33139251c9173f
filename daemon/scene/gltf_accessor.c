// gltf_accessor.c - accessors: checked against their views, and read where Assimp misreads them.
//
// Source: glTF 2.0, "Accessors"; the conversions of normalised integers are those of
// "Animations" (equations for decoding).
#include "scene/gltf_file.h"

#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <string.h>

#define MAX_COUNT 0x7fffffffu
#define MAX_ZEROS (1u << 22) // elements that cost the file nothing

static const char *const type_name[] = {"SCALAR", "VEC2", "VEC3", "VEC4",
                                        "MAT2",   "MAT3", "MAT4", NULL};

static uint32_t component_bytes(uint32_t type)
{
    switch (type) {
    case GLTF_I8:
    case GLTF_U8:
        return 1;
    case GLTF_I16:
    case GLTF_U16:
        return 2;
    case GLTF_U32:
    case GLTF_F32:
        return 4;
    default:
        return 0;
    }
}

static bool read_component(const struct glint_json *object, uint32_t *type)
{
    const struct glint_json at = glint_json_member(object, "componentType");
    if (!glint_json_require(&at) || !glint_json_uint(&at, 0, UINT32_MAX, type))
        return false;
    return component_bytes(*type) != 0 || glint_json_fault(&at, "%u is no component type", *type);
}

static bool read_shape(const struct glint_json *at, struct glint_gltf_accessor *a)
{
    const struct glint_json count = glint_json_member(at, "count");
    const struct glint_json type = glint_json_member(at, "type");
    const struct glint_json normalized = glint_json_member(at, "normalized");
    int shape = 0;
    if (!glint_json_require(&count) || !glint_json_require(&type) ||
        !glint_json_uint(&count, 1, MAX_COUNT, &a->count) ||
        !glint_json_choice(&type, type_name, &shape) ||
        !glint_json_bool(&normalized, &a->normalized) || !read_component(at, &a->type))
        return false;
    if (shape == 4 || shape == 5)
        return glint_json_fault(&type, "nothing has the type %s", type_name[shape]);
    a->components = shape == 6 ? 16 : (uint32_t)shape + 1;
    a->element = (size_t)a->components * component_bytes(a->type);
    return true;
}

// count elements of `bytes` each, `stride` apart, from the member byteOffset on in the view.
static bool fits(struct glint_gltf *g, const struct glint_json *at, uint32_t view, uint32_t count,
                 size_t bytes, size_t stride, size_t *offset)
{
    const struct glint_json member = glint_json_member(at, "byteOffset");
    uint32_t from = 0;
    if (!glint_json_uint(&member, 0, UINT32_MAX, &from))
        return false;
    const size_t size = g->view[view].data.size;
    if (!g->view[view].data.bytes)
        return glint_json_fault(at, "buffer view %u has no data", view);
    const size_t needs = (size_t)(count - 1) * stride + bytes;
    if (from > size || needs > size - from)
        return glint_json_fault(at, "%u elements need %zu bytes from byte %u of a view of %zu",
                                count, needs, from, size);
    *offset = from;
    return true;
}

static bool read_sparse(struct glint_gltf *g, const struct glint_json *accessor,
                        struct glint_gltf_accessor *a)
{
    const struct glint_json at = glint_gltf_object(accessor, "sparse");
    if (!at.value)
        return true;
    const struct glint_json count = glint_json_member(&at, "count");
    const struct glint_json indices = glint_gltf_object(&at, "indices");
    const struct glint_json values = glint_gltf_object(&at, "values");
    if (!glint_json_require(&count) || !glint_json_require(&indices) ||
        !glint_json_require(&values) || !glint_json_uint(&count, 1, a->count, &a->sparse) ||
        !read_component(&indices, &a->sparse_type))
        return false;
    if (a->sparse_type != GLTF_U8 && a->sparse_type != GLTF_U16 && a->sparse_type != GLTF_U32)
        return glint_json_fault(&indices, "sparse indices must be unsigned integers");
    const uint32_t iv = glint_gltf_index(g, &indices, "bufferView", GLTF_VIEWS);
    const uint32_t vv = glint_gltf_index(g, &values, "bufferView", GLTF_VIEWS);
    if (iv == GLINT_NONE || vv == GLINT_NONE)
        return glint_json_fault(&at, "the sparse accessor has no data");
    const size_t step = component_bytes(a->sparse_type);
    size_t from_index, from_value;
    if (!fits(g, &indices, iv, a->sparse, step, step, &from_index) ||
        !fits(g, &values, vv, a->sparse, a->element, a->element, &from_value))
        return false;
    a->sparse_index = g->view[iv].data.bytes + from_index;
    a->sparse_value = g->view[vv].data.bytes + from_value;
    return true;
}

bool glint_gltf_accessor_read(struct glint_gltf *g, uint32_t index, struct glint_gltf_accessor *out)
{
    const struct glint_json at = glint_gltf_item(g, GLTF_ACCESSORS, index);
    struct glint_gltf_accessor a = {.number = index, .view = GLINT_NONE};
    if (!read_shape(&at, &a))
        return false;
    bool has_view = glint_json_member(&at, "bufferView").value != NULL;
    a.view = glint_gltf_index(g, &at, "bufferView", GLTF_VIEWS);
    a.stride = a.element;
    if (has_view && a.view == GLINT_NONE)
        return false;
    if (has_view && !g->view[a.view].data.bytes && !g->err->status) {
        // its buffer has no data, which is allowed: as if there were no view
        glint_gltf_note(g, "no data", "buffer view %u has no data; accessor %u reads as zeros",
                        a.view, index);
        a.view = GLINT_NONE;
        has_view = false;
    }
    if (has_view && g->view[a.view].stride)
        a.stride = g->view[a.view].stride;
    if (a.stride < a.element)
        return glint_json_fault(&at, "elements of %zu bytes are %zu bytes apart", a.element,
                                a.stride);
    if (has_view && !fits(g, &at, a.view, a.count, a.element, a.stride, &a.offset))
        return false;
    if (!read_sparse(g, &at, &a))
        return false;
    if (!has_view && a.count > MAX_ZEROS)
        return glint_json_fault(&at, "the accessor has no data for %u elements", a.count);
    *out = a;
    return true;
}

static uint32_t unsigned_at(const uint8_t *p, uint32_t type)
{
    uint16_t h;
    uint32_t w;
    switch (type) {
    case GLTF_U8:
        return *p;
    case GLTF_U16:
        memcpy(&h, p, 2);
        return h;
    default:
        memcpy(&w, p, 4);
        return w;
    }
}

static float float_at(const uint8_t *p, uint32_t type, bool normalized)
{
    int8_t b;
    int16_t s;
    float f;
    switch (type) {
    case GLTF_F32:
        memcpy(&f, p, 4);
        return f;
    case GLTF_I8:
        memcpy(&b, p, 1);
        return normalized ? fmaxf((float)b / 127, -1) : (float)b;
    case GLTF_I16:
        memcpy(&s, p, 2);
        return normalized ? fmaxf((float)s / 32767, -1) : (float)s;
    case GLTF_U8:
        return normalized ? (float)*p / 255 : (float)*p;
    case GLTF_U16:
        f = (float)unsigned_at(p, type);
        return normalized ? f / 65535 : f;
    default:
        return (float)unsigned_at(p, type);
    }
}

bool glint_gltf_accessor_fault(struct glint_gltf *g, const struct glint_gltf_accessor *a,
                               const char *format, ...)
{
    char pointer[32], detail[320];
    va_list args;
    va_start(args, format);
    vsnprintf(detail, sizeof detail, format, args);
    va_end(args);
    snprintf(pointer, sizeof pointer, "/accessors/%u", a->number);
    glint_fail(g->err, GLINT_E_RANGE, pointer, "%s", detail);
    return false;
}

// The next of the elements that sparse values replace, checked.
static bool sparse_target(struct glint_gltf *g, const struct glint_gltf_accessor *a, uint32_t k,
                          uint32_t *target)
{
    *target =
        unsigned_at(a->sparse_index + (size_t)k * component_bytes(a->sparse_type), a->sparse_type);
    return *target < a->count ||
           glint_gltf_accessor_fault(g, a, "sparse index %u is %u; there are %u elements", k,
                                     *target, a->count);
}

static void element_floats(const struct glint_gltf_accessor *a, const uint8_t *from, float *out)
{
    const uint32_t step = component_bytes(a->type);
    for (uint32_t c = 0; c < a->components; c++)
        out[c] = float_at(from + c * step, a->type, a->normalized);
}

bool glint_gltf_accessor_floats(struct glint_gltf *g, const struct glint_gltf_accessor *a,
                                float *out)
{
    const uint8_t *from = a->view == GLINT_NONE ? NULL : g->view[a->view].data.bytes + a->offset;
    if (!from)
        memset(out, 0, (size_t)a->count * a->components * sizeof *out);
    else if (a->type == GLTF_F32 && a->stride == a->element)
        memcpy(out, from, a->count * a->element);
    else
        for (uint32_t i = 0; i < a->count; i++)
            element_floats(a, from + i * a->stride, out + (size_t)i * a->components);
    for (uint32_t k = 0, target; k < a->sparse; k++) {
        if (!sparse_target(g, a, k, &target))
            return false;
        element_floats(a, a->sparse_value + k * a->element, out + (size_t)target * a->components);
    }
    return true;
}

bool glint_gltf_accessor_indices(struct glint_gltf *g, const struct glint_gltf_accessor *a,
                                 uint32_t *out)
{
    if (a->view == GLINT_NONE)
        memset(out, 0, (size_t)a->count * sizeof *out);
    for (uint32_t i = 0; a->view != GLINT_NONE && i < a->count; i++)
        out[i] = unsigned_at(g->view[a->view].data.bytes + a->offset + i * a->stride, a->type);
    for (uint32_t k = 0, target; k < a->sparse; k++) {
        if (!sparse_target(g, a, k, &target))
            return false;
        out[target] = unsigned_at(a->sparse_value + k * a->element, a->type);
    }
    return true;
}
