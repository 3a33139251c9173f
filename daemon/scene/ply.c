// ply.c - PLY, text and binary: one mesh of faces or of triangle strips.
//
// Vertices may have normals, texture coordinates (s t, u v, texture_u texture_v) and colours:
// integers are encoded for a screen, floats are linear. Other properties and elements are skipped.
#include "scene/model.h"
#include "scene/ply_header.h"
#include "scene/polygon.h"

#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { X, Y, Z, NX, NY, NZ, U, V, RED, GREEN, BLUE, ALPHA, SLOTS };

struct ply {
    struct glint_model model;
    struct glint_ply_header header;
    struct glint_words words; // of text
    const uint8_t *at, *end;  // of binary
    const char *element;      // being read, for faults
    uint32_t number;          // of it
    bool has[SLOTS];
    float *position, *normal, *uv, *color;
    uint32_t vertices; // once they are read
    uint32_t (*triangle)[3];
    uint32_t triangles, triangle_capacity;
    uint32_t *corner; // of the face or strip being read
    uint32_t corners, corner_capacity;
    uint32_t (*cut)[3];
    float (*point)[3];
    uint32_t cut_capacity, point_capacity;
    uint32_t thin; // faces of less than three corners
};

__attribute__((format(printf, 3, 4))) static bool fault(struct ply *p, glint_status status,
                                                        const char *format, ...)
{
    char text[300];
    va_list args;
    va_start(args, format);
    vsnprintf(text, sizeof text, format, args);
    va_end(args);
    if (p->header.format == GLINT_PLY_TEXT)
        glint_fail(p->model.err, status, "", "line %u, %s %u: %s", p->words.line, p->element,
                   p->number, text);
    else
        glint_fail(p->model.err, status, "", "%s %u: %s", p->element, p->number, text);
    return false;
}

// ---- one value

static bool read_word(struct ply *p, double *out)
{
    struct glint_word word = glint_words_next(&p->words);
    while (!word.length && glint_words_line(&p->words, false))
        word = glint_words_next(&p->words);
    if (!word.length)
        return fault(p, GLINT_E_SYNTAX, "the file ends here");
    if (glint_word_number(word, out) != word.length)
        return fault(p, GLINT_E_RANGE, "\"%.*s\" is no number", glint_word_shown(word), word.text);
    return true;
}

static double decode(uint64_t bits, enum glint_ply_type type)
{
    const uint32_t low = (uint32_t)bits;
    float single;
    double twice;
    switch (type) {
    case GLINT_PLY_I8:
        return (int8_t)bits;
    case GLINT_PLY_I16:
        return (int16_t)bits;
    case GLINT_PLY_I32:
        return (int32_t)bits;
    case GLINT_PLY_F32:
        memcpy(&single, &low, sizeof single);
        return single;
    case GLINT_PLY_F64:
        memcpy(&twice, &bits, sizeof twice);
        return twice;
    default:
        return (double)bits;
    }
}

static bool read_bytes(struct ply *p, enum glint_ply_type type, double *out)
{
    const uint32_t size = glint_ply_size(type);
    if ((size_t)(p->end - p->at) < size)
        return fault(p, GLINT_E_SYNTAX, "the file ends here");
    uint64_t bits = 0;
    for (uint32_t i = 0; i < size; i++) {
        const uint32_t place = p->header.format == GLINT_PLY_LITTLE ? i : size - 1 - i;
        bits |= (uint64_t)p->at[i] << (8 * place);
    }
    p->at += size;
    *out = decode(bits, type);
    return true;
}

static bool read_value(struct ply *p, enum glint_ply_type type, double *out)
{
    return p->header.format == GLINT_PLY_TEXT ? read_word(p, out) : read_bytes(p, type, out);
}

// What can follow at most: each value takes room.
static bool read_length(struct ply *p, const struct glint_ply_property *property, uint32_t *out)
{
    double value;
    if (!read_value(p, property->count, &value))
        return false;
    const bool text = p->header.format == GLINT_PLY_TEXT;
    const size_t left = text ? (size_t)(p->words.text_end - p->words.at) / 2 + 1
                             : (size_t)(p->end - p->at) / glint_ply_size(property->type);
    if (!(value >= 0 && value <= (double)left && value <= GLINT_MAX_MESH_COUNT) ||
        value != floor(value))
        return fault(p, GLINT_E_SYNTAX, "a list of %g values, but the file has room for %zu", value,
                     left);
    *out = (uint32_t)value;
    return true;
}

