// job.c - the tables of a job: its outputs and its plain members.
#include "protocol/job_parts.h"

#include <stdlib.h>
#include <string.h>

static const struct {
    uint32_t bit;
    const char *name;
} outputs[] = {
    {GLINT_OUT_BEAUTY, "beauty"},
    {GLINT_OUT_CRYPTO_OBJECT, "crypto_object"},
    {GLINT_OUT_CRYPTO_MATERIAL, "crypto_material"},
    {GLINT_OUT_CRYPTO_ASSET, "crypto_asset"},
    {GLINT_OUT_DEPTH, "depth"},
    {GLINT_OUT_NORMAL, "normal"},
    {GLINT_OUT_ALBEDO, "albedo"},
    {GLINT_OUT_SAMPLES, "samples"},
    {GLINT_OUT_VARIANCE, "variance"},
    {GLINT_OUT_MOTION, "motion"},
    {GLINT_OUT_MATTE_SUMS, "matte_sums"},
};

static const char *const filters[] = {"box", "blackman_harris", NULL};
static const char *const as_it_takes[] = {"auto", NULL};
static const char *const estimates[] = {"halves", "batches", "none", NULL};
const float glint_filter_widths[] = {[GLINT_FILTER_BOX] = 1, [GLINT_FILTER_BLACKMAN_HARRIS] = 1.5f};

const struct glint_field glint_job_fields[] = {
    GLINT_FIELD(STRING, struct glint_job, scene),
    GLINT_FIELD(STRING, struct glint_job, name),
    GLINT_FIELD_KNOWN("camera"),
    GLINT_FIELD_KNOWN("resolution"),
    GLINT_FIELD_KNOWN("region"),
    GLINT_FIELD_KNOWN("outputs"),
    GLINT_FIELD_KNOWN("accuracy"),
    GLINT_FIELD_KNOWN("mattes"),
    GLINT_FIELD_KNOWN("filter"),
    GLINT_FIELD_KNOWN("stop"),
    GLINT_FIELD_KNOWN("sample_range"),
    GLINT_FIELD(UINT, struct glint_job, frame, .high = UINT32_MAX),
    GLINT_FIELD(FLOAT, struct glint_job, fps, .high = 1000),
    GLINT_FIELD(FLOAT, struct glint_job, shutter, .count = 2, .low = -16, .high = 16),
    GLINT_FIELD(STRING, struct glint_job, animation),
    GLINT_FIELD(BOOL, struct glint_job, live),
    GLINT_FIELD(BOOL, struct glint_job, adaptive),
    {.name = "estimate",
     .kind = GLINT_FIELD_CHOICE,
     .offset = offsetof(struct glint_job, estimate),
     .choices = estimates},
    GLINT_FIELD(UINT, struct glint_job, max_bounces, .high = 1024),
    GLINT_FIELD(UINT, struct glint_job, seed, .high = UINT32_MAX),
    GLINT_FIELD(INT, struct glint_job, priority, .low = -100, .high = 100),
    {0},
};

const struct glint_field glint_filter_fields[] = {
    {.name = "kind",
     .kind = GLINT_FIELD_CHOICE,
     .offset = offsetof(struct glint_job, filter),
     .choices = filters},
    {.name = "width",
     .kind = GLINT_FIELD_FLOAT,
     .offset = offsetof(struct glint_job, filter_width),
     .low = 0.5,
     .high = 16},
    {0},
};

const struct glint_field glint_stop_fields[] = {
    GLINT_FIELD(UINT, struct glint_job_stop, samples, .low = 1, .high = GLINT_MAX_SAMPLES),
    GLINT_FIELD(DOUBLE, struct glint_job_stop, seconds, .low = 1e-3, .high = 1e9),
    GLINT_FIELD(DOUBLE, struct glint_job_stop, error, .low = 1e-9, .high = 1e9),
    GLINT_FIELD(UINT, struct glint_job_stop, least, .high = GLINT_MAX_SAMPLES),
    {0},
};

const struct glint_field glint_budget_fields[] = {
    {.name = "time",
     .kind = GLINT_FIELD_DOUBLE,
     .offset = offsetof(struct glint_job_budget, seconds),
     .low = 1e-3,
     .high = 1e9},
    GLINT_FIELD(DOUBLE, struct glint_job_budget, error, .low = 1e-9, .high = 1e9),
    {0},
};

const struct glint_field glint_matte_fields[] = {
    {.name = "slots",
     .kind = GLINT_FIELD_UINT,
     .offset = offsetof(struct glint_job, matte_slots),
     .low = 4,
     .high = 32},
    {.name = "levels",
     .kind = GLINT_FIELD_COUNT,
     .offset = offsetof(struct glint_job, matte_levels),
     .low = 1,
     .high = GLINT_MAX_LEVELS,
     .choices = as_it_takes},
    {.name = "alpha",
     .kind = GLINT_FIELD_FLOAT,
     .offset = offsetof(struct glint_job, matte_alpha),
     .high = 16},
    {.name = "clamp", .kind = GLINT_FIELD_BOOL, .offset = offsetof(struct glint_job, matte_clamp)},
    {.name = "diffuse_cut",
     .kind = GLINT_FIELD_BOOL,
     .offset = offsetof(struct glint_job, matte_diffuse_cut)},
    {.name = "env_id",
     .kind = GLINT_FIELD_BOOL,
     .offset = offsetof(struct glint_job, matte_env_id)},
    {.name = "classes",
     .kind = GLINT_FIELD_BOOL,
     .offset = offsetof(struct glint_job, matte_classes)},
    {.name = "depth_bins",
     .kind = GLINT_FIELD_UINT,
     .offset = offsetof(struct glint_job, matte_depth_bins),
     .high = 10},
    {.name = "cone_width",
     .kind = GLINT_FIELD_UINT,
     .offset = offsetof(struct glint_job, matte_cone_width),
     .high = GLINT_MAX_SIDE},
    {0},
};

uint32_t glint_output_from_name(const char *name)
{
    for (size_t i = 0; i < sizeof outputs / sizeof *outputs; i++)
        if (strcmp(outputs[i].name, name) == 0)
            return outputs[i].bit;
    return 0;
}

const char *glint_output_name(uint32_t bit)
{
    for (size_t i = 0; i < sizeof outputs / sizeof *outputs; i++)
        if (outputs[i].bit == bit)
            return outputs[i].name;
    return NULL;
}

glint_status glint_job_copy(struct glint_job *out, const struct glint_job *job,
                            struct glint_error *err)
{
    *out = *job;
    out->arena = (struct glint_arena){0};
    char **const string[] = {&out->scene,     &out->name,      &out->camera_name,
                             &out->animation, &out->camera.id, &out->camera.name};
    bool fine = true;
    for (size_t i = 0; i < sizeof string / sizeof *string; i++) {
        char *copy = glint_arena_string(&out->arena, *string[i]);
        fine &= copy || !*string[i];
        *string[i] = copy;
    }
    if (fine)
        return GLINT_OK;
    glint_arena_finish(&out->arena);
    return glint_fail(err, GLINT_E_NOMEM, "", "no memory for a job");
}

void glint_job_destroy(struct glint_job **job)
{
    if (!*job)
        return;
    struct glint_arena arena = (*job)->arena;
    glint_arena_finish(&arena);
    free(*job);
    *job = NULL;
}
