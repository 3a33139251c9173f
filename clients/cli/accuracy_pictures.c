// accuracy_pictures.c - a plot for every knob, and differences from the references.
#include "accuracy_report.h"

#include "accuracy_files.h"
#include "accuracy_mean.h"
#include "accuracy_plot.h"
#include "protocol/png.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define MAX_LINES 16

// ---- plots

static glint_status draw_knob(const struct glint_accuracy_run *run,
                              const struct glint_accuracy_sum *sum, size_t first, cJSON *names,
                              struct glint_error *err)
{
    const struct glint_accuracy_plan *plan = run->plan;
    const struct glint_accuracy_setting *knob = &plan->setting[first];
    const size_t twin = plan->group[knob->group].twin;
    struct glint_accuracy_point *point = calloc(MAX_LINES * run->steps, sizeof *point);
    struct glint_accuracy_line line[MAX_LINES];
    size_t lines = 0;
    if (!point)
        return glint_fail(err, GLINT_E_NOMEM, "", "no memory for a plot");
    for (size_t i = 0; i < plan->settings && lines < MAX_LINES; i++) {
        if (i != twin && strcmp(plan->setting[i].knob, knob->knob) != 0)
            continue;
        struct glint_accuracy_point *own = point + lines * run->steps;
        memcpy(own, sum[i].point, run->steps * sizeof *own);
        line[lines++] = (struct glint_accuracy_line){
            i == twin ? "exact twin" : plan->setting[i].value, own, run->steps};
    }
    glint_accuracy_mark_front(point, lines * run->steps);
    char title[256], name[GLINT_ACCURACY_NAME], file[128];
    glint_accuracy_file_name(knob->knob, name, sizeof name);
    snprintf(title, sizeof title, "%.100s: %s", run->scene, knob->knob);
    snprintf(file, sizeof file, "plots/%s.svg", name);
    struct glint_text text = {0};
    const bool matte = plan->group[knob->group].matte;
    glint_accuracy_plot(&text,
                        &(struct glint_accuracy_plot){
                            title, matte ? "total variation of coverage" : "rmse61", line, lines});
    cJSON_AddItemToArray(names, cJSON_CreateString(file));
    free(point);
    return glint_accuracy_save(run->folder, file, &text, err);
}

static bool is_first(const struct glint_accuracy_plan *plan, size_t index)
{
    for (size_t i = 0; i < index; i++)
        if (strcmp(plan->setting[i].knob, plan->setting[index].knob) == 0)
            return false;
    return !plan->setting[index].twin;
}

glint_status glint_accuracy_draw(const struct glint_accuracy_run *run,
                                 const struct glint_accuracy_sum *sum, cJSON **names,
                                 struct glint_error *err)
{
    glint_status st = GLINT_OK;
    *names = cJSON_CreateArray();
    for (size_t i = 0; i < run->plan->settings && !st; i++)
        if (is_first(run->plan, i))
            st = draw_knob(run, sum, i, *names, err);
    return st;
}

// ---- differences

static glint_status encode(const struct glint_accuracy_reference *reference, float *const plane[3],
                           uint8_t **bytes, size_t *size, struct glint_error *err)
{
    const uint32_t w = reference->mean.width, h = reference->mean.height;
    const struct glint_png_options plain = {.tonemap = GLINT_TONEMAP_CLIP};
    const struct glint_png_image image = {w, h, plane[0], plane[1], plane[2], NULL};
    if (reference->matte)
        return glint_png_coverage(plane[0], w, h, bytes, size, err);
    return glint_png_color(&image, &plain, bytes, size, err);
}

static glint_status show(const struct glint_accuracy_run *run,
                         const struct glint_accuracy_setting *s, struct glint_error *err)
{
    const struct glint_accuracy_reference *reference = &run->reference[s->group];
    const size_t pixels = (size_t)run->width * run->height;
    char name[160], knob[GLINT_ACCURACY_NAME], value[GLINT_ACCURACY_VALUE];
    struct glint_accuracy_mean mean;
    uint8_t *bytes = NULL;
    size_t size;
    glint_accuracy_mean_name(run, s, name);
    glint_status st = glint_accuracy_mean_load(&mean, run->folder, name, &reference->mean, err);
    if (st)
        return st;
    float *planes = malloc(3 * pixels * sizeof *planes);
    float *const plane[3] = {planes, planes + pixels, planes + 2 * pixels};
    if (planes) {
        glint_accuracy_difference(&mean.mean, reference, (float **)plane);
        st = encode(reference, plane, &bytes, &size, err);
    } else {
        st = glint_fail(err, GLINT_E_NOMEM, "", "no memory for a picture");
    }
    glint_accuracy_file_name(s->knob, knob, sizeof knob);
    glint_accuracy_file_name(s->value, value, sizeof value);
    snprintf(name, sizeof name, "differences/%s-%s.png", knob, value);
    if (!st)
        st = glint_accuracy_save_bytes(run->folder, name, bytes, size, err);
    free(bytes);
    free(planes);
    glint_accuracy_mean_finish(&mean);
    return st;
}

glint_status glint_accuracy_show_differences(const struct glint_accuracy_run *run,
                                             struct glint_error *err)
{
    glint_status st = GLINT_OK;
    for (size_t i = 0; i < run->plan->settings && !st; i++)
        st = show(run, &run->plan->setting[i], err);
    return st;
}