static bool skip(struct ply *p, const struct glint_ply_property *property)
{
    uint32_t count = 1;
    double value;
    if (property->list && !read_length(p, property, &count))
        return false;
    while (count--)
        if (!read_value(p, property->type, &value))
            return false;
    return true;
}

// ---- vertices

static int slot_of(struct glint_word name)
{
    static const char *const names[SLOTS][4] = {
        [X] = {"x"},
        [Y] = {"y"},
        [Z] = {"z"},
        [NX] = {"nx"},
        [NY] = {"ny"},
        [NZ] = {"nz"},
        [U] = {"s", "u", "texture_u", "texcoord_u"},
        [V] = {"t", "v", "texture_v", "texcoord_v"},
        [RED] = {"red", "r", "diffuse_red"},
        [GREEN] = {"green", "g", "diffuse_green"},
        [BLUE] = {"blue", "b", "diffuse_blue"},
        [ALPHA] = {"alpha", "a", "diffuse_alpha"},
    };
    for (int slot = 0; slot < SLOTS; slot++)
        for (int i = 0; i < 4 && names[slot][i]; i++)
            if (glint_word_is(name, names[slot][i]))
                return slot;
    return SLOTS;
}

// Integers stand for 0..1.
static double scale_of(enum glint_ply_type type)
{
    return type == GLINT_PLY_U8 ? 1 / 255.0 : type == GLINT_PLY_U16 ? 1 / 65535.0 : 1;
}

static bool read_vertex(struct ply *p, const struct glint_ply_element *e)
{
    float value[SLOTS] = {[ALPHA] = 1};
    for (uint32_t i = 0; i < e->properties; i++) {
        const struct glint_ply_property *property = &e->property[i];
        const int slot = property->list ? SLOTS : slot_of(property->name);
        double read = 0;
        if (slot == SLOTS) {
            if (!skip(p, property))
                return false;
            continue;
        }
        if (!read_value(p, property->type, &read))
            return false;
        if (!(fabs(read) <= (double)GLINT_MAX_COORDINATE))
            return fault(p, GLINT_E_RANGE, "%.*s is %g, outside of -%g to %g",
                         glint_word_shown(property->name), property->name.text, read,
                         (double)GLINT_MAX_COORDINATE, (double)GLINT_MAX_COORDINATE);
        if (slot >= RED)
            read *= scale_of(property->type);
        value[slot] = (float)read;
        if (slot >= RED && slot < ALPHA && scale_of(property->type) < 1)
            value[slot] = glint_model_linear(value[slot]);
    }
    const size_t v = p->number;
    memcpy(p->position + 3 * v, value + X, 3 * sizeof *value);
    if (p->normal)
        memcpy(p->normal + 3 * v, value + NX, 3 * sizeof *value);
    if (p->uv) {
        p->uv[2 * v] = value[U];
        p->uv[2 * v + 1] = 1 - value[V]; // v goes up in PLY
    }
    for (int k = 0; p->color && k < 4; k++)
        p->color[4 * v + (size_t)k] = fminf(fmaxf(value[RED + k], 0), 1);
    return true;
}

static bool has_all(const struct ply *p, int first, int last)
{
    for (int slot = first; slot <= last; slot++)
        if (!p->has[slot])
            return false;
    return true;
}

static bool allocate(struct ply *p, const struct glint_ply_element *e)
{
    struct glint_arena *arena = &p->model.scene->arena;
    for (uint32_t i = 0; i < e->properties; i++) {
        const int slot = slot_of(e->property[i].name);
        if (slot < SLOTS && !e->property[i].list)
            p->has[slot] = true;
    }
    if (!has_all(p, X, Z)) {
        glint_fail(p->model.err, GLINT_E_RANGE, "", "the vertices have no x, y and z");
        return false;
    }
    const size_t n = e->count;
    p->position = glint_arena_array(arena, n, 3 * sizeof(float));
    p->normal = has_all(p, NX, NZ) ? glint_arena_array(arena, n, 3 * sizeof(float)) : NULL;
    p->uv = has_all(p, U, V) ? glint_arena_array(arena, n, 2 * sizeof(float)) : NULL;
    p->color = has_all(p, RED, BLUE) ? glint_arena_array(arena, n, 4 * sizeof(float)) : NULL;
    return (p->position && (p->normal || !has_all(p, NX, NZ)) && (p->uv || !has_all(p, U, V)) &&
            (p->color || !has_all(p, RED, BLUE))) ||
           glint_model_nomem(&p->model);
}

