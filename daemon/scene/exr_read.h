// exr_read.h - one picture of an OpenEXR file in memory, row by row, behind a C interface.
//
// OpenEXR's C library does not decode DWAA and DWAB, its C++ library does. No threads, no files.
//
// Thread-safety: reentrant.
#ifndef GLINT_SCENE_EXR_READ_H
#define GLINT_SCENE_EXR_READ_H

#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

struct glint_exr;

enum glint_exr_result { GLINT_EXR_OK, GLINT_EXR_FAULT, GLINT_EXR_NOMEM };

// What is wrong with the file, ended by 0.
struct glint_exr_fault {
    char text[200];
};

// Opens the first part, and in it the first layer, that has R, G and B, or Y; deep parts are passed
// over. The picture is the display window. `bytes` must outlive *out; side: most pixels along an edge.
enum glint_exr_result glint_exr_open(struct glint_exr **out, const uint8_t *bytes, size_t size,
                                     uint32_t side, struct glint_exr_fault *fault);
uint32_t glint_exr_width(const struct glint_exr *exr);
uint32_t glint_exr_height(const struct glint_exr *exr);
// rgb: [width][3] of the row, counted from the top; black outside of the data window.
enum glint_exr_result glint_exr_row(struct glint_exr *exr, uint32_t y, float *rgb,
                                    struct glint_exr_fault *fault);
void glint_exr_close(struct glint_exr **exr);

#ifdef __cplusplus
}
#endif

#endif
