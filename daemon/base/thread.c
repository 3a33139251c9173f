#include "base/thread.h"

#include <math.h>
#include <signal.h>
#include <stdio.h>
#include <string.h>
#include <sys/resource.h>
#include <time.h>
#include <unistd.h>

glint_status glint_thread_start(pthread_t *out, const char *name, void *(*run)(void *), void *arg,
                                struct glint_error *err)
{
    // A new thread inherits the mask, so it is set around the start: no moment without it.
    sigset_t all, before;
    sigfillset(&all);
    pthread_sigmask(SIG_SETMASK, &all, &before);
    const int failure = pthread_create(out, NULL, run, arg);
    pthread_sigmask(SIG_SETMASK, &before, NULL);
    if (failure)
        return glint_fail(err, GLINT_E_CAPACITY, "", "no thread for %s: %s", name,
                          strerror(failure));

    char text[16];
    snprintf(text, sizeof text, "%s", name);
    pthread_setname_np(*out, text);
    return GLINT_OK;
}

void glint_condition_init(pthread_cond_t *out)
{
    pthread_condattr_t attr;
    pthread_condattr_init(&attr);
    pthread_condattr_setclock(&attr, CLOCK_MONOTONIC);
    pthread_cond_init(out, &attr);
    pthread_condattr_destroy(&attr);
}

bool glint_condition_wait(pthread_cond_t *condition, pthread_mutex_t *mutex, double deadline)
{
    if (!(deadline < 1e15))
        return !pthread_cond_wait(condition, mutex);
    const double whole = floor(deadline);
    const struct timespec until = {(time_t)whole, (long)((deadline - whole) * 1e9)};
    return !pthread_cond_timedwait(condition, mutex, &until);
}

void glint_thread_yield_to_others(int steps)
{
    const id_t thread = (id_t)gettid(); // Linux has a nice for each
    setpriority(PRIO_PROCESS, thread, getpriority(PRIO_PROCESS, thread) + steps);
}
