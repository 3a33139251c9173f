// OpenEXR pictures: what they decode to, and that nothing damaged does harm. The corpora are found by
// GLINT_SCENES and skipped where they are not.
#include "scene/image_decode.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>
#include <dirent.h>
#include <math.h>
#include <openexr.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>
#include <unistd.h>

// ---- pictures of our own

struct maker {
    uint8_t bytes[1 << 16];
    uint64_t size;
};

static int64_t put(exr_const_context_t file, void *user, const void *bytes, uint64_t n, uint64_t at,
                   exr_stream_error_func_ptr_t failed)
{
    struct maker *m = user;
    (void)file;
    (void)failed;
    assert_true(at + n <= sizeof m->bytes);
    memcpy(m->bytes + at, bytes, n);
    m->size = at + n > m->size ? at + n : m->size;
    return (int64_t)n;
}

struct layout {
    const char *const *channel; // sorted
    int channels;
    int data[4], display[4]; // least x, y, greatest x, y
};

static exr_attr_box2i_t box_of(const int b[4])
{
    exr_attr_box2i_t box;
    box.min.x = b[0];
    box.min.y = b[1];
    box.max.x = b[2];
    box.max.y = b[3];
    return box;
}

#define CHECK(call) assert_int_equal(call, EXR_ERR_SUCCESS)

// Float channels, one chunk a line; value of channel c at (x, y) of the data window is
// values[(y * width + x) * channels + c].
static struct maker *make(const struct layout *l, const float *values)
{
    struct maker *m = calloc(1, sizeof *m);
    exr_context_initializer_t init = EXR_DEFAULT_CONTEXT_INITIALIZER;
    exr_context_t f;
    int part;
    const exr_attr_box2i_t data = box_of(l->data), display = box_of(l->display);
    exr_attr_v2f_t middle;
    middle.x = middle.y = 0.0f;
    init.user_data = m;
    init.write_fn = put;
    CHECK(exr_start_write(&f, "made", EXR_WRITE_FILE_DIRECTLY, &init));
    CHECK(exr_add_part(f, "part", EXR_STORAGE_SCANLINE, &part));
    CHECK(exr_initialize_required_attr(f, part, &display, &data, 1.0f, &middle, 1.0f,
                                       EXR_LINEORDER_INCREASING_Y, EXR_COMPRESSION_NONE));
    for (int c = 0; c < l->channels; c++)
        CHECK(exr_add_channel(f, part, l->channel[c], EXR_PIXEL_FLOAT, EXR_PERCEPTUALLY_LINEAR, 1,
                              1));
    CHECK(exr_write_header(f));
    const int w = data.max.x - data.min.x + 1;
    for (int y = data.min.y; y <= data.max.y; y++) {
        float line[256];
        for (int c = 0; c < l->channels; c++)
            for (int x = 0; x < w; x++)
                line[c * w + x] = values[((y - data.min.y) * w + x) * l->channels + c];
        CHECK(exr_write_scanline_chunk(f, part, y, line, (uint64_t)(w * l->channels) * 4));
    }
    CHECK(exr_finish(&f));
    return m;
}

static float half_value(const struct glint_pixels *p, uint32_t x, uint32_t y, int c)
{
    _Float16 h;
    memcpy(&h, (const uint16_t *)p->pixels + 4 * ((size_t)y * p->width + x) + c, sizeof h);
    return (float)h;
}

static const char *const rgb[] = {"B", "G", "R"};

static void display_window_is_the_picture(void **state)
{
    (void)state;
    // Two pixels of data in the second line, one of them beyond the right edge.
    const struct layout l = {rgb, 3, {2, 1, 3, 1}, {0, 0, 2, 1}};
    const float values[] = {3, 2, 1, 6, 5, 4};
    struct glint_error err = {0};
    struct glint_arena arena = {0};
    struct glint_pixels p;
    struct maker *m = make(&l, values);
    assert_int_equal(glint_image_decode(&p, &arena, m->bytes, m->size, "/i", &err), GLINT_OK);
    assert_int_equal(p.width, 3);
    assert_int_equal(p.height, 2);
    assert_int_equal(p.format, GLINT_IMAGE_RGBA16F);
    for (uint32_t i = 0; i < 6; i++)
        for (int c = 0; c < 4; c++)
            assert_true(half_value(&p, i % 3, i / 3, c) == (c == 3   ? 1.0f
                                                            : i == 5 ? 1.0f + c
                                                                     : 0.0f));
    assert_int_equal(p.clamped, 0);
    glint_arena_finish(&arena);
    free(m);
}

static void what_no_light_can_be_is_clamped_and_counted(void **state)
{
    (void)state;
    static const char *const grey[] = {"A", "Y"};
    const struct layout l = {grey, 2, {0, 0, 4, 0}, {0, 0, 4, 0}};
    const float values[] = {0, 0.5f, 0, -1, 0, NAN, 0, INFINITY, 0, 1e6f};
    const float want[] = {0.5f, 0, 0, 65504, 65504};
    struct glint_error err = {0};
    struct glint_arena arena = {0};
    struct glint_pixels p;
    struct maker *m = make(&l, values);
    assert_int_equal(glint_image_decode(&p, &arena, m->bytes, m->size, "/i", &err), GLINT_OK);
    for (uint32_t x = 0; x < 5; x++)
        for (int c = 0; c < 3; c++)
            assert_true(half_value(&p, x, 0, c) == want[x]);
    assert_int_equal(p.clamped, 4 * 3);
    glint_arena_finish(&arena);
    free(m);
}

