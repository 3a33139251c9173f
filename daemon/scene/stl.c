// stl.c - STL, text and binary: triangles of three corners each, flat as the format means them.
//
// Stored normals are not read: they follow from the corners, and files have them wrong. Each solid
// of a text file is an object.
#include "scene/model.h"
#include "scene/words.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#define HEADER_BYTES 84u
#define TRIANGLE_BYTES 50u

struct solid {
    struct glint_word name;
    uint32_t first, count; // corners
};

struct stl {
    struct glint_model model;
    struct glint_words words;
    float (*corner)[3];
    uint32_t corners, corner_capacity;
    struct solid *solid;
    uint32_t solids, solid_capacity;
};

static uint32_t u32(const uint8_t *p)
{
    return p[0] | (uint32_t)p[1] << 8 | (uint32_t)p[2] << 16 | (uint32_t)p[3] << 24;
}

// ---- to the scene

static bool add_solid(struct stl *s, const struct solid *solid, uint32_t material)
{
    char name[256];
    const size_t length = solid->name.length < sizeof name ? solid->name.length : sizeof name - 1;
    memcpy(name, solid->name.text, length);
    name[length] = '\0';
    const uint32_t object = glint_model_object(&s->model, name);
    struct glint_mesh *mesh =
        object != GLINT_NONE ? glint_model_mesh(&s->model, object, material, name) : NULL;
    if (!mesh)
        return false;
    struct glint_arena *arena = &s->model.scene->arena;
    float *position = glint_arena_array(arena, solid->count, sizeof *s->corner);
    uint32_t *index = glint_arena_array(arena, solid->count, sizeof *index);
    if (!position || !index)
        return glint_model_nomem(&s->model);
    memcpy(position, s->corner + solid->first, solid->count * sizeof *s->corner);
    for (uint32_t i = 0; i < solid->count; i++)
        index[i] = i;
    mesh->position = position;
    mesh->index = index;
    mesh->vertices = solid->count;
    mesh->triangles = solid->count / 3;
    return true;
}

static void add_solids(struct stl *s)
{
    if (!s->corners) {
        glint_fail(s->model.err, GLINT_E_RANGE, "", "the file has no triangles");
        return;
    }
    if (!glint_model_room(&s->model, s->solids, s->solids, 1))
        return;
    const uint32_t material = glint_model_material(&s->model, "");
    for (uint32_t i = 0; material != GLINT_NONE && i < s->solids; i++)
        if (s->solid[i].count && !add_solid(s, &s->solid[i], material))
            return;
}

// ---- binary

static bool read_corners(struct stl *s, const uint8_t *at, uint32_t triangle)
{
    for (int k = 0; k < 9; k++) {
        const uint32_t bits = u32(at + 12 + 4 * k);
        float value;
        memcpy(&value, &bits, sizeof value);
        if (!(fabsf(value) <= GLINT_MAX_COORDINATE)) {
            glint_fail(s->model.err, GLINT_E_RANGE, "", "triangle %u: %g is outside of -%g to %g",
                       triangle, (double)value, (double)GLINT_MAX_COORDINATE,
                       (double)GLINT_MAX_COORDINATE);
            return false;
        }
        s->corner[3 * (size_t)triangle + (size_t)k / 3][k % 3] = value;
    }
    return true;
}

static void read_binary(struct stl *s, const uint8_t *bytes, uint32_t triangles)
{
    s->corner = malloc((size_t)triangles * 3 * sizeof *s->corner + 1);
    s->solid = calloc(1, sizeof *s->solid);
    if (!s->corner || !s->solid) {
        glint_model_nomem(&s->model);
        return;
    }
    bool coloured = false;
    const uint8_t *at = bytes + HEADER_BYTES;
    for (uint32_t i = 0; i < triangles; i++, at += TRIANGLE_BYTES) {
        if (!read_corners(s, at, i) && s->model.err->count >= GLINT_MAX_FAULTS)
            return;
        coloured |= at[48] || at[49];
    }
    if (coloured)
        glint_scene_warn(s->model.scene, "colours of triangles are ignored");
    s->corners = 3 * triangles;
    s->solids = 1;
    s->solid[0] = (struct solid){.name = {"", 0}, .count = s->corners};
}

