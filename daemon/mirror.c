#include "mirror.h"

#include <stdlib.h>

struct glint_mirror {
    glint_jobs *jobs;
    glint_store *store;
    glint_metric *by_state[GLINT_JOB_CANCELLED + 1];
    glint_metric *submitted, *slices, *busy, *scenes, *bytes, *imports, *failures;
};

static void refresh_jobs(const struct glint_mirror *m)
{
    struct glint_jobs_stats stats;
    glint_jobs_stats(m->jobs, &stats);
    for (int s = 0; s <= GLINT_JOB_CANCELLED; s++)
        glint_metric_set(m->by_state[s], stats.by_state[s]);
    glint_metric_set(m->submitted, (double)stats.submitted);
    glint_metric_set(m->slices, (double)stats.slices);
    glint_metric_set(m->busy, stats.worker_busy_seconds);
}

static void refresh_scenes(const struct glint_mirror *m)
{
    struct glint_store_stats stats;
    glint_store_stats(m->store, &stats);
    glint_metric_set(m->scenes, stats.scenes);
    glint_metric_set(m->bytes, (double)stats.resident_bytes);
    glint_metric_set(m->imports, (double)stats.imports);
    glint_metric_set(m->failures, (double)stats.import_failures);
}

static void refresh(void *user)
{
    refresh_jobs(user);
    refresh_scenes(user);
}

static void name_jobs(struct glint_mirror *m, glint_metrics *metrics)
{
    for (int s = 0; s <= GLINT_JOB_CANCELLED; s++) {
        const struct glint_label label = {"state", glint_job_state_name((enum glint_job_state)s)};
        m->by_state[s] = glint_metrics_gauge(metrics, "jobs", "Jobs by state.", &label, 1);
    }
    m->submitted = glint_metrics_counter(metrics, "jobs_submitted_total", "Jobs taken.", NULL, 0);
    m->slices = glint_metrics_counter(metrics, "slices_total", "Slices rendered.", NULL, 0);
    m->busy = glint_metrics_counter(metrics, "worker_busy_seconds_total",
                                    "Time that workers spent on slices.", NULL, 0);
}

static void name_scenes(struct glint_mirror *m, glint_metrics *metrics)
{
    m->scenes = glint_metrics_gauge(metrics, "scenes", "Scenes by name.", NULL, 0);
    m->bytes = glint_metrics_gauge(metrics, "scene_resident_bytes",
                                   "Memory of every scene revision that lives.", NULL, 0);
    m->imports = glint_metrics_counter(metrics, "imports_total", "Scenes imported.", NULL, 0);
    m->failures = glint_metrics_counter(metrics, "import_failures_total",
                                        "Scenes that were refused or did not fit.", NULL, 0);
}

glint_status glint_mirror_create(glint_mirror **out, glint_metrics *metrics, glint_jobs *jobs,
                                 glint_store *store, uint32_t workers, struct glint_error *err)
{
    glint_mirror *m = *out = calloc(1, sizeof *m);
    if (!m)
        return glint_fail(err, GLINT_E_NOMEM, "", "no memory for metrics");
    m->jobs = jobs;
    m->store = store;
    name_jobs(m, metrics);
    name_scenes(m, metrics);
    glint_metric_set(glint_metrics_gauge(metrics, "workers", "Worker threads.", NULL, 0), workers);
    glint_metrics_on_read(metrics, refresh, m);
    return GLINT_OK;
}

void glint_mirror_destroy(glint_mirror **mirror)
{
    free(*mirror);
    *mirror = NULL;
}
