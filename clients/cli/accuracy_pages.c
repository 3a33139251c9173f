// accuracy_pages.c - the report as JSON and as pages for a browser.
#include "accuracy_report.h"

#include "accuracy_files.h"
#include "accuracy_plot.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>

static const char *const cost_name[] = {[GLINT_COST_RAYS] = "rays", [GLINT_COST_CPU] = "cpu"};

// ---- JSON

static void add_number(cJSON *object, const char *name, double value)
{
    if (isfinite(value))
        cJSON_AddNumberToObject(object, name, value);
    else
        cJSON_AddNullToObject(object, name);
}

static void add_interval(cJSON *object, const char *name, const struct glint_accuracy_interval *i)
{
    cJSON *list = cJSON_AddArrayToObject(object, name);
    const double value[] = {i->middle, i->low, i->high};
    for (int k = 0; k < 3; k++)
        cJSON_AddItemToArray(list, isfinite(value[k]) ? cJSON_CreateNumber(value[k])
                                                      : cJSON_CreateNull());
}

static void add_points(cJSON *object, const struct glint_accuracy_run *run,
                       const struct glint_accuracy_sum *sum)
{
    cJSON *points = cJSON_AddArrayToObject(object, "points");
    for (size_t i = 0; i < run->steps; i++) {
        const struct glint_accuracy_point *p = &sum->point[i];
        cJSON *o = cJSON_CreateObject();
        cJSON_AddNumberToObject(o, "spp", p->spp);
        cJSON_AddNumberToObject(o, "seeds", p->seeds);
        add_number(o, "rays", p->cost[GLINT_COST_RAYS]);
        add_number(o, "cpu_seconds", p->cost[GLINT_COST_CPU]);
        add_interval(o, "error", &p->error);
        cJSON_AddBoolToObject(o, "reference_limited", p->limited);
        cJSON_AddItemToArray(points, o);
    }
}

static cJSON *describe(const struct glint_accuracy_run *run, const struct glint_accuracy_sum *sum)
{
    const struct glint_accuracy_setting *s = sum->setting;
    cJSON *o = cJSON_CreateObject();
    cJSON_AddStringToObject(o, "knob", s->knob);
    cJSON_AddStringToObject(o, "value", s->value);
    cJSON_AddStringToObject(o, "reference", run->plan->group[s->group].name);
    cJSON_AddBoolToObject(o, "unbiased", s->unbiased);
    cJSON_AddBoolToObject(o, "other_question", s->other_question);
    cJSON_AddItemToObject(o, "job", cJSON_Duplicate(s->job, true));
    add_points(o, run, sum);
    cJSON_AddNumberToObject(o, "bias2", sum->spread.bias2);
    cJSON_AddNumberToObject(o, "bias2_se", sum->spread.bias2_se);
    cJSON_AddNumberToObject(o, "sd", sqrt(sum->spread.variance));
    for (int c = 0; c < GLINT_COSTS; c++) {
        char name[32];
        snprintf(name, sizeof name, "%s_over_exact", cost_name[c]);
        add_interval(o, name, &sum->ratio[c]);
        snprintf(name, sizeof name, "loses_by_%s_from_spp", cost_name[c]);
        add_number(o, name, sum->loses[c]);
    }
    return o;
}

static glint_status write_json(const struct glint_accuracy_run *run,
                               const struct glint_accuracy_sum *sum, const cJSON *capabilities,
                               struct glint_error *err)
{
    cJSON *root = cJSON_CreateObject();
    cJSON_AddStringToObject(root, "scene", run->scene);
    cJSON_AddStringToObject(root, "build", run->build);
    cJSON_AddNumberToObject(root, "width", run->width);
    cJSON_AddNumberToObject(root, "height", run->height);
    cJSON_AddNumberToObject(root, "seeds", run->seeds);
    cJSON_AddNumberToObject(root, "threads", run->threads);
    cJSON_AddNumberToObject(root, "reference_samples", 2.0 * run->reference_samples);
    cJSON *settings = cJSON_AddArrayToObject(root, "settings");
    for (size_t i = 0; i < run->plan->settings; i++)
        cJSON_AddItemToArray(settings, describe(run, &sum[i]));
    cJSON_AddItemToObject(root, "not_called_for", cJSON_Duplicate(run->plan->skipped, true));
    const cJSON *unbuilt = cJSON_GetObjectItemCaseSensitive(capabilities, "unbuilt");
    cJSON_AddItemToObject(root, "no_method_built", cJSON_Duplicate(unbuilt, true));
    char *text = cJSON_Print(root);
    cJSON_Delete(root);
    struct glint_text out = {0};
    glint_text_add(&out, text ? text : "");
    free(text);
    glint_text_add(&out, "\n");
    return glint_accuracy_save(run->folder, "accuracy.json", &out, err);
}

