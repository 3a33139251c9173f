// job_write.c - a job with every default spelled out.
#include "protocol/job_parts.h"
#include "protocol/scene_parts.h"

#include <string.h>

static void write_uints(struct glint_text *t, const char *key, const uint32_t *value, size_t count)
{
    glint_text_key(t, key);
    glint_text_add(t, "[");
    for (size_t i = 0; i < count; i++) {
        glint_text_item(t);
        glint_text_print(t, "%u", value[i]);
    }
    glint_text_add(t, "]");
}

static void write_camera(struct glint_text *t, const struct glint_job *job)
{
    if (job->has_camera) {
        glint_text_key(t, "camera");
        glint_text_add(t, "{");
        glint_camera_write(t, &job->camera);
        glint_text_add(t, "}");
    } else if (job->camera_name) {
        glint_text_key(t, "camera");
        glint_text_string(t, job->camera_name);
    }
}

static void write_outputs(struct glint_text *t, uint32_t outputs)
{
    glint_text_key(t, "outputs");
    glint_text_add(t, "[");
    for (uint32_t bit = 1; bit; bit <<= 1) {
        if (!(outputs & bit) || !glint_output_name(bit))
            continue;
        glint_text_item(t);
        glint_text_string(t, glint_output_name(bit));
    }
    glint_text_add(t, "]");
}

static void write_group(struct glint_text *t, const char *key, const struct glint_field *fields,
                        const void *record)
{
    glint_text_key(t, key);
    glint_text_add(t, "{");
    glint_fields_write(t, fields, record);
    glint_text_add(t, "}");
}

// The dials of a parent after its plain members.
static void write_dials(struct glint_text *t, const char *parent, const struct glint_field *fields,
                        const void *record, const struct glint_job *job)
{
    glint_text_key(t, parent);
    glint_text_add(t, "{");
    glint_fields_write(t, fields, record);
    for (int d = 0; d < GLINT_DIAL_COUNT; d++) {
        if (strcmp(glint_dial_table[d].parent, parent))
            continue;
        glint_text_key(t, glint_dial_table[d].name);
        glint_text_string(t, glint_dial_table[d].setting[job->dial[d]]);
    }
    glint_text_add(t, "}");
}

// Where the settings were to be picked, for what: beside it stand those that were.
static void write_accuracy(struct glint_text *t, const struct glint_job *job)
{
    const struct glint_job_budget *budget = &job->budget;
    struct glint_field fields[3] = {{0}};
    size_t n = 0;
    for (const struct glint_field *f = glint_budget_fields; f->kind; f++)
        if (*(const double *)((const char *)budget + f->offset) > 0)
            fields[n++] = *f;
    write_dials(t, "accuracy", fields, budget, job);
}

// What was not asked for is left out: an absent member of `stop` imposes nothing.
static void write_stop(struct glint_text *t, const struct glint_job *job)
{
    const struct glint_job_stop *stop = &job->stop;
    glint_text_key(t, "stop");
    glint_text_add(t, "{");
    if (stop->samples < GLINT_MAX_SAMPLES && !job->sample_range[1]) {
        glint_text_key(t, "samples");
        glint_text_print(t, "%u", stop->samples);
    }
    if (stop->seconds > 0) {
        glint_text_key(t, "seconds");
        glint_text_double(t, stop->seconds);
    }
    if (stop->error > 0) {
        glint_text_key(t, "error");
        glint_text_double(t, stop->error);
    }
    if (stop->least > 0) {
        glint_text_key(t, "least");
        glint_text_print(t, "%u", stop->least);
    }
    glint_text_add(t, "}");
}

char *glint_job_write(const struct glint_job *job)
{
    struct glint_text t = {0};
    glint_text_add(&t, "{");
    glint_fields_write(&t, glint_job_fields, job);
    write_camera(&t, job);
    write_uints(&t, "resolution", (const uint32_t[]){job->width, job->height}, 2);
    write_uints(&t, "region", job->region, 4);
    write_outputs(&t, job->outputs);
    write_accuracy(&t, job);
    write_dials(&t, "mattes", glint_matte_fields, job, job);
    write_group(&t, "filter", glint_filter_fields, job);
    if (job->sample_range[1])
        write_uints(&t, "sample_range", job->sample_range, 2);
    write_stop(&t, job);
    glint_text_add(&t, "}");
    return glint_text_take(&t, NULL);
}
