// frame.h - a rectangle of named image planes with the header attributes that travel with it.
//
// What the film gives out, what the EXR writer takes and the reader gives back.
//
// Thread-safety: built by one thread, immutable afterwards.
#ifndef GLINT_PROTOCOL_FRAME_H
#define GLINT_PROTOCOL_FRAME_H

#include "arena.h"
#include "status.h"

#include <stdbool.h>
#include <stdint.h>

enum glint_pixel_type { GLINT_PIXEL_HALF, GLINT_PIXEL_FLOAT, GLINT_PIXEL_UINT };

struct glint_channel {
    char *name;                 // "R", "Z", "CryptoObject00.R": at most 31 bytes
    enum glint_pixel_type type; // in the file
    float *plane;               // [height][width]; GLINT_PIXEL_UINT: the bits of a uint32
};

enum glint_attribute_kind {
    GLINT_ATTR_STRING,
    GLINT_ATTR_INT,
    GLINT_ATTR_FLOAT,
    GLINT_ATTR_M44F,
    GLINT_ATTR_CHROMATICITIES
};

struct glint_attribute {
    char *name;
    enum glint_attribute_kind kind;
    char *text;       // GLINT_ATTR_STRING
    int32_t integer;  // GLINT_ATTR_INT
    float number[16]; // FLOAT: [0]; M44F row-major; CHROMATICITIES: rx ry gx gy bx by wx wy
};

struct glint_frame {
    struct glint_arena arena; // owns names, planes, texts
    uint32_t display_width, display_height;
    int32_t x, y;           // of the data window's first pixel in the display window
    uint32_t width, height; // of the data window
    uint32_t channels, attributes;
    struct glint_channel *channel;
    struct glint_attribute *attribute;
    uint32_t channel_capacity, attribute_capacity;
};

glint_status glint_frame_create(struct glint_frame **out, uint32_t display_width,
                                uint32_t display_height, int32_t x, int32_t y, uint32_t width,
                                uint32_t height, struct glint_error *err);
void glint_frame_destroy(struct glint_frame **frame);

// Adds a zeroed plane and returns it, or NULL without memory.
float *glint_frame_channel(struct glint_frame *frame, const char *name, enum glint_pixel_type type);

// Finds a plane by name, or NULL.
float *glint_frame_find(const struct glint_frame *frame, const char *name);

// Add an attribute; GLINT_E_NOMEM only.
glint_status glint_frame_string(struct glint_frame *frame, const char *name, const char *text);
glint_status glint_frame_int(struct glint_frame *frame, const char *name, int32_t value);
glint_status glint_frame_float(struct glint_frame *frame, const char *name, float value);
glint_status glint_frame_matrix(struct glint_frame *frame, const char *name, const float m[16]);
glint_status glint_frame_chromaticities(struct glint_frame *frame, const float c[8]);
const struct glint_attribute *glint_frame_attribute(const struct glint_frame *frame,
                                                    const char *name);

#endif
