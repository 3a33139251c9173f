// image_decode_hdr.c - Radiance RGBE pictures (.hdr) to RGBA16F.
//
// Source: G. Ward, "Real Pixels", Graphics Gems II, and Radiance's src/common/color.c: run-length
// encoding per component ("new") or per pixel ("old"), or none. A component is m * 2^(e-136),
// without the half step that Radiance adds, as OpenImageIO and most viewers read it.
#include "protocol/half.h"
#include "scene/image_decode.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

struct reader {
    const uint8_t *at, *end;
};

struct header {
    double exposure; // product of the EXPOSURE lines; radiance is the stored value over it
    uint32_t width, height;
};

// Copies the next line without its end, or returns false.
static bool next_line(struct reader *r, char *line, size_t capacity)
{
    const uint8_t *end = memchr(r->at, '\n', (size_t)(r->end - r->at));
    if (!end || (size_t)(end - r->at) >= capacity)
        return false;
    memcpy(line, r->at, (size_t)(end - r->at));
    line[end - r->at] = '\0';
    r->at = end + 1;
    return true;
}

// NULL when the header is one that is read here, else what is wrong with it.
static const char *read_header(struct reader *r, struct header *h)
{
    char line[256];
    bool rgbe = false;
    h->exposure = 1;
    while (next_line(r, line, sizeof line) && line[0]) {
        if (strncmp(line, "FORMAT=", 7) == 0)
            rgbe = strcmp(line + 7, "32-bit_rle_rgbe") == 0;
        if (strncmp(line, "EXPOSURE=", 9) == 0)
            h->exposure *= strtod(line + 9, NULL);
    }
    if (!rgbe)
        return "its format is not 32-bit_rle_rgbe";
    if (!(h->exposure > 0 && isfinite(h->exposure)))
        return "its exposure is not a positive number";
    int used = 0;
    if (!next_line(r, line, sizeof line) ||
        sscanf(line, "-Y %9u +X %9u%n", &h->height, &h->width, &used) != 2 || line[used])
        return "its resolution line is not \"-Y height +X width\"";
    return NULL;
}

// One component of a scan line in the new encoding.
static bool read_component(struct reader *r, uint8_t *rgbe, uint32_t width)
{
    for (uint32_t x = 0; x < width;) {
        if (r->end - r->at < 2)
            return false;
        const uint32_t code = *r->at++;
        const bool run = code > 128;
        const uint32_t n = run ? code - 128 : code;
        if (!n || n > width - x || (!run && (size_t)(r->end - r->at) < n))
            return false;
        for (uint32_t i = 0; i < n; i++)
            rgbe[4 * x++] = run ? *r->at : *r->at++;
        r->at += run;
    }
    return true;
}

// Flat pixels; 1 1 1 n repeats the last, successive ones counting in higher digits.
static bool read_old(struct reader *r, uint8_t *rgbe, uint32_t width)
{
    unsigned shift = 0;
    for (uint32_t x = 0; x < width;) {
        if (r->end - r->at < 4)
            return false;
        uint8_t p[4];
        memcpy(p, r->at, 4);
        r->at += 4;
        if (p[0] != 1 || p[1] != 1 || p[2] != 1) {
            memcpy(rgbe + 4 * x++, p, 4);
            shift = 0;
            continue;
        }
        const uint32_t n = shift < 16 ? (uint32_t)p[3] << shift : UINT32_MAX;
        if (!x || n > width - x)
            return false;
        for (uint32_t i = 0; i < n; i++, x++)
            memcpy(rgbe + 4 * x, rgbe + 4 * (x - 1), 4);
        shift += 8;
    }
    return true;
}

static bool read_row(struct reader *r, uint8_t *rgbe, uint32_t width)
{
    const bool coded = width >= 8 && width < 32768 && r->end - r->at >= 4 && r->at[0] == 2 &&
                       r->at[1] == 2 && (uint32_t)(r->at[2] << 8 | r->at[3]) == width;
    if (!coded)
        return read_old(r, rgbe, width);
    r->at += 4;
    for (int c = 0; c < 4; c++)
        if (!read_component(r, rgbe + c, width))
            return false;
    return true;
}

static void convert_row(const uint8_t *rgbe, uint16_t *out, uint32_t width, double exposure)
{
    uint64_t clamped = 0;
    for (uint32_t x = 0; x < width; x++, rgbe += 4, out += 4) {
        const double scale = rgbe[3] ? ldexp(1 / exposure, rgbe[3] - 136) : 0;
        for (int c = 0; c < 3; c++)
            out[c] = glint_half_from_float((float)(rgbe[c] * scale), &clamped);
        out[3] = 0x3c00;
    }
}

glint_status glint_image_decode_hdr(struct glint_pixels *out, struct glint_arena *arena,
                                    const uint8_t *bytes, size_t size, const char *pointer,
                                    struct glint_error *err)
{
    struct reader r = {bytes, bytes + size};
    struct header h = {0};
    const char *fault = read_header(&r, &h);
    if (fault)
        return glint_fail(err, GLINT_E_RANGE, pointer, "the Radiance picture is not read: %s",
                          fault);
    glint_status st =
        glint_pixels_alloc(out, arena, h.width, h.height, GLINT_IMAGE_RGBA16F, pointer, err);
    uint8_t *rgbe = st ? NULL : malloc((size_t)h.width * 4);
    if (!st && !rgbe)
        st = glint_fail(err, GLINT_E_NOMEM, pointer, "no memory for a scan line");
    for (uint32_t y = 0; !st && y < h.height; y++) {
        if (read_row(&r, rgbe, h.width))
            convert_row(rgbe, (uint16_t *)out->pixels + (size_t)y * h.width * 4, h.width,
                        h.exposure);
        else
            st = glint_fail(err, GLINT_E_RANGE, pointer,
                            "the Radiance picture is damaged in scan line %u of %u", y, h.height);
    }
    free(rgbe);
    return st;
}
