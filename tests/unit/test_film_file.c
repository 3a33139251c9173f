// Films in files: whole, or refused. Whoever wrote them may have been cut off, or mean harm.
#include "tests/unit/film_bytes.h"

#include "protocol/film_file.h"
#include "protocol/film_pack.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>

#include <cmocka.h>
#include <fcntl.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <unistd.h>

static void check_header(const struct glint_film_header *h)
{
    const struct glint_film_moment *m = &h->moment;
    float to_camera[16], to_ndc[16];
    static const uint64_t counts[GLINT_COUNTS] = {5, 4, 3, 2, 1, 77, 9007199254740992};
    for (int i = 0; i < 16; i++) {
        to_camera[i] = (float)i / 3;
        to_ndc[i] = i ? -INFINITY : 1e-30f;
    }
    assert_string_equal(h->info.software, "glint x");
    assert_string_equal(h->info.revision, "abcd");
    assert_memory_equal(h->info.to_camera, to_camera, sizeof to_camera);
    assert_memory_equal(h->info.to_ndc, to_ndc, sizeof to_ndc);
    assert_int_equal(h->info.job->seed, 9);
    assert_int_equal(h->info.job->sample_range[0], 5);
    assert_int_equal(h->info.mattes, 4);
    assert_string_equal(h->info.matte[3].name[0], "равнина");
    assert_int_equal(h->info.matte[3].id[0], 0x9623511e);
    assert_int_equal(h->info.matte[2].id[2], 0);
    assert_true(m->sample == 8 && m->samples == 8 && m->target == 20 && !m->complete);
    assert_true(m->estimate.error == 0.25 && m->estimate.spread == 0.125 &&
                m->estimate.linear == 0.5 && m->estimate.tone_mapped == 0.375 &&
                isnan(m->estimate.tail) && m->worker_seconds == 1.5 &&
                m->camera_rays == 123456789012);
    assert_memory_equal(m->count, counts, sizeof m->count);
    assert_true(m->excess.pixels == 12 && m->excess.needed == 8 && m->excess.left_out == 0.25);
    assert_true(m->points == 2 && m->curve[0].error == 0.4 && isnan(m->curve[1].error));
    assert_non_null(cJSON_GetObjectItem(h->seconds, "a pass"));
    assert_non_null(cJSON_GetObjectItem(h->plan, "effects"));
}

static void check_tiles(const glint_film_file *file)
{
    const struct glint_film_info *info = &glint_film_file_header(file)->info;
    const size_t size = glint_film_file_tile_bytes(file);
    uint32_t *wanted = malloc(size), *got = malloc(size);
    for (uint32_t t = 0; t < 2; t++) {
        film_fill(info, t, wanted);
        assert_int_equal(glint_film_file_samples(file, t), t ? 11 : 3);
        assert_int_equal(glint_film_file_tile(file, t, got, NULL), GLINT_OK);
        assert_memory_equal(got, wanted, size);
    }
    free(wanted);
    free(got);
}

static void what_is_written_is_read_from_any_offset(void **state)
{
    (void)state;
    struct film_bytes b = film_example();
    for (size_t offset = 0; offset < 3; offset++) {
        glint_film_file *file;
        struct glint_error err = {0};
        const int fd = memfd_create("film", MFD_CLOEXEC);
        assert_int_equal(pwrite(fd, b.at, b.size, (off_t)offset), b.size);
        lseek(fd, (off_t)offset, SEEK_SET);
        if (glint_film_file_open(&file, fd, &err))
            fail_msg("%s: %s", err.fault[0].pointer, err.fault[0].detail);
        close(fd);
        check_header(glint_film_file_header(file));
        check_tiles(file);
        glint_film_file_close(&file);
    }
    free(b.at);
}

static void every_truncation_is_refused(void **state)
{
    (void)state;
    const struct film_bytes b = film_example();
    for (size_t n = 0; n < b.size; n++)
        film_assert_refused((struct film_bytes){b.at, n}, GLINT_E_SYNTAX);
    free(b.at);
}

static void every_flipped_byte_is_refused(void **state)
{
    (void)state;
    const struct film_bytes b = film_example();
    uint64_t seed = 3;
    for (size_t n = 0; n < b.size; n++) {
        const uint8_t was = b.at[n];
        b.at[n] ^= (uint8_t)(1 + film_dice(&seed, 255));
        film_assert_refused(b, n >= 8 && n < 12 ? 0
                                                : GLINT_E_SYNTAX); // the version may be another one
        b.at[n] = was;
    }
    free(b.at);
}

static void later_version_is_refused_by_its_name(void **state)
{
    (void)state;
    const struct film_bytes b = film_example();
    glint_film_file *file;
    struct glint_error err = {0};
    b.at[8] = 7;
    assert_int_equal(film_open(b, &file, &err), GLINT_E_VERSION);
    assert_non_null(strstr(err.fault[0].detail, "version 7"));
    assert_non_null(strstr(err.fault[0].detail, "up to 2"));
    glint_error_finish(&err);
    free(b.at);
}

static void film_that_goes_on_after_its_end_is_refused(void **state)
{
    (void)state;
    struct film_bytes b = film_example();
    b.at = realloc(b.at, b.size + 1);
    b.at[b.size++] = 0;
    film_assert_refused(b, GLINT_E_SYNTAX);
    free(b.at);
}

static void assert_faults(const char *text, const char *const *pointers, size_t count)
{
    struct glint_film_header *header;
    struct glint_error err = {0};
    assert_true(glint_film_header_parse(&header, text, strlen(text), &err) != GLINT_OK);
    assert_null(header);
    for (size_t i = 0; i < count; i++) {
        bool found = false;
        for (size_t k = 0; k < err.count; k++)
            found |= !strcmp(err.fault[k].pointer, pointers[i]);
        if (!found)
            fail_msg("no fault at %s", pointers[i]);
    }
    assert_int_equal(err.count, count);
    glint_error_finish(&err);
}

