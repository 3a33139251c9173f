#include "accuracy_run.h"

#include "accuracy_files.h"
#include "accuracy_mean.h"
#include "accuracy_render.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

// Seeds of the two halves of references: far from those of settings, which count from 1.
#define REFERENCE_SEED 1000001u

// What was there already took no time.
static double seconds_left(const struct glint_accuracy_run *run)
{
    return run->rendered ? run->seconds / (double)run->rendered * (double)(run->all - run->done)
                         : NAN;
}

static void show(struct glint_accuracy_run *run)
{
    const struct glint_progress_state state = {.fraction = (double)run->done / (double)run->all,
                                               .samples = (uint32_t)run->done,
                                               .target_samples = (uint32_t)run->all,
                                               .unit = "jobs",
                                               .error = NAN,
                                               .eta_seconds = seconds_left(run),
                                               .state = "rendering"};
    glint_progress_show(&run->session->progress, &state);
}

static double now(void)
{
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

static glint_status render(struct glint_accuracy_run *run, const struct glint_accuracy_order *order,
                           struct glint_error *err)
{
    const double start = now();
    const glint_status st = glint_accuracy_render(run->session, order, err);
    run->seconds += now() - start;
    run->rendered++;
    return st;
}

// ---- references

struct half {
    const char *folder;
    char name[160];
};

static glint_status keep_half(void *user, const struct glint_accuracy_look *look,
                              struct glint_error *err)
{
    const struct half *half = user;
    return glint_accuracy_save_frame(look->frame, half->folder, half->name, err);
}

static glint_status load_half(struct glint_accuracy_run *run, size_t group, const struct half *half,
                              struct glint_accuracy_image *out, struct glint_error *err)
{
    struct glint_frame *frame;
    glint_status st = glint_accuracy_load_frame(&frame, run->folder, half->name, err);
    if (!st && !frame)
        st = glint_fail(err, GLINT_E_IO, "", "%s has gone", half->name);
    if (!st)
        st = glint_accuracy_image_take(out, frame, run->plan->group[group].matte, err);
    glint_frame_destroy(&frame);
    return st;
}

static glint_status render_half(struct glint_accuracy_run *run, size_t group, int h,
                                struct glint_accuracy_image *out, struct glint_error *err)
{
    const struct glint_accuracy_group *g = &run->plan->group[group];
    struct half half = {.folder = run->folder};
    struct glint_frame *known;
    char name[GLINT_ACCURACY_NAME];
    glint_accuracy_file_name(g->name, name, sizeof name);
    snprintf(half.name, sizeof half.name, "work/reference-%s-%u-%c.exr", name,
             run->reference_samples, "ab"[h]);
    const struct glint_accuracy_order order = {.job = run->plan->setting[g->twin].job,
                                               .seed = REFERENCE_SEED + (uint32_t)h,
                                               .ladder = &run->reference_samples,
                                               .steps = 1,
                                               .look = keep_half,
                                               .user = &half};
    glint_status st = glint_accuracy_load_frame(&known, run->folder, half.name, err);
    if (!st && !known)
        st = render(run, &order, err);
    glint_frame_destroy(&known);
    run->done++;
    show(run);
    return st ? st : load_half(run, group, &half, out, err);
}

static glint_status make_references(struct glint_accuracy_run *run, struct glint_error *err)
{
    glint_status st = GLINT_OK;
    run->reference = calloc(run->plan->groups, sizeof *run->reference);
    if (!run->reference)
        return glint_fail(err, GLINT_E_NOMEM, "", "no memory for references");
    for (size_t g = 0; g < run->plan->groups && !st; g++) {
        struct glint_accuracy_image half[2] = {{0}};
        for (int h = 0; h < 2 && !st; h++)
            st = render_half(run, g, h, &half[h], err);
        if (!st)
            st = glint_accuracy_reference_take(&run->reference[g], half, run->plan->group[g].matte,
                                               err);
        glint_accuracy_image_finish(&half[0]);
        glint_accuracy_image_finish(&half[1]);
    }
    return st;
}

// ---- settings

struct taking {
    struct glint_accuracy_run *run;
    const struct glint_accuracy_setting *setting;
    unsigned seed;
    struct glint_accuracy_mean mean;
};

void glint_accuracy_mean_name(const struct glint_accuracy_run *run,
                              const struct glint_accuracy_setting *setting, char out[160])
{
    char knob[GLINT_ACCURACY_NAME], value[GLINT_ACCURACY_VALUE];
    glint_accuracy_file_name(setting->knob, knob, sizeof knob);
    glint_accuracy_file_name(setting->value, value, sizeof value);
    snprintf(out, 160, "work/mean-%s-%s-%u.exr", knob, value, run->ladder[run->steps - 1]);
}

static void fill_error(struct glint_accuracy_row *row, const struct glint_accuracy_error *e)
{
    row->rmse61 = e->rmse61;
    row->relmse = e->relmse;
    row->relmse_trim = e->relmse_trim;
    row->matte_mae = e->matte_mae;
    row->tv = e->tv;
    row->matte_max = e->matte_max;
    row->lost = e->lost;
    row->within = e->within;
}

static void fill_names(struct glint_accuracy_row *row, const struct taking *t)
{
    const struct glint_accuracy_run *run = t->run;
    snprintf(row->scene, sizeof row->scene, "%s", run->scene);
    snprintf(row->method, sizeof row->method, "%s", t->setting->method);
    snprintf(row->knob, sizeof row->knob, "%s", t->setting->knob);
    snprintf(row->value, sizeof row->value, "%s", t->setting->value);
    snprintf(row->seed, sizeof row->seed, "%u", t->seed);
    snprintf(row->build, sizeof row->build, "%s", run->build);
    row->threads = run->threads;
}

static glint_status add_row(struct taking *t, const struct glint_accuracy_look *look,
                            const struct glint_accuracy_image *image, struct glint_error *err)
{
    const struct glint_accuracy_group *group = &t->run->plan->group[t->setting->group];
    struct glint_accuracy_error e;
    struct glint_accuracy_row *row = glint_accuracy_table_add(&t->run->table);
    if (!row)
        return glint_fail(err, GLINT_E_NOMEM, "", "no memory for a row");
    glint_accuracy_compare(&e, image, &t->run->reference[t->setting->group]);
    fill_names(row, t);
    fill_error(row, &e);
    row->spp = look->spp;
    memcpy(row->rays, look->rays, sizeof row->rays);
    row->cpu = look->cpu;
    row->wall = look->wall;
    row->est_error = look->error;
    snprintf(row->ref_id, sizeof row->ref_id, "%s:2x%u%s", group->name, t->run->reference_samples,
             e.limited ? ":limited" : "");
    return GLINT_OK;
}

static glint_status take_look(void *user, const struct glint_accuracy_look *look,
                              struct glint_error *err)
{
    struct taking *t = user;
    const size_t group = t->setting->group;
    struct glint_accuracy_image image;
    glint_status st =
        glint_accuracy_image_take(&image, look->frame, t->run->plan->group[group].matte, err);
    if (st)
        return st;
    st = glint_accuracy_image_align(&image, &t->run->reference[group].mean, err);
    if (!st)
        st = add_row(t, look, &image, err);
    if (!st && look->spp == t->run->ladder[t->run->steps - 1] && !(t->mean.seeds >> t->seed & 1))
        glint_accuracy_mean_add(&t->mean, t->seed, &image);
    glint_accuracy_image_finish(&image);
    return st;
}

static bool is_of(void *user, const struct glint_accuracy_row *row)
{
    const struct taking *t = user;
    char seed[16];
    snprintf(seed, sizeof seed, "%u", t->seed);
    return !strcmp(row->seed, seed) && !strcmp(row->value, t->setting->value) &&
           !strcmp(row->knob, t->setting->knob);
}

// Whether the table has all of a setting's rows of this seed.
static bool is_there(const struct taking *t)
{
    char seed[16];
    snprintf(seed, sizeof seed, "%u", t->seed);
    for (size_t i = 0; i < t->run->steps; i++)
        if (!glint_accuracy_table_find(&t->run->table, t->setting->knob, t->setting->value, seed,
                                       t->run->ladder[i]))
            return false;
    return t->mean.seeds >> t->seed & 1;
}

static glint_status render_missing(struct taking *t, const char *name, struct glint_error *err)
{
    struct glint_accuracy_run *run = t->run;
    const struct glint_accuracy_order order = {.job = t->setting->job,
                                               .seed = t->seed,
                                               .ladder = run->ladder,
                                               .steps = run->steps,
                                               .look = take_look,
                                               .user = t};
    glint_accuracy_table_drop(&run->table, is_of, t);
    glint_status st = render(run, &order, err);
    if (!st)
        st = glint_accuracy_mean_save(&t->mean, run->folder, name, err);
    return st ? st : glint_accuracy_table_write(&run->table, run->folder, err);
}

static glint_status take_setting(struct glint_accuracy_run *run, size_t index, unsigned seed,
                                 struct glint_error *err)
{
    struct taking t = {.run = run, .setting = &run->plan->setting[index], .seed = seed};
    char name[160];
    glint_accuracy_mean_name(run, t.setting, name);
    glint_status st = glint_accuracy_mean_load(&t.mean, run->folder, name,
                                               &run->reference[t.setting->group].mean, err);
    if (!st && !is_there(&t))
        st = render_missing(&t, name, err);
    glint_accuracy_mean_finish(&t.mean);
    run->done++;
    show(run);
    return st;
}

// Forth with odd seeds and back with even ones: neighbours in time are compared.
static glint_status take_seed(struct glint_accuracy_run *run, unsigned seed,
                              struct glint_error *err)
{
    const size_t n = run->plan->settings;
    glint_status st = GLINT_OK;
    for (size_t i = 0; i < n && !st; i++)
        st = take_setting(run, seed % 2 ? i : n - 1 - i, seed, err);
    return st;
}

glint_status glint_accuracy_run(struct glint_accuracy_run *run, struct glint_error *err)
{
    run->all = 2 * run->plan->groups + run->seeds * run->plan->settings;
    glint_status st = make_references(run, err);
    for (unsigned seed = 1; seed <= run->seeds && !st; seed++)
        st = take_seed(run, seed, err);
    glint_progress_finish(&run->session->progress);
    return st;
}

void glint_accuracy_run_finish(struct glint_accuracy_run *run)
{
    for (size_t g = 0; run->reference && g < run->plan->groups; g++)
        glint_accuracy_reference_finish(&run->reference[g]);
    free(run->reference);
    glint_accuracy_table_finish(&run->table);
}
