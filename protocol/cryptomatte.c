// cryptomatte.c - names to IDs, manifests and headers, ranks to mattes.
#include "protocol/cryptomatte.h"

#include "protocol/utf8.h"

#include <assert.h>
#include <ctype.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define TYPE_BYTES 27 // leaves room for two digits and a component in a channel's 31

// Source: Austin Appleby, MurmurHash3_x86_32 (public domain); blocks are read little-endian.
static uint32_t rotate(uint32_t x, int bits)
{
    return x << bits | x >> (32 - bits);
}

static uint32_t scramble(uint32_t k)
{
    return rotate(k * 0xcc9e2d51u, 15) * 0x1b873593u;
}

uint32_t glint_murmur3_32(const void *bytes, size_t length, uint32_t seed)
{
    const uint8_t *p = bytes;
    uint32_t h = seed;
    size_t left = length;
    for (; left >= 4; left -= 4, p += 4) {
        const uint32_t k = p[0] | p[1] << 8 | p[2] << 16 | (uint32_t)p[3] << 24;
        h = rotate(h ^ scramble(k), 13) * 5 + 0xe6546b64u;
    }
    uint32_t tail = 0;
    while (left)
        tail = tail << 8 | p[--left];
    h ^= scramble(tail) ^ (uint32_t)length;
    h = (h ^ h >> 16) * 0x85ebca6bu;
    h = (h ^ h >> 13) * 0xc2b2ae35u;
    return h ^ h >> 16;
}

uint32_t glint_cryptomatte_id(const char *name)
{
    const char *text = *name ? name : "default";
    const uint32_t h = glint_murmur3_32(text, strlen(text), 0);
    const uint32_t exponent = h >> 23 & 255;
    return exponent == 0 || exponent == 255 ? h ^ 1u << 23 : h;
}

void glint_cryptomatte_key(const char *type, char key[8])
{
    snprintf(key, 8, "%07x", glint_cryptomatte_id(type) >> 4);
}

static bool well_formed(const char *type)
{
    size_t i = 0;
    while (isalnum((unsigned char)type[i]) || type[i] == '_')
        i++;
    return isalpha((unsigned char)type[0]) && !type[i] && i <= TYPE_BYTES;
}

glint_status glint_cryptomatte_type_check(const char *const *types, size_t count,
                                          struct glint_error *err)
{
    glint_status st = GLINT_OK;
    for (size_t i = 0; i < count; i++) {
        if (!well_formed(types[i]))
            st = glint_fail(err, GLINT_E_RANGE, "",
                            "'%s' is no Cryptomatte type: a letter, then at "
                            "most %d letters, digits and underscores",
                            types[i], TYPE_BYTES - 1);
        for (size_t j = 0; j < count; j++)
            if (i != j && !strncmp(types[i], types[j], strlen(types[i])) &&
                (i < j || strcmp(types[i], types[j])))
                st = glint_fail(err, GLINT_E_RANGE, "",
                                "the Cryptomatte type '%s' is a prefix of "
                                "'%s': readers would mix the two",
                                types[i], types[j]);
    }
    return st;
}

static bool names_type(const struct glint_attribute *a)
{
    return a->kind == GLINT_ATTR_STRING && !strncmp(a->name, "cryptomatte/", 12) &&
           !strcmp(strrchr(a->name, '/'), "/name");
}

static bool holds_ranks_of(const char *channel, const char *type)
{
    const size_t length = strlen(type);
    if (strncmp(channel, type, length))
        return false;
    const size_t digits = strspn(channel + length, "0123456789");
    return digits >= 2 && channel[length + digits] == '.';
}

const struct glint_attribute *glint_cryptomatte_type_of(const struct glint_frame *frame,
                                                        const char *channel)
{
    for (uint32_t i = 0; i < frame->attributes; i++)
        if (names_type(&frame->attribute[i]) && holds_ranks_of(channel, frame->attribute[i].text))
            return &frame->attribute[i];
    return NULL;
}

