// frame.c - planes and texts in the arena, the two lists beside it.
#include "protocol/frame.h"

#include "protocol/job.h"

#include <assert.h>
#include <stdlib.h>
#include <string.h>

#define NAME_BYTES 31

static glint_status check(uint32_t display_width, uint32_t display_height, int32_t x, int32_t y,
                          uint32_t width, uint32_t height, struct glint_error *err)
{
    glint_status st = GLINT_OK;
    if (display_width < 1 || display_width > GLINT_MAX_SIDE || display_height < 1 ||
        display_height > GLINT_MAX_SIDE)
        st = glint_fail(err, GLINT_E_RANGE, "", "a display window of %ux%u, not 1..%u on a side",
                        display_width, display_height, GLINT_MAX_SIDE);
    if (width < 1 || width > GLINT_MAX_SIDE || height < 1 || height > GLINT_MAX_SIDE)
        st = glint_fail(err, GLINT_E_RANGE, "", "a data window of %ux%u, not 1..%u on a side",
                        width, height, GLINT_MAX_SIDE);
    if (!st && (x > INT32_MAX - (int32_t)width || y > INT32_MAX - (int32_t)height))
        st = glint_fail(err, GLINT_E_RANGE, "", "a data window that starts at %d,%d", x, y);
    return st;
}

glint_status glint_frame_create(struct glint_frame **out, uint32_t display_width,
                                uint32_t display_height, int32_t x, int32_t y, uint32_t width,
                                uint32_t height, struct glint_error *err)
{
    assert(out);
    *out = NULL;
    glint_status st = check(display_width, display_height, x, y, width, height, err);
    if (st)
        return st;
    struct glint_frame *frame = malloc(sizeof *frame);
    if (!frame)
        return glint_fail(err, GLINT_E_NOMEM, "", "no memory for a frame");
    *frame = (struct glint_frame){.display_width = display_width,
                                  .display_height = display_height,
                                  .x = x,
                                  .y = y,
                                  .width = width,
                                  .height = height};
    *out = frame;
    return GLINT_OK;
}

void glint_frame_destroy(struct glint_frame **frame)
{
    struct glint_frame *f = *frame;
    *frame = NULL;
    if (!f)
        return;
    glint_arena_finish(&f->arena);
    free(f->channel);
    free(f->attribute);
    free(f);
}

// The array with room for one more element behind `used`, or NULL; then the old one stays.
static void *grow(void *array, uint32_t used, uint32_t *capacity, size_t size)
{
    if (used < *capacity)
        return array;
    const uint32_t wanted = *capacity ? *capacity * 2 : 8;
    void *larger = realloc(array, wanted * size);
    if (larger)
        *capacity = wanted;
    return larger;
}

float *glint_frame_channel(struct glint_frame *frame, const char *name, enum glint_pixel_type type)
{
    assert(*name && strlen(name) <= NAME_BYTES && !glint_frame_find(frame, name));
    struct glint_channel *channel =
        grow(frame->channel, frame->channels, &frame->channel_capacity, sizeof *channel);
    if (!channel)
        return NULL;
    frame->channel = channel;
    char *copy = glint_arena_string(&frame->arena, name);
    float *plane =
        glint_arena_array(&frame->arena, (size_t)frame->width * frame->height, sizeof *plane);
    if (!copy || !plane)
        return NULL;
    channel[frame->channels++] = (struct glint_channel){copy, type, plane};
    return plane;
}

float *glint_frame_find(const struct glint_frame *frame, const char *name)
{
    for (uint32_t i = 0; i < frame->channels; i++)
        if (!strcmp(frame->channel[i].name, name))
            return frame->channel[i].plane;
    return NULL;
}

const struct glint_attribute *glint_frame_attribute(const struct glint_frame *frame,
                                                    const char *name)
{
    for (uint32_t i = 0; i < frame->attributes; i++)
        if (!strcmp(frame->attribute[i].name, name))
            return &frame->attribute[i];
    return NULL;
}

// Stores `value` under `name`, in place of an attribute that has the name already.
static glint_status put(struct glint_frame *frame, const char *name, struct glint_attribute value)
{
    assert(*name && strlen(name) <= NAME_BYTES);
    for (uint32_t i = 0; i < frame->attributes; i++)
        if (!strcmp(frame->attribute[i].name, name)) {
            value.name = frame->attribute[i].name;
            frame->attribute[i] = value;
            return GLINT_OK;
        }
    value.name = glint_arena_string(&frame->arena, name);
    struct glint_attribute *attribute =
        grow(frame->attribute, frame->attributes, &frame->attribute_capacity, sizeof *attribute);
    if (attribute)
        frame->attribute = attribute;
    if (!attribute || !value.name)
        return GLINT_E_NOMEM;
    attribute[frame->attributes++] = value;
    return GLINT_OK;
}

glint_status glint_frame_string(struct glint_frame *frame, const char *name, const char *text)
{
    char *copy = glint_arena_string(&frame->arena, text);
    if (!copy)
        return GLINT_E_NOMEM;
    return put(frame, name, (struct glint_attribute){.kind = GLINT_ATTR_STRING, .text = copy});
}

glint_status glint_frame_int(struct glint_frame *frame, const char *name, int32_t value)
{
    return put(frame, name, (struct glint_attribute){.kind = GLINT_ATTR_INT, .integer = value});
}

glint_status glint_frame_float(struct glint_frame *frame, const char *name, float value)
{
    return put(frame, name, (struct glint_attribute){.kind = GLINT_ATTR_FLOAT, .number = {value}});
}

static glint_status put_numbers(struct glint_frame *frame, const char *name,
                                enum glint_attribute_kind kind, const float *number, size_t count)
{
    struct glint_attribute value = {.kind = kind};
    memcpy(value.number, number, count * sizeof *number);
    return put(frame, name, value);
}

glint_status glint_frame_matrix(struct glint_frame *frame, const char *name, const float m[16])
{
    return put_numbers(frame, name, GLINT_ATTR_M44F, m, 16);
}

glint_status glint_frame_chromaticities(struct glint_frame *frame, const float c[8])
{
    return put_numbers(frame, "chromaticities", GLINT_ATTR_CHROMATICITIES, c, 8);
}
