#include "protocol/cryptomatte.h"
#include "protocol/exr.h"
#include "protocol/half.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>
#include <dirent.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#define COUNT(array) (sizeof(array) / sizeof *(array))

struct file {
    uint8_t *bytes;
    size_t size;
};

static struct file write_file(const struct glint_frame *f, enum glint_exr_compression compression,
                              enum glint_exr_layout layout)
{
    const struct glint_exr_options options = {
        .compression = compression, .layout = layout, .zip_level = 4};
    struct file file;
    assert_int_equal(glint_exr_write(f, &options, &file.bytes, &file.size, NULL, NULL), GLINT_OK);
    return file;
}

static float from_bits(uint32_t bits)
{
    float value;
    memcpy(&value, &bits, sizeof value);
    return value;
}

static uint32_t to_bits(float value)
{
    uint32_t bits;
    memcpy(&bits, &value, sizeof bits);
    return bits;
}

// A frame with every pixel type, a region that lies partly outside, two Cryptomattes and
// attributes of every kind.
static struct glint_frame *make(uint32_t width, uint32_t height)
{
    static const struct {
        const char *name;
        enum glint_pixel_type type;
    } row[] = {
        {"R", GLINT_PIXEL_HALF},
        {"G", GLINT_PIXEL_HALF},
        {"B", GLINT_PIXEL_HALF},
        {"A", GLINT_PIXEL_HALF},
        {"Z", GLINT_PIXEL_FLOAT},
        {"N.Y", GLINT_PIXEL_FLOAT},
        {"N.X", GLINT_PIXEL_FLOAT},
        {"samples.Y", GLINT_PIXEL_UINT},
        {"CryptoObject00.R", GLINT_PIXEL_FLOAT},
        {"CryptoObject00.G", GLINT_PIXEL_FLOAT},
        {"CryptoMaterial00.R", GLINT_PIXEL_FLOAT},
        {"CryptoMaterial00.G", GLINT_PIXEL_FLOAT},
    };
    struct glint_frame *f;
    assert_int_equal(glint_frame_create(&f, 100, 80, -3, 7, width, height, NULL), GLINT_OK);
    uint32_t state = 1;
    for (size_t c = 0; c < COUNT(row); c++) {
        float *plane = glint_frame_channel(f, row[c].name, row[c].type);
        for (size_t i = 0; i < (size_t)width * height; i++) {
            state = state * 1664525u + 1013904223u;
            plane[i] =
                row[c].type == GLINT_PIXEL_HALF
                    ? glint_float_from_half(state >> 8 & 0x7bff)
                    : from_bits(row[c].type == GLINT_PIXEL_UINT ? state : state & 0xbf7fffff);
        }
    }
    const float primaries[8] = {.64f, .33f, .30f, .60f, .15f, .06f, .3127f, .3290f};
    const float matrix[16] = {1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15, 16};
    assert_int_equal(glint_frame_chromaticities(f, primaries), GLINT_OK);
    assert_int_equal(glint_frame_matrix(f, "worldToCamera", matrix), GLINT_OK);
    assert_int_equal(glint_frame_int(f, "glint/samples", 64), GLINT_OK);
    assert_int_equal(glint_frame_float(f, "framesPerSecond", 23.976f), GLINT_OK);
    assert_int_equal(glint_frame_string(f, "comments", "равнина \"quoted\""), GLINT_OK);
    assert_int_equal(glint_cryptomatte_header(f, "CryptoObject", "{\"torus\":\"f19c73fd\"}"),
                     GLINT_OK);
    assert_int_equal(glint_cryptomatte_header(f, "CryptoMaterial", "{}"), GLINT_OK);
    return f;
}

