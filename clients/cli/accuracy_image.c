#include "accuracy_image.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define OTHERS (GLINT_ACCURACY_CHANNELS - 1)
#define MAX_IDS 4096

void glint_accuracy_image_finish(struct glint_accuracy_image *image)
{
    for (size_t i = 0; i < image->channels; i++)
        free(image->channel[i].plane);
    *image = (struct glint_accuracy_image){0};
}

static size_t pixels_of(const struct glint_accuracy_image *image)
{
    return (size_t)image->width * image->height;
}

// A zeroed plane, NULL without memory.
static float *add(struct glint_accuracy_image *image, const char *type, uint32_t id)
{
    float *plane = calloc(pixels_of(image), sizeof *plane);
    if (!plane)
        return NULL;
    const size_t i = image->channels++;
    snprintf(image->channel[i].type, sizeof image->channel[i].type, "%s", type);
    image->channel[i].id = id;
    return image->channel[i].plane = plane;
}

static glint_status no_memory(struct glint_error *err)
{
    return glint_fail(err, GLINT_E_NOMEM, "", "no memory for an image");
}

static glint_status take_colour(struct glint_accuracy_image *out, const struct glint_frame *frame,
                                struct glint_error *err)
{
    static const char *const names[] = {"R", "G", "B"};
    for (int c = 0; c < 3; c++) {
        const float *from = glint_frame_find(frame, names[c]);
        if (!from)
            return glint_fail(err, GLINT_E_RANGE, "", "the frame has no channel %s", names[c]);
        float *to = add(out, names[c], 0);
        if (!to)
            return no_memory(err);
        memcpy(to, from, pixels_of(out) * sizeof *to);
    }
    return GLINT_OK;
}

// ---- coverage

struct covered {
    char type[32];
    uint32_t id;
    double sum;
};

struct census {
    struct covered id[MAX_IDS];
    size_t ids;
};

// One rank of a Cryptomatte type of objects: its planes of IDs and coverage; false: it is none.
static bool rank_of(const struct glint_frame *frame, uint32_t channel, char type[32],
                    const float **id, const float **coverage)
{
    const char *name = frame->channel[channel].name;
    const size_t n = strlen(name);
    if (n < 5 || n > 31 || strncmp(name, "Crypto", 6) != 0 || name[n - 2] != '.' ||
        (name[n - 1] != 'R' && name[n - 1] != 'B'))
        return false;
    char other[32];
    memcpy(other, name, n + 1);
    other[n - 1] = name[n - 1] == 'R' ? 'G' : 'A';
    *id = frame->channel[channel].plane;
    *coverage = glint_frame_find(frame, other);
    memcpy(type, name, n - 4); // without the layer's digits
    type[n - 4] = '\0';
    return *coverage != NULL;
}

typedef void each_rank(void *user, const char *type, uint32_t id, size_t pixel, float coverage);

// Calls `each` for every rank of every pixel that covers something.
static void walk(const struct glint_frame *frame, each_rank *each, void *user)
{
    const size_t pixels = (size_t)frame->width * frame->height;
    for (uint32_t c = 0; c < frame->channels; c++) {
        char type[32];
        const float *id, *coverage;
        if (!rank_of(frame, c, type, &id, &coverage))
            continue;
        for (size_t p = 0; p < pixels; p++) {
            uint32_t bits;
            memcpy(&bits, &id[p], sizeof bits);
            if (coverage[p] != 0)
                each(user, type, bits, p, coverage[p]);
        }
    }
}

static struct covered *count(struct census *census, const char *type, uint32_t id)
{
    for (size_t i = 0; i < census->ids; i++)
        if (census->id[i].id == id && strcmp(census->id[i].type, type) == 0)
            return &census->id[i];
    if (census->ids == MAX_IDS)
        return NULL;
    struct covered *c = &census->id[census->ids++];
    snprintf(c->type, sizeof c->type, "%s", type);
    c->id = id;
    return c;
}

static void tally(void *user, const char *type, uint32_t id, size_t pixel, float coverage)
{
    struct covered *c = count(user, type, id);
    (void)pixel;
    if (c)
        c->sum += coverage;
}

