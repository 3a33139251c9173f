// Films in files: whole, or refused. Whoever wrote them may have been cut off, or mean harm.
#include "kernels/gk_film.h"
#include "kernels/gk_matte.h"
#include "protocol/film_file.h"
#include "protocol/film_pack.h"
#include "protocol/film_words.h"

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

#define HEAD 24 // bytes before the header

static const char *const job_text =
    "{\"scene\":\"s\",\"resolution\":[40,20],\"region\":[3,1,30,16],\"outputs\":[\"beauty\","
    "\"depth\",\"motion\",\"crypto_object\"],\"mattes\":{\"levels\":2,\"slots\":4},\"seed\":9,"
    "\"sample_range\":[5,20]}";

static const struct glint_matte_key keys[] = {
    {{NULL, NULL, NULL}, {0, 0, 0}},
    {{NULL, NULL, NULL}, {0, 0, 0}},
    {{"torus", "gold \"24\"", NULL}, {0xf19c73fd, 1, 0}},
    {{"равнина", NULL, "asset"}, {0x9623511e, 0, 1}},
};

static uint64_t seed;

static uint32_t dice(uint32_t sides)
{
    seed = seed * 6364136223846793005u + 1442695040888963407u;
    return (uint32_t)(seed >> 33) % sides;
}

struct bytes {
    uint8_t *at;
    size_t size;
};

static int file_of(struct bytes b)
{
    const int fd = memfd_create("film", MFD_CLOEXEC);
    assert_int_equal(write(fd, b.at, b.size), b.size);
    lseek(fd, 0, SEEK_SET);
    return fd;
}

static glint_status open_bytes(struct bytes b, glint_film_file **out, struct glint_error *err)
{
    const int fd = file_of(b);
    const glint_status st = glint_film_file_open(out, fd, err);
    close(fd);
    return st;
}

static struct glint_film_header example_header(struct glint_job *job)
{
    struct glint_film_header h = {
        .info = {.job = job,
                 .aovs = true,
                 .flow = true,
                 .coverage = true,
                 .software = "glint x",
                 .revision = "abcd",
                 .mattes = 4,
                 .matte = keys},
        .moment = {.sample = 8,
                   .samples = 8,
                   .tiles_log2 = 0,
                   .target = 20,
                   .estimate = {0.25, 0.125, 0.5, 0.375, NAN},
                   .worker_seconds = 1.5,
                   .camera_rays = 123456789012,
                   .count = {5, 4, 3, 2, 1, 77, 9007199254740992},
                   .points = 2,
                   .curve = {{2, 0.5, 0.4, 0.1, 7}, {4, 0.75, NAN, NAN, 9}}},
        .seconds = cJSON_Parse("{\"a pass\":0.125}"),
        .plan = cJSON_Parse("{\"effects\":[]}")};
    for (int i = 0; i < 16; i++) {
        h.info.to_camera[i] = (float)i / 3;
        h.info.to_ndc[i] = i ? -INFINITY : 1e-30f;
    }
    return h;
}

// Words of tile `tile`: few are not zero.
static void fill_tile(const struct glint_film_info *info, uint32_t tile, uint32_t *memory)
{
    const size_t planes = glint_film_info_plane_bytes(info) / 4;
    memset(memory, 0, glint_film_info_plane_bytes(info) + glint_film_info_table_bytes(info));
    for (size_t i = tile; i < planes; i += 97)
        memory[i] = gk_as_u32((float)(i + tile));
    uint64_t *table = (uint64_t *)(void *)(memory + planes);
    for (uint32_t i = 0; i < GK_TILE_PIXELS; i += 5)
        table[i * 6] = gk_matte_pack(1 + (i + tile) % 3, 1, 3 * GK_MATTE_ONE);
}

// Two tiles, the second with the samples of the pass.
static struct bytes example(void)
{
    struct glint_job *job;
    struct glint_error err = {0};
    struct glint_film_writer w = {0};
    const int fd = memfd_create("film", MFD_CLOEXEC);
    assert_int_equal(glint_job_parse(&job, job_text, strlen(job_text), &err), GLINT_OK);
    struct glint_film_header h = example_header(job);
    assert_int_equal(glint_film_writer_begin(&w, fd, &h, &err), GLINT_OK);
    uint32_t *memory = malloc(w.tile_bytes);
    for (uint32_t t = 0; t < 2; t++) {
        fill_tile(&h.info, t, memory);
        assert_int_equal(glint_film_writer_tile(&w, t, t ? 11 : 3, memory, &err), GLINT_OK);
    }
    assert_int_equal(glint_film_writer_end(&w, &err), GLINT_OK);
    glint_film_writer_finish(&w);
    free(memory);
    cJSON_Delete(h.seconds);
    cJSON_Delete(h.plan);
    glint_job_destroy(&job);
    const struct bytes b = {malloc((size_t)lseek(fd, 0, SEEK_END)), (size_t)lseek(fd, 0, SEEK_END)};
    assert_int_equal(pread(fd, b.at, b.size, 0), b.size);
    close(fd);
    return b;
}

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
        fill_tile(info, t, wanted);
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
    struct bytes b = example();
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