// ---- text

static bool begin_solid(struct stl *s)
{
    if (!glint_model_grow(&s->model, (void **)&s->solid, s->solids, &s->solid_capacity,
                          sizeof *s->solid))
        return false;
    s->solid[s->solids++] =
        (struct solid){.name = glint_words_rest(&s->words), .first = s->corners};
    return true;
}

static bool read_vertex(struct stl *s)
{
    if (!s->solids && !begin_solid(s))
        return false;
    if (!glint_model_grow(&s->model, (void **)&s->corner, s->corners, &s->corner_capacity,
                          sizeof *s->corner))
        return false;
    if (!glint_words_floats(&s->words, 3, GLINT_MAX_COORDINATE, s->corner[s->corners]))
        return false;
    s->corners++;
    s->solid[s->solids - 1].count++;
    return true;
}

static void end_facet(struct stl *s)
{
    const uint32_t count = s->solids ? s->solid[s->solids - 1].count : 0;
    if (count % 3)
        glint_words_fault(&s->words, "the facet has %u corners, not 3", count % 3);
}

static void read_line(struct stl *s)
{
    static const char *const plain[] = {"facet", "outer", "endloop", "endsolid", "color"};
    const struct glint_word word = glint_words_next(&s->words);
    if (glint_word_is(word, "vertex")) {
        read_vertex(s);
    } else if (glint_word_is(word, "solid")) {
        begin_solid(s);
    } else if (glint_word_is(word, "endfacet")) {
        end_facet(s);
    } else if (word.length) {
        for (size_t i = 0; i < sizeof plain / sizeof *plain; i++)
            if (glint_word_is(word, plain[i]))
                return;
        glint_words_fault(&s->words, "\"%.*s\" is no word of STL", glint_word_shown(word),
                          word.text);
    }
}

static void read_text(struct stl *s, const uint8_t *bytes, size_t size)
{
    glint_words_start(&s->words, bytes, size, s->model.err);
    while (s->model.err->count < GLINT_MAX_FAULTS && s->model.err->status != GLINT_E_NOMEM &&
           glint_words_line(&s->words, false))
        read_line(s);
    if (!s->model.err->status && s->corners % 3)
        glint_fail(s->model.err, GLINT_E_SYNTAX, "", "the file ends inside a facet");
}

// Text begins with "solid", but so do many binary files, which the size gives away.
static void read(struct stl *s, const uint8_t *bytes, size_t size)
{
    const uint64_t triangles = size >= HEADER_BYTES ? u32(bytes + 80) : 0;
    const uint64_t wanted = HEADER_BYTES + triangles * TRIANGLE_BYTES;
    size_t blank = 0;
    while (blank < size && strchr(" \t\r\n", bytes[blank]) && bytes[blank])
        blank++;
    const bool solid = size - blank >= 5 &&
                       glint_word_is((struct glint_word){(const char *)bytes + blank, 5}, "solid");
    if (solid && (size < HEADER_BYTES || size != wanted))
        read_text(s, bytes, size);
    else if (size < HEADER_BYTES || size < wanted || triangles > GLINT_MAX_MESH_COUNT / 3)
        glint_fail(s->model.err, GLINT_E_SYNTAX, "",
                   "the file has %zu bytes; %llu triangles as its header says need %llu", size,
                   (unsigned long long)triangles, (unsigned long long)wanted);
    else
        read_binary(s, bytes, (uint32_t)triangles);
}

glint_status glint_stl_import(struct glint_scene **out, const uint8_t *bytes, size_t size,
                              struct glint_error *err)
{
    struct stl s = {0};
    if (glint_model_start(&s.model, err)) {
        read(&s, bytes, size);
        if (!err->status)
            add_solids(&s);
    }
    free(s.corner);
    free(s.solid);
    return glint_model_finish(&s.model, out);
}
