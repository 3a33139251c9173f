// main.c - glintd: starts every part of the daemon in order, waits for a signal, ends them in turn.
#include "base/folders.h"
#include "base/listen.h"
#include "base/log.h"
#include "base/memory.h"
#include "base/metrics.h"
#include "base/thread.h"
#include "device/device.h"
#include "http/http.h"
#include "jobs/jobs.h"
#include "mirror.h"
#include "options.h"
#include "scene/store.h"

#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <sys/resource.h>
#include <unistd.h>

#define DRAIN_SECONDS 10.0                // for answers under way, once it is asked to end
#define IMPORT_CPU_SECONDS 300.0          // of the child, for one scene
#define SMALLEST_IMPORT ((size_t)1 << 30) // bytes of address space that any import may use

struct house {
    struct glint_options options;
    char *state, *cache;
    int listen_fd; // until the HTTP server has it
    char url[GLINT_URL_BYTES];
    glint_importer *importer;
    glint_devices *devices;
    glint_store *store;
    glint_jobs *jobs;
    glint_metrics *metrics;
    glint_mirror *mirror;
    glint_http *http;
};

static void ending_signals(sigset_t *set)
{
    sigemptyset(set);
    sigaddset(set, SIGTERM);
    sigaddset(set, SIGINT);
}

// Every connection, stream and scene needs descriptors; more than the soft limit costs nothing.
static void raise_file_limit(void)
{
    struct rlimit files;
    if (getrlimit(RLIMIT_NOFILE, &files))
        return;
    files.rlim_cur = files.rlim_max;
    setrlimit(RLIMIT_NOFILE, &files);
}

static struct glint_import_limits import_limits(void)
{
    const size_t half = (size_t)(glint_memory_total() / 2);
    return (struct glint_import_limits){half > SMALLEST_IMPORT ? half : SMALLEST_IMPORT,
                                        IMPORT_CPU_SECONDS};
}

// What must come before any other thread: the importer's helper is forked from this one, before it
// has a socket, and devices set the environment. Folders wait until the address is taken: a daemon
// that is refused leaves none behind.
static glint_status start_alone(struct house *h, struct glint_error *err)
{
    glint_status st = glint_importer_create(&h->importer, err);
    if (!st)
        st = glint_listen(&h->listen_fd, h->url, h->options.listen, err);
    if (!st)
        st = glint_folder_state(&h->state, h->options.state, err);
    if (!st)
        st = glint_folder_cache(&h->cache, h->state, err);
    if (!st)
        st = glint_devices_create(&h->devices, h->options.threads, h->cache, err);
    return st;
}

static glint_status start_threads(struct house *h, struct glint_error *err)
{
    const struct glint_import_limits limits = import_limits();
    glint_status st = glint_store_create(&h->store, h->devices, h->importer, &limits, err);
    if (!st)
        st = glint_jobs_create(&h->jobs, h->devices, h->store, NULL, err);
    if (!st)
        st = glint_metrics_create(&h->metrics, err);
    if (!st)
        st = glint_mirror_create(&h->mirror, h->metrics, h->jobs, h->store,
                                 glint_devices_workers(h->devices), err);
    const struct glint_http_params params = {.listen_fd = h->listen_fd,
                                             .jobs = h->jobs,
                                             .store = h->store,
                                             .devices = h->devices,
                                             .metrics = h->metrics,
                                             .version = PACKAGE_VERSION};
    if (!st)
        st = glint_http_create(&h->http, &params, err);
    if (!st)
        h->listen_fd = -1;
    return st;
}

static void finish(struct house *h)
{
    glint_http_destroy(&h->http);
    glint_jobs_destroy(&h->jobs);
    glint_store_destroy(&h->store);
    glint_mirror_destroy(&h->mirror);
    glint_metrics_destroy(&h->metrics);
    glint_devices_destroy(&h->devices);
    glint_importer_destroy(&h->importer);
    if (h->listen_fd >= 0)
        close(h->listen_fd);
    free(h->cache);
    free(h->state);
}

// Somebody who asks twice does not want to wait.
static void *exit_on_next_signal(void *unused)
{
    (void)unused;
    sigset_t ending;
    int signal;
    ending_signals(&ending);
    sigwait(&ending, &signal);
    _exit(EXIT_FAILURE);
}

static void drain(struct house *h)
{
    pthread_t impatience;
    if (!glint_thread_start(&impatience, "second signal", exit_on_next_signal, NULL, NULL))
        pthread_detach(impatience);
    if (!glint_http_drain(h->http, DRAIN_SECONDS))
        glint_log(GLINT_LOG_WARNING, "main", NULL, NULL, "requests were cut off after %.0f s",
                  DRAIN_SECONDS);
}

static void serve(struct house *h)
{
    printf("glintd: listening on %s\n", h->url);
    fflush(stdout);
    glint_log(GLINT_LOG_INFO, "main", NULL, NULL, "%u workers on %s, state in %s",
              glint_devices_workers(h->devices), glint_devices_name(h->devices), h->state);
    sigset_t ending;
    int signal = 0;
    ending_signals(&ending);
    sigwait(&ending, &signal);
    glint_log(GLINT_LOG_INFO, "main", NULL, NULL, "signal %d: ending", signal);
    drain(h);
}

static int fail(struct glint_error *err)
{
    for (size_t i = 0; i < err->count; i++)
        glint_log(GLINT_LOG_ERROR, "main", NULL, NULL, "%s", err->fault[i].detail);
    // The only input at this point is the command line.
    const int code =
        err->status == GLINT_E_RANGE ? GLINT_EXIT_USAGE : glint_status_exit(err->status);
    glint_error_finish(err);
    return code;
}

int main(int argc, char **argv)
{
    struct house house = {.listen_fd = -1};
    struct glint_error err = {0};
    const int code = glint_options_parse(&house.options, argc, argv);
    if (code >= 0)
        return code;
    glint_log_start(house.options.format);
    sigset_t ending;
    ending_signals(&ending);
    pthread_sigmask(SIG_BLOCK, &ending, NULL); // until sigwait takes them
    signal(SIGPIPE, SIG_IGN);
    raise_file_limit();

    glint_status st = start_alone(&house, &err);
    if (!st)
        st = start_threads(&house, &err);
    if (!st)
        serve(&house);
    finish(&house);
    return st ? fail(&err) : EXIT_SUCCESS;
}