// ---- pages

static void begin(struct glint_text *t, const char *title, const char *scene)
{
    glint_text_add(t, "<!doctype html>\n<html lang=\"en\"><meta charset=\"utf-8\"><title>");
    glint_accuracy_escape(t, title);
    glint_text_add(t,
                   "</title>\n<style>body{font:15px/1.5 system-ui;margin:2em "
                   "auto;max-width:70em;padding:0 1em}"
                   "td,th{padding:.1em 1em .1em 0;text-align:left;vertical-align:top}"
                   "td{white-space:nowrap}td.n{text-align:right;font-variant-numeric:tabular-nums}"
                   "img{max-width:100%}figure{display:inline-block;margin:.4em}</style>\n<h1>");
    glint_accuracy_escape(t, title);
    glint_text_add(t, ": ");
    glint_accuracy_escape(t, scene);
    glint_text_add(t, "</h1>\n");
}

static void add_text(struct glint_text *t, const char *text)
{
    glint_text_add(t, "<td>");
    glint_accuracy_escape(t, text);
}

static void add_figure(struct glint_text *t, double value)
{
    if (isfinite(value))
        glint_text_print(t, "<td class=\"n\">%.4g", value);
    else
        glint_text_add(t, "<td class=\"n\">-");
}

static void add_range(struct glint_text *t, const struct glint_accuracy_interval *i)
{
    if (isfinite(i->middle))
        glint_text_print(t, "<td class=\"n\">%.3f [%.3f, %.3f]", i->middle, i->low, i->high);
    else
        glint_text_add(t, "<td class=\"n\">-");
}

static void add_costs(struct glint_text *t, const struct glint_accuracy_run *run,
                      const struct glint_accuracy_sum *sum)
{
    glint_text_print(
        t,
        "<h2>Marginal costs</h2>\n<p>Over the exact twin at %u samples; error is rmse61, "
        "of mattes the total variation of coverage; bias is the root of "
        "|bias&sup2;| with its sign: a negative one is noise.\n<table><tr><th>knob<th>value<th>rays"
        "<th>CPU seconds<th>error<th>bias<th>deviation\n",
        run->ladder[run->steps - 1]);
    for (size_t i = 0; i < run->plan->settings; i++) {
        const struct glint_accuracy_sum *s = &sum[i];
        const double b2 = s->spread.bias2;
        glint_text_add(t, "<tr>");
        add_text(t, s->setting->knob);
        add_text(t, s->setting->value);
        add_range(t, &s->ratio[GLINT_COST_RAYS]);
        add_range(t, &s->ratio[GLINT_COST_CPU]);
        add_figure(t, s->point[run->steps - 1].error.middle);
        add_figure(t, b2 < 0 ? -sqrt(-b2) : sqrt(b2));
        add_figure(t, sqrt(s->spread.variance));
        glint_text_add(t, s->setting->other_question         ? "<td>another picture\n"
                          : s->point[run->steps - 1].limited ? "<td>reference limited\n"
                                                             : "\n");
    }
    glint_text_add(t, "</table>\n");
}

static void add_plots(struct glint_text *t, const cJSON *plots)
{
    const cJSON *name;
    glint_text_add(t, "<h2>Error against cost</h2>\n");
    cJSON_ArrayForEach(name, plots) {
        glint_text_add(t, "<p><img alt=\"\" src=\"");
        glint_accuracy_escape(t, name->valuestring);
        glint_text_add(t, "\">\n");
    }
}