static void assert_equal_frames(const struct glint_frame *a, const struct glint_frame *b)
{
    assert_int_equal(a->display_width, b->display_width);
    assert_int_equal(a->display_height, b->display_height);
    assert_int_equal(a->x, b->x);
    assert_int_equal(a->y, b->y);
    assert_int_equal(a->width, b->width);
    assert_int_equal(a->height, b->height);
    assert_int_equal(a->channels, b->channels);
    assert_int_equal(a->attributes, b->attributes);
    for (uint32_t i = 0; i < a->channels; i++) {
        const struct glint_channel *c = &a->channel[i];
        const float *plane = glint_frame_find(b, c->name);
        assert_non_null(plane);
        assert_memory_equal(plane, c->plane, sizeof(float) * a->width * a->height);
        for (uint32_t j = 0; j < b->channels; j++)
            if (!strcmp(b->channel[j].name, c->name))
                assert_int_equal(b->channel[j].type, c->type);
    }
    for (uint32_t i = 0; i < a->attributes; i++) {
        const struct glint_attribute *x = &a->attribute[i], *y = glint_frame_attribute(b, x->name);
        assert_non_null(y);
        assert_int_equal(x->kind, y->kind);
        assert_int_equal(x->integer, y->integer);
        assert_memory_equal(x->number, y->number, sizeof x->number);
        if (x->text)
            assert_string_equal(x->text, y->text);
    }
}

static void a_frame_comes_back_to_the_bit(void **state)
{
    (void)state;
    static const uint32_t size[][2] = {{1, 1}, {3, 5}, {64, 64}, {67, 33}, {130, 1}};
    for (size_t s = 0; s < COUNT(size); s++) {
        struct glint_frame *f = make(size[s][0], size[s][1]);
        for (int c = GLINT_EXR_NONE; c <= GLINT_EXR_ZIPS; c++)
            for (int l = GLINT_EXR_SINGLE; l <= GLINT_EXR_MULTIPART; l++) {
                struct file file = write_file(f, c, l);
                struct glint_frame *back;
                assert_int_equal(glint_exr_read(&back, file.bytes, file.size, NULL), GLINT_OK);
                assert_equal_frames(f, back);
                glint_frame_destroy(&back);
                free(file.bytes);
            }
        glint_frame_destroy(&f);
    }
}

// u: half of the last place of a half's eleven bits, relative.
static void a_half_is_its_float_to_2_to_the_minus_11(void **state)
{
    (void)state;
    struct glint_frame *f = make(67, 33), *half, *whole;
    for (uint32_t c = 0; c < f->channels; c++)
        for (size_t i = 0; f->channel[c].type == GLINT_PIXEL_HALF && i < 67 * 33; i++)
            f->channel[c].plane[i] = ldexpf(1.0f + (float)(i * 7919 % 2211) / 2211.0f, i % 29 - 14);
    struct file file = write_file(f, GLINT_EXR_ZIP, GLINT_EXR_SINGLE);
    assert_int_equal(glint_exr_read(&half, file.bytes, file.size, NULL), GLINT_OK);
    free(file.bytes);
    const struct glint_exr_options options = {
        .compression = GLINT_EXR_ZIP, .zip_level = 4, .floats = true};
    assert_int_equal(glint_exr_write(f, &options, &file.bytes, &file.size, NULL, NULL), GLINT_OK);
    assert_int_equal(glint_exr_read(&whole, file.bytes, file.size, NULL), GLINT_OK);
    free(file.bytes);
    double largest = 0;
    for (uint32_t c = 0; c < f->channels; c++) {
        assert_memory_equal(whole->channel[c].plane, glint_frame_find(f, whole->channel[c].name),
                            67 * 33 * sizeof(float));
        assert_int_not_equal(whole->channel[c].type, GLINT_PIXEL_HALF);
        const float *exact = glint_frame_find(f, half->channel[c].name);
        for (size_t i = 0; half->channel[c].type == GLINT_PIXEL_HALF && i < 67 * 33; i++)
            largest = fmax(largest, fabs((double)half->channel[c].plane[i] / exact[i] - 1));
    }
    assert_true(largest > 0.9 * 0x1p-11 && largest <= 0x1p-11);
    glint_frame_destroy(&f);
    glint_frame_destroy(&half);
    glint_frame_destroy(&whole);
}