glint_status glint_cryptomatte_check(const struct glint_frame *frame, struct glint_error *err)
{
    const char **types = malloc((frame->attributes + 1) * sizeof *types);
    if (!types)
        return glint_fail(err, GLINT_E_NOMEM, "", "no memory for a list of Cryptomatte types");
    size_t count = 0;
    for (uint32_t i = 0; i < frame->attributes; i++)
        if (names_type(&frame->attribute[i]))
            types[count++] = frame->attribute[i].text;
    glint_status st = glint_cryptomatte_type_check(types, count, err);
    free(types);
    return st;
}

// Manifest entries: what the manifest calls a name, and the ID of its own bytes.
struct entry {
    const char *name;
    uint32_t id;
};

static int by_name(const void *a, const void *b)
{
    return strcmp(((const struct entry *)a)->name, ((const struct entry *)b)->name);
}

static int by_id_then_name(const void *a, const void *b)
{
    const struct entry *x = a, *y = b;
    return x->id != y->id ? (x->id > y->id) - (x->id < y->id) : by_name(a, b);
}

static struct entry *entries(const char *const *names, size_t count)
{
    struct entry *list = malloc((count ? count : 1) * sizeof *list);
    for (size_t i = 0; list && i < count; i++)
        list[i] = (struct entry){*names[i] ? names[i] : "default", glint_cryptomatte_id(names[i])};
    return list;
}

// A JSON string (RFC 8259); bytes that are no UTF-8 become U+FFFD.
static void put_string(FILE *to, const char *text)
{
    putc('"', to);
    size_t left = strlen(text);
    while (left) {
        const unsigned char c = (unsigned char)*text;
        const size_t bytes = glint_utf8_sequence(text, left);
        if (!bytes)
            fputs("\xef\xbf\xbd", to);
        else if (c == '"' || c == '\\')
            fprintf(to, "\\%c", c);
        else if (c < 0x20)
            fprintf(to, "\\u%04x", c);
        else
            fwrite(text, 1, bytes, to);
        text += bytes ? bytes : 1;
        left -= bytes ? bytes : 1;
    }
    putc('"', to);
}

static void put_manifest(FILE *to, const struct entry *list, size_t count)
{
    putc('{', to);
    for (size_t i = 0; i < count; i++) {
        if (i && !strcmp(list[i].name, list[i - 1].name))
            continue;
        if (i)
            putc(',', to);
        put_string(to, list[i].name);
        fprintf(to, ":\"%08x\"", list[i].id);
    }
    putc('}', to);
}

char *glint_cryptomatte_manifest(const char *const *names, size_t count)
{
    struct entry *list = entries(names, count);
    if (!list)
        return NULL;
    qsort(list, count, sizeof *list, by_name);
    char *text = NULL;
    size_t length;
    FILE *to = open_memstream(&text, &length);
    if (to) {
        put_manifest(to, list, count);
        const bool complete = !ferror(to);
        if (fclose(to) || !complete) {
            free(text);
            text = NULL;
        }
    }
    free(list);
    return text;
}

glint_status glint_cryptomatte_clashes(const char *const *names, size_t count,
                                       struct glint_cryptomatte_clash **out, size_t *clashes)
{
    *out = NULL;
    *clashes = 0;
    struct entry *list = entries(names, count);
    struct glint_cryptomatte_clash *clash = malloc((count ? count : 1) * sizeof *clash);
    if (!list || !clash) {
        free(list);
        free(clash);
        return GLINT_E_NOMEM;
    }
    qsort(list, count, sizeof *list, by_id_then_name);
    for (size_t i = 1; i < count; i++)
        if (list[i].id == list[i - 1].id && strcmp(list[i].name, list[i - 1].name))
            clash[(*clashes)++] = (struct glint_cryptomatte_clash){list[i - 1].name, list[i].name};
    free(list);
    *out = clash;
    return GLINT_OK;
}