static void assert_refused(struct bytes b, glint_status status)
{
    glint_film_file *file;
    struct glint_error err = {0};
    const glint_status st = open_bytes(b, &file, &err);
    assert_null(file);
    assert_true(st != GLINT_OK && err.count > 0);
    if (status)
        assert_int_equal(st, status);
    glint_error_finish(&err);
}

static void every_truncation_is_refused(void **state)
{
    (void)state;
    const struct bytes b = example();
    for (size_t n = 0; n < b.size; n++)
        assert_refused((struct bytes){b.at, n}, GLINT_E_SYNTAX);
    free(b.at);
}

static void every_flipped_byte_is_refused(void **state)
{
    (void)state;
    const struct bytes b = example();
    seed = 3;
    for (size_t n = 0; n < b.size; n++) {
        const uint8_t was = b.at[n];
        b.at[n] ^= (uint8_t)(1 + dice(255));
        assert_refused(b, n >= 8 && n < 12 ? 0 : GLINT_E_SYNTAX); // the version may be another one
        b.at[n] = was;
    }
    free(b.at);
}

static void later_version_is_refused_by_its_name(void **state)
{
    (void)state;
    const struct bytes b = example();
    glint_film_file *file;
    struct glint_error err = {0};
    b.at[8] = 7;
    assert_int_equal(open_bytes(b, &file, &err), GLINT_E_VERSION);
    assert_non_null(strstr(err.fault[0].detail, "version 7"));
    assert_non_null(strstr(err.fault[0].detail, "up to 2"));
    glint_error_finish(&err);
    free(b.at);
}

static void film_that_goes_on_after_its_end_is_refused(void **state)
{
    (void)state;
    struct bytes b = example();
    b.at = realloc(b.at, b.size + 1);
    b.at[b.size++] = 0;
    assert_refused(b, GLINT_E_SYNTAX);
    free(b.at);
}

// ---- with every CRC as it should be

static uint32_t word(const struct bytes *b, size_t at)
{
    uint32_t w;
    memcpy(&w, b->at + at, 4);
    return w;
}

static void set_word(const struct bytes *b, size_t at, uint32_t w)
{
    memcpy(b->at + at, &w, 4);
}

// Puts the CRCs of all records right as far as their lengths lead.
static void seal(const struct bytes *b)
{
    uint32_t chain = 0, crc;
    size_t at = HEAD + word(b, 16), end;
    if (at > b->size)
        return;
    crc = glint_film_crc(b->at, 20, b->at + HEAD, word(b, 16));
    set_word(b, 20, crc);
    chain = glint_film_crc(&chain, 4, &crc, 4);
    for (; at + 16 <= b->size; at = end) {
        const bool last = word(b, at) == GLINT_FILM_END;
        end = at + 16 + (last ? 0 : (size_t)word(b, at + 8));
        if (end > b->size)
            return;
        if (last)
            set_word(b, at + 8, chain);
        crc = glint_film_crc(b->at + at, 12, b->at + at + 16, end - at - 16);
        set_word(b, at + 12, crc);
        chain = glint_film_crc(&chain, 4, &crc, 4);
    }
}

// Tables of one word of what was lost, with 77 units in it, as the pixels of the example have them.
static void lose_in_one_word(const struct glint_film_info *info, uint32_t *memory)
{
    uint64_t *table = (uint64_t *)(void *)((uint8_t *)memory + glint_film_info_plane_bytes(info));
    for (uint32_t i = 0; i < GK_TILE_PIXELS; i++) {
        memmove(table + i * 5, table + i * 6, 4 * sizeof *table);
        table[i * 5 + 4] = i == 3 ? 77 : 0;
    }
}

