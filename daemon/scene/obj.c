// obj.c - the lines of an OBJ file.
//
// Polygons are cut into triangles, `o` and `g` name objects, `usemtl` names materials; `s` smooths
// what has no normals. Free-form curves and surfaces are not read.
#include "protocol/utf8.h"
#include "scene/obj_file.h"
#include "scene/polygon.h"

#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define MAX_NAME 1000  // bytes that are kept
#define MAX_UNKNOWN 8u // warnings of words that nobody knows

void glint_obj_warn(struct glint_obj *o, const char *format, ...)
{
    char text[600];
    va_list args;
    va_start(args, format);
    vsnprintf(text, sizeof text, format, args);
    va_end(args);
    glint_utf8_clean(text);
    glint_scene_warn(o->model.scene, "%s", text);
}

// ---- lists

uint32_t glint_obj_list_add(struct glint_obj *o, struct glint_obj_list *list,
                            struct glint_word word)
{
    const int length = word.length < MAX_NAME ? (int)word.length : MAX_NAME;
    char *name = glint_arena_print(&o->scratch, "%.*s", length, word.text);
    uint32_t *number = name ? glint_gltf_names_at(&list->index, &o->scratch, name) : NULL;
    if (!number) {
        glint_model_nomem(&o->model);
        return GLINT_NONE;
    }
    if (*number)
        return *number - 1;
    if (!glint_model_grow(&o->model, (void **)&list->name, list->count, &list->capacity,
                          sizeof *list->name))
        return GLINT_NONE;
    list->name[list->count] = name;
    *number = ++list->count;
    return list->count - 1;
}

static bool find_part(struct glint_obj *o)
{
    if (o->current != GLINT_NONE)
        return true;
    char key[32];
    snprintf(key, sizeof key, "%u %u", o->object, o->material);
    uint32_t *number = glint_gltf_names_at(&o->part_index, &o->scratch, key);
    if (!number)
        return glint_model_nomem(&o->model);
    if (!*number) {
        if (!glint_model_grow(&o->model, (void **)&o->part, o->parts, &o->part_capacity,
                              sizeof *o->part))
            return false;
        o->part[o->parts] = (struct glint_obj_part){o->object, o->material, 0};
        *number = ++o->parts;
    }
    o->current = *number - 1;
    return true;
}

// ---- vertices

// Numbers that end in what is none are taken for what they begin with; programs write such things.
static bool read_numbers(struct glint_obj *o, uint32_t least, uint32_t most, float *out,
                         uint32_t *count)
{
    struct glint_word word;
    for (*count = 0; *count < most && (word = glint_words_next(&o->words)).length; ++*count) {
        double value = 0;
        const size_t used = glint_word_number(word, &value);
        if (!used)
            return glint_words_fault(&o->words, "\"%.*s\" is no number", glint_word_shown(word),
                                     word.text);
        if (!(fabs(value) <= (double)GLINT_MAX_COORDINATE))
            return glint_words_fault(&o->words, "%.*s is outside of -%g to %g",
                                     glint_word_shown(word), word.text,
                                     (double)GLINT_MAX_COORDINATE, (double)GLINT_MAX_COORDINATE);
        out[*count] = (float)value;
    }
    return *count >= least ||
           glint_words_fault(&o->words, "%u numbers are expected, %u are there", least, *count);
}

static bool append(struct glint_obj *o, struct glint_obj_floats *to, uint32_t width,
                   const float *value)
{
    if (!glint_model_grow(&o->model, (void **)&to->value, to->count, &to->capacity,
                          width * sizeof *value))
        return false;
    memcpy(to->value + (size_t)to->count++ * width, value, width * sizeof *value);
    return true;
}

// x y z, x y z w, x y z r g b or x y z w r g b. The weight matters to free-form surfaces only.
static void read_position(struct glint_obj *o)
{
    float value[7] = {0}, color[4] = {1, 1, 1, 1};
    uint32_t count;
    read_numbers(o, 3, 7, value, &count); // after a fault it still has its number
    const bool colored = count >= 6;
    for (int k = 0; colored && k < 3; k++)
        color[k] = glint_model_linear(fminf(fmaxf(value[count - 3 + (uint32_t)k], 0), 1));
    o->has_color |= colored;
    if (append(o, &o->position, 3, value))
        append(o, &o->color, 4, color);
}

static void read_uv(struct glint_obj *o)
{
    float value[3] = {0};
    uint32_t count;
    read_numbers(o, 1, 3, value, &count);
    value[1] = 1 - value[1]; // v goes up in OBJ
    append(o, &o->uv, 2, value);
}

static void read_normal(struct glint_obj *o)
{
    float value[3] = {0};
    uint32_t count;
    read_numbers(o, 3, 3, value, &count);
    append(o, &o->normal, 3, value);
}

// ---- faces