static void the_same_frame_gives_the_same_bytes(void **state)
{
    (void)state;
    struct glint_frame *f = make(50, 40);
    for (int l = GLINT_EXR_SINGLE; l <= GLINT_EXR_MULTIPART; l++) {
        struct file a = write_file(f, GLINT_EXR_ZIP, l), b = write_file(f, GLINT_EXR_ZIP, l);
        assert_int_equal(a.size, b.size);
        assert_memory_equal(a.bytes, b.bytes, a.size);
        free(a.bytes);
        free(b.bytes);
    }
    glint_frame_destroy(&f);
}

static size_t occurrences(struct file file, const char *text)
{
    size_t count = 0;
    const uint8_t *at = file.bytes, *end = file.bytes + file.size;
    while ((at = memmem(at, (size_t)(end - at), text, strlen(text))) != NULL) {
        count++;
        at++;
    }
    return count;
}

static void the_first_part_repeats_every_cryptomatte_key(void **state)
{
    (void)state;
    struct glint_frame *f = make(8, 8);
    struct file single = write_file(f, GLINT_EXR_ZIP, GLINT_EXR_SINGLE);
    struct file multi = write_file(f, GLINT_EXR_ZIP, GLINT_EXR_MULTIPART);
    static const char *const keys[] = {"cryptomatte/3ae39a5/manifest", "cryptomatte/be359d6/name"};
    for (size_t i = 0; i < COUNT(keys); i++) {
        assert_int_equal(occurrences(single, keys[i]), 1);
        assert_int_equal(occurrences(multi, keys[i]), 2);
    }
    // Colour is first: its part is named before any other layer appears.
    const uint8_t *colour = memmem(multi.bytes, multi.size, "rgba", 4);
    const uint8_t *object = memmem(multi.bytes, multi.size, "CryptoObject00.R", 17);
    assert_true(colour && object && colour < object);
    free(single.bytes);
    free(multi.bytes);
    glint_frame_destroy(&f);
}

static void every_half_survives(void **state)
{
    (void)state;
    uint64_t clamped = 0;
    for (uint32_t h = 0; h < 0x10000; h++) {
        const uint32_t magnitude = h & 0x7fff;
        const uint16_t back = glint_half_from_float(glint_float_from_half((uint16_t)h), &clamped);
        if (magnitude < 0x7c00)
            assert_int_equal(back, h);
        else if (magnitude == 0x7c00)
            assert_int_equal(back, (h & 0x8000) | 0x7bff);
        else
            assert_int_equal(back, (h & 0x8000) | 0x7e00);
    }
    assert_int_equal(clamped, 2);
    assert_true(glint_float_from_half(0x3c00) == 1 && glint_float_from_half(0xc000) == -2);
    assert_true(glint_float_from_half(0x7bff) == GLINT_HALF_MAX);
    assert_true(glint_float_from_half(0x0001) == 0x1p-24f);
}

static void floats_round_to_the_nearest_half_ties_to_even(void **state)
{
    (void)state;
    uint64_t clamped = 0;
    for (uint32_t h = 0; h < 0x7bff; h++) {
        const float low = glint_float_from_half((uint16_t)h), high = glint_float_from_half(h + 1);
        const float middle = low + (high - low) / 2; // exact: halves have 13 bits fewer
        const uint16_t even = h & 1 ? h + 1 : h;
        assert_int_equal(glint_half_from_float(middle, &clamped), even);
        assert_int_equal(glint_half_from_float(nextafterf(middle, 0), &clamped), h);
        assert_int_equal(glint_half_from_float(nextafterf(middle, INFINITY), &clamped), h + 1);
        assert_int_equal(glint_half_from_float(-middle, &clamped), 0x8000 | even);
    }
    assert_int_equal(clamped, 0);
}