static struct bytes example_of_version_1(void)
{
    struct glint_job *job;
    struct glint_film_writer w = {0};
    const int fd = memfd_create("film", MFD_CLOEXEC);
    assert_int_equal(glint_job_parse(&job, job_text, strlen(job_text), NULL), GLINT_OK);
    struct glint_film_header h = example_header(job);
    assert_int_equal(glint_film_writer_begin(&w, fd, &h, NULL), GLINT_OK);
    uint32_t *memory = malloc(w.tile_bytes);
    w.tile_bytes -= GK_TILE_PIXELS * 8;
    for (uint32_t t = 0; t < 2; t++) {
        fill_tile(&h.info, t, memory);
        lose_in_one_word(&h.info, memory);
        assert_int_equal(glint_film_writer_tile(&w, t, t ? 11 : 3, memory, NULL), GLINT_OK);
    }
    assert_int_equal(glint_film_writer_end(&w, NULL), GLINT_OK);
    glint_film_writer_finish(&w);
    free(memory);
    cJSON_Delete(h.seconds);
    cJSON_Delete(h.plan);
    glint_job_destroy(&job);
    const struct bytes b = {malloc((size_t)lseek(fd, 0, SEEK_END)), (size_t)lseek(fd, 0, SEEK_END)};
    assert_int_equal(pread(fd, b.at, b.size, 0), b.size);
    close(fd);
    set_word(&b, 8, 1);
    seal(&b);
    return b;
}

// What is seen directly is all that the example has.
static void tables_of_version_1_have_lost_what_they_say(void **state)
{
    (void)state;
    const struct bytes b = example_of_version_1();
    glint_film_file *file;
    assert_int_equal(open_bytes(b, &file, NULL), GLINT_OK);
    const struct glint_film_info *info = &glint_film_file_header(file)->info;
    const size_t size = glint_film_file_tile_bytes(file);
    uint32_t *wanted = malloc(size), *got = malloc(size);
    fill_tile(info, 1, wanted);
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

static bool try_bytes(struct bytes b)
{
    glint_film_file *file;
    struct glint_error err = {0};
    const glint_status st = open_bytes(b, &file, &err);
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
    const struct bytes whole = example();
    const size_t records = HEAD + word(&whole, 16);
    uint32_t sound = 0;
    seed = 11;
    for (int round = 0; round < 6000; round++) {
        struct bytes b = {malloc(whole.size), whole.size};
        memcpy(b.at, whole.at, whole.size);
        for (uint32_t n = 1 + dice(4); n > 0; n--) {
            const size_t from = round % 3 == 0 ? HEAD : round % 3 == 1 ? records : 8;
            const size_t end = round % 3 == 0 ? records : round % 3 == 1 ? records + 1900 : b.size;
            static const char json[] = "0123456789\"{}[],:-.eE tfn";
            const size_t at = from + dice((uint32_t)(end - from));
            b.at[at] = round % 3 == 0 ? (uint8_t)json[dice(sizeof json - 1)] : (uint8_t)dice(256);
        }
        seal(&b);
        sound += try_bytes(b);
        free(b.at);
    }
    assert_true(sound > 100); // planes may hold anything
    free(whole.at);
}

static void change_record(size_t field, uint32_t value)
{
    struct bytes b = example();
    set_word(&b, HEAD + word(&b, 16) + field, value);
    seal(&b);
    assert_refused(b, GLINT_E_SYNTAX);
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
    struct bytes b = example();
    const size_t tile = HEAD + word(&b, 16), bytes = word(&b, tile + 8);
    const uint64_t slot = gk_matte_pack(4, 1, 3 * GK_MATTE_ONE);
    memcpy(b.at + tile + 16 + bytes - 8, &slot, 8); // the last slot of the tile
    seal(&b);
    assert_refused(b, GLINT_E_SYNTAX);
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
    seed = 1;
    assert_int_equal(glint_film_pack_bound(BYTES), sizeof packed);
    for (uint32_t share = 0; share <= 10; share++) {
        size_t kept = 0;
        for (int i = 0; i < BYTES / 4; i++) {
            words[i] = dice(10) < share ? 1 + dice(1 << 30) : 0;
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
    const struct bytes b = example();
    glint_film_file *file;
    struct glint_error err = {0};
    const int fd = file_of(b);
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
    assert_int_equal(glint_job_parse(&job, job_text, strlen(job_text), &err), GLINT_OK);
    struct glint_film_header h = example_header(job);
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
        cmocka_unit_test(tables_of_version_1_have_lost_what_they_say),
        cmocka_unit_test(film_that_goes_on_after_its_end_is_refused),
        cmocka_unit_test(forged_films_are_refused_or_sound),
        cmocka_unit_test(tiles_that_cannot_be_are_refused),
        cmocka_unit_test(key_without_names_is_refused),
        cmocka_unit_test(every_fault_of_a_header_is_named),
        cmocka_unit_test(packing_leaves_out_what_is_zero),
        cmocka_unit_test(file_that_is_written_to_later_is_not_believed),
        cmocka_unit_test(full_disk_is_told_of),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
