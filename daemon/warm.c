#include "warm.h"

#include "base/clock.h"
#include "base/thread.h"
#include "render/common.h"

#include <pthread.h>
#include <stdlib.h>
#include <string.h>

// Who starts a daemon that has been used before renders something first, most likely what it knows.
#define QUIET_SECONDS 3.0

struct glint_warm {
    glint_devices *devices;
    pthread_t thread;
    pthread_mutex_t mutex; // of `ended`
    pthread_cond_t end;
    bool ended;
};

// Whoever starts daemons one after the other, as tests do, wants none of it.
static bool is_wanted(void)
{
    const char *wish = getenv("GLINT_FORESEE");
    return !wish || strcmp(wish, "no");
}

// False: the daemon ends.
static bool keep_quiet(glint_warm *w)
{
    const double until = glint_now() + QUIET_SECONDS;
    pthread_mutex_lock(&w->mutex);
    while (!w->ended && glint_condition_wait(&w->end, &w->mutex, until))
        ;
    const bool on = !w->ended;
    pthread_mutex_unlock(&w->mutex);
    return on;
}

static void *run(void *arg)
{
    glint_warm *w = arg;
    char options[GLINT_COMMON_OPTIONS];
    const bool known = glint_program_recall(w->devices);
    bool idle = is_wanted() && (!known || keep_quiet(w)) && glint_program_foresee_known(w->devices);
    for (size_t i = 0; idle && i < glint_common_variant(i, options); i++)
        idle = glint_program_foresee(w->devices, options);
    return NULL;
}

static void finish(glint_warm **warm)
{
    pthread_cond_destroy(&(*warm)->end);
    pthread_mutex_destroy(&(*warm)->mutex);
    free(*warm);
    *warm = NULL;
}

glint_status glint_warm_start(glint_warm **out, glint_devices *devices, struct glint_error *err)
{
    *out = malloc(sizeof **out);
    if (!*out)
        return glint_fail(err, GLINT_E_NOMEM, "", "no memory to foresee anything");
    (*out)->devices = devices;
    (*out)->ended = false;
    pthread_mutex_init(&(*out)->mutex, NULL);
    glint_condition_init(&(*out)->end);
    const glint_status st = glint_thread_start(&(*out)->thread, "warm", run, *out, err);
    if (st)
        finish(out);
    return st;
}

void glint_warm_destroy(glint_warm **warm)
{
    glint_warm *w = *warm;
    if (!w)
        return;
    pthread_mutex_lock(&w->mutex);
    w->ended = true;
    pthread_cond_signal(&w->end);
    pthread_mutex_unlock(&w->mutex);
    glint_devices_hurry(w->devices);
    pthread_join(w->thread, NULL);
    finish(warm);
}
