#include "tests/unit/film_bytes.h"

#include "kernels/gk_film.h"
#include "kernels/gk_matte.h"
#include "protocol/film_file.h"
#include "protocol/film_words.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>

#include <cmocka.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <unistd.h>

const char *const film_job =
    "{\"scene\":\"s\",\"resolution\":[40,20],\"region\":[3,1,30,16],\"outputs\":[\"beauty\","
    "\"depth\",\"motion\",\"crypto_object\"],\"mattes\":{\"levels\":2,\"slots\":4},\"seed\":9,"
    "\"sample_range\":[5,20]}";

static const struct glint_matte_key keys[] = {
    {{NULL, NULL, NULL}, {0, 0, 0}},
    {{NULL, NULL, NULL}, {0, 0, 0}},
    {{"torus", "gold \"24\"", NULL}, {0xf19c73fd, 1, 0}},
    {{"равнина", NULL, "asset"}, {0x9623511e, 0, 1}},
};

uint32_t film_dice(uint64_t *seed, uint32_t sides)
{
    *seed = *seed * 6364136223846793005u + 1442695040888963407u;
    return (uint32_t)(*seed >> 33) % sides;
}

int film_descriptor(struct film_bytes b)
{
    const int fd = memfd_create("film", MFD_CLOEXEC);
    assert_int_equal(write(fd, b.at, b.size), b.size);
    lseek(fd, 0, SEEK_SET);
    return fd;
}

glint_status film_open(struct film_bytes b, glint_film_file **out, struct glint_error *err)
{
    const int fd = film_descriptor(b);
    const glint_status st = glint_film_file_open(out, fd, err);
    close(fd);
    return st;
}

struct glint_film_header film_header(struct glint_job *job)
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
                   .estimate = {0.25, 0.125, 0.5, 0.375, NAN, NAN},
                   .worker_seconds = 1.5,
                   .camera_rays = 123456789012,
                   .count = {5, 4, 3, 2, 1, 77, 9007199254740992},
                   .excess = {12, 8, 0.25},
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

void film_fill(const struct glint_film_info *info, uint32_t tile, uint32_t *memory)
{
    const size_t planes = glint_film_info_plane_bytes(info) / 4;
    memset(memory, 0, glint_film_info_plane_bytes(info) + glint_film_info_table_bytes(info));
    for (size_t i = tile; i < planes; i += 97)
        memory[i] = gk_as_u32((float)(i + tile));
    uint64_t *table = (uint64_t *)(void *)(memory + planes);
    for (uint32_t i = 0; i < GK_TILE_PIXELS; i += 5)
        table[i * 6] = gk_matte_pack(1 + (i + tile) % 3, 1, 3 * GK_MATTE_ONE);
}

uint32_t film_word(const struct film_bytes *b, size_t at)
{
    uint32_t w;
    memcpy(&w, b->at + at, 4);
    return w;
}

void film_set_word(const struct film_bytes *b, size_t at, uint32_t w)
{
    memcpy(b->at + at, &w, 4);
}

void film_seal(const struct film_bytes *b)
{
    uint32_t chain = 0, crc;
    size_t at = FILM_HEAD + film_word(b, 16), end;
    if (at > b->size)
        return;
    crc = glint_film_crc(b->at, 20, b->at + FILM_HEAD, film_word(b, 16));
    film_set_word(b, 20, crc);
    chain = glint_film_crc(&chain, 4, &crc, 4);
    for (; at + 16 <= b->size; at = end) {
        const bool last = film_word(b, at) == GLINT_FILM_END;
        end = at + 16 + (last ? 0 : (size_t)film_word(b, at + 8));
        if (end > b->size)
            return;
        if (last)
            film_set_word(b, at + 8, chain);
        crc = glint_film_crc(b->at + at, 12, b->at + at + 16, end - at - 16);
        film_set_word(b, at + 12, crc);
        chain = glint_film_crc(&chain, 4, &crc, 4);
    }
}

// `lose` changes the tables of a tile to such of fewer words, NULL: as they are.
static struct film_bytes written(void (*lose)(const struct glint_film_info *, uint32_t *))
{
    struct glint_job *job;
    struct glint_film_writer w = {0};
    const int fd = memfd_create("film", MFD_CLOEXEC);
    assert_int_equal(glint_job_parse(&job, film_job, strlen(film_job), NULL), GLINT_OK);
    struct glint_film_header h = film_header(job);
    assert_int_equal(glint_film_writer_begin(&w, fd, &h, NULL), GLINT_OK);
    uint32_t *memory = malloc(w.tile_bytes);
    if (lose)
        w.tile_bytes -= GK_TILE_PIXELS * 8;
    for (uint32_t t = 0; t < 2; t++) {
        film_fill(&h.info, t, memory);
        if (lose)
            lose(&h.info, memory);
        assert_int_equal(glint_film_writer_tile(&w, t, t ? 11 : 3, memory, NULL), GLINT_OK);
    }
    assert_int_equal(glint_film_writer_end(&w, NULL), GLINT_OK);
    glint_film_writer_finish(&w);
    free(memory);
    cJSON_Delete(h.seconds);
    cJSON_Delete(h.plan);
    glint_job_destroy(&job);
    const off_t end = lseek(fd, 0, SEEK_END);
    const struct film_bytes b = {malloc((size_t)end), (size_t)end};
    assert_int_equal(pread(fd, b.at, b.size, 0), b.size);
    close(fd);
    return b;
}

struct film_bytes film_example(void)
{
    return written(NULL);
}

static void lose_in_one_word(const struct glint_film_info *info, uint32_t *memory)
{
    uint64_t *table = (uint64_t *)(void *)((uint8_t *)memory + glint_film_info_plane_bytes(info));
    for (uint32_t i = 0; i < GK_TILE_PIXELS; i++) {
        memmove(table + i * 5, table + i * 6, 4 * sizeof *table);
        table[i * 5 + 4] = i == 3 ? 77 : 0;
    }
}

struct film_bytes film_example_of_version_1(void)
{
    const struct film_bytes b = written(lose_in_one_word);
    film_set_word(&b, 8, 1);
    film_seal(&b);
    return b;
}

void film_assert_refused(struct film_bytes b, glint_status status)
{
    glint_film_file *file;
    struct glint_error err = {0};
    const glint_status st = film_open(b, &file, &err);
    assert_null(file);
    assert_true(st != GLINT_OK && err.count > 0);
    if (status)
        assert_int_equal(st, status);
    glint_error_finish(&err);
}