// ---- faces and strips

static bool read_corner(struct ply *p, enum glint_ply_type type, bool strip)
{
    double value;
    if (!read_value(p, type, &value))
        return false;
    const bool restart = strip && value == -1;
    if (!restart && !(value >= 0 && value < p->vertices && value == floor(value)))
        return fault(p, GLINT_E_RANGE, "vertex %g of %u", value, p->vertices);
    if (!glint_model_grow(&p->model, (void **)&p->corner, p->corners, &p->corner_capacity,
                          sizeof *p->corner))
        return false;
    p->corner[p->corners++] = restart ? GLINT_NONE : (uint32_t)value;
    return true;
}

static bool add_triangle(struct ply *p, uint32_t a, uint32_t b, uint32_t c)
{
    if (!glint_model_grow(&p->model, (void **)&p->triangle, p->triangles, &p->triangle_capacity,
                          sizeof *p->triangle))
        return false;
    const uint32_t corner[3] = {a, b, c};
    memcpy(p->triangle[p->triangles++], corner, sizeof corner);
    return true;
}

static bool add_face(struct ply *p)
{
    const uint32_t n = p->corners;
    p->thin += n < 3;
    if (n < 3)
        return true;
    if (n == 3)
        return add_triangle(p, p->corner[0], p->corner[1], p->corner[2]);
    while (p->cut_capacity < n)
        if (!glint_model_grow(&p->model, (void **)&p->cut, p->cut_capacity, &p->cut_capacity,
                              sizeof *p->cut))
            return false;
    while (p->point_capacity < n)
        if (!glint_model_grow(&p->model, (void **)&p->point, p->point_capacity, &p->point_capacity,
                              sizeof *p->point))
            return false;
    for (uint32_t i = 0; i < n; i++)
        memcpy(p->point[i], p->position + 3 * (size_t)p->corner[i], sizeof *p->point);
    glint_polygon_cut(p->point, n, p->cut);
    for (uint32_t i = 0; i + 2 < n; i++)
        if (!add_triangle(p, p->corner[p->cut[i][0]], p->corner[p->cut[i][1]],
                          p->corner[p->cut[i][2]]))
            return false;
    return true;
}

// Every second triangle of a strip turns the other way; -1 starts a new one.
static bool add_strips(struct ply *p)
{
    uint32_t first = 0;
    for (uint32_t i = 0; i < p->corners; i++) {
        if (p->corner[i] == GLINT_NONE) {
            first = i + 1;
            continue;
        }
        if (i < first + 2)
            continue;
        const bool odd = (i - first) % 2;
        if (!add_triangle(p, p->corner[i - 2], p->corner[odd ? i : i - 1],
                          p->corner[odd ? i - 1 : i]))
            return false;
    }
    return true;
}

static bool read_polygon(struct ply *p, const struct glint_ply_element *e, bool strip)
{
    p->corners = 0;
    for (uint32_t i = 0; i < e->properties; i++) {
        const struct glint_ply_property *property = &e->property[i];
        uint32_t count;
        if (!property->list || !(glint_word_is(property->name, "vertex_indices") ||
                                 glint_word_is(property->name, "vertex_index"))) {
            if (!skip(p, property))
                return false;
            continue;
        }
        if (!read_length(p, property, &count))
            return false;
        while (count--)
            if (!read_corner(p, property->type, strip))
                return false;
    }
    return strip ? add_strips(p) : add_face(p);
}

// ---- elements

enum kind { VERTEX, FACE, STRIPS, OTHER };

