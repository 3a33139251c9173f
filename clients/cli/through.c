#include "through.h"

#include "protocol/cryptomatte.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static const struct {
    const char *name, *infix;
    bool apart; // holds nothing of what is seen directly
} classes[] = {
    {"primary", "", false},       {"glossy", "Gloss", false}, {"reflection", "Refl", true},
    {"refraction", "Refr", true}, {"depth0", "D0", false},    {"depth1", "D1", false},
    {"depth2", "D2", false},      {"depth3", "D3", false},    {"depth4", "D4", false},
    {"depth5", "D5", false},      {"depth6", "D6", false},    {"depth7", "D7", false},
    {"depth8", "D8", false},      {"depth9", "D9", false},
};
#define CLASSES (sizeof classes / sizeof *classes)

static size_t find(const char *name, size_t length)
{
    size_t i = 0;
    while (i < CLASSES &&
           (strlen(classes[i].name) != length || strncmp(classes[i].name, name, length)))
        i++;
    return i;
}

// What one class covers, added where it is another kind of light than before.
struct sums {
    float *direct, *bounced, *apart; // [pixels]
    float *one;
    size_t pixels;
};

static void add(struct sums *s, size_t class_index)
{
    float *to = classes[class_index].apart ? s->apart : class_index ? s->bounced : s->direct;
    for (size_t p = 0; p < s->pixels; p++)
        to[p] += s->one[p];
}

static glint_status add_class(const struct glint_frame *frame, const char *type, const char *name,
                              size_t length, uint32_t id, struct sums *s, struct glint_error *err)
{
    char bounced[40];
    const size_t i = find(name, length);
    if (i == CLASSES)
        return glint_fail(err, GLINT_E_NOT_FOUND, "", "--through knows no class '%.*s'",
                          (int)(length < 40 ? length : 40), name);
    if (i > 0 && strncmp(type, "Crypto", 6))
        return glint_fail(err, GLINT_E_NOT_FOUND, "", "%s has no mattes through bounces", type);
    snprintf(bounced, sizeof bounced, "Crypto%s%.20s", classes[i].infix, type + 6);
    const glint_status st = glint_cryptomatte_matte(frame, i ? bounced : type, &id, 1, s->one, err);
    if (!st)
        add(s, i);
    return st;
}

static void unite(const struct sums *s, float *plane)
{
    for (size_t p = 0; p < s->pixels; p++)
        plane[p] = fminf(fmaxf(s->direct[p], s->bounced[p]) + s->apart[p], 1.0f);
}

glint_status glint_through_matte(const struct glint_frame *frame, const char *type,
                                 const char *through, uint32_t id, float *plane,
                                 struct glint_error *err)
{
    const size_t pixels = (size_t)frame->width * frame->height;
    float *block = calloc(pixels, 4 * sizeof *block);
    if (!block)
        return glint_fail(err, GLINT_E_NOMEM, "", "no memory for a matte");
    struct sums s = {block, block + pixels, block + 2 * pixels, block + 3 * pixels, pixels};
    glint_status st = GLINT_OK;
    for (const char *at = through ? through : "primary"; at;) {
        const size_t length = strcspn(at, ",");
        const glint_status one = add_class(frame, type, at, length, id, &s, err);
        st = st ? st : one;
        at = at[length] ? at + length + 1 : NULL;
    }
    unite(&s, plane);
    free(block);
    return st;
}
