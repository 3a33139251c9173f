#include "accuracy_mean.h"

#include "accuracy_files.h"

#include <stdio.h>
#include <string.h>

unsigned glint_accuracy_mean_count(const struct glint_accuracy_mean *mean)
{
    return (unsigned)__builtin_popcount(mean->seeds);
}

void glint_accuracy_mean_finish(struct glint_accuracy_mean *mean)
{
    glint_accuracy_image_finish(&mean->mean);
    glint_accuracy_image_finish(&mean->squares);
}

static size_t pixels_of(const struct glint_accuracy_mean *m)
{
    return (size_t)m->mean.width * m->mean.height;
}

// Copies the planes out of the frame; false: it has others.
static bool take(struct glint_accuracy_mean *out, const struct glint_frame *frame)
{
    const struct glint_attribute *seeds = glint_frame_attribute(frame, "glint/seeds");
    if (!seeds || seeds->kind != GLINT_ATTR_INT || frame->width != out->mean.width ||
        frame->height != out->mean.height)
        return false;
    for (size_t c = 0; c < out->mean.channels; c++) {
        char name[2][16];
        snprintf(name[0], sizeof name[0], "mean.%02zu", c);
        snprintf(name[1], sizeof name[1], "squares.%02zu", c);
        const float *mean = glint_frame_find(frame, name[0]);
        const float *squares = glint_frame_find(frame, name[1]);
        if (!mean || !squares)
            return false;
        memcpy(out->mean.channel[c].plane, mean, pixels_of(out) * sizeof *mean);
        memcpy(out->squares.channel[c].plane, squares, pixels_of(out) * sizeof *squares);
    }
    out->seeds = (uint32_t)seeds->integer;
    return true;
}

glint_status glint_accuracy_mean_load(struct glint_accuracy_mean *out, const char *folder,
                                      const char *name, const struct glint_accuracy_image *like,
                                      struct glint_error *err)
{
    struct glint_frame *frame;
    *out = (struct glint_accuracy_mean){0};
    glint_status st = glint_accuracy_load_frame(&frame, folder, name, err);
    if (!st)
        st = glint_accuracy_image_like(&out->mean, like, err);
    if (!st)
        st = glint_accuracy_image_like(&out->squares, like, err);
    if (!st && frame && !take(out, frame))
        st = glint_fail(err, GLINT_E_RANGE, "",
                        "%s/%s is of another programme; give another folder", folder, name);
    glint_frame_destroy(&frame);
    if (st)
        glint_accuracy_mean_finish(out);
    return st;
}

void glint_accuracy_mean_add(struct glint_accuracy_mean *m, unsigned seed,
                             const struct glint_accuracy_image *image)
{
    m->seeds |= 1u << seed;
    const double count = glint_accuracy_mean_count(m);
    for (size_t c = 0; c < m->mean.channels; c++) {
        float *mean = m->mean.channel[c].plane, *squares = m->squares.channel[c].plane;
        for (size_t p = 0; p < pixels_of(m); p++) {
            const double d = (double)image->channel[c].plane[p] - mean[p];
            const double moved = mean[p] + d / count;
            squares[p] += (float)(d * (image->channel[c].plane[p] - moved));
            mean[p] = (float)moved;
        }
    }
}

static glint_status fill(struct glint_frame *frame, const struct glint_accuracy_mean *m)
{
    for (size_t c = 0; c < m->mean.channels; c++) {
        char name[2][16];
        snprintf(name[0], sizeof name[0], "mean.%02zu", c);
        snprintf(name[1], sizeof name[1], "squares.%02zu", c);
        float *mean = glint_frame_channel(frame, name[0], GLINT_PIXEL_FLOAT);
        float *squares = glint_frame_channel(frame, name[1], GLINT_PIXEL_FLOAT);
        if (!mean || !squares)
            return GLINT_E_NOMEM;
        memcpy(mean, m->mean.channel[c].plane, pixels_of(m) * sizeof *mean);
        memcpy(squares, m->squares.channel[c].plane, pixels_of(m) * sizeof *squares);
    }
    return glint_frame_int(frame, "glint/seeds", (int32_t)m->seeds);
}

glint_status glint_accuracy_mean_save(const struct glint_accuracy_mean *m, const char *folder,
                                      const char *name, struct glint_error *err)
{
    struct glint_frame *frame;
    const uint32_t w = m->mean.width, h = m->mean.height;
    glint_status st = glint_frame_create(&frame, w, h, 0, 0, w, h, err);
    if (st)
        return st;
    st = fill(frame, m) ? glint_fail(err, GLINT_E_NOMEM, "", "no memory for an image") : GLINT_OK;
    if (!st)
        st = glint_accuracy_save_frame(frame, folder, name, err);
    glint_frame_destroy(&frame);
    return st;
}