static void values_over_the_half_range_are_clamped_and_counted(void **state)
{
    (void)state;
    const float value[8] = {65504, 65505, -65520, INFINITY, -INFINITY, 1e30f, NAN, -1};
    struct glint_frame *f;
    assert_int_equal(glint_frame_create(&f, 8, 1, 0, 0, 8, 1, NULL), GLINT_OK);
    memcpy(glint_frame_channel(f, "R", GLINT_PIXEL_HALF), value, sizeof value);
    memcpy(glint_frame_channel(f, "Z", GLINT_PIXEL_FLOAT), value, sizeof value);
    const struct glint_exr_options options = {0};
    struct file file;
    uint64_t clamped = 99;
    assert_int_equal(glint_exr_write(f, &options, &file.bytes, &file.size, &clamped, NULL),
                     GLINT_OK);
    assert_int_equal(clamped, 5);
    struct glint_frame *back;
    assert_int_equal(glint_exr_read(&back, file.bytes, file.size, NULL), GLINT_OK);
    const float *r = glint_frame_find(back, "R");
    static const float want[6] = {65504, 65504, -65504, 65504, -65504, 65504};
    for (int i = 0; i < 6; i++)
        assert_true(r[i] == want[i]);
    assert_true(isnan(r[6]) && r[7] == -1);
    assert_memory_equal(glint_frame_find(back, "Z"), value, sizeof value);
    glint_frame_destroy(&back);
    glint_frame_destroy(&f);
    free(file.bytes);
}

static void what_would_break_ids_is_refused(void **state)
{
    (void)state;
    const struct glint_exr_options options = {.compression = GLINT_EXR_ZIP};
    struct file file;
    for (int i = 0; i < 3; i++) {
        struct glint_frame *f;
        struct glint_error err = {0};
        assert_int_equal(glint_frame_create(&f, 1, 1, 0, 0, 1, 1, NULL), GLINT_OK);
        if (i) { // i == 0: a frame without channels
            glint_cryptomatte_header(f, "CryptoObject", "{}");
            glint_frame_channel(f, "CryptoObject00.R",
                                i == 1 ? GLINT_PIXEL_HALF : GLINT_PIXEL_FLOAT);
        }
        if (i == 2)
            glint_cryptomatte_header(f, "CryptoObjectReflect", "{}");
        assert_int_equal(glint_exr_write(f, &options, &file.bytes, &file.size, NULL, &err),
                         GLINT_E_RANGE);
        assert_null(file.bytes);
        assert_int_equal(err.count, 1);
        glint_error_finish(&err);
        glint_frame_destroy(&f);
    }
}

// Reads from memory that ends where the file ends, for the sanitizers to guard.
static glint_status read_copy(const uint8_t *bytes, size_t size)
{
    uint8_t *copy = malloc(size ? size : 1);
    memcpy(copy, bytes, size);
    struct glint_frame *f;
    struct glint_error err = {0};
    glint_status st = glint_exr_read(&f, copy, size, &err);
    assert_true(!st == !!f);
    assert_int_equal(st, err.status);
    assert_int_not_equal(st, GLINT_E_NOMEM);
    glint_frame_destroy(&f);
    glint_error_finish(&err);
    free(copy);
    return st;
}

static void every_truncation_is_refused(void **state)
{
    (void)state;
    struct glint_frame *f = make(20, 40);
    for (int l = GLINT_EXR_SINGLE; l <= GLINT_EXR_MULTIPART; l++) {
        struct file file = write_file(f, GLINT_EXR_ZIP, l);
        for (size_t size = 0; size < file.size; size += size < 4000 ? 1 : 97)
            assert_int_not_equal(read_copy(file.bytes, size), GLINT_OK);
        assert_int_not_equal(read_copy(file.bytes, file.size - 1), GLINT_OK);
        assert_int_equal(read_copy(file.bytes, file.size), GLINT_OK);
        free(file.bytes);
    }
    glint_frame_destroy(&f);
}

