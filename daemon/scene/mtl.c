// mtl.c - the lines of material libraries, and which library has the materials that are in use.
#include "scene/mtl.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#define MAX_VALUE 1e9f // of any number in a library

// ---- one statement

static bool read_color(struct glint_words *w, float out[3])
{
    struct glint_word word = glint_words_next(w);
    double value = 0;
    if (glint_word_is(word, "spectral") || glint_word_is(word, "xyz"))
        return true; // left as if it were not there
    for (int i = 0; i < 3; i++) {
        if (i && !word.length) { // one number stands for three
            out[i] = out[0];
            continue;
        }
        if (!glint_word_number(word, &value) || !(fabs(value) <= (double)MAX_VALUE))
            return glint_words_fault(w, "\"%.*s\" is no share of light", glint_word_shown(word),
                                     word.text);
        out[i] = (float)fmax(value, 0);
        word = glint_words_next(w);
    }
    return true;
}

static bool read_number(struct glint_words *w, float *out)
{
    struct glint_word word = glint_words_next(w);
    if (glint_word_is(word, "-halo"))
        word = glint_words_next(w);
    double value = 0;
    if (!glint_word_number(word, &value) || !(fabs(value) <= (double)MAX_VALUE))
        return glint_words_fault(w, "\"%.*s\" is no number", glint_word_shown(word), word.text);
    *out = (float)value;
    return true;
}

// Up to `most` numbers; what follows the last stays unread.
static void read_some(struct glint_words *w, int most, float *out)
{
    for (int i = 0; i < most; i++) {
        const struct glint_words before = *w;
        const struct glint_word word = glint_words_next(w);
        double value;
        if (!word.length || glint_word_number(word, &value) != word.length ||
            !(fabs(value) <= (double)MAX_VALUE)) {
            *w = before;
            return;
        }
        out[i] = (float)value;
    }
}

// False: the word is no option, but where the path begins.
static bool read_option(struct glint_words *w, struct glint_word word, struct glint_mtl_texture *t)
{
    static const char *const skipped[] = {"-blendu", "-blendv", "-cc",    "-imfchan",
                                          "-type",   "-texres", "-boost", "-t"};
    float offset[3] = {t->offset[0], t->offset[1]}, scale[3] = {t->scale[0], t->scale[1]};
    float two[3];
    if (glint_word_is(word, "-o")) {
        read_some(w, 3, offset);
        memcpy(t->offset, offset, sizeof t->offset);
    } else if (glint_word_is(word, "-s")) {
        read_some(w, 3, scale);
        memcpy(t->scale, scale, sizeof t->scale);
    } else if (glint_word_is(word, "-bm")) {
        read_some(w, 1, &t->bump);
    } else if (glint_word_is(word, "-mm")) {
        read_some(w, 2, two);
    } else if (glint_word_is(word, "-clamp")) {
        t->clamp = glint_word_is(glint_words_next(w), "on");
    } else {
        for (size_t i = 0; i < sizeof skipped / sizeof *skipped; i++)
            if (glint_word_is(word, skipped[i])) {
                if (i == 7)
                    read_some(w, 3, two);
                else
                    glint_words_next(w);
                return true;
            }
        return false;
    }
    return true;
}

// Options, then the path, which may have blanks in it.
static bool read_map(struct glint_obj *o, struct glint_words *w, struct glint_mtl_texture *t)
{
    *t = (struct glint_mtl_texture){.scale = {1, 1}, .bump = 1, .line = w->line};
    struct glint_words before;
    struct glint_word word;
    do {
        before = *w;
        word = glint_words_next(w);
    } while (word.length && word.text[0] == '-' && read_option(w, word, t));
    word = glint_words_rest(&before);
    if (!word.length)
        return glint_words_fault(w, "the map names no file");
    t->path = glint_arena_print(&o->scratch, "%.*s", word.length < 4000 ? (int)word.length : 4000,
                                word.text);
    return t->path != NULL || glint_model_nomem(&o->model);
}

// ---- a library