// One number of "v/vt/vn": from 1, or from the last one back. Empty: none.
static bool read_index(struct glint_obj *o, struct glint_word word, const char *what,
                       uint32_t so_far, uint32_t all, uint32_t *out)
{
    int64_t number;
    *out = GLINT_NONE;
    if (!word.length)
        return true;
    if (!glint_word_integer(word, -(int64_t)UINT32_MAX, UINT32_MAX, &number) || !number)
        return glint_words_fault(&o->words, "\"%.*s\" is no number of a %s", glint_word_shown(word),
                                 word.text, what);
    const int64_t index = number > 0 ? number - 1 : so_far + number;
    if (index < 0 || index >= all)
        return glint_words_fault(&o->words, "%s %lld: the file has %u, %u of them before this line",
                                 what, (long long)number, all, so_far);
    *out = (uint32_t)index;
    return true;
}

static struct glint_word split(struct glint_word *rest)
{
    const char *slash = memchr(rest->text, '/', rest->length);
    const size_t length = slash ? (size_t)(slash - rest->text) : rest->length;
    const struct glint_word first = {rest->text, length};
    const size_t skip = slash ? length + 1 : length;
    *rest = (struct glint_word){rest->text + skip, rest->length - skip};
    return first;
}

static bool read_corner(struct glint_obj *o, struct glint_word word)
{
    struct glint_obj_corner c;
    struct glint_word rest = word;
    const struct glint_word v = split(&rest), vt = split(&rest), vn = split(&rest);
    if (!v.length || rest.length)
        return glint_words_fault(&o->words, "\"%.*s\" is no corner of a face",
                                 glint_word_shown(word), word.text);
    bool fine = read_index(o, v, "vertex", o->position.count, o->positions, &c.position);
    fine &= read_index(o, vt, "texture coordinate", o->uv.count, o->uvs, &c.uv);
    fine &= read_index(o, vn, "normal", o->normal.count, o->normals, &c.normal);
    if (!fine || !glint_model_grow(&o->model, (void **)&o->corner, o->corners, &o->corner_capacity,
                                   sizeof *o->corner))
        return false;
    o->corner[o->corners++] = c;
    return true;
}

static bool add_triangle(struct glint_obj *o, const uint32_t number[3])
{
    if (!glint_model_grow(&o->model, (void **)&o->triangle, o->triangles, &o->triangle_capacity,
                          sizeof *o->triangle))
        return false;
    struct glint_obj_triangle *t = &o->triangle[o->triangles++];
    t->part = o->current;
    t->smooth = o->smooth;
    for (int i = 0; i < 3; i++)
        t->corner[i] = o->corner[number[i]];
    o->part[o->current].triangles++;
    return true;
}

static bool make_room(struct glint_obj *o, uint32_t corners)
{
    while (o->point_capacity < corners)
        if (!glint_model_grow(&o->model, (void **)&o->point, o->point_capacity, &o->point_capacity,
                              sizeof *o->point))
            return false;
    while (o->cut_capacity < corners)
        if (!glint_model_grow(&o->model, (void **)&o->cut, o->cut_capacity, &o->cut_capacity,
                              sizeof *o->cut))
            return false;
    return true;
}

// A position that comes later in the file is not known yet; then the polygon becomes a fan.
static bool cut(struct glint_obj *o)
{
    if (!make_room(o, o->corners))
        return false;
    memset(o->point, 0, o->corners * sizeof *o->point);
    for (uint32_t i = 0; i < o->corners; i++)
        if (o->corner[i].position < o->position.count)
            memcpy(o->point[i], o->position.value + 3 * (size_t)o->corner[i].position,
                   sizeof *o->point);
    glint_polygon_cut(o->point, o->corners, o->cut);
    for (uint32_t i = 0; i + 2 < o->corners; i++)
        if (!add_triangle(o, o->cut[i]))
            return false;
    return true;
}

static void read_face(struct glint_obj *o)
{
    struct glint_word word;
    o->corners = 0;
    while ((word = glint_words_next(&o->words)).length)
        if (!read_corner(o, word))
            return;
    if (o->corners < 3)
        o->left_out++;
    else if (find_part(o))
        cut(o);
}

// ---- the state

static void read_object(struct glint_obj *o)
{
    o->object = glint_obj_list_add(o, &o->objects, glint_words_rest(&o->words));
    o->current = GLINT_NONE;
}

static void read_material(struct glint_obj *o)
{
    o->material = glint_obj_list_add(o, &o->materials, glint_words_rest(&o->words));
    o->current = GLINT_NONE;
}

static void read_smoothing(struct glint_obj *o)
{
    const struct glint_word word = glint_words_next(&o->words);
    int64_t group = 0;
    o->smooth = 0;
    if (glint_word_is(word, "on"))
        o->smooth = 1;
    else if (glint_word_integer(word, 0, UINT32_MAX, &group))
        o->smooth = (uint32_t)group;
}

