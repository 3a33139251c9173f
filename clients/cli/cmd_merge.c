// cmd_merge.c - merge: films of parts of a job become one frame, one film, or both.
#include "command.h"
#include "output.h"
#include "protocol/exr.h"
#include "protocol/film_merge.h"

#include <errno.h>
#include <fcntl.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

// What the command line asks for.
struct wish {
    const char *frame, *film; // files, or NULL
    uint32_t outputs;         // 0: all of the job's
    bool partial;
    struct glint_exr_options exr;
};

static bool read_outputs(const char *list, uint32_t *outputs)
{
    while (list) {
        char name[32];
        const size_t n = strcspn(list, ",");
        snprintf(name, sizeof name, "%.*s", (int)(n < 31 ? n : 31), list);
        const uint32_t bit = glint_output_from_name(name);
        if (!bit)
            return false;
        *outputs |= bit;
        list = list[n] ? list + n + 1 : NULL;
    }
    return true;
}

static glint_status read_wish(struct glint_session *s, const struct glint_arguments *a,
                              struct wish *w, struct glint_error *err)
{
    const char *layout = glint_options_text(a, "layout"), *pixels = glint_options_text(a, "pixels");
    const char *outputs = glint_options_text(a, "outputs");
    *w = (struct wish){.frame = glint_options_text(a, "output"),
                       .film = glint_options_text(a, "film"),
                       .partial = glint_options_flag(a, "partial"),
                       .exr = {.compression = GLINT_EXR_ZIP}};
    if (!w->frame && !w->film)
        return glint_session_usage(s, err, "merge wants -o FRAME.exr, --film FILE or both");
    if (w->frame && !glint_output_is(w->frame, "exr"))
        return glint_session_usage(s, err, "%s: merged frames are .exr", w->frame);
    if (!read_outputs(outputs, &w->outputs))
        return glint_session_usage(s, err, "--outputs: no such output in '%s'", outputs);
    if (layout && strcmp(layout, "single") && strcmp(layout, "multipart"))
        return glint_session_usage(s, err, "--layout is single or multipart, not '%s'", layout);
    if (layout && !strcmp(layout, "multipart"))
        w->exr.layout = GLINT_EXR_MULTIPART;
    if (pixels && strcmp(pixels, "half") && strcmp(pixels, "float"))
        return glint_session_usage(s, err, "--pixels is half or float, not '%s'", pixels);
    w->exr.floats = pixels && !strcmp(pixels, "float");
    return GLINT_OK;
}

// ---- films

static glint_status open_film(const char *path, struct glint_film_part *part,
                              struct glint_error *err)
{
    glint_film_file *file = NULL;
    struct glint_error own = {0};
    const int fd = open(path, O_RDONLY | O_CLOEXEC);
    glint_status st = fd < 0 ? glint_fail(&own, GLINT_E_IO, "", "%s", strerror(errno))
                             : glint_film_file_open(&file, fd, &own);
    if (fd >= 0)
        close(fd);
    for (size_t i = 0; i < own.count; i++)
        glint_fail(err, st, own.fault[i].pointer, "%s: %s", path, own.fault[i].detail);
    glint_error_finish(&own);
    *part = (struct glint_film_part){file, path};
    return st;
}

static void close_films(struct glint_film_part *part, size_t count)
{
    for (size_t i = 0; i < count; i++) {
        glint_film_file *file = (glint_film_file *)part[i].file;
        glint_film_file_close(&file);
    }
    free(part);
}

// All that can be opened are, so that every one that cannot is told of.
static glint_status open_films(const struct glint_arguments *a, struct glint_film_part **out,
                               struct glint_error *err)
{
    glint_status st = GLINT_OK;
    *out = calloc((size_t)a->count, sizeof **out);
    if (!*out)
        return glint_fail(err, GLINT_E_NOMEM, "", "no memory");
    for (int i = 0; i < a->count; i++) {
        const glint_status one = open_film(a->text[i], &(*out)[i], err);
        st = st ? st : one;
    }
    if (st)
        close_films(*out, (size_t)a->count);
    return st;
}

// ---- files

static glint_status put(struct glint_output_file *file, const void *bytes, size_t size,
                        struct glint_error *err)
{
    glint_output_write(file, bytes, size); // closing says what went wrong
    return glint_output_close(file, true, err);
}

