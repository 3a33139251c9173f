// Films whose CRCs are as they should be, but not what they cover.
#include "tests/unit/film_bytes.h"

#include "kernels/gk_matte.h"
#include "protocol/film_file.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>

#include <cmocka.h>
#include <stdlib.h>
#include <string.h>

// What is seen directly is all that the example has.
static void tables_of_version_1_have_lost_what_they_say(void **state)
{
    (void)state;
    const struct film_bytes b = film_example_of_version_1();
    glint_film_file *file;
    assert_int_equal(film_open(b, &file, NULL), GLINT_OK);
    const struct glint_film_info *info = &glint_film_file_header(file)->info;
    const size_t size = glint_film_file_tile_bytes(file);
    uint32_t *wanted = malloc(size), *got = malloc(size);
    film_fill(info, 1, wanted);
    uint64_t *table = (uint64_t *)(void *)((uint8_t *)wanted + glint_film_info_plane_bytes(info));
    table[3 * 6 + 4 + GK_MATTE_LOST_PRIMARY] = 77;
    assert_int_equal(glint_film_file_tile(file, 1, got, NULL), GLINT_OK);
    assert_memory_equal(got, wanted, size);
    free(wanted);
    free(got);
    glint_film_file_close(&file);
    free(b.at);
}

static glint_status file_begin(void *user, uint32_t tile, struct glint_film_pixels *out,
                               struct glint_error *err)
{
    const glint_film_file *file = *(glint_film_file **)user;
    const struct glint_film_info *info = &glint_film_file_header(file)->info;
    const uint32_t samples = glint_film_file_samples(file, tile);
    uint8_t *memory = calloc(1, glint_film_file_tile_bytes(file));
    ((void **)user)[1] = memory;
    out->planes = (const float *)(void *)memory;
    out->table = (const uint64_t *)(void *)(memory + glint_film_info_plane_bytes(info));
    out->table = info->coverage ? out->table : NULL;
    out->half[0] = glint_film_half(info->job->sample_range[0], samples, 0);
    out->half[1] = glint_film_half(info->job->sample_range[0], samples, 1);
    return samples ? glint_film_file_tile(file, tile, memory, err) : GLINT_OK;
}

static void file_end(void *user, uint32_t tile)
{
    (void)tile;
    free(((void **)user)[1]);
}

// Whatever was read makes frames and mattes.
static void use(glint_film_file *file)
{
    void *user[2] = {file, NULL};
    const struct glint_film_info *info = &glint_film_file_header(file)->info;
    const struct glint_film_source source = {
        .info = info, .user = user, .begin = file_begin, .end = file_end};
    struct glint_frame *frame = NULL;
    struct glint_matte_totals totals;
    if ((uint64_t)info->job->region[2] * info->job->region[3] > 1 << 16)
        return; // takes time and shows nothing else
    assert_int_equal(
        glint_film_frame(&source, info->job->region, info->job->outputs, &frame, NULL, NULL),
        GLINT_OK);
    glint_frame_destroy(&frame);
    if (!info->coverage)
        return;
    struct glint_matte_found *found;
    size_t count;
    assert_int_equal(glint_film_mattes(&source, 7u, &totals, NULL), GLINT_OK);
    glint_matte_totals_finish(&totals);
    assert_int_equal(glint_film_pick(&source, info->job->region[0], info->job->region[1],
                                     info->job->outputs, &found, &count, NULL),
                     GLINT_OK);
    free(found);
}

static bool try_bytes(struct film_bytes b)
{
    glint_film_file *file;
    struct glint_error err = {0};
    const glint_status st = film_open(b, &file, &err);
    assert_int_equal(st != GLINT_OK, err.count > 0);
    if (!st)
        use(file);
    glint_film_file_close(&file);
    glint_error_finish(&err);
    return !st;
}

// Bytes of the header, of lengths and of packed tiles, with CRCs that fit.
static void forged_films_are_refused_or_sound(void **state)
{
    (void)state;
    const struct film_bytes whole = film_example();
    const size_t records = FILM_HEAD + film_word(&whole, 16);
    uint32_t sound = 0;
    uint64_t seed = 11;
    for (int round = 0; round < 6000; round++) {
        struct film_bytes b = {malloc(whole.size), whole.size};
        memcpy(b.at, whole.at, whole.size);
        for (uint32_t n = 1 + film_dice(&seed, 4); n > 0; n--) {
            const size_t from = round % 3 == 0 ? FILM_HEAD : round % 3 == 1 ? records : 8;
            const size_t end = round % 3 == 0 ? records : round % 3 == 1 ? records + 1900 : b.size;
            static const char json[] = "0123456789\"{}[],:-.eE tfn";
            const size_t at = from + film_dice(&seed, (uint32_t)(end - from));
            b.at[at] = round % 3 == 0 ? (uint8_t)json[film_dice(&seed, sizeof json - 1)]
                                      : (uint8_t)film_dice(&seed, 256);
        }
        film_seal(&b);
        sound += try_bytes(b);
        free(b.at);
    }
    assert_true(sound > 100); // planes may hold anything
    free(whole.at);
}

static void change_record(size_t field, uint32_t value)
{
    struct film_bytes b = film_example();
    film_set_word(&b, FILM_HEAD + film_word(&b, 16) + field, value);
    film_seal(&b);
    film_assert_refused(b, GLINT_E_SYNTAX);
    free(b.at);
}

static void tiles_that_cannot_be_are_refused(void **state)
{
    (void)state;
    change_record(0, 1);          // twice the second
    change_record(0, 2);          // there are two
    change_record(0, UINT32_MAX); // the end comes too early
    change_record(4, 0);          // no samples
    change_record(4, 4);          // samples of no pass
    change_record(8, 0);          // too few bytes
    change_record(8, UINT32_MAX); // beyond the file
    change_record(8, 1);
}

static void key_without_names_is_refused(void **state)
{
    (void)state;
    struct film_bytes b = film_example();
    const size_t tile = FILM_HEAD + film_word(&b, 16), bytes = film_word(&b, tile + 8);
    const uint64_t slot = gk_matte_pack(4, 1, 3 * GK_MATTE_ONE);
    memcpy(b.at + tile + 16 + bytes - 8, &slot, 8); // the last slot of the tile
    film_seal(&b);
    film_assert_refused(b, GLINT_E_SYNTAX);
    free(b.at);
}
int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(tables_of_version_1_have_lost_what_they_say),
        cmocka_unit_test(forged_films_are_refused_or_sound),
        cmocka_unit_test(tiles_that_cannot_be_are_refused),
        cmocka_unit_test(key_without_names_is_refused),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
