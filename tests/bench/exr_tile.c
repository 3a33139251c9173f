// exr_tile.c - what it costs to encode one streamed tile: 64x64 half RGBA, ZIP level 4.
//
// Prints the median and the best time of many tiles of a smooth and of a noisy picture, and as the
// last line one JSON object. The price that streaming was planned with is 0.6 ms for the noisy one.
#include "protocol/exr.h"

#include <stdio.h>
#include <stdlib.h>
#include <time.h>

#define SIDE 64
#define TILES 400

static double now_ms(void)
{
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return (double)t.tv_sec * 1e3 + (double)t.tv_nsec * 1e-6;
}

// A gradient, with the noise of a picture of a few samples per pixel where asked.
static struct glint_frame *make_tile(float noise)
{
    static const char *const names[] = {"R", "G", "B", "A"};
    struct glint_frame *f;
    if (glint_frame_create(&f, 1920, 1080, 640, 512, SIDE, SIDE, NULL))
        exit(1);
    uint32_t state = 1;
    for (int c = 0; c < 4; c++) {
        float *plane = glint_frame_channel(f, names[c], GLINT_PIXEL_HALF);
        for (int i = 0; i < SIDE * SIDE; i++) {
            state = state * 1664525u + 1013904223u;
            const float u = (float)(state >> 8) * 0x1p-24f;
            plane[i] = c == 3 ? 1 : 0.2f + 0.01f * (float)(i % SIDE) + noise * u * u;
        }
    }
    return f;
}

static int by_value(const void *a, const void *b)
{
    const double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

static double measure(const char *name, float noise)
{
    static const struct glint_exr_options options = {
        .compression = GLINT_EXR_ZIP, .layout = GLINT_EXR_SINGLE, .zip_level = 4};
    struct glint_frame *f = make_tile(noise);
    double ms[TILES];
    size_t size = 0;
    for (int i = 0; i < TILES; i++) {
        uint8_t *bytes;
        const double start = now_ms();
        if (glint_exr_write(f, &options, &bytes, &size, NULL, NULL))
            exit(1);
        ms[i] = now_ms() - start;
        free(bytes);
    }
    glint_frame_destroy(&f);
    qsort(ms, TILES, sizeof *ms, by_value);
    printf("%-7s %6zu bytes, median %.3f ms, best %.3f ms\n", name, size, ms[TILES / 2], ms[0]);
    return ms[TILES / 2];
}

int main(void)
{
    const double smooth = measure("smooth", 0), noisy = measure("noisy", 1);
    printf(
        "{\"bench\": \"exr-tile\", \"smooth_ms\": %.4f, \"noisy_ms\": %.4f, \"limit_ms\": 0.6}\n",
        smooth, noisy);
    return 0;
}
