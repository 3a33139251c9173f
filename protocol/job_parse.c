// job_parse.c - a job's JSON, every fault of it at once.
#include "protocol/job_parts.h"
#include "protocol/scene_parts.h"

#include <assert.h>
#include <stdlib.h>
#include <string.h>

#define MAX_KNOWN 16
#define MIN_FPS 0.01f

static void set_defaults(struct glint_job *job)
{
    job->width = 1280;
    job->height = 720;
    job->outputs = GLINT_OUT_BEAUTY | GLINT_OUT_CRYPTO;
    memcpy(job->dial, glint_preset_table[0].setting, sizeof job->dial);
    job->matte_levels = GLINT_DEFAULT_LEVELS;
    job->matte_alpha = 0.1f;
    job->matte_clamp = job->matte_diffuse_cut = job->matte_env_id = true;
    job->filter = GLINT_FILTER_BLACKMAN_HARRIS;
    job->max_bounces = 8;
    job->stop.samples = GLINT_DEFAULT_SAMPLES;
}

static void check_scene_name(const struct glint_json *at, const char *name)
{
    static const char allowed[] =
        "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789._-";
    const size_t n = name ? strlen(name) : 0;
    if (name && (n < 1 || n > 128 || strspn(name, allowed) != n))
        glint_json_fault(at, "a scene's name has 1 to 128 of A-Z a-z 0-9 . _ -");
}

static void read_camera(const struct glint_json *at, struct glint_job *job)
{
    if (cJSON_IsObject(at->value)) {
        job->has_camera = true;
        glint_camera_read(at, "camera", NULL, &job->arena, &job->camera);
    } else if (at->value && !cJSON_IsString(at->value)) {
        glint_json_fault(at, "the name of one of the scene's cameras, or a camera, is expected");
    } else {
        glint_json_string(at, &job->arena, &job->camera_name);
    }
}

static void read_resolution(const struct glint_json *at, struct glint_job *job)
{
    uint32_t size[2] = {job->width, job->height};
    if (!glint_json_uints(at, 2, 1, GLINT_MAX_SIDE, size))
        size[0] = size[1] = GLINT_MAX_SIDE; // so that a region is not blamed for it
    job->width = size[0];
    job->height = size[1];
}

static void read_region(const struct glint_json *at, struct glint_job *job)
{
    uint32_t r[4] = {0, 0, job->width, job->height};
    if (glint_json_uints(at, 4, 0, GLINT_MAX_SIDE, r) &&
        (r[2] < 1 || r[3] < 1 || r[0] + r[2] > job->width || r[1] + r[3] > job->height))
        glint_json_fault(at, "%u x %u pixels at %u, %u are not inside of %u x %u", r[2], r[3], r[0],
                         r[1], job->width, job->height);
    memcpy(job->region, r, sizeof r);
}

static void read_output(const struct glint_json *at, uint32_t *outputs)
{
    const char *names[33] = {NULL};
    for (int bit = 0, n = 0; bit < 32; bit++)
        if (glint_output_name(1u << bit))
            names[n++] = glint_output_name(1u << bit);
    int choice = 0;
    if (!glint_json_choice(at, names, &choice))
        return;
    const uint32_t bit = glint_output_from_name(names[choice]);
    if (*outputs & bit)
        glint_json_fault(at, "\"%s\" is listed twice", names[choice]);
    *outputs |= bit;
}

static void read_outputs(const struct glint_json *at, struct glint_job *job)
{
    size_t count, i = 0;
    if (!at->value || !glint_json_length(at, &count))
        return;
    if (!count)
        glint_json_fault(at, "at least one output is expected");
    job->outputs = 0;
    for (const cJSON *c = at->value->child; c; c = c->next, i++) {
        const struct glint_json item = glint_json_item(at, c, i);
        read_output(&item, &job->outputs);
    }
    if (job->outputs & GLINT_OUT_MATTE_SUMS && !(job->outputs & GLINT_OUT_CRYPTO))
        glint_json_fault(at, "matte_sums come with crypto_object, crypto_material or crypto_asset");
}

// ---- accuracy and mattes: what rows of the dial table name `parent`

