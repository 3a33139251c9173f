// image_decode.h - PNG, JPEG, Radiance and OpenEXR pictures to the two pixel formats of a scene.
//
// The format is known by the file's first bytes. PNG and JPEG become RGBA8 in their own encoding
// (colour profiles are not applied, 16-bit samples are rounded to 8), Radiance and
// OpenEXR become linear RGBA16F: what is above 65504, below 0 or no number is clamped to 0..65504.
//
// Thread-safety: reentrant.
#ifndef GLINT_SCENE_IMAGE_DECODE_H
#define GLINT_SCENE_IMAGE_DECODE_H

#include "protocol/scene.h"

#define GLINT_IMAGE_MAX_SIDE 16384u
#define GLINT_IMAGE_MAX_PIXELS (1u << 27)

struct glint_pixels {
    uint32_t width, height;
    enum glint_image_format format;
    void *pixels; // rows from top to bottom, no padding; in the arena that was given
    size_t bytes;
    uint64_t clamped; // values of OpenEXR that were beyond what a picture of light can hold
};

// Sizes are checked before anything is allocated.
//   GLINT_E_RANGE at `pointer`: not a picture of these formats, damaged, or too large
//   GLINT_E_NOMEM
glint_status glint_image_decode(struct glint_pixels *out, struct glint_arena *arena,
                                const uint8_t *bytes, size_t size, const char *pointer,
                                struct glint_error *err);

// Shared by the decoders: checks the size and allocates out->pixels.
glint_status glint_pixels_alloc(struct glint_pixels *out, struct glint_arena *arena, uint32_t width,
                                uint32_t height, enum glint_image_format format,
                                const char *pointer, struct glint_error *err);

glint_status glint_image_decode_png(struct glint_pixels *out, struct glint_arena *arena,
                                    const uint8_t *bytes, size_t size, const char *pointer,
                                    struct glint_error *err);
glint_status glint_image_decode_jpeg(struct glint_pixels *out, struct glint_arena *arena,
                                     const uint8_t *bytes, size_t size, const char *pointer,
                                     struct glint_error *err);
glint_status glint_image_decode_hdr(struct glint_pixels *out, struct glint_arena *arena,
                                    const uint8_t *bytes, size_t size, const char *pointer,
                                    struct glint_error *err);

glint_status glint_image_decode_exr(struct glint_pixels *out, struct glint_arena *arena,
                                    const uint8_t *bytes, size_t size, const char *pointer,
                                    struct glint_error *err);

#endif