static void read_library(struct glint_obj *o)
{
    glint_obj_list_add(o, &o->libraries, glint_words_rest(&o->words));
}

static void leave_out(struct glint_obj *o)
{
    o->left_out++;
}

static void ignore(struct glint_obj *o)
{
    (void)o;
}

static const struct statement {
    const char *word;
    void (*read)(struct glint_obj *o);
} statements[] = {
    {"v", read_position},
    {"f", read_face},
    {"vt", read_uv},
    {"vn", read_normal},
    {"o", read_object},
    {"g", read_object},
    {"usemtl", read_material},
    {"mtllib", read_library},
    {"s", read_smoothing},
    {"l", leave_out},
    {"p", leave_out},
    {"vp", ignore},
    {"fo", read_face},
    {"mg", ignore},
    {"usemap", ignore},
    {"maplib", ignore},
    {"shadow_obj", ignore},
    {"trace_obj", ignore},
    {"lod", ignore},
    {"bevel", ignore},
    {"c_interp", ignore},
    {"d_interp", ignore},
    {"curv", leave_out},
    {"curv2", leave_out},
    {"surf", leave_out},
    {"parm", ignore},
    {"trim", ignore},
    {"hole", ignore},
    {"scrv", ignore},
    {"sp", ignore},
    {"end", ignore},
    {"con", ignore},
    {"cstype", ignore},
    {"deg", ignore},
    {"bmat", ignore},
    {"step", ignore},
    {"stech", ignore},
    {"ctech", ignore},
    {"call", leave_out},
    {"csh", leave_out},
    {NULL, NULL},
};

static void read_line(struct glint_obj *o)
{
    const struct glint_word word = glint_words_next(&o->words);
    if (!word.length || word.text[0] == '#')
        return;
    const struct statement *s = statements;
    while (s->word && !glint_word_is(word, s->word))
        s++;
    if (s->word)
        s->read(o);
    else if (o->unknown++ < MAX_UNKNOWN)
        glint_obj_warn(o, "line %u is left out: \"%.*s\" is no word of OBJ", o->words.line,
                       glint_word_shown(word), word.text);
}

// ---- the file

// How much there is in all: faces may name what comes after them.
static void count_vertices(struct glint_obj *o, const uint8_t *bytes, size_t size)
{
    struct glint_words w;
    glint_words_start(&w, bytes, size, o->model.err);
    while (glint_words_line(&w, true)) {
        const struct glint_word word = glint_words_next(&w);
        o->positions += glint_word_is(word, "v");
        o->uvs += glint_word_is(word, "vt");
        o->normals += glint_word_is(word, "vn");
    }
}

static void read(struct glint_obj *o, const uint8_t *bytes, size_t size)
{
    const struct glint_error *err = o->model.err;
    const struct glint_word none = {"", 0};
    count_vertices(o, bytes, size);
    o->current = GLINT_NONE;
    o->object = glint_obj_list_add(o, &o->objects, none);
    o->material = glint_obj_list_add(o, &o->materials, none);
    glint_words_start(&o->words, bytes, size, o->model.err);
    while (err->count < GLINT_MAX_FAULTS && err->status != GLINT_E_NOMEM &&
           glint_words_line(&o->words, true))
        read_line(o);
    if (!err->status && !o->triangles)
        glint_fail(o->model.err, GLINT_E_RANGE, "", "the file has no faces: %u vertices alone",
                   o->positions);
    if (!err->status)
        glint_obj_smooth(o);
    if (!err->status)
        glint_obj_read_materials(o);
    if (!err->status)
        glint_obj_make_meshes(o);
    if (!err->status && o->left_out)
        glint_scene_warn(o->model.scene,
                         "%u lines, points, curves and faces of less than three corners are left "
                         "out",
                         o->left_out);
}

static void list_finish(struct glint_obj_list *list)
{
    glint_gltf_names_finish(&list->index);
    free(list->name);
}

static void finish(struct glint_obj *o)
{
    list_finish(&o->objects);
    list_finish(&o->materials);
    list_finish(&o->libraries);
    glint_gltf_names_finish(&o->part_index);
    free(o->position.value);
    free(o->color.value);
    free(o->uv.value);
    free(o->normal.value);
    free(o->part);
    free(o->triangle);
    free(o->corner);
    free(o->point);
    free(o->cut);
    glint_arena_finish(&o->scratch);
}

glint_status glint_obj_import(struct glint_scene **out, const uint8_t *bytes, size_t size,
                              struct glint_files *files, struct glint_error *err)
{
    struct glint_obj o = {.files = files};
    if (glint_model_start(&o.model, err))
        read(&o, bytes, size);
    finish(&o);
    return glint_model_finish(&o.model, out);
}
