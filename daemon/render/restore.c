// restore.c - renders into files and back.
#include "render/adaptive.h"
#include "render/archive.h"
#include "render/capture.h"

#include <stdlib.h>
#include <string.h>

// ---- into a file

static glint_status write_tiles(struct glint_film_writer *w, struct glint_capture *c,
                                struct glint_error *err)
{
    const uint32_t tiles = glint_film_columns(c->view->film) * glint_film_rows(c->view->film);
    glint_status st = GLINT_OK;
    for (uint32_t t = 0; !st && t < tiles; t++) {
        const uint32_t samples =
            glint_film_capture_take(c->view->film, t, c->memory).samples; // whole ones
        if (samples)
            st = glint_film_writer_tile(w, t, samples, c->memory, err);
    }
    return st ? st : glint_film_writer_end(w, err);
}

static cJSON *describe_seconds(const double seconds[GLINT_PASSES])
{
    cJSON *o = cJSON_CreateObject();
    for (int p = 0; p < GLINT_PASSES; p++)
        cJSON_AddNumberToObject(o, glint_pass_name[p], seconds[p]);
    return o;
}

static glint_status write_film(struct glint_capture *c, int fd, struct glint_error *err)
{
    const struct glint_plan_use use = {c->view->scene, &c->view->job, c->seconds,
                                       glint_render_pixels(c->render)};
    struct glint_film_header header = {.info = c->view->info,
                                       .moment = c->moment,
                                       .seconds = describe_seconds(c->seconds),
                                       .plan = glint_plan_describe(&c->view->plan, &use)};
    struct glint_film_writer w = {0};
    header.info.job = &c->job;
    glint_status st = glint_film_writer_begin(&w, fd, &header, err);
    if (!st)
        st = write_tiles(&w, c, err);
    glint_film_writer_finish(&w);
    cJSON_Delete(header.seconds);
    cJSON_Delete(header.plan);
    return st;
}

static glint_status copy_film(const glint_archive *a, int fd, struct glint_error *err)
{
    const glint_film_file *file = glint_archive_file(a);
    const struct glint_film_header *h = glint_film_file_header(file);
    const uint32_t tiles = glint_film_info_columns(&h->info) * glint_film_info_rows(&h->info);
    struct glint_film_writer w = {0};
    void *memory = malloc(glint_film_file_tile_bytes(file));
    glint_status st = memory ? glint_film_writer_begin(&w, fd, h, err)
                             : glint_fail(err, GLINT_E_NOMEM, "", "no memory for a tile");
    for (uint32_t t = 0; !st && t < tiles; t++) {
        const uint32_t samples = glint_film_file_samples(file, t);
        if (samples)
            st = glint_film_file_tile(file, t, memory, err);
        if (samples && !st)
            st = glint_film_writer_tile(&w, t, samples, memory, err);
    }
    if (!st)
        st = glint_film_writer_end(&w, err);
    glint_film_writer_finish(&w);
    free(memory);
    return st;
}

glint_status glint_render_film(glint_render *r, int fd, struct glint_error *err)
{
    if (r->archive)
        return copy_film(r->archive, fd, err);
    struct glint_capture c;
    glint_status st = glint_capture_begin(&c, r, err);
    if (st)
        return st;
    st = write_film(&c, fd, err);
    glint_capture_end(&c);
    return st;
}

// ---- and back

static void take_moment(glint_render *r, const struct glint_film_header *h)
{
    const struct glint_film_moment *m = &h->moment;
    r->worker_seconds = m->worker_seconds;
    r->stats.camera_rays = m->camera_rays;
    r->stats.bounce_rays = m->bounce_rays;
    r->stats.shadow_rays = m->shadow_rays;
    memcpy(r->stats.count, m->count, sizeof r->stats.count);
    for (int p = 0; p < GLINT_PASSES; p++) {
        const cJSON *seconds = cJSON_GetObjectItemCaseSensitive(h->seconds, glint_pass_name[p]);
        r->stats.seconds[p] = cJSON_IsNumber(seconds) ? seconds->valuedouble : 0.0;
    }
    memcpy(r->curve, m->curve, sizeof r->curve);
    r->points = m->points;
    r->excess = m->excess;
    r->estimate = (struct glint_film_estimate){.whole = m->estimate};
    r->measured = glint_adaptive_goes(r) ? glint_adaptive_mean(r, m->sample)
                                         : m->sample - glint_render_first(r);
    r->estimated = (uint32_t)r->measured;
    r->forecast = GLINT_NO_FORECAST;
    r->pass_seconds = m->worker_seconds;
}

// Samples of each tile of a file, malloc'd.
static uint32_t *samples_of(const glint_film_file *file, struct glint_error *err)
{
    const struct glint_film_info *info = &glint_film_file_header(file)->info;
    const uint32_t tiles = glint_film_info_columns(info) * glint_film_info_rows(info);
    uint32_t *samples = malloc(tiles * sizeof *samples);
    for (uint32_t t = 0; samples && t < tiles; t++)
        samples[t] = glint_film_file_samples(file, t);
    if (!samples)
        glint_fail(err, GLINT_E_NOMEM, "", "no memory for %u tiles", tiles);
    return samples;
}

