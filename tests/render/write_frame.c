// write_frame.c - OpenEXR files for tests/render/test_exr_readers.py.
//
//   write_frame OUT none|zip|zips single|multipart   the frame that the test knows pixel by pixel
//   write_frame --copy IN OUT                        what our reader makes of IN, uncompressed
//   write_frame --ids                                the ID of each line of the standard input
#include "protocol/cryptomatte.h"
#include "protocol/exr.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define WIDTH 48
#define HEIGHT 32
#define NAMES 8

static const char *const names[NAMES] = {"bunny",
                                         "torus",
                                         "равнина",
                                         "name, with, comma",
                                         "name containing a \"quote\"  ",
                                         "flowerA.flowerA_petal11.:778",
                                         "flowerA.flowerA_petal1.:1065",
                                         "back\\slash"};

static void fail(const struct glint_error *err)
{
    fprintf(stderr, "%s\n", glint_error_text(err));
    exit(1);
}

static float *channel(struct glint_frame *f, const char *name, enum glint_pixel_type type)
{
    float *plane = glint_frame_channel(f, name, type);
    if (!plane)
        exit(1);
    return plane;
}

static void add_images(struct glint_frame *f)
{
    float *r = channel(f, "R", GLINT_PIXEL_HALF), *g = channel(f, "G", GLINT_PIXEL_HALF);
    float *b = channel(f, "B", GLINT_PIXEL_HALF), *a = channel(f, "A", GLINT_PIXEL_HALF);
    float *z = channel(f, "Z", GLINT_PIXEL_FLOAT), *n = channel(f, "N.X", GLINT_PIXEL_FLOAT);
    float *samples = channel(f, "samples.Y", GLINT_PIXEL_UINT);
    for (uint32_t i = 0; i < WIDTH * HEIGHT; i++) {
        const uint32_t x = i % WIDTH, y = i / WIDTH, count = 1000000 * y + x;
        r[i] = (float)x / 8;
        g[i] = -(float)y;
        b[i] = x == 7 ? 1e9f : 0.1f;
        a[i] = 1;
        z[i] = x % 2 ? 1e30f : 1.1f + (float)y;
        n[i] = (float)x * 0.001f - 0.02f;
        memcpy(&samples[i], &count, sizeof count);
    }
}

// Half a name, a quarter of the next, and an eighth each of another one and of nothing.
static void add_ranks(struct glint_frame *f, const char *type, uint32_t shift)
{
    float *plane[12];
    for (int i = 0; i < 12; i++) {
        char name[32];
        snprintf(name, sizeof name, "%s%02d.%c", type, i / 4, "RGBA"[i % 4]);
        plane[i] = channel(f, name, GLINT_PIXEL_FLOAT);
    }
    for (uint32_t i = 0; i < WIDTH * HEIGHT; i++) {
        const uint32_t k = i % WIDTH / 6 + shift;
        struct glint_cryptomatte_rank rank[4] = {
            {glint_cryptomatte_id(names[(k + 3) % NAMES]), 0.125f},
            {glint_cryptomatte_id(names[(k + 1) % NAMES]), 0.25f},
            {0, 0.125f},
            {glint_cryptomatte_id(names[k % NAMES]), 0.5f}};
        glint_cryptomatte_sort(rank, 4);
        for (int j = 0; j < 4; j++) {
            memcpy(&plane[2 * j][i], &rank[j].id, sizeof rank[j].id);
            plane[2 * j + 1][i] = rank[j].coverage;
        }
    }
}

static void add_attributes(struct glint_frame *f)
{
    static const float primaries[8] = {.64f, .33f, .30f, .60f, .15f, .06f, .3127f, .3290f};
    static const float matrix[16] = {1, 0, 0, 0, 0, 0, -1, 0, 0, 1, 0, 0, 5, 6, 7, 1};
    char *manifest = glint_cryptomatte_manifest(names, NAMES);
    if (!manifest || glint_frame_chromaticities(f, primaries) ||
        glint_frame_matrix(f, "worldToCamera", matrix) || glint_frame_int(f, "glint/samples", 64) ||
        glint_frame_float(f, "framesPerSecond", 24) ||
        glint_frame_string(f, "comments", "two\nlines") ||
        glint_cryptomatte_header(f, "CryptoObject", manifest) ||
        glint_cryptomatte_header(f, "CryptoMaterial", manifest))
        exit(1);
    free(manifest);
}

static int save(const struct glint_frame *f, const char *path,
                const struct glint_exr_options *options)
{
    struct glint_error err = {0};
    uint8_t *bytes;
    size_t size;
    uint64_t clamped;
    if (glint_exr_write(f, options, &bytes, &size, &clamped, &err))
        fail(&err);
    FILE *to = fopen(path, "wb");
    const int bad = !to || fwrite(bytes, 1, size, to) != size || fclose(to);
    free(bytes);
    printf("%llu\n", (unsigned long long)clamped);
    return bad;
}

static int write_known(const char *path, const char *compression, const char *layout)
{
    struct glint_frame *f;
    if (glint_frame_create(&f, 96, 64, 10, -5, WIDTH, HEIGHT, NULL))
        return 1;
    add_images(f);
    add_ranks(f, "CryptoObject", 0);
    add_ranks(f, "CryptoMaterial", 2);
    add_attributes(f);
    const struct glint_exr_options options = {
        .compression = strcmp(compression, "none") == 0  ? GLINT_EXR_NONE
                       : strcmp(compression, "zip") == 0 ? GLINT_EXR_ZIP
                                                         : GLINT_EXR_ZIPS,
        .layout = strcmp(layout, "multipart") == 0 ? GLINT_EXR_MULTIPART : GLINT_EXR_SINGLE};
    const int bad = save(f, path, &options);
    glint_frame_destroy(&f);
    return bad;
}

static int copy(const char *from, const char *to)
{
    const size_t most = 1 << 26;
    uint8_t *bytes = malloc(most);
    FILE *file = fopen(from, "rb");
    if (!bytes || !file)
        return 1;
    const size_t size = fread(bytes, 1, most, file);
    fclose(file);
    struct glint_error err = {0};
    struct glint_frame *f;
    if (glint_exr_read(&f, bytes, size, &err))
        fail(&err);
    free(bytes);
    const int bad = save(f, to, &(struct glint_exr_options){.compression = GLINT_EXR_NONE});
    glint_frame_destroy(&f);
    return bad;
}

static int print_ids(void)
{
    char line[4096];
    while (fgets(line, sizeof line, stdin)) {
        line[strcspn(line, "\n")] = 0;
        printf("%08x\n", glint_cryptomatte_id(line));
    }
    return 0;
}

int main(int argc, char **argv)
{
    if (argc == 2 && !strcmp(argv[1], "--ids"))
        return print_ids();
    if (argc == 4 && !strcmp(argv[1], "--copy"))
        return copy(argv[2], argv[3]);
    return argc == 4 ? write_known(argv[1], argv[2], argv[3]) : 64;
}
