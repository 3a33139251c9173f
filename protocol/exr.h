// exr.h - frames and tiles as OpenEXR, in memory. The only file that names exr_*.
//
// Thread-safety: reentrant.
#ifndef GLINT_PROTOCOL_EXR_H
#define GLINT_PROTOCOL_EXR_H

#include "frame.h"

enum glint_exr_compression { GLINT_EXR_NONE, GLINT_EXR_ZIP, GLINT_EXR_ZIPS };
enum glint_exr_layout { GLINT_EXR_SINGLE, GLINT_EXR_MULTIPART };

struct glint_exr_options {
    enum glint_exr_compression compression;
    enum glint_exr_layout layout; // MULTIPART: part 0 is R,G,B,A and repeats the cryptomatte keys
    bool floats;                  // what a frame has as half is written as float
    int zip_level;                // 1..9, 0 for the default, 4
    bool foreign;                 // a frame that was read: its Cryptomatte types stay what they are
};

// Writes a complete scanline file, channels sorted bytewise, half colour clamped to its range
// (*clamped counts the values, may be NULL). *bytes is malloc'd.
glint_status glint_exr_write(const struct glint_frame *frame,
                             const struct glint_exr_options *options, uint8_t **bytes, size_t *size,
                             uint64_t *clamped, struct glint_error *err);

// Reads a single- or multi-part scanline or tiled file; all parts' channels in one frame.
// Refuses images over GLINT_MAX_SIDE on a side and files it cannot read, without crashing.
glint_status glint_exr_read(struct glint_frame **out, const uint8_t *bytes, size_t size,
                            struct glint_error *err);

#endif