static void every_fault_of_a_header_is_named(void **state)
{
    (void)state;
    static const char *const missing[] = {"/software", "/revision",        "/job",
                                          "/planes",   "/world_to_camera", "/world_to_ndc",
                                          "/moment",   "/mattes"};
    static const char *const wrong[] = {"/software",
                                        "/job/resolution/0",
                                        "/job/scene",
                                        "/planes/aovs",
                                        "/world_to_camera",
                                        "/moment/samples",
                                        "/moment/curve/0/samples",
                                        "/moment/curve/0/rays",
                                        "/moment/counts/hats",
                                        "/moment/counts/nested",
                                        "/mattes/0/1",
                                        "/mattes/1",
                                        "/plan",
                                        "/hats"};
    assert_faults("{}", missing, sizeof missing / sizeof *missing);
    assert_faults(
        "{\"software\":7,\"revision\":\"\",\"job\":{\"resolution\":[0,1]},"
        "\"planes\":{\"aovs\":1,\"flow\":false,\"coverage\":true},"
        "\"world_to_camera\":[1],\"world_to_ndc\":[0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0],"
        "\"moment\":{\"sample\":0,\"samples\":17,\"camera_rays\":0,\"bounce_rays\":0,"
        "\"shadow_rays\":0,\"counts\":{\"hats\":1,\"not_a_number\":0,"
        "\"infinite\":0,\"negative\":0,\"nested\":-1,\"bright\":0,"
        "\"coverage_clamped\":0,\"coverage_lost\":0},\"curve\":[{\"samples\":0,\"seconds\":1}]},"
        "\"mattes\":[[\"a\",2,\"b\"],[\"a\"]],\"plan\":4,\"hats\":1}",
        wrong, sizeof wrong / sizeof *wrong);
}

static void packing_leaves_out_what_is_zero(void **state)
{
    (void)state;
    enum { BYTES = 4096 };
    uint32_t words[BYTES / 4], back[BYTES / 4];
    uint8_t packed[BYTES + BYTES / 32];
    uint64_t seed = 1;
    assert_int_equal(glint_film_pack_bound(BYTES), sizeof packed);
    for (uint32_t share = 0; share <= 10; share++) {
        size_t kept = 0;
        for (int i = 0; i < BYTES / 4; i++) {
            words[i] = film_dice(&seed, 10) < share ? 1 + film_dice(&seed, 1 << 30) : 0;
            kept += words[i] != 0;
        }
        const size_t size = glint_film_pack(words, BYTES, packed);
        assert_int_equal(size, BYTES / 32 + kept * 4);
        assert_true(glint_film_unpack(packed, size, back, BYTES));
        assert_memory_equal(words, back, BYTES);
        assert_false(glint_film_unpack(packed, size - 1, back, BYTES));
        assert_false(glint_film_unpack(packed, size + 4, back, BYTES));
    }
    assert_false(glint_film_unpack(packed, 3, back, BYTES));
}

static void file_that_is_written_to_later_is_not_believed(void **state)
{
    (void)state;
    const struct film_bytes b = film_example();
    glint_film_file *file;
    struct glint_error err = {0};
    const int fd = film_descriptor(b);
    assert_int_equal(glint_film_file_open(&file, fd, NULL), GLINT_OK);
    uint8_t *memory = malloc(glint_film_file_tile_bytes(file));
    assert_int_equal(pwrite(fd, "!", 1, (off_t)(b.size - 40)), 1);
    assert_int_equal(glint_film_file_tile(file, 0, memory, NULL), GLINT_OK);
    assert_int_equal(glint_film_file_tile(file, 1, memory, &err), GLINT_E_IO);
    glint_error_finish(&err);
    assert_int_equal(ftruncate(fd, 100), 0);
    assert_int_equal(glint_film_file_tile(file, 0, memory, NULL), GLINT_E_IO);
    free(memory);
    glint_film_file_close(&file);
    close(fd);
    free(b.at);
}

static void full_disk_is_told_of(void **state)
{
    (void)state;
    struct glint_job *job;
    struct glint_error err = {0};
    struct glint_film_writer w = {0};
    const int fd = memfd_create("film", MFD_CLOEXEC | MFD_ALLOW_SEALING);
    assert_int_equal(fcntl(fd, F_ADD_SEALS, F_SEAL_GROW), 0);
    assert_int_equal(glint_job_parse(&job, film_job, strlen(film_job), &err), GLINT_OK);
    struct glint_film_header h = film_header(job);
    assert_int_equal(glint_film_writer_begin(&w, fd, &h, &err), GLINT_OK); // buffered
    assert_int_equal(glint_film_writer_end(&w, &err), GLINT_E_IO);
    glint_film_writer_finish(&w);
    glint_error_finish(&err);
    cJSON_Delete(h.seconds);
    cJSON_Delete(h.plan);
    glint_job_destroy(&job);
    close(fd);
}
int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(what_is_written_is_read_from_any_offset),
        cmocka_unit_test(every_truncation_is_refused),
        cmocka_unit_test(every_flipped_byte_is_refused),
        cmocka_unit_test(later_version_is_refused_by_its_name),
        cmocka_unit_test(film_that_goes_on_after_its_end_is_refused),
        cmocka_unit_test(every_fault_of_a_header_is_named),
        cmocka_unit_test(packing_leaves_out_what_is_zero),
        cmocka_unit_test(file_that_is_written_to_later_is_not_believed),
        cmocka_unit_test(full_disk_is_told_of),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