static void read_preset(const struct glint_json *at, struct glint_job *job)
{
    const char *names[MAX_KNOWN] = {NULL};
    assert(glint_preset_count < MAX_KNOWN);
    for (size_t i = 0; i < glint_preset_count; i++)
        names[i] = glint_preset_table[i].name;
    int preset = 0;
    if (at->value && glint_json_choice(at, names, &preset))
        memcpy(job->dial, glint_preset_table[preset].setting, sizeof job->dial);
}

static void read_dials(const struct glint_json *object, const char *parent, struct glint_job *job)
{
    for (int d = 0; d < GLINT_DIAL_COUNT; d++) {
        const struct glint_dial_row *row = &glint_dial_table[d];
        if (strcmp(row->parent, parent))
            continue;
        const struct glint_json at = glint_json_member(object, row->name);
        int setting = job->dial[d];
        glint_json_choice(&at, row->setting, &setting);
        job->dial[d] = (uint8_t)setting;
        job->pinned |= at.value ? 1u << d : 0;
    }
}

// The dials of `parent` and the plain members are all that the object may have.
static void known_only(const struct glint_json *object, const char *parent,
                       const struct glint_field *plain)
{
    const char *names[MAX_KNOWN] = {NULL};
    size_t n = 0;
    for (; plain->kind; plain++)
        names[n++] = plain->name;
    for (int d = 0; d < GLINT_DIAL_COUNT; d++)
        if (strcmp(glint_dial_table[d].parent, parent) == 0)
            names[n++] = glint_dial_table[d].name;
    assert(n < MAX_KNOWN);
    glint_json_only(object, names);
}

static void read_accuracy(const struct glint_json *at, struct glint_job *job)
{
    static const struct glint_field plain[] = {
        GLINT_FIELD_KNOWN("preset"), GLINT_FIELD_KNOWN("time"), GLINT_FIELD_KNOWN("error"), {0}};
    const struct glint_json preset = glint_json_member(at, "preset");
    known_only(at, "accuracy", plain);
    read_preset(&preset, job);
    read_dials(at, "accuracy", job);
    glint_fields_read_listed(at, glint_budget_fields, &job->arena, &job->budget);
}

// Who has the settings picked says what for, and renders all of a frame once.
static void check_budget(const struct glint_json *root, struct glint_job *job)
{
    const struct glint_json at = glint_json_member(root, "accuracy");
    const struct glint_json error = glint_json_member(&at, "error");
    const struct glint_json stop = glint_json_member(root, "stop");
    if (glint_json_member(root, "max_bounces").value)
        job->pinned |= 1u << GLINT_DIAL_COUNT;
    if (job->budget.seconds <= 0 && job->budget.error <= 0)
        return;
    if (job->budget.seconds > 0 && job->budget.error > 0)
        glint_json_fault(&error, "a time or an error is asked for, not both");
    if (job->live || job->sample_range[1])
        glint_json_fault(&at, "the settings of a %s are not picked",
                         job->live ? "live job" : "sample range");
    if (!stop.value)
        job->stop.samples = GLINT_MAX_SAMPLES;
}

// Who writes as many ranks as it takes keeps all the candidates that there can be.
static uint32_t slots_for(uint32_t levels)
{
    if (!levels)
        return (uint32_t)glint_matte_fields[0].high;
    return levels > GLINT_DEFAULT_LEVELS ? 2 * levels : 2 * GLINT_DEFAULT_LEVELS;
}

// Twice as many candidates as ranks that are written: CONVENTIONS' ranking filter.
static void read_slots(const struct glint_json *mattes, struct glint_job *job)
{
    const struct glint_json slots = glint_json_member(mattes, "slots");
    const struct glint_json levels = glint_json_member(mattes, "levels");
    const struct glint_field *f = glint_matte_fields;
    bool fine = glint_fields_read_one(&levels, &f[1], &job->arena, job);
    job->matte_slots = slots_for(job->matte_levels);
    fine &= glint_json_uint(&slots, (uint32_t)f[0].low, (uint32_t)f[0].high, &job->matte_slots);
    if (!fine)
        return;
    if (job->matte_slots % 2)
        glint_json_fault(&slots, "an even number is expected, not %u", job->matte_slots);
    else if (job->matte_slots > f[0].high)
        glint_json_fault(&levels, "%u levels need %u slots; there are at most %.0f",
                         job->matte_levels, job->matte_slots, f[0].high);
    else if (job->matte_slots < 2 * job->matte_levels)
        glint_json_fault(&slots, "%u levels need at least %u slots, not %u", job->matte_levels,
                         2 * job->matte_levels, job->matte_slots);
}

