#include "scene/ply_header.h"

#include <stdarg.h>
#include <stdio.h>
#include <string.h>

struct reader {
    struct glint_ply_header *out;
    struct glint_words words;
    bool formatted, ended;
};

__attribute__((format(printf, 2, 3))) static bool refuse(struct reader *r, const char *format, ...)
{
    char text[300];
    va_list args;
    va_start(args, format);
    vsnprintf(text, sizeof text, format, args);
    va_end(args);
    glint_fail(r->words.err, GLINT_E_SYNTAX, "", "line %u: %s", r->words.line, text);
    return false;
}

uint32_t glint_ply_size(enum glint_ply_type type)
{
    static const uint32_t size[] = {1, 1, 2, 2, 4, 4, 4, 8};
    return size[type];
}

static bool read_format(struct reader *r)
{
    static const char *const name[] = {"ascii", "binary_little_endian", "binary_big_endian"};
    const struct glint_word word = glint_words_next(&r->words);
    for (int i = 0; i < 3; i++)
        if (glint_word_is(word, name[i])) {
            r->out->format = (enum glint_ply_format)i;
            r->formatted = true;
            return true;
        }
    return refuse(r, "\"%.*s\" is no format of PLY", glint_word_shown(word), word.text);
}

static bool read_type(struct reader *r, enum glint_ply_type *out)
{
    static const char *const name[][2] = {
        {"char", "int8"}, {"uchar", "uint8"}, {"short", "int16"},   {"ushort", "uint16"},
        {"int", "int32"}, {"uint", "uint32"}, {"float", "float32"}, {"double", "float64"}};
    const struct glint_word word = glint_words_next(&r->words);
    for (int i = 0; i < 8; i++)
        if (glint_word_is(word, name[i][0]) || glint_word_is(word, name[i][1])) {
            *out = (enum glint_ply_type)i;
            return true;
        }
    return refuse(r, "\"%.*s\" is no type of PLY", glint_word_shown(word), word.text);
}

static bool read_element(struct reader *r)
{
    if (r->out->elements == GLINT_PLY_ELEMENTS)
        return refuse(r, "more than %u elements", GLINT_PLY_ELEMENTS);
    struct glint_ply_element *e = &r->out->element[r->out->elements++];
    e->name = glint_words_next(&r->words);
    const struct glint_word word = glint_words_next(&r->words);
    int64_t count;
    if (!glint_word_integer(word, 0, UINT32_MAX, &count))
        return refuse(r, "\"%.*s\" is no number of elements", glint_word_shown(word), word.text);
    e->count = (uint32_t)count;
    return true;
}

static bool read_property(struct reader *r)
{
    struct glint_ply_element *e = r->out->elements ? &r->out->element[r->out->elements - 1] : NULL;
    if (!e)
        return refuse(r, "a property before any element");
    if (e->properties == GLINT_PLY_PROPERTIES)
        return refuse(r, "more than %u properties", GLINT_PLY_PROPERTIES);
    struct glint_ply_property *p = &e->property[e->properties++];
    const struct glint_words before = r->words;
    p->list = glint_word_is(glint_words_next(&r->words), "list");
    if (!p->list)
        r->words = before;
    else if (!read_type(r, &p->count))
        return false;
    if (p->list && p->count >= GLINT_PLY_F32)
        return refuse(r, "the length of a list is no whole number");
    if (!read_type(r, &p->type))
        return false;
    p->name = glint_words_next(&r->words);
    return p->name.length != 0 || refuse(r, "the property has no name");
}

static bool read_line(struct reader *r)
{
    const struct glint_word word = glint_words_next(&r->words);
    if (!word.length || glint_word_is(word, "comment") || glint_word_is(word, "obj_info"))
        return true;
    if (glint_word_is(word, "format"))
        return read_format(r);
    if (glint_word_is(word, "element"))
        return read_element(r);
    if (glint_word_is(word, "property"))
        return read_property(r);
    r->ended = glint_word_is(word, "end_header");
    return r->ended ||
           refuse(r, "\"%.*s\" is no word of a PLY header", glint_word_shown(word), word.text);
}

// The fewest bytes that an element can take: a list may be empty, a number in text is a digit and
// what separates it.
static uint64_t least_bytes(const struct glint_ply_header *h, const struct glint_ply_element *e)
{
    uint64_t bytes = 0;
    for (uint32_t i = 0; i < e->properties; i++)
        bytes += h->format == GLINT_PLY_TEXT ? 2
                 : e->property[i].list       ? glint_ply_size(e->property[i].count)
                                             : glint_ply_size(e->property[i].type);
    return bytes;
}

static bool check_counts(struct reader *r, size_t size)
{
    const struct glint_ply_header *h = r->out;
    const uint64_t left = size - h->bytes + (h->format == GLINT_PLY_TEXT); // no last line break
    uint64_t wanted = 0;
    for (uint32_t i = 0; i < h->elements; i++) {
        const struct glint_ply_element *e = &h->element[i];
        wanted += e->count * least_bytes(h, e);
        if (wanted <= left)
            continue;
        glint_fail(r->words.err, GLINT_E_SYNTAX, "",
                   "the file is too short for %u elements \"%.*s\": they need %llu bytes or more, "
                   "%zu are left after the header",
                   e->count, glint_word_shown(e->name), e->name.text, (unsigned long long)wanted,
                   size - h->bytes);
        return false;
    }
    return true;
}

static bool read(struct reader *r, const uint8_t *bytes, size_t size)
{
    if (!glint_words_line(&r->words, false) || !glint_word_is(glint_words_next(&r->words), "ply")) {
        glint_fail(r->words.err, GLINT_E_SYNTAX, "", "the file does not start with \"ply\"");
        return false;
    }
    while (!r->ended)
        if (!glint_words_line(&r->words, false))
            return refuse(r, "the file ends inside its header");
        else if (!read_line(r))
            return false;
    if (!r->formatted)
        return refuse(r, "the header names no format");
    r->out->bytes = (size_t)(r->words.next - (const char *)bytes);
    r->out->lines = r->words.line;
    return check_counts(r, size);
}

glint_status glint_ply_header_read(struct glint_ply_header *out, const uint8_t *bytes, size_t size,
                                   struct glint_error *err)
{
    struct reader r = {.out = out};
    memset(out, 0, sizeof *out);
    glint_words_start(&r.words, bytes, size, err);
    return read(&r, bytes, size) ? GLINT_OK : err->status;
}