glint_status glint_cryptomatte_header(struct glint_frame *frame, const char *type,
                                      const char *manifest)
{
    char key[8];
    glint_cryptomatte_key(type, key);
    const struct {
        const char *name, *text;
    } row[] = {{"name", type},
               {"hash", "MurmurHash3_32"},
               {"conversion", "uint32_to_float32"},
               {"manifest", manifest}};
    for (size_t i = 0; i < sizeof row / sizeof *row; i++) {
        char name[32];
        snprintf(name, sizeof name, "cryptomatte/%s/%s", key, row[i].name);
        glint_status st = glint_frame_string(frame, name, row[i].text);
        if (st)
            return st;
    }
    return GLINT_OK;
}

static bool ranks_before(struct glint_cryptomatte_rank a, struct glint_cryptomatte_rank b)
{
    return a.coverage != b.coverage ? a.coverage > b.coverage : a.id < b.id;
}

void glint_cryptomatte_sort(struct glint_cryptomatte_rank *rank, size_t count)
{
    // Insertion: a pixel has a few ranks, mostly in order from the last snapshot.
    for (size_t i = 1; i < count; i++) {
        const struct glint_cryptomatte_rank moving = rank[i];
        size_t j = i;
        for (; j && ranks_before(moving, rank[j - 1]); j--)
            rank[j] = rank[j - 1];
        rank[j] = moving;
    }
}

static int compare_ids(const void *a, const void *b)
{
    const uint32_t x = *(const uint32_t *)a, y = *(const uint32_t *)b;
    return (x > y) - (x < y);
}

// The plane of component 0..3 of a layer under any of the spellings that writers use.
static const float *find_component(const struct glint_frame *frame, const char *type,
                                   unsigned layer, unsigned component)
{
    static const char *const spelling[4][3] = {
        {"R", "r", "red"}, {"G", "g", "green"}, {"B", "b", "blue"}, {"A", "a", "alpha"}};
    for (size_t i = 0; i < 3; i++) {
        char name[256];
        snprintf(name, sizeof name, "%s%02u.%s", type, layer, spelling[component][i]);
        const float *plane = glint_frame_find(frame, name);
        if (plane)
            return plane;
    }
    return NULL;
}

// Adds to `plane` the coverage of one rank where its ID is in the sorted set.
static void add_rank(const float *id, const float *coverage, size_t pixels, const uint32_t *set,
                     size_t count, float *plane)
{
    for (size_t i = 0; i < pixels; i++) {
        uint32_t bits;
        memcpy(&bits, &id[i], sizeof bits);
        if (bsearch(&bits, set, count, sizeof *set, compare_ids))
            plane[i] += coverage[i];
    }
}

glint_status glint_cryptomatte_matte(const struct glint_frame *frame, const char *type,
                                     const uint32_t *ids, size_t count, float *plane,
                                     struct glint_error *err)
{
    assert(frame && type && plane && (ids || !count));
    if (!find_component(frame, type, 0, 0) || !find_component(frame, type, 0, 1))
        return glint_fail(err, GLINT_E_NOT_FOUND, "", "the frame has no Cryptomatte '%s'", type);
    uint32_t *set = malloc((count ? count : 1) * sizeof *set);
    if (!set)
        return glint_fail(err, GLINT_E_NOMEM, "", "no memory for %zu IDs", count);
    if (count)
        memcpy(set, ids, count * sizeof *set);
    qsort(set, count, sizeof *set, compare_ids);
    const size_t pixels = (size_t)frame->width * frame->height;
    memset(plane, 0, pixels * sizeof *plane);
    for (unsigned rank = 0;; rank++) {
        const float *id = find_component(frame, type, rank / 2, rank % 2 * 2);
        const float *coverage = find_component(frame, type, rank / 2, rank % 2 * 2 + 1);
        if (!id || !coverage)
            break;
        add_rank(id, coverage, pixels, set, count, plane);
    }
    free(set);
    return GLINT_OK;
}
