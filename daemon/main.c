// main.c - glintd: starts every part of the daemon in order, waits for a signal, ends them in turn.
#include "base/folders.h"
#include "base/log.h"
#include "base/memory.h"
#include "base/notify.h"
#include "house.h"
#include "options.h"
#include "serve.h"

#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <sys/resource.h>
#include <unistd.h>

#define IMPORT_CPU_SECONDS 300.0          // of the child, for one scene
#define SMALLEST_IMPORT ((size_t)1 << 30) // bytes of address space that any import may use

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

static glint_status take_socket(struct glint_house *h, struct glint_error *err)
{
    const struct glint_guard guard = {h->settings.token_file, h->settings.tls_cert};
    const glint_status st = glint_notify_socket(&h->listen_fd, err);
    if (st)
        return st;
    return h->listen_fd < 0 ? glint_listen(&h->listen_fd, h->url, h->settings.listen, guard, err)
                            : glint_listen_adopt(h->listen_fd, h->url, guard, err);
}

static glint_status read_tokens(struct glint_house *h, struct glint_error *err)
{
    if (!h->settings.token_file)
        return GLINT_OK;
    const glint_status st = glint_tokens_create(&h->tokens, err);
    return st ? st : glint_tokens_load(h->tokens, h->settings.token_file, err);
}

static glint_status read_certificate(struct glint_house *h, struct glint_error *err)
{
    if (!h->settings.tls_cert)
        return GLINT_OK;
    return glint_tls_create(&h->tls, h->settings.tls_cert, h->settings.tls_key, err);
}

static glint_status read_files(struct glint_house *h, struct glint_error *err)
{
    glint_status st = glint_settings_read(&h->settings, &h->source, err);
    if (!st)
        st = read_tokens(h, err);
    if (!st)
        st = read_certificate(h, err);
    return st;
}

// What must come before any other thread: the importer's helper is forked from this one, before it
// has a socket, and devices set the environment. Folders wait until the address is taken: a daemon
// that is refused leaves none behind.
static glint_status start_alone(struct glint_house *h, struct glint_error *err)
{
    glint_status st = glint_importer_create(&h->importer, err);
    if (!st)
        st = take_socket(h, err);
    if (!st)
        st = glint_folder_state(&h->state, h->settings.state, err);
    if (!st)
        st = glint_folder_cache(&h->cache, h->state, err);
    glint_devices_once();
    if (!st)
        st = glint_devices_create(&h->devices, h->settings.threads, h->cache, err);
    return st;
}

static glint_status start_threads(struct glint_house *h, struct glint_error *err)
{
    const struct glint_import_limits limits = import_limits();
    glint_status st = glint_metrics_create(&h->metrics, err);
    if (!st)
        st = glint_keeper_create(&h->keeper, h->state, h->metrics, err);
    if (!st)
        st = glint_store_create(&h->store, h->devices, h->importer, &limits, h->keeper, err);
    if (!st)
        st = glint_jobs_create(&h->jobs, h->devices, h->store, &h->settings.jobs, h->keeper, err);
    if (!st) {
        glint_jobs_set_checkpoint(h->jobs, h->settings.checkpoint_seconds);
        glint_jobs_set_film_disk(h->jobs, h->settings.film_bytes);
    }
    if (!st)
        st = glint_store_begin(h->store, err); // once the jobs have said what they need
    if (!st)
        st = glint_mirror_create(&h->mirror, h->metrics, h->jobs, h->store, h->devices, err);
    const struct glint_http_params params = {.listen_fd = h->listen_fd,
                                             .jobs = h->jobs,
                                             .store = h->store,
                                             .devices = h->devices,
                                             .metrics = h->metrics,
                                             .tokens = h->tokens,
                                             .tls = h->tls,
                                             .limits = h->settings.http,
                                             .version = PACKAGE_VERSION};
    if (!st)
        st = glint_http_create(&h->http, &params, err);
    if (!st)
        h->listen_fd = -1;
    if (!st)
        st = glint_warm_start(&h->warm, h->devices, err);
    return st;
}

static void finish(struct glint_house *h)
{
    glint_warm_destroy(&h->warm);
    glint_http_destroy(&h->http);
    glint_jobs_destroy(&h->jobs);
    glint_store_destroy(&h->store);
    glint_keeper_destroy(&h->keeper);
    glint_mirror_destroy(&h->mirror);
    glint_metrics_destroy(&h->metrics);
    glint_devices_destroy(&h->devices);
    glint_importer_destroy(&h->importer);
    if (h->listen_fd >= 0)
        close(h->listen_fd);
    free(h->cache);
    free(h->state);
}

static int fail(struct glint_error *err, int unusable)
{
    for (size_t i = 0; i < err->count; i++)
        glint_log(GLINT_LOG_ERROR, "main", NULL, NULL, "%s", err->fault[i].detail);
    const int code = err->status == GLINT_E_RANGE ? unusable : glint_status_exit(err->status);
    glint_notify_status("%s", glint_error_text(err));
    glint_error_finish(err);
    return code;
}

static void prepare_process(void)
{
    sigset_t heeded;
    glint_serve_signals(&heeded);
    pthread_sigmask(SIG_BLOCK, &heeded, NULL); // until sigwait takes them
    signal(SIGPIPE, SIG_IGN);
    signal(SIGXFSZ, SIG_IGN); // a file that may not grow is a full disk
    raise_file_limit();
    glint_memory_share_arena();
}

static int run(struct glint_house *h)
{
    struct glint_error err = {0};
    if (read_files(h, &err)) {
        glint_log_start(GLINT_LOG_AUTO);
        return fail(&err, GLINT_EXIT_SETTINGS);
    }
    glint_log_start(h->settings.log_format);
    glint_log_filter(h->settings.log_level, h->settings.debug);
    prepare_process();
    glint_status st = start_alone(h, &err);
    if (!st)
        st = start_threads(h, &err);
    if (!st)
        glint_serve(h);
    finish(h);
    glint_serve_finish();
    return st ? fail(&err, GLINT_EXIT_USAGE) : EXIT_SUCCESS;
}

int main(int argc, char **argv)
{
    struct glint_house house = {.listen_fd = -1};
    int code = glint_options_parse(&house.source, argc, argv);
    if (code >= 0)
        return code;
    code = run(&house);
    glint_tls_destroy(&house.tls);
    glint_tokens_destroy(&house.tokens);
    glint_settings_finish(&house.settings);
    glint_options_finish(&house.source);
    return code;
}
