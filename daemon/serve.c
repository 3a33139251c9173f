#include "serve.h"

#include "base/log.h"
#include "base/notify.h"
#include "base/thread.h"
#include "ticker.h"

#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>
#include <unistd.h>

#define WATCHDOG_SHARE 0.5    // of the time after which the service manager loses patience
#define PATIENCE_SECONDS 20.0 // asked for at a time, while it ends
#define PATIENCE_STEP 5.0     // between two times
#define MOST_PATIENCE 900.0   // altogether: what takes longer hangs

void glint_serve_signals(sigset_t *set)
{
    static const int heeded[] = {SIGTERM, SIGINT, SIGHUP, SIGUSR1};
    sigemptyset(set);
    for (size_t i = 0; i < sizeof heeded / sizeof *heeded; i++)
        sigaddset(set, heeded[i]);
}

static void tell_fixed(const char *name)
{
    glint_log(GLINT_LOG_WARNING, "main", NULL, NULL,
              "%s cannot change while the daemon runs: restart it", name);
}

static void tell_faults(struct glint_error *err)
{
    for (size_t i = 0; i < err->count; i++)
        glint_log(GLINT_LOG_ERROR, "main", NULL, NULL, "%s", err->fault[i].detail);
    glint_notify_ready("as before, as something is wrong: %s", glint_error_text(err));
    glint_error_finish(err);
}

// What may change while the daemon runs. Takes *settings.
static void apply(struct glint_house *h, struct glint_settings *settings)
{
    glint_settings_compare(&h->settings, settings, tell_fixed);
    glint_settings_finish(&h->settings);
    h->settings = *settings;
    glint_log_filter(h->settings.log_level, h->settings.debug);
    glint_jobs_set_limits(h->jobs, &h->settings.jobs);
    glint_jobs_set_checkpoint(h->jobs, h->settings.checkpoint_seconds);
    glint_jobs_set_film_disk(h->jobs, h->settings.film_bytes);
    glint_http_set_limits(h->http, &h->settings.http);
}

// All files before any change. *tokens: NULL where none are needed.
static glint_status read_files(struct glint_house *h, struct glint_settings *settings,
                               glint_tokens **tokens, struct glint_error *err)
{
    *tokens = NULL;
    glint_status st = glint_settings_read(settings, &h->source, err);
    if (!st && h->tokens && settings->token_file) {
        st = glint_tokens_create(tokens, err);
        st = st ? st : glint_tokens_load(*tokens, settings->token_file, err);
    }
    if (!st && h->tls && settings->tls_cert)
        st = glint_tls_load(h->tls, settings->tls_cert, settings->tls_key, err);
    return st;
}

// Nothing changes where anything is wrong.
static void reload(struct glint_house *h)
{
    struct glint_error err = {0};
    struct glint_settings settings;
    glint_tokens *tokens;
    glint_notify_reloading();
    if (read_files(h, &settings, &tokens, &err)) {
        glint_settings_finish(&settings);
        tell_faults(&err);
    } else {
        if (tokens)
            glint_tokens_exchange(h->tokens, tokens);
        apply(h, &settings);
        glint_log(GLINT_LOG_INFO, "main", NULL, NULL, "settings were read again");
        glint_notify_ready("serving %s", h->url);
    }
    glint_tokens_destroy(&tokens);
}

// Somebody who asks twice does not want to wait.
static void *exit_on_next_signal(void *unused)
{
    (void)unused;
    sigset_t ending;
    int signal;
    sigemptyset(&ending);
    sigaddset(&ending, SIGTERM);
    sigaddset(&ending, SIGINT);
    sigwait(&ending, &signal);
    _exit(EXIT_FAILURE);
}

static double watchdog_seconds;

static void tell_alive(struct glint_house *h)
{
    struct glint_jobs_stats jobs;
    glint_jobs_stats(h->jobs, &jobs);
    glint_notify_alive();
    glint_notify_status("serving %s; jobs: %u rendering, %u queued", h->url,
                        jobs.by_state[GLINT_JOB_RENDERING], jobs.by_state[GLINT_JOB_QUEUED]);
}

// Who does not come round keeps this from returning, or from saying that all is well.
static void watch(void *user)
{
    struct glint_house *h = user;
    struct glint_error err = {0};
    const struct glint_statement nothing = {.sql = "SELECT 1"};
    glint_jobs_ping(h->jobs);
    if (h->keeper)
        glint_journal_read(glint_keeper_journal(h->keeper), &nothing, NULL, NULL, &err);
    if (!err.status && !glint_http_beats(h->http, watchdog_seconds))
        glint_fail(&err, GLINT_E_INTERNAL, "", "no HTTP thread answers");
    if (!err.status)
        tell_alive(h);
    else
        glint_log(GLINT_LOG_ERROR, "main", NULL, NULL, "the watchdog is not told: %s",
                  glint_error_text(&err));
    glint_error_finish(&err);
}

static glint_ticker *patience, *watchdog;

static void start_watchdog(struct glint_house *h)
{
    watchdog_seconds = glint_notify_watchdog();
    struct glint_error err = {0};
    if (watchdog_seconds > 0 &&
        glint_ticker_create(&watchdog, "watchdog", watchdog_seconds * WATCHDOG_SHARE, watch, h,
                            &err))
        glint_log(GLINT_LOG_ERROR, "main", NULL, NULL, "%s", glint_error_text(&err));
    glint_error_finish(&err);
}

static void ask_for_patience(void *unused)
{
    (void)unused;
    static double asked; // by this thread alone
    if ((asked += PATIENCE_STEP) < MOST_PATIENCE)
        glint_notify_more_time(PATIENCE_SECONDS);
}

static void drain(struct glint_house *h)
{
    pthread_t impatience;
    glint_ticker_destroy(&watchdog); // it does not watch services that end
    glint_notify_stopping();
    if (!glint_thread_start(&impatience, "second signal", exit_on_next_signal, NULL, NULL))
        pthread_detach(impatience);
    glint_ticker_create(&patience, "patience", PATIENCE_STEP, ask_for_patience, NULL, NULL);
    if (!glint_http_drain(h->http, h->settings.drain_seconds))
        glint_log(GLINT_LOG_WARNING, "main", NULL, NULL, "requests were cut off after %.0f s",
                  h->settings.drain_seconds);
    glint_notify_status("ending: jobs are brought to the disk");
}

void glint_serve_finish(void)
{
    glint_ticker_destroy(&patience);
}

static void start(struct glint_house *h)
{
    printf("glintd: listening on %s\n", h->url);
    fflush(stdout);
    glint_log(GLINT_LOG_INFO, "main", NULL, NULL, "%u workers on %s, state in %s",
              glint_devices_workers(h->devices), glint_devices_name(h->devices), h->state);
    glint_notify_ready("serving %s", h->url);
    start_watchdog(h);
}

void glint_serve(struct glint_house *h)
{
    sigset_t heeded;
    int signal = 0;
    glint_serve_signals(&heeded);
    start(h);
    while (sigwait(&heeded, &signal) || (signal != SIGTERM && signal != SIGINT))
        if (signal == SIGHUP)
            reload(h);
        else if (signal == SIGUSR1)
            glint_jobs_checkpoint(h->jobs);
    glint_log(GLINT_LOG_INFO, "main", NULL, NULL, "signal %d: ending", signal);
    drain(h);
}