static bool skip_all(struct ply *p, const struct glint_ply_element *e)
{
    for (uint32_t i = 0; i < e->properties; i++)
        if (!skip(p, &e->property[i]))
            return false;
    return true;
}

static bool read_one(struct ply *p, const struct glint_ply_element *e, enum kind kind)
{
    switch (kind) {
    case VERTEX:
        return read_vertex(p, e);
    case FACE:
    case STRIPS:
        return read_polygon(p, e, kind == STRIPS);
    default:
        return skip_all(p, e);
    }
}

static enum kind kind_of(const struct glint_ply_element *e)
{
    return glint_word_is(e->name, "vertex")      ? VERTEX
           : glint_word_is(e->name, "face")      ? FACE
           : glint_word_is(e->name, "tristrips") ? STRIPS
                                                 : OTHER;
}

static bool begin_element(struct ply *p, const struct glint_ply_element *e, enum kind kind)
{
    if ((kind == FACE || kind == STRIPS) && !p->vertices)
        return fault(p, GLINT_E_RANGE, "there are no vertices before it");
    if (kind == VERTEX && p->position)
        return fault(p, GLINT_E_RANGE, "the vertices are given twice");
    return kind != VERTEX || allocate(p, e);
}

// Where one value is at fault the next element cannot be found: the first fault ends the file.
static bool read_element(struct ply *p, const struct glint_ply_element *e)
{
    const enum kind kind = kind_of(e);
    char name[64];
    snprintf(name, sizeof name, "%.*s", glint_word_shown(e->name), e->name.text);
    p->element = name;
    p->number = 0;
    if (!e->count)
        return true;
    if (!begin_element(p, e, kind))
        return false;
    for (; p->number < e->count; p->number++)
        if (!read_one(p, e, kind))
            return false;
    if (kind == VERTEX)
        p->vertices = e->count;
    return true;
}

// ---- to the scene

static void add_mesh(struct ply *p)
{
    struct glint_model *m = &p->model;
    if (!p->triangles) {
        glint_fail(m->err, GLINT_E_RANGE, "", "the file has no triangles: %u vertices, no faces",
                   p->vertices);
        return;
    }
    if (!glint_model_room(m, 1, 1, 1))
        return;
    const uint32_t material = glint_model_material(m, ""), object = glint_model_object(m, "");
    if (material == GLINT_NONE || object == GLINT_NONE)
        return;
    struct glint_mesh *mesh = glint_model_mesh(m, object, material, "");
    uint32_t *index = glint_arena_array(&m->scene->arena, p->triangles, sizeof *p->triangle);
    if (!mesh || !index) {
        glint_model_nomem(m);
        return;
    }
    memcpy(index, p->triangle, p->triangles * sizeof *p->triangle);
    mesh->vertices = p->vertices;
    mesh->triangles = p->triangles;
    mesh->position = p->position;
    mesh->normal = p->normal;
    mesh->uv = p->uv;
    mesh->color = p->color;
    mesh->index = index;
    if (p->normal)
        glint_model_clean_normals(mesh);
    if (p->color) // they are the surface's, not a tint of the default grey
        for (int k = 0; k < 3; k++)
            m->scene->material[material].base_color[k] = 1;
    if (p->thin)
        glint_scene_warn(m->scene, "%u faces of less than three corners are left out", p->thin);
}

static void read(struct ply *p, const uint8_t *bytes, size_t size)
{
    if (glint_ply_header_read(&p->header, bytes, size, p->model.err))
        return;
    const uint8_t *body = bytes + p->header.bytes;
    p->at = body;
    p->end = bytes + size;
    glint_words_start(&p->words, body, size - p->header.bytes, p->model.err);
    p->words.line = p->header.lines;
    for (uint32_t i = 0; i < p->header.elements; i++)
        if (!read_element(p, &p->header.element[i]))
            return;
    add_mesh(p);
}

glint_status glint_ply_import(struct glint_scene **out, const uint8_t *bytes, size_t size,
                              struct glint_error *err)
{
    struct ply p = {.element = ""};
    if (glint_model_start(&p.model, err))
        read(&p, bytes, size);
    free(p.triangle);
    free(p.corner);
    free(p.cut);
    free(p.point);
    return glint_model_finish(&p.model, out);
}