static void damaged_bytes_never_crash_the_reader(void **state)
{
    (void)state;
    struct glint_frame *f = make(20, 40);
    uint32_t seed = 7;
    for (int l = GLINT_EXR_SINGLE; l <= GLINT_EXR_MULTIPART; l++) {
        struct file file = write_file(f, GLINT_EXR_ZIP, l);
        uint8_t *damaged = malloc(file.size);
        for (int round = 0; round < 1500; round++) {
            memcpy(damaged, file.bytes, file.size);
            const size_t range = round % 3 ? file.size : 3000; // the header is worth more rounds
            for (int k = 0; k <= round % 7; k++) {
                seed = seed * 1664525u + 1013904223u;
                const uint8_t byte = seed >> 24;
                seed = seed * 1664525u + 1013904223u;
                damaged[(seed >> 4) % range] = round % 2 ? byte : (byte & 1 ? 255 : 0);
            }
            read_copy(damaged, file.size);
        }
        free(damaged);
        free(file.bytes);
    }
    glint_frame_destroy(&f);
}

// Overwrites the four numbers of a box2i attribute.
static void set_box(struct file file, const char *name, int32_t right, int32_t bottom)
{
    uint8_t *at = memmem(file.bytes, file.size, name, strlen(name) + 1);
    assert_non_null(at);
    const int32_t box[4] = {0, 0, right, bottom};
    memcpy(at + strlen(name) + 1 + strlen("box2i") + 1 + 4, box, sizeof box);
}

static void a_size_that_the_file_cannot_hold_costs_no_memory(void **state)
{
    (void)state;
    // 16384x16384 is allowed as such; the others are not, or are no rectangles.
    static const int32_t row[][2] = {
        {16383, 16383}, {16383, 255}, {16384, 0}, {2147483647, 0}, {-2, 0}};
    struct glint_frame *f = make(8, 8);
    for (size_t i = 0; i < COUNT(row); i++) {
        struct file file = write_file(f, GLINT_EXR_ZIP, GLINT_EXR_SINGLE);
        set_box(file, "dataWindow", row[i][0], row[i][1]);
        struct rusage before, after;
        getrusage(RUSAGE_SELF, &before);
        const glint_status st = read_copy(file.bytes, file.size);
        getrusage(RUSAGE_SELF, &after);
        assert_true(st == GLINT_E_SYNTAX || st == GLINT_E_RANGE);
        assert_true(after.ru_maxrss - before.ru_maxrss < 32768); // KiB
        free(file.bytes);
    }
    glint_frame_destroy(&f);
}

static const char *scenes(void)
{
    const char *path = getenv("GLINT_SCENES");
    return path ? path : "../shared/scenes";
}

static struct file load(const char *path)
{
    struct file file = {NULL, 0};
    FILE *from = fopen(path, "rb");
    if (!from)
        return file;
    file.bytes = malloc(1 << 24);
    file.size = fread(file.bytes, 1, 1 << 24, from);
    fclose(from);
    return file;
}

// In a child with little memory and time; its exit status, or 128 and the signal.
static int read_in_child(const char *path)
{
    const pid_t child = fork();
    if (child == 0) {
#if !defined __SANITIZE_ADDRESS__ && !defined __SANITIZE_THREAD__
        const struct rlimit memory = {1u << 30, 1u << 30};
        setrlimit(RLIMIT_AS, &memory);
#endif
        alarm(60);
        struct file file = load(path);
        struct glint_frame *f;
        glint_status st = glint_exr_read(&f, file.bytes, file.size, NULL);
        glint_frame_destroy(&f);
        free(file.bytes);
        _exit(st == GLINT_E_NOMEM || st == GLINT_E_INTERNAL);
    }
    int status;
    assert_int_equal(waitpid(child, &status, 0), child);
    return WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
}