static void every_truncation_is_refused(void **state)
{
    (void)state;
    const struct layout l = {rgb, 3, {0, 0, 3, 3}, {0, 0, 3, 3}};
    float values[48];
    for (int i = 0; i < 48; i++)
        values[i] = (float)i;
    struct maker *m = make(&l, values);
    for (uint64_t n = 4; n < m->size; n++) {
        struct glint_error err = {0};
        struct glint_arena arena = {0};
        struct glint_pixels p;
        uint8_t *part = malloc(n); // so that a sanitizer sees the end
        memcpy(part, m->bytes, n);
        assert_int_equal(glint_image_decode(&p, &arena, part, n, "/i", &err), GLINT_E_RANGE);
        assert_string_equal(err.fault[0].pointer, "/i");
        free(part);
        glint_error_finish(&err);
        glint_arena_finish(&arena);
    }
    free(m);
}

// ---- corpora

static uint8_t *read_file(const char *path, size_t *size)
{
    FILE *f = fopen(path, "rb");
    if (!f)
        return NULL;
    fseek(f, 0, SEEK_END);
    *size = (size_t)ftell(f);
    rewind(f);
    uint8_t *bytes = malloc(*size + 1);
    const size_t got = fread(bytes, 1, *size, f);
    fclose(f);
    assert_int_equal(got, *size);
    return bytes;
}

static glint_status decode_file(const char *path, struct glint_pixels *p, struct glint_arena *arena)
{
    struct glint_error err = {0};
    size_t size = 0;
    uint8_t *bytes = read_file(path, &size);
    assert_non_null(bytes);
    const glint_status st = glint_image_decode(p, arena, bytes, size, "/i", &err);
    free(bytes);
    glint_error_finish(&err);
    return st;
}

static const char *scenes(const char *folder, char *path, size_t capacity)
{
    const char *top = getenv("GLINT_SCENES"), *source = getenv("top_srcdir");
    if (top)
        snprintf(path, capacity, "%s/%s", top, folder);
    else
        snprintf(path, capacity, "%s/../shared/scenes/%s", source ? source : ".", folder);
    if (access(path, R_OK))
        skip();
    return path;
}

// Each within five seconds; how many of them are pictures after all.
static void assert_harmless(const char *folder)
{
    char top[2048], path[4096];
    unsigned read = 0, refused = 0;
    DIR *d = opendir(scenes(folder, top, sizeof top));
    assert_non_null(d);
    for (struct dirent *e; (e = readdir(d));) {
        struct glint_arena arena = {0};
        struct glint_pixels p;
        if (e->d_name[0] == '.')
            continue;
        snprintf(path, sizeof path, "%s/%s", top, e->d_name);
        const clock_t start = clock();
        const glint_status st = decode_file(path, &p, &arena);
        assert_true(st == GLINT_OK || st == GLINT_E_RANGE || st == GLINT_E_NOMEM);
        if (clock() - start > 5 * CLOCKS_PER_SEC)
            fail_msg("%s took %g s", e->d_name, (double)(clock() - start) / CLOCKS_PER_SEC);
        read += st == GLINT_OK;
        refused += st != GLINT_OK;
        glint_arena_finish(&arena);
    }
    closedir(d);
    print_message("# %s: %u read, %u refused\n", folder, read, refused);
}

static void damaged_files_do_no_harm(void **state)
{
    (void)state;
    assert_harmless("hostile/exr-damaged");
}

static void files_from_another_writer_do_no_harm(void **state)
{
    (void)state;
    assert_harmless("hostile/exr-tinyexr");
}

static void environments_in_dwab_are_read(void **state)
{
    (void)state;
    static const char *const name[] = {"env/forest.dwab.exr", "env/sunset.dwab.exr"};
    for (int i = 0; i < 2; i++) {
        char path[2048];
        struct glint_arena arena = {0};
        struct glint_pixels p;
        assert_int_equal(decode_file(scenes(name[i], path, sizeof path), &p, &arena), GLINT_OK);
        assert_true(p.width == 2 * p.height);
        double sum = 0.0;
        for (uint32_t y = 0; y < p.height; y++)
            for (uint32_t x = 0; x < p.width; x++)
                sum += half_value(&p, x, y, 1);
        print_message("# %s: %ux%u, mean of G %.4f, %llu values clamped\n", name[i], p.width,
                      p.height, sum / ((double)p.width * p.height), (unsigned long long)p.clamped);
        assert_true(sum > 0.0);
        glint_arena_finish(&arena);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(display_window_is_the_picture),
        cmocka_unit_test(what_no_light_can_be_is_clamped_and_counted),
        cmocka_unit_test(every_truncation_is_refused),
        cmocka_unit_test(damaged_files_do_no_harm),
        cmocka_unit_test(files_from_another_writer_do_no_harm),
        cmocka_unit_test(environments_in_dwab_are_read),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
