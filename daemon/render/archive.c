#include "render/archive.h"

#include <stdlib.h>

struct glint_archive {
    glint_film_file *file;
};

glint_status glint_archive_create(glint_archive **out, glint_film_file **file,
                                  struct glint_error *err)
{
    *out = calloc(1, sizeof **out);
    if (!*out)
        return glint_fail(err, GLINT_E_NOMEM, "", "no memory for a film");
    (*out)->file = *file;
    *file = NULL;
    return GLINT_OK;
}

void glint_archive_close(glint_archive **archive)
{
    if (*archive)
        glint_film_file_close(&(*archive)->file);
    free(*archive);
    *archive = NULL;
}

const glint_film_file *glint_archive_file(const glint_archive *a)
{
    return a->file;
}

// A reader of tiles.
struct reader {
    const glint_film_file *file;
    uint64_t memory[]; // of a tile
};

static glint_status begin_tile(void *user, uint32_t tile, struct glint_film_pixels *out,
                               struct glint_error *err)
{
    struct reader *r = user;
    const struct glint_film_info *info = &glint_film_file_header(r->file)->info;
    const uint32_t samples = glint_film_file_samples(r->file, tile);
    out->planes = (const float *)(const void *)r->memory;
    if (info->coverage)
        out->table = r->memory + glint_film_info_plane_bytes(info) / sizeof *r->memory;
    for (uint32_t h = 0; h < 2; h++)
        out->half[h] = glint_film_half(info->job->sample_range[0], samples, h);
    return samples ? glint_film_file_tile(r->file, tile, r->memory, err) : GLINT_OK;
}

static void end_tile(void *user, uint32_t tile)
{
    (void)user;
    (void)tile;
}

glint_status glint_archive_source(const glint_archive *a, struct glint_film_source *out,
                                  struct glint_error *err)
{
    const struct glint_film_header *header = glint_film_file_header(a->file);
    struct reader *r = malloc(sizeof *r + glint_film_file_tile_bytes(a->file));
    if (!r)
        return glint_fail(err, GLINT_E_NOMEM, "", "no memory for a tile");
    r->file = a->file;
    *out = (struct glint_film_source){.info = &header->info,
                                      .complete = header->moment.complete,
                                      .user = r,
                                      .begin = begin_tile,
                                      .end = end_tile};
    return GLINT_OK;
}

void glint_archive_release(struct glint_film_source *source)
{
    free(source->user);
}

uint32_t glint_archive_biases(const glint_archive *a)
{
    return glint_film_file_header(a->file)->moment.biases;
}

cJSON *glint_archive_plan(const glint_archive *a)
{
    const cJSON *plan = glint_film_file_header(a->file)->plan;
    return plan ? cJSON_Duplicate(plan, true) : cJSON_CreateObject();
}