static unsigned read_folder(const char *name)
{
    char folder[2048], path[4096];
    snprintf(folder, sizeof folder, "%s/hostile/%s", scenes(), name);
    DIR *d = opendir(folder);
    if (!d)
        return 0;
    unsigned files = 0;
    for (struct dirent *e = readdir(d); e; e = readdir(d)) {
        if (*e->d_name == '.')
            continue;
        snprintf(path, sizeof path, "%s/%s", folder, e->d_name);
        const int rc = read_in_child(path);
        if (rc)
            print_message("# %s: %d\n", path, rc);
        assert_int_equal(rc, 0);
        files++;
    }
    closedir(d);
    return files;
}

static void known_hostile_files_do_no_harm(void **state)
{
    (void)state;
    if (read_folder("exr-damaged") + read_folder("exr-tinyexr") == 0)
        skip();
}

static void published_cryptomatte_samples_are_read(void **state)
{
    (void)state;
    char path[4096];
    snprintf(path, sizeof path, "%s/cryptomatte/special_chars.exr", scenes());
    struct file file = load(path);
    if (!file.bytes)
        skip();
    struct glint_frame *f;
    assert_int_equal(glint_exr_read(&f, file.bytes, file.size, NULL), GLINT_OK);
    free(file.bytes);
    assert_int_equal(f->width, 64);
    unsigned types = 0;
    float *matte = calloc((size_t)f->width * f->height, sizeof *matte);
    for (uint32_t i = 0; i < f->attributes; i++) {
        const struct glint_attribute *a = &f->attribute[i];
        if (strncmp(a->name, "cryptomatte/", 12) || !strstr(a->name, "/name"))
            continue;
        types++;
        const uint32_t nothing = 0;
        assert_int_equal(glint_cryptomatte_matte(f, a->text, &nothing, 1, matte, NULL), GLINT_OK);
    }
    assert_true(types > 0);
    free(matte);
    glint_frame_destroy(&f);
}

static void ids_keep_patterns_that_arithmetic_would_lose(void **state)
{
    (void)state;
    // Signalling NaNs, subnormals, minus zero: no ID of ours, but of others.
    static const uint32_t bits[] = {0x7f800001, 0xffa00000, 1, 0x80000000, 0x007fffff, 0x7f800000};
    struct glint_frame *f, *back;
    assert_int_equal(glint_frame_create(&f, COUNT(bits), 1, 0, 0, COUNT(bits), 1, NULL), GLINT_OK);
    memcpy(glint_frame_channel(f, "CryptoObject00.R", GLINT_PIXEL_FLOAT), bits, sizeof bits);
    struct file file = write_file(f, GLINT_EXR_ZIPS, GLINT_EXR_SINGLE);
    assert_int_equal(glint_exr_read(&back, file.bytes, file.size, NULL), GLINT_OK);
    const float *plane = glint_frame_find(back, "CryptoObject00.R");
    for (size_t i = 0; i < COUNT(bits); i++)
        assert_int_equal(to_bits(plane[i]), bits[i]);
    free(file.bytes);
    glint_frame_destroy(&f);
    glint_frame_destroy(&back);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_frame_comes_back_to_the_bit),
        cmocka_unit_test(a_half_is_its_float_to_2_to_the_minus_11),
        cmocka_unit_test(the_same_frame_gives_the_same_bytes),
        cmocka_unit_test(the_first_part_repeats_every_cryptomatte_key),
        cmocka_unit_test(every_half_survives),
        cmocka_unit_test(floats_round_to_the_nearest_half_ties_to_even),
        cmocka_unit_test(values_over_the_half_range_are_clamped_and_counted),
        cmocka_unit_test(what_would_break_ids_is_refused),
        cmocka_unit_test(ids_keep_patterns_that_arithmetic_would_lose),
        cmocka_unit_test(every_truncation_is_refused),
        cmocka_unit_test(damaged_bytes_never_crash_the_reader),
        cmocka_unit_test(a_size_that_the_file_cannot_hold_costs_no_memory),
        cmocka_unit_test(known_hostile_files_do_no_harm),
        cmocka_unit_test(published_cryptomatte_samples_are_read),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