static void read_mattes(const struct glint_json *at, struct glint_job *job)
{
    known_only(at, "mattes", glint_matte_fields);
    read_dials(at, "mattes", job);
    read_slots(at, job);
    glint_fields_read_listed(at, glint_matte_fields + 2, &job->arena, job);
    const struct glint_json bins = glint_json_member(at, "depth_bins");
    if (job->matte_classes && job->matte_depth_bins)
        glint_json_fault(&bins, "a path has a class of bounce or one of depth, not both");
}

// ---- the rest

static void read_filter(const struct glint_json *at, struct glint_job *job)
{
    job->filter_width = 0; // out of range: not said
    glint_fields_read(at, glint_filter_fields, &job->arena, job);
    if (job->filter_width == 0)
        job->filter_width = glint_filter_widths[job->filter];
}

static void read_stop(const struct glint_json *at, struct glint_job *job)
{
    if (!at->value)
        return;
    job->stop = (struct glint_job_stop){.samples = GLINT_MAX_SAMPLES};
    glint_fields_read(at, glint_stop_fields, &job->arena, &job->stop);
}

// The range says how many samples there are, and a part of a frame does not know the error of all.
static void read_sample_range(const struct glint_json *root, struct glint_job *job)
{
    const struct glint_json at = glint_json_member(root, "sample_range");
    const struct glint_json stop = glint_json_member(root, "stop");
    const struct glint_json samples = glint_json_member(&stop, "samples");
    const struct glint_json error = glint_json_member(&stop, "error");
    const struct glint_json live = glint_json_member(root, "live");
    uint32_t range[2];
    if (!at.value || !glint_json_uints(&at, 2, 0, GLINT_MAX_SAMPLES, range))
        return;
    if (range[0] >= range[1]) {
        glint_json_fault(&at, "from %u to %u there is no sample", range[0], range[1]);
        return;
    }
    memcpy(job->sample_range, range, sizeof range);
    job->stop.samples = range[1] - range[0];
    if (samples.value)
        glint_json_fault(&samples, "the sample range says how many samples there are");
    if (error.value)
        glint_json_fault(&error, "a job with a sample range does not stop by its error");
    if (job->live)
        glint_json_fault(&live, "a live job has no sample range");
}

// Frames a second: the scene's where it is 0, else as in a scene.
static void check_time(const struct glint_json *root, const struct glint_job *job)
{
    const struct glint_json fps = glint_json_member(root, "fps");
    const struct glint_json shutter = glint_json_member(root, "shutter");
    if (job->fps > 0 && job->fps < MIN_FPS)
        glint_json_fault(&fps, "%g is neither 0, the scene's, nor at least %g", job->fps, MIN_FPS);
    if (job->shutter[0] > job->shutter[1])
        glint_json_fault(&shutter, "it opens at %g, after it closes at %g", job->shutter[0],
                         job->shutter[1]);
}

// Each edit starts the frame of a live job anew: its error has no history to stop by, and its scene
// has other names.
static void check_live(const struct glint_json *root, const struct glint_job *job)
{
    const struct glint_json mattes = glint_json_member(root, "mattes");
    const struct glint_json eviction = glint_json_member(&mattes, "eviction");
    if (job->live && job->dial[GLINT_DIAL_EVICTION] == GLINT_EVICTION_EXACT)
        glint_json_fault(&eviction, "a live job does not know how many names there will be");
    const struct glint_json stop = glint_json_member(root, "stop");
    const struct glint_json error = glint_json_member(&stop, "error");
    if (job->live && job->stop.error > 0)
        glint_json_fault(&error, "a live job stops by samples or seconds, not by its error");
}

