#include "base/metrics.h"

#include <assert.h>
#include <inttypes.h>
#include <math.h>
#include <pthread.h>
#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define MAX_BOUNDS 16
#define MAX_REFRESHERS 8

enum kind { COUNTER, GAUGE, HISTOGRAM };
static const char *const kind_name[] = {"counter", "gauge", "histogram"};

struct glint_metric {
    glint_metrics *home;
    const char *name, *help;
    enum kind kind;
    char *labels;        // `a="x",b="y"`, owned
    double value;        // histogram: sum of what was observed
    const double *bound; // histogram: [bounds]
    size_t bounds;
    uint64_t count[MAX_BOUNDS + 1]; // histogram: observations by bucket, not cumulated
};

struct glint_metrics {
    pthread_mutex_t mutex;
    glint_metric *series[GLINT_MAX_SERIES]; // series of one family stand together
    size_t count;
    struct {
        void (*call)(void *user);
        void *user;
    } refresh[MAX_REFRESHERS];
    size_t refreshers;
};

glint_status glint_metrics_create(glint_metrics **out, struct glint_error *err)
{
    *out = calloc(1, sizeof **out);
    if (!*out)
        return glint_fail(err, GLINT_E_NOMEM, "", "no memory for metrics");
    pthread_mutex_init(&(*out)->mutex, NULL);
    return GLINT_OK;
}

static void free_series(glint_metric *m)
{
    if (m)
        free(m->labels);
    free(m);
}

void glint_metrics_destroy(glint_metrics **metrics)
{
    glint_metrics *m = *metrics;
    if (!m)
        return;
    for (size_t i = 0; i < m->count; i++)
        free_series(m->series[i]);
    pthread_mutex_destroy(&m->mutex);
    free(m);
    *metrics = NULL;
}

static void write_escaped(FILE *f, const char *text, bool quotes)
{
    for (; *text; text++) {
        if (*text == '\n')
            fputs("\\n", f);
        else if (*text == '\\' || (quotes && *text == '"'))
            fprintf(f, "\\%c", *text);
        else
            fputc(*text, f);
    }
}

// malloc'd, NULL without memory.
static char *print_labels(const struct glint_label *label, size_t labels)
{
    char *text = NULL;
    size_t length;
    FILE *f = open_memstream(&text, &length);
    if (!f)
        return NULL;
    for (size_t i = 0; i < labels; i++) {
        fprintf(f, "%s%s=\"", i ? "," : "", label[i].name);
        write_escaped(f, label[i].value, true);
        fputc('"', f);
    }
    if (fclose(f)) {
        free(text);
        return NULL;
    }
    return text;
}

// The series itself, or where it belongs: behind the last of its family.
static glint_metric *find(const glint_metrics *m, const char *name, const char *labels,
                          size_t *place)
{
    *place = m->count;
    for (size_t i = 0; i < m->count; i++) {
        if (strcmp(m->series[i]->name, name))
            continue;
        if (!strcmp(m->series[i]->labels, labels))
            return m->series[i];
        *place = i + 1;
    }
    return NULL;
}

// Takes what `wanted` owns.
static glint_metric *add(glint_metrics *m, const glint_metric *wanted, size_t place)
{
    glint_metric *made = m->count < GLINT_MAX_SERIES ? malloc(sizeof *made) : NULL;
    if (!made) {
        free(wanted->labels);
        return NULL;
    }
    *made = *wanted;
    memmove(m->series + place + 1, m->series + place, (m->count - place) * sizeof *m->series);
    m->series[place] = made;
    m->count++;
    return made;
}

static glint_metric *find_or_add(glint_metrics *m, glint_metric wanted,
                                 const struct glint_label *label, size_t labels)
{
    wanted.home = m;
    wanted.labels = print_labels(label, labels);
    if (!wanted.labels)
        return NULL;
    pthread_mutex_lock(&m->mutex);
    size_t place;
    glint_metric *found = find(m, wanted.name, wanted.labels, &place);
    if (found)
        free(wanted.labels);
    else
        found = add(m, &wanted, place);
    pthread_mutex_unlock(&m->mutex);
    assert(!found || found->kind == wanted.kind);
    return found;
}

glint_metric *glint_metrics_counter(glint_metrics *m, const char *name, const char *help,
                                    const struct glint_label *label, size_t labels)
{
    return find_or_add(m, (glint_metric){.name = name, .help = help, .kind = COUNTER}, label,
                       labels);
}

glint_metric *glint_metrics_gauge(glint_metrics *m, const char *name, const char *help,
                                  const struct glint_label *label, size_t labels)
{
    return find_or_add(m, (glint_metric){.name = name, .help = help, .kind = GAUGE}, label, labels);
}