static glint_status write_frame(const glint_film_sum *sum, const struct wish *w, uint64_t *size,
                                struct glint_error *err)
{
    const struct glint_film_source *source = glint_film_sum_source(sum);
    const struct glint_job *job = source->info->job;
    if (w->outputs & ~job->outputs)
        return glint_fail(err, GLINT_E_RANGE, "", "the films do not have all of these outputs");
    struct glint_frame *frame;
    uint8_t *bytes = NULL;
    size_t length = 0;
    glint_status st = glint_film_frame(source, job->region, w->outputs ? w->outputs : job->outputs,
                                       &frame, NULL, err);
    if (!st)
        st = glint_exr_write(frame, &w->exr, &bytes, &length, NULL, err);
    glint_frame_destroy(&frame);
    struct glint_output_file file;
    if (!st)
        st = glint_output_open(&file, w->frame, err);
    if (!st)
        st = put(&file, bytes, length, err);
    free(bytes);
    *size = length;
    return st;
}

static glint_status write_film(const glint_film_sum *sum, const char *path, struct glint_error *err)
{
    struct glint_output_file file;
    glint_status st = glint_output_open(&file, path, err);
    if (st)
        return st;
    st = glint_film_sum_write(sum, file.fd, err);
    const glint_status closed = glint_output_close(&file, !st, err);
    return st ? st : closed;
}

static void report(const struct glint_session *s, const glint_film_sum *sum, const struct wish *w,
                   uint64_t size)
{
    const char *const *warning;
    const size_t warnings = glint_film_sum_warnings(sum, &warning);
    const bool complete = glint_film_sum_source(sum)->complete;
    for (size_t i = 0; !s->json && i < warnings; i++)
        fprintf(stderr, "glint: warning: %s\n", warning[i]);
    if (!s->json) {
        if (w->frame)
            printf("%s: %llu bytes%s\n", w->frame, (unsigned long long)size,
                   complete ? "" : ", not complete");
        if (w->film)
            printf("%s: a film\n", w->film);
        return;
    }
    cJSON *document = cJSON_CreateObject();
    if (w->frame) {
        cJSON_AddStringToObject(document, "file", w->frame);
        cJSON_AddNumberToObject(document, "bytes", (double)size);
    }
    if (w->film)
        cJSON_AddStringToObject(document, "film", w->film);
    cJSON_AddBoolToObject(document, "complete", complete);
    cJSON_AddItemToObject(document, "warnings",
                          cJSON_CreateStringArray((const char **)warning, (int)warnings));
    glint_session_print(document);
}

static glint_status merge(struct glint_session *s, const struct glint_film_part *part, size_t count,
                          const struct wish *w, struct glint_error *err)
{
    glint_film_sum *sum;
    uint64_t size = 0;
    glint_status st = glint_film_merge(&sum, part, count, w->partial, err);
    if (!st && w->film)
        st = write_film(sum, w->film, err);
    if (!st && w->frame)
        st = write_frame(sum, w, &size, err);
    if (!st)
        report(s, sum, w, size);
    glint_film_sum_destroy(&sum);
    return st;
}

static glint_status run_merge(struct glint_session *s, const struct glint_arguments *a,
                              struct glint_error *err)
{
    struct wish wish;
    struct glint_film_part *part;
    glint_status st = read_wish(s, a, &wish, err);
    if (!st)
        st = open_films(a, &part, err);
    if (st)
        return st;
    st = merge(s, part, (size_t)a->count, &wish, err);
    close_films(part, (size_t)a->count);
    return st;
}

static const struct glint_option options[] = {
    {"output", 'o', "FILE", "the frame, .exr"},
    {"film", 0, "FILE", "the films as one, to be merged further or restored"},
    {"outputs", 0, "A,B", "only these outputs"},
    {"layout", 0, "KIND", "single (default) or multipart"},
    {"pixels", 0, "KIND", "of colour: half (default) or float"},
    {"partial", 0, NULL, "also where samples are missing"},
    {0},
};

const struct glint_command glint_command_merge = {
    .name = "merge",
    .operands = "FILM...",
    .summary = "Add up films of parts of a job",
    .detail = "Films of one job, split by region, by sample_range or both, make the frame of one\n"
              "run, bit for bit. 'glint get JOB -o FILE.film' downloads them.",
    .options = options,
    .least = 1,
    .most = 10000,
    .run = run_merge,
};