// The end is the job's, which may have moved since; what the film has it has.
static bool take_pass(glint_render *r, const struct glint_film_moment *m, const uint32_t *samples)
{
    const uint32_t end = m->sample + m->samples;
    if (!glint_pass_resume(r, m, samples))
        return false;
    if (glint_adaptive_goes(r))
        r->target = glint_adaptive_target(r, r->job.stop.samples);
    r->target = r->target < end ? end : r->target;
    return true;
}

// With all tiles in the film: whether it stops is decided as it was.
static void go_on(glint_render *r, const struct glint_film_moment *m)
{
    glint_render_foresee(r);
    if (!m->samples) {
        glint_pass_stops(r, m->sample);
        glint_pass_begin(r, m->sample);
    } else if (r->pass.done == r->pass.blocks) {
        glint_pass_end(r);
    }
}

static glint_status take_tiles(glint_render *r, const glint_film_file *file,
                               const uint32_t *samples, struct glint_error *err)
{
    const uint32_t tiles = glint_film_columns(r->film) * glint_film_rows(r->film);
    uint32_t *memory = malloc(glint_film_tile_bytes(r->film));
    glint_status st =
        memory ? GLINT_OK : glint_fail(err, GLINT_E_NOMEM, "", "no memory for a tile");
    for (uint32_t t = 0; !st && t < tiles; t++) {
        if (!samples[t])
            continue;
        st = glint_film_file_tile(file, t, memory, err);
        if (st)
            break;
        glint_film_put(r->film, t, memory, samples[t]);
        if (samples[t] >= 2)
            glint_render_measure(r, t, samples[t]);
        glint_render_measure_ranks(r, t, samples[t]);
    }
    free(memory);
    return st;
}

static glint_status torn_pass(struct glint_error *err)
{
    return glint_fail(err, GLINT_E_SYNTAX, "",
                      "tiles of one block of the film have more or fewer "
                      "samples than each other");
}

static glint_status restore(glint_render *r, const glint_film_file *file, const uint32_t *samples,
                            struct glint_error *err)
{
    const struct glint_film_header *h = glint_film_file_header(file);
    glint_status st = glint_film_same(&r->view->info, &h->info, false, "the film", err);
    if (st)
        return st;
    pthread_mutex_lock(&r->mutex);
    if (h->moment.shares && r->job.adaptive)
        st = glint_adaptive_take(r, h->moment.shares, err);
    if (!st)
        st = take_pass(r, &h->moment, samples) ? take_tiles(r, file, samples, err) : torn_pass(err);
    if (st) {
        glint_render_forget(r);
    } else {
        take_moment(r, h);
        go_on(r, &h->moment);
    }
    pthread_mutex_unlock(&r->mutex);
    return st;
}

glint_status glint_render_restore(glint_render *r, int fd, struct glint_error *err)
{
    glint_film_file *file;
    glint_status st = glint_film_file_open(&file, fd, err);
    if (st)
        return st;
    uint32_t *samples = samples_of(file, err);
    st = samples ? restore(r, file, samples, err) : GLINT_E_NOMEM;
    free(samples);
    glint_film_file_close(&file);
    return st;
}

// ---- without a scene

static glint_status fill(glint_render *r, glint_film_file **file, struct glint_error *err)
{
    const struct glint_film_header *h = glint_film_file_header(*file);
    glint_status st = glint_job_copy(&r->job, h->job, err);
    if (st)
        return st;
    if (h->moment.shares && r->job.adaptive)
        st = glint_adaptive_take(r, h->moment.shares, err);
    if (st)
        return st;
    r->target = h->moment.target;
    r->stopped = h->moment.stopped;
    take_moment(r, h);
    uint32_t *samples = samples_of(*file, err);
    if (!samples)
        return GLINT_E_NOMEM;
    st = glint_pass_resume(r, &h->moment, samples) ? GLINT_OK : torn_pass(err);
    free(samples);
    return st ? st : glint_archive_create(&r->archive, file, err);
}

glint_status glint_render_open(glint_render **out, int fd, struct glint_error *err)
{
    *out = NULL;
    glint_film_file *file;
    glint_status st = glint_film_file_open(&file, fd, err);
    if (st)
        return st;
    glint_render *r = calloc(1, sizeof *r);
    if (r) {
        pthread_mutex_init(&r->mutex, NULL);
        st = fill(r, &file, err);
    } else {
        st = glint_fail(err, GLINT_E_NOMEM, "", "no memory for a render");
    }
    glint_film_file_close(&file);
    if (st && r)
        glint_render_destroy(&r);
    *out = r;
    return st;
}