static int more(const void *a, const void *b)
{
    const struct covered *x = a, *y = b;
    if (x->sum != y->sum)
        return (x->sum < y->sum) - (x->sum > y->sum);
    return x->id != y->id ? (x->id > y->id) - (x->id < y->id) : strcmp(x->type, y->type);
}

static size_t channel_of(const struct glint_accuracy_image *image, const char *type, uint32_t id)
{
    size_t i = 0;
    while (i + 1 < image->channels &&
           (image->channel[i].id != id || strcmp(image->channel[i].type, type) != 0))
        i++;
    return i; // the last: the others
}

static void deposit(void *user, const char *type, uint32_t id, size_t pixel, float coverage)
{
    struct glint_accuracy_image *image = user;
    image->channel[channel_of(image, type, id)].plane[pixel] += coverage;
}

static glint_status take_mattes(struct glint_accuracy_image *out, const struct glint_frame *frame,
                                struct glint_error *err)
{
    struct census *census = calloc(1, sizeof *census);
    if (!census)
        return no_memory(err);
    walk(frame, tally, census);
    qsort(census->id, census->ids, sizeof *census->id, more);
    glint_status st = GLINT_OK;
    for (size_t i = 0; i < census->ids && i < OTHERS && !st; i++)
        if (!add(out, census->id[i].type, census->id[i].id))
            st = no_memory(err);
    free(census);
    if (!st && !add(out, "others", 0))
        st = no_memory(err);
    if (!st)
        walk(frame, deposit, out);
    return st;
}

glint_status glint_accuracy_image_take(struct glint_accuracy_image *out,
                                       const struct glint_frame *frame, bool matte,
                                       struct glint_error *err)
{
    *out = (struct glint_accuracy_image){.width = frame->width, .height = frame->height};
    const glint_status st = matte ? take_mattes(out, frame, err) : take_colour(out, frame, err);
    if (st)
        glint_accuracy_image_finish(out);
    return st;
}

glint_status glint_accuracy_image_like(struct glint_accuracy_image *out,
                                       const struct glint_accuracy_image *like,
                                       struct glint_error *err)
{
    *out = (struct glint_accuracy_image){.width = like->width, .height = like->height};
    for (size_t i = 0; i < like->channels; i++)
        if (!add(out, like->channel[i].type, like->channel[i].id)) {
            glint_accuracy_image_finish(out);
            return no_memory(err);
        }
    return GLINT_OK;
}

#define GLOSS "CryptoGloss"

static bool has_gloss(const struct glint_accuracy_image *image)
{
    for (size_t i = 0; i < image->channels; i++)
        if (strncmp(image->channel[i].type, GLOSS, strlen(GLOSS)) == 0)
            return true;
    return false;
}

static void add_plane(struct glint_accuracy_image *to, const char *type, uint32_t id,
                      const float *plane)
{
    float *sum = to->channel[channel_of(to, type, id)].plane;
    for (size_t p = 0; p < pixels_of(to); p++)
        sum[p] += plane[p];
}

// Who has no coverage through reflections takes what is seen directly for it.
static void add_directly_seen(struct glint_accuracy_image *to,
                              const struct glint_accuracy_image *from)
{
    char type[48];
    for (size_t i = 0; i + 1 < from->channels; i++) { // the last: the others
        snprintf(type, sizeof type, GLOSS "%s", from->channel[i].type + strlen("Crypto"));
        add_plane(to, type, from->channel[i].id, from->channel[i].plane);
    }
}

glint_status glint_accuracy_image_align(struct glint_accuracy_image *image,
                                        const struct glint_accuracy_image *like,
                                        struct glint_error *err)
{
    struct glint_accuracy_image to;
    if (image->width != like->width || image->height != like->height)
        return glint_fail(err, GLINT_E_RANGE, "", "a frame of %u x %u pixels instead of %u x %u",
                          image->width, image->height, like->width, like->height);
    glint_status st = glint_accuracy_image_like(&to, like, err);
    if (st)
        return st;
    for (size_t i = 0; i < image->channels; i++)
        add_plane(&to, image->channel[i].type, image->channel[i].id, image->channel[i].plane);
    if (has_gloss(like) && !has_gloss(image))
        add_directly_seen(&to, image);
    glint_accuracy_image_finish(image);
    *image = to;
    return GLINT_OK;
}
