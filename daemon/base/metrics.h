// metrics.h - counters, gauges and histograms, and their Prometheus text (version 0.0.4).
//
// A series is a family name and labels; asking for one that exists gives the same one again. All
// names get the prefix "glint_". Labels must come from small fixed sets (a route, a state), never
// from clients: at most GLINT_MAX_SERIES exist, later ones are NULL, and every call takes NULL.
//
// Thread-safety: any thread; one mutex, under which nothing is called.
#ifndef GLINT_BASE_METRICS_H
#define GLINT_BASE_METRICS_H

#include "protocol/status.h"

#define GLINT_MAX_SERIES 1024

typedef struct glint_metrics glint_metrics;
typedef struct glint_metric glint_metric; // one series; lives as long as its registry

struct glint_label {
    const char *name, *value;
};

glint_status glint_metrics_create(glint_metrics **out, struct glint_error *err);
void glint_metrics_destroy(glint_metrics **metrics);

// name: "jobs_submitted_total", a static string like `help`; labels are copied.
glint_metric *glint_metrics_counter(glint_metrics *metrics, const char *name, const char *help,
                                    const struct glint_label *label, size_t labels);
glint_metric *glint_metrics_gauge(glint_metrics *metrics, const char *name, const char *help,
                                  const struct glint_label *label, size_t labels);
// bound: `bounds` (at most 16) upper bounds in increasing order, static; +Inf is added.
glint_metric *glint_metrics_histogram(glint_metrics *metrics, const char *name, const char *help,
                                      const double *bound, size_t bounds,
                                      const struct glint_label *label, size_t labels);

void glint_metric_add(glint_metric *metric, double amount);    // counter: amount >= 0; gauge
void glint_metric_set(glint_metric *metric, double value);     // gauge, or a count kept elsewhere
void glint_metric_observe(glint_metric *metric, double value); // histogram

// Called at the start of every glint_metrics_text, on its thread, to bring mirrored values up to
// date. At most 8, set before other threads read.
void glint_metrics_on_read(glint_metrics *metrics, void (*refresh)(void *user), void *user);

// The whole exposition, malloc'd, NULL without memory. *length may be NULL.
char *glint_metrics_text(glint_metrics *metrics, size_t *length);

#endif
