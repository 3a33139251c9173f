#include "ticker.h"

#include "base/clock.h"
#include "base/thread.h"

#include <stdbool.h>
#include <stdlib.h>

struct glint_ticker {
    pthread_t thread;
    pthread_mutex_t mutex;
    pthread_cond_t ending;
    bool ends; // under the mutex
    double seconds;
    void (*tick)(void *user);
    void *user;
};

// Returns false when it is to end.
static bool rest(glint_ticker *t)
{
    const double until = glint_now() + t->seconds;
    pthread_mutex_lock(&t->mutex);
    while (!t->ends && glint_condition_wait(&t->ending, &t->mutex, until)) {
    }
    const bool goes_on = !t->ends;
    pthread_mutex_unlock(&t->mutex);
    return goes_on;
}

static void *run(void *user)
{
    glint_ticker *t = user;
    do
        t->tick(t->user);
    while (rest(t));
    return NULL;
}

static void release(glint_ticker *t)
{
    pthread_cond_destroy(&t->ending);
    pthread_mutex_destroy(&t->mutex);
    free(t);
}

glint_status glint_ticker_create(glint_ticker **out, const char *name, double seconds,
                                 void (*tick)(void *user), void *user, struct glint_error *err)
{
    *out = NULL;
    glint_ticker *t = calloc(1, sizeof *t);
    if (!t)
        return glint_fail(err, GLINT_E_NOMEM, "", "no memory for a thread");
    t->seconds = seconds;
    t->tick = tick;
    t->user = user;
    pthread_mutex_init(&t->mutex, NULL);
    glint_condition_init(&t->ending);
    const glint_status st = glint_thread_start(&t->thread, name, run, t, err);
    if (st)
        release(t);
    else
        *out = t;
    return st;
}

void glint_ticker_destroy(glint_ticker **ticker)
{
    glint_ticker *t = *ticker;
    *ticker = NULL;
    if (!t)
        return;
    pthread_mutex_lock(&t->mutex);
    t->ends = true;
    pthread_cond_signal(&t->ending);
    pthread_mutex_unlock(&t->mutex);
    pthread_join(t->thread, NULL);
    release(t);
}