static const struct {
    const char *word;
    size_t offset; // of a float
    bool color;
} numbers[] = {
    {"Kd", offsetof(struct glint_mtl, kd), true},
    {"Ks", offsetof(struct glint_mtl, ks), true},
    {"Ke", offsetof(struct glint_mtl, ke), true},
    {"Tf", offsetof(struct glint_mtl, tf), true},
    {"Ns", offsetof(struct glint_mtl, ns), false},
    {"Ni", offsetof(struct glint_mtl, ni), false},
    {"d", offsetof(struct glint_mtl, d), false},
    {"Tr", offsetof(struct glint_mtl, tr), false},
    {"Pr", offsetof(struct glint_mtl, pr), false},
    {"Pm", offsetof(struct glint_mtl, pm), false},
    {"Pc", offsetof(struct glint_mtl, pc), false},
    {"Pcr", offsetof(struct glint_mtl, pcr), false},
    {"illum", offsetof(struct glint_mtl, illum), false},
};

static const struct {
    const char *word;
    enum glint_mtl_map map;
} maps[] = {
    {"map_Kd", GLINT_MTL_DIFFUSE},   {"map_d", GLINT_MTL_OPACITY},   {"map_Ke", GLINT_MTL_EMISSION},
    {"map_Pr", GLINT_MTL_ROUGHNESS}, {"map_Pm", GLINT_MTL_METALLIC}, {"norm", GLINT_MTL_NORMAL},
    {"map_Kn", GLINT_MTL_NORMAL},    {"map_Bump", GLINT_MTL_BUMP},   {"bump", GLINT_MTL_BUMP},
};

// What has no part in a picture, or none that this renderer could show.
static const char *const silent[] = {"Ka", "map_Ka", "sharpness", "map_aat", "aniso", "anisor"};

static bool read_statement(struct glint_obj *o, struct glint_words *w, struct glint_mtl *m,
                           struct glint_word word)
{
    for (size_t i = 0; i < sizeof numbers / sizeof *numbers; i++)
        if (glint_word_is(word, numbers[i].word)) {
            float *to = (float *)((char *)m + numbers[i].offset);
            return numbers[i].color ? read_color(w, to) : read_number(w, to);
        }
    for (size_t i = 0; i < sizeof maps / sizeof *maps; i++)
        if (glint_word_is(word, maps[i].word))
            return read_map(o, w, &m->map[maps[i].map]);
    for (size_t i = 0; i < sizeof silent / sizeof *silent; i++)
        if (glint_word_is(word, silent[i]))
            return true;
    if (o->unknown++ < 8)
        glint_obj_warn(o, "%s, line %u is left out: %.*s is not shown", w->file, w->line,
                       glint_word_shown(word), word.text);
    return true;
}

static struct glint_mtl *begin(struct glint_obj *o, struct glint_mtl_list *list,
                               const struct glint_words *w)
{
    if (!glint_model_grow(&o->model, (void **)&list->item, list->count, &list->capacity,
                          sizeof *list->item))
        return NULL;
    struct glint_mtl *m = &list->item[list->count++];
    *m = (struct glint_mtl){.name = glint_words_rest(w), .file = w->file};
    for (size_t i = 0; i < sizeof numbers / sizeof *numbers; i++)
        for (int k = 0; k < (numbers[i].color ? 3 : 1); k++)
            ((float *)((char *)m + numbers[i].offset))[k] = NAN;
    return m;
}

bool glint_mtl_read(struct glint_obj *o, struct glint_mtl_list *list, const struct glint_file *file)
{
    struct glint_words w;
    struct glint_mtl *m = NULL;
    glint_words_start(&w, file->bytes, file->size, o->model.err);
    w.file = file->name;
    while (o->model.err->count < GLINT_MAX_FAULTS && o->model.err->status != GLINT_E_NOMEM &&
           glint_words_line(&w, true)) {
        const struct glint_word word = glint_words_next(&w);
        if (!word.length || word.text[0] == '#')
            continue;
        if (glint_word_is(word, "newmtl"))
            m = begin(o, list, &w);
        else if (m)
            read_statement(o, &w, m, word);
        else
            glint_words_fault(&w, "%.*s comes before any newmtl", glint_word_shown(word),
                              word.text);
    }
    return !o->model.err->status;
}

