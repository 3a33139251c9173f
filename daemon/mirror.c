#include "mirror.h"

#include "base/memory.h"
#include "base/process.h"

#include <stdlib.h>

struct glint_mirror {
    glint_jobs *jobs;
    glint_store *store;
    glint_metric *by_state[GLINT_JOB_CANCELLED + 1], *by_wait[GLINT_WAITS];
    glint_metric *submitted, *waits, *wait_seconds, *slices, *busy, *films, *ended_films,
        *most_film;
    glint_metric *scenes, *bytes, *imports, *failures;
    glint_metric *heap_used, *heap_free, *heap_mapped;
    glint_metric *cpu, *started, *resident, *address, *threads, *files, *most_files;
};

static void refresh_jobs(const struct glint_mirror *m)
{
    struct glint_jobs_stats stats;
    glint_jobs_stats(m->jobs, &stats);
    for (int s = 0; s <= GLINT_JOB_CANCELLED; s++)
        glint_metric_set(m->by_state[s], stats.by_state[s]);
    for (int w = GLINT_WAIT_NONE + 1; w < GLINT_WAITS; w++)
        glint_metric_set(m->by_wait[w], stats.by_wait[w]);
    glint_metric_set(m->submitted, (double)stats.submitted);
    glint_metric_set(m->waits, (double)stats.started);
    glint_metric_set(m->wait_seconds, stats.wait_seconds);
    glint_metric_set(m->slices, (double)stats.slices);
    glint_metric_set(m->busy, stats.worker_busy_seconds);
    glint_metric_set(m->films, (double)stats.film_bytes);
    glint_metric_set(m->ended_films, (double)stats.ended_film_bytes);
    glint_metric_set(m->most_film, (double)stats.limits.memory_bytes);
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

static void refresh_process(const struct glint_mirror *m)
{
    struct glint_process p;
    glint_process_look(&p);
    glint_metric_set(m->cpu, p.cpu_seconds);
    glint_metric_set(m->started, p.started);
    glint_metric_set(m->resident, (double)p.resident_bytes);
    glint_metric_set(m->address, (double)p.virtual_bytes);
    glint_metric_set(m->threads, p.threads);
    glint_metric_set(m->files, p.files);
    glint_metric_set(m->most_files, p.most_files);
}

static void refresh_heap(const struct glint_mirror *m)
{
    struct glint_heap heap;
    glint_memory_heap(&heap);
    glint_metric_set(m->heap_used, (double)heap.used);
    glint_metric_set(m->heap_free, (double)heap.free);
    glint_metric_set(m->heap_mapped, (double)heap.mapped);
}

static void refresh(void *user)
{
    refresh_jobs(user);
    refresh_scenes(user);
    refresh_heap(user);
    refresh_process(user);
}

static void name_jobs(struct glint_mirror *m, glint_metrics *metrics)
{
    for (int s = 0; s <= GLINT_JOB_CANCELLED; s++) {
        const struct glint_label label = {"state", glint_job_state_name((enum glint_job_state)s)};
        m->by_state[s] = glint_metrics_gauge(metrics, "jobs", "Jobs by state.", &label, 1);
    }
    for (int w = GLINT_WAIT_NONE + 1; w < GLINT_WAITS; w++) {
        const struct glint_label label = {"reason", glint_wait_name((enum glint_wait)w)};
        m->by_wait[w] = glint_metrics_gauge(metrics, "jobs_waiting",
                                            "Queued jobs by what they wait for.", &label, 1);
    }
    m->submitted = glint_metrics_counter(metrics, "jobs_submitted_total", "Jobs taken.", NULL, 0);
    m->waits = glint_metrics_counter(metrics, "job_waits_total",
                                     "Times that a queued job got its first slice.", NULL, 0);
    m->wait_seconds = glint_metrics_counter(metrics, "job_wait_seconds_total",
                                            "Time that they were queued before.", NULL, 0);
    m->slices = glint_metrics_counter(metrics, "slices_total", "Slices rendered.", NULL, 0);
    m->busy = glint_metrics_counter(metrics, "worker_busy_seconds_total",
                                    "Time that workers spent on slices.", NULL, 0);
}

static void name_films(struct glint_mirror *m, glint_metrics *metrics)
{
    static const char help[] = "Memory of films.";
    const struct glint_label going = {"jobs", "going"}, ended = {"jobs", "ended"};
    m->films = glint_metrics_gauge(metrics, "film_bytes", help, &going, 1);
    m->ended_films = glint_metrics_gauge(metrics, "film_bytes", help, &ended, 1);
    m->most_film = glint_metrics_gauge(metrics, "film_limit_bytes",
                                       "Memory that all films may have together.", NULL, 0);
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

static void name_heap(struct glint_mirror *m, glint_metrics *metrics)
{
    static const char help[] = "Memory that the C library has from the system, by what it is.";
    const struct glint_label used = {"state", "used"}, idle = {"state", "free"},
                             mapped = {"state", "mapped"};
    m->heap_used = glint_metrics_gauge(metrics, "heap_bytes", help, &used, 1);
    m->heap_free = glint_metrics_gauge(metrics, "heap_bytes", help, &idle, 1);
    m->heap_mapped = glint_metrics_gauge(metrics, "heap_bytes", help, &mapped, 1);
}

static void name_process(struct glint_mirror *m, glint_metrics *metrics)
{
    m->cpu = glint_metrics_counter(metrics, "process_cpu_seconds_total",
                                   "Processor time of all threads.", NULL, 0);
    m->started = glint_metrics_gauge(metrics, "process_start_time_seconds",
                                     "When it was started, since 1970.", NULL, 0);
    m->resident = glint_metrics_gauge(metrics, "process_resident_memory_bytes",
                                      "Memory of the process that is not swapped out.", NULL, 0);
    m->address = glint_metrics_gauge(metrics, "process_virtual_memory_bytes",
                                     "Address space of the process.", NULL, 0);
    m->threads = glint_metrics_gauge(metrics, "process_threads", "Threads.", NULL, 0);
    m->files = glint_metrics_gauge(metrics, "process_open_fds", "Open descriptors.", NULL, 0);
    m->most_files =
        glint_metrics_gauge(metrics, "process_max_fds", "Descriptors that may be open.", NULL, 0);
}

static void name_build(glint_metrics *metrics, const char *device)
{
    const struct glint_label label[] = {{"version", PACKAGE_VERSION}, {"device", device}};
    glint_metric_set(glint_metrics_gauge(metrics, "build_info",
                                         "1, with what runs and on what as labels.", label, 2),
                     1);
}

glint_status glint_mirror_create(glint_mirror **out, glint_metrics *metrics, glint_jobs *jobs,
                                 glint_store *store, const glint_devices *devices,
                                 struct glint_error *err)
{
    glint_mirror *m = *out = calloc(1, sizeof *m);
    if (!m)
        return glint_fail(err, GLINT_E_NOMEM, "", "no memory for metrics");
    m->jobs = jobs;
    m->store = store;
    name_build(metrics, glint_devices_name(devices));
    name_jobs(m, metrics);
    name_films(m, metrics);
    name_scenes(m, metrics);
    name_heap(m, metrics);
    name_process(m, metrics);
    glint_metric_set(glint_metrics_gauge(metrics, "workers", "Worker threads.", NULL, 0),
                     glint_devices_workers(devices));
    glint_metrics_on_read(metrics, refresh, m);
    return GLINT_OK;
}

void glint_mirror_destroy(glint_mirror **mirror)
{
    free(*mirror);
    *mirror = NULL;
}