static void add_differences(struct glint_text *t, const struct glint_accuracy_run *run)
{
    glint_text_print(t,
                     "<h2>Differences x 8</h2>\n<p>Mean of %u seeds with %u samples, from the "
                     "reference.\n<p>",
                     run->seeds, run->ladder[run->steps - 1]);
    for (size_t i = 0; i < run->plan->settings; i++) {
        const struct glint_accuracy_setting *s = &run->plan->setting[i];
        char knob[GLINT_ACCURACY_NAME], value[GLINT_ACCURACY_VALUE];
        glint_accuracy_file_name(s->knob, knob, sizeof knob);
        glint_accuracy_file_name(s->value, value, sizeof value);
        glint_text_print(t, "<figure><img alt=\"\" src=\"differences/%s-%s.png\"><figcaption>",
                         knob, value);
        glint_accuracy_escape(t, s->knob);
        glint_text_add(t, " ");
        glint_accuracy_escape(t, s->value);
        glint_text_add(t, "</figcaption></figure>\n");
    }
}

static void add_list(struct glint_text *t, const char *title, const cJSON *list, const char *name,
                     const char *why)
{
    const cJSON *item;
    if (!cJSON_GetArraySize(list))
        return;
    glint_text_print(t, "<h2>%s</h2>\n<ul>\n", title);
    cJSON_ArrayForEach(item, list) {
        const char *a = cJSON_GetStringValue(cJSON_GetObjectItemCaseSensitive(item, name));
        const char *b = cJSON_GetStringValue(cJSON_GetObjectItemCaseSensitive(item, why));
        glint_text_add(t, "<li>");
        glint_accuracy_escape(t, a ? a : "");
        glint_text_add(t, " (");
        glint_accuracy_escape(t, b ? b : "");
        glint_text_add(t, ")\n");
    }
    glint_text_add(t, "</ul>\n");
}

static glint_status write_index(const struct glint_accuracy_run *run,
                                const struct glint_accuracy_sum *sum, const cJSON *capabilities,
                                const cJSON *plots, struct glint_error *err)
{
    struct glint_text t = {0};
    begin(&t, "What accuracy costs", run->scene);
    glint_text_print(&t,
                     "<p>%u x %u pixels, %u seeds, %u threads, references of 2 x %u samples; "
                     "<a href=\"accuracy.csv\">accuracy.csv</a>, "
                     "<a href=\"accuracy.json\">accuracy.json</a>, "
                     "<a href=\"failures.html\">where approximations lose</a>.\n",
                     run->width, run->height, run->seeds, run->threads, run->reference_samples);
    add_costs(&t, run, sum);
    add_plots(&t, plots);
    add_differences(&t, run);
    add_list(&t, "Not measured", run->plan->skipped, "knob", "why");
    add_list(&t, "Approximations of the design that are not built (and what would be exact)",
             cJSON_GetObjectItemCaseSensitive(capabilities, "unbuilt"), "approximation", "exact");
    glint_text_add(&t, "</html>\n");
    return glint_accuracy_save(run->folder, "index.html", &t, err);
}

static glint_status write_failures(const struct glint_accuracy_run *run,
                                   const struct glint_accuracy_sum *sum, struct glint_error *err)
{
    struct glint_text t = {0};
    begin(&t, "Where approximations lose to more samples", run->scene);
    glint_text_add(&t,
                   "<p>From these numbers of samples on the exact twin, given samples for the "
                   "same cost, has less error than the lower end of the approximation's "
                   "interval; the cost is the lower end of its interval, too. The factor is that "
                   "of the errors at the most samples that lose. What asks for another picture, "
                   "as a filter does, is not among them."
                   "\n<table><tr><th>knob<th>value<th>by rays from<th>factor<th>by CPU "
                   "seconds from<th>factor\n");
    for (size_t i = 0; i < run->plan->settings; i++) {
        const struct glint_accuracy_sum *s = &sum[i];
        if (isnan(s->loses[0]) && isnan(s->loses[1]))
            continue;
        glint_text_add(&t, "<tr>");
        add_text(&t, s->setting->knob);
        add_text(&t, s->setting->value);
        for (int c = 0; c < GLINT_COSTS; c++) {
            add_figure(&t, s->loses[c]);
            add_figure(&t, s->by[c]);
        }
        glint_text_add(&t, "\n");
    }
    glint_text_add(&t, "</table>\n</html>\n");
    return glint_accuracy_save(run->folder, "failures.html", &t, err);
}

glint_status glint_accuracy_write_pages(const struct glint_accuracy_run *run,
                                        const struct glint_accuracy_sum *sum,
                                        const cJSON *capabilities, const cJSON *plots,
                                        struct glint_error *err)
{
    glint_status st = write_json(run, sum, capabilities, err);
    if (!st)
        st = write_index(run, sum, capabilities, plots, err);
    return st ? st : write_failures(run, sum, err);
}