// ---- the libraries of a file

// `names` may be one path with blanks in it or several paths.
static void read_library(struct glint_obj *o, struct glint_mtl_list *list, const char *names)
{
    struct glint_file *file = glint_files_find(o->files, names);
    if (file) {
        glint_mtl_read(o, list, file);
        return;
    }
    struct glint_words w;
    struct glint_word word;
    glint_words_start(&w, names, strlen(names), o->model.err);
    glint_words_line(&w, false);
    while ((word = glint_words_next(&w)).length) {
        const char *name = glint_arena_print(&o->scratch, "%.*s", (int)word.length, word.text);
        file = name ? glint_files_find(o->files, name) : NULL;
        if (file)
            glint_mtl_read(o, list, file);
        else if (o->files)
            glint_fail(o->model.err, GLINT_E_RANGE, "",
                       "the material library \"%.200s\" is not among the files", names);
        else
            glint_obj_warn(o,
                           "the material library \"%.200s\" is not here: send the files as "
                           "multipart/form-data",
                           names);
        if (!file)
            return;
    }
}

static void mark_maps(struct glint_obj *o, const struct glint_mtl *m)
{
    for (int i = 0; i < GLINT_MTL_MAPS; i++)
        if (m->map[i].path)
            glint_files_find(o->files, m->map[i].path);
}

static const struct glint_mtl *find(struct glint_obj *o, const struct glint_mtl_list *list,
                                    const char *name)
{
    const struct glint_word wanted = {name, strlen(name)};
    for (uint32_t i = 0; i < list->count; i++)
        if (glint_word_equal(list->item[i].name, wanted))
            return &list->item[i];
    if (*name)
        glint_obj_warn(o, "material \"%.200s\" is in no library; it is grey", name);
    return NULL;
}

static bool is_used(const struct glint_obj *o, uint32_t material)
{
    for (uint32_t i = 0; i < o->parts; i++)
        if (o->part[i].material == material)
            return true;
    return false;
}

static void make(struct glint_obj *o, const struct glint_mtl_list *list,
                 struct glint_mtl_images *images, uint32_t number)
{
    const char *name = o->materials.name[number];
    const struct glint_mtl *from = find(o, list, name);
    const uint32_t index = glint_model_material(&o->model, name);
    o->scene_material[number] = index;
    if (index == GLINT_NONE)
        return;
    struct glint_material *to = &o->model.scene->material[index];
    if (from) {
        glint_mtl_convert(o, from, to);
        glint_mtl_textures(images, from, to);
    } else if (o->has_color) { // the colours are the surface's, not a tint of grey
        for (int k = 0; k < 3; k++)
            to->base_color[k] = 1;
    }
}

static void make_all(struct glint_obj *o, const struct glint_mtl_list *list)
{
    struct glint_mtl_images images;
    if (glint_mtl_images_start(&images, o, o->materials.count))
        for (uint32_t i = 0; i < o->materials.count && o->model.err->status != GLINT_E_NOMEM; i++)
            if (is_used(o, i))
                make(o, list, &images, i);
    glint_mtl_images_finish(&images);
}

void glint_obj_read_materials(struct glint_obj *o)
{
    struct glint_mtl_list list = {0};
    for (uint32_t i = 0; i < o->libraries.count; i++)
        read_library(o, &list, o->libraries.name[i]);
    for (uint32_t i = 0; i < list.count; i++)
        mark_maps(o, &list.item[i]);
    o->scene_material =
        glint_arena_array(&o->scratch, o->materials.count, sizeof *o->scene_material);
    if (!o->scene_material)
        glint_model_nomem(&o->model);
    else if (glint_model_room(&o->model, o->objects.count, o->parts, o->materials.count))
        make_all(o, &list);
    free(list.item);
}