// A pilot decides for all samples of a frame that does not change.
static void check_adaptive(const struct glint_json *root, const struct glint_job *job)
{
    const struct glint_json at = glint_json_member(root, "adaptive");
    if (!job->adaptive)
        return;
    if (job->live)
        glint_json_fault(&at, "a live job takes the same samples everywhere");
    if (job->sample_range[1])
        glint_json_fault(&at, "a job with a sample range takes all of it everywhere");
    else if (job->stop.samples < GLINT_ADAPTIVE_SAMPLES)
        glint_json_fault(&at, "at least %u samples are expected, not %u: 16 are the pilot's",
                         GLINT_ADAPTIVE_SAMPLES, job->stop.samples);
}

// What has no independent parts cannot be asked for its error.
static void check_estimate(const struct glint_json *root, const struct glint_job *job)
{
    const struct glint_json stop = glint_json_member(root, "stop");
    const struct glint_json accuracy = glint_json_member(root, "accuracy");
    const struct {
        bool asked;
        struct glint_json at;
    } needs[] = {{job->stop.error > 0, glint_json_member(&stop, "error")},
                 {job->budget.error > 0, glint_json_member(&accuracy, "error")},
                 {job->adaptive, glint_json_member(root, "adaptive")},
                 {job->outputs & GLINT_OUT_VARIANCE, glint_json_member(root, "outputs")}};
    for (size_t i = 0; job->estimate == GLINT_ESTIMATE_NONE && i < sizeof needs / sizeof *needs;
         i++)
        if (needs[i].asked)
            glint_json_fault(&needs[i].at, "with estimate none a job does not know its noise");
}

static void read_members(const struct glint_json *root, struct glint_job *job)
{
    const struct {
        const char *name;
        void (*read)(const struct glint_json *, struct glint_job *);
    } parts[] = {{"camera", read_camera},     {"resolution", read_resolution},
                 {"region", read_region},     {"outputs", read_outputs},
                 {"accuracy", read_accuracy}, {"mattes", read_mattes},
                 {"filter", read_filter},     {"stop", read_stop}};
    const struct glint_json scene = glint_json_member(root, "scene");
    glint_fields_read(root, glint_job_fields, &job->arena, job);
    glint_json_require(&scene);
    check_scene_name(&scene, job->scene);
    check_time(root, job);
    for (size_t i = 0; i < sizeof parts / sizeof *parts; i++) {
        const struct glint_json at = glint_json_member(root, parts[i].name);
        parts[i].read(&at, job);
    }
    read_sample_range(root, job);
    check_live(root, job);
    check_budget(root, job);
    check_adaptive(root, job);
    check_estimate(root, job);
    if (!job->name)
        job->name = glint_arena_string(&job->arena, "");
    if (!job->name)
        glint_fail(root->err, GLINT_E_NOMEM, "", "no memory for a job");
}

static glint_status read_tree(struct glint_job *job, const cJSON *tree, struct glint_error *err)
{
    struct glint_error faults = {0}; // of this job alone, whatever `err` holds already
    const struct glint_json root = glint_json_root(tree, &faults);
    set_defaults(job);
    read_members(&root, job);
    const glint_status status = faults.status;
    for (size_t i = 0; i < faults.count; i++)
        glint_fail(err, status, faults.fault[i].pointer, "%s", faults.fault[i].detail);
    glint_error_finish(&faults);
    return status;
}

glint_status glint_job_parse(struct glint_job **out, const char *text, size_t length,
                             struct glint_error *err)
{
    assert(out && text);
    *out = NULL;
    cJSON *tree;
    glint_status status = glint_json_parse(&tree, text, length, &glint_json_request, err);
    if (status)
        return status;
    struct glint_job *job = calloc(1, sizeof *job);
    status =
        job ? read_tree(job, tree, err) : glint_fail(err, GLINT_E_NOMEM, "", "no memory for a job");
    cJSON_Delete(tree);
    if (status)
        glint_job_destroy(&job);
    *out = job;
    return status;
}