glint_metric *glint_metrics_histogram(glint_metrics *m, const char *name, const char *help,
                                      const double *bound, size_t bounds,
                                      const struct glint_label *label, size_t labels)
{
    assert(bounds <= MAX_BOUNDS);
    return find_or_add(
        m,
        (glint_metric){
            .name = name, .help = help, .kind = HISTOGRAM, .bound = bound, .bounds = bounds},
        label, labels);
}

void glint_metric_add(glint_metric *metric, double amount)
{
    if (!metric)
        return;
    assert(metric->kind == GAUGE || (metric->kind == COUNTER && amount >= 0));
    pthread_mutex_lock(&metric->home->mutex);
    metric->value += amount;
    pthread_mutex_unlock(&metric->home->mutex);
}

void glint_metric_set(glint_metric *metric, double value)
{
    if (!metric)
        return;
    assert(metric->kind != HISTOGRAM);
    pthread_mutex_lock(&metric->home->mutex);
    metric->value = value;
    pthread_mutex_unlock(&metric->home->mutex);
}

void glint_metric_observe(glint_metric *metric, double value)
{
    if (!metric)
        return;
    assert(metric->kind == HISTOGRAM);
    size_t bucket = 0;
    while (bucket < metric->bounds && !(value <= metric->bound[bucket]))
        bucket++;
    pthread_mutex_lock(&metric->home->mutex);
    metric->count[bucket]++;
    metric->value += value;
    pthread_mutex_unlock(&metric->home->mutex);
}

void glint_metrics_on_read(glint_metrics *m, void (*refresh)(void *user), void *user)
{
    pthread_mutex_lock(&m->mutex);
    assert(m->refreshers < MAX_REFRESHERS);
    m->refresh[m->refreshers].call = refresh;
    m->refresh[m->refreshers].user = user;
    m->refreshers++;
    pthread_mutex_unlock(&m->mutex);
}

static void write_number(FILE *f, double value)
{
    if (isnan(value))
        fputs("NaN\n", f);
    else if (isinf(value))
        fputs(value > 0 ? "+Inf\n" : "-Inf\n", f);
    else
        fprintf(f, "%.15g\n", value);
}

static void write_bucket(FILE *f, const glint_metric *s, const char *bound, uint64_t cumulated)
{
    fprintf(f, "glint_%s_bucket{%s%sle=\"%s\"} %" PRIu64 "\n", s->name, s->labels,
            *s->labels ? "," : "", bound, cumulated);
}

static void write_histogram(FILE *f, const glint_metric *s)
{
    const char *open = *s->labels ? "{" : "", *close = *s->labels ? "}" : "";
    uint64_t cumulated = 0;
    for (size_t i = 0; i < s->bounds; i++) {
        char bound[32];
        snprintf(bound, sizeof bound, "%.15g", s->bound[i]);
        write_bucket(f, s, bound, cumulated += s->count[i]);
    }
    write_bucket(f, s, "+Inf", cumulated += s->count[s->bounds]);
    fprintf(f, "glint_%s_sum%s%s%s ", s->name, open, s->labels, close);
    write_number(f, s->value);
    fprintf(f, "glint_%s_count%s%s%s %" PRIu64 "\n", s->name, open, s->labels, close, cumulated);
}

static void write_series(FILE *f, const glint_metric *s)
{
    if (s->kind == HISTOGRAM) {
        write_histogram(f, s);
        return;
    }
    fprintf(f, "glint_%s%s%s%s ", s->name, *s->labels ? "{" : "", s->labels, *s->labels ? "}" : "");
    write_number(f, s->value);
}

static void write_all(FILE *f, const glint_metrics *m)
{
    for (size_t i = 0; i < m->count; i++) {
        const glint_metric *s = m->series[i];
        if (!i || strcmp(m->series[i - 1]->name, s->name)) {
            fprintf(f, "# HELP glint_%s ", s->name);
            write_escaped(f, s->help, false);
            fprintf(f, "\n# TYPE glint_%s %s\n", s->name, kind_name[s->kind]);
        }
        write_series(f, s);
    }
}

char *glint_metrics_text(glint_metrics *m, size_t *length)
{
    for (size_t i = 0; i < m->refreshers; i++)
        m->refresh[i].call(m->refresh[i].user);
    char *text = NULL;
    size_t bytes = 0;
    FILE *f = open_memstream(&text, &bytes);
    if (!f)
        return NULL;
    pthread_mutex_lock(&m->mutex);
    write_all(f, m);
    pthread_mutex_unlock(&m->mutex);
    if (fclose(f)) {
        free(text);
        return NULL;
    }
    if (length)
        *length = bytes;
    return text;
}
