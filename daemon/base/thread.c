#include "base/thread.h"

#include <math.h>
#include <sched.h>
#include <signal.h>
#include <stdatomic.h>
#include <stdint.h>
#include <stdio.h>
#include <string.h>
#include <sys/resource.h>
#include <sys/syscall.h>
#include <time.h>
#include <unistd.h>

#define MOST_HELPERS 7

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

struct share {
    size_t count;
    atomic_size_t next; // relaxed: an item is whose turn it was; the join publishes what was made
    void (*each)(void *user, size_t i);
    void *user;
};

static void *take_items(void *arg)
{
    struct share *s = arg;
    for (size_t i; (i = atomic_fetch_add_explicit(&s->next, 1, memory_order_relaxed)) < s->count;)
        s->each(s->user, i);
    return NULL;
}

// Besides that of the caller.
static size_t other_cores(void)
{
    cpu_set_t set;
    const int cores = sched_getaffinity(0, sizeof set, &set) ? 1 : CPU_COUNT(&set);
    return cores < 1 ? 0 : cores > MOST_HELPERS ? MOST_HELPERS : (size_t)cores - 1;
}

void glint_thread_each(const char *name, size_t count, void (*each)(void *user, size_t i),
                       void *user)
{
    struct share s = {.count = count, .each = each, .user = user};
    const size_t most = count > 1 ? other_cores() : 0;
    pthread_t helper[MOST_HELPERS];
    size_t helpers = 0;
    while (helpers < most && helpers + 1 < count &&
           !glint_thread_start(&helper[helpers], name, take_items, &s, NULL))
        helpers++;
    take_items(&s);
    while (helpers > 0)
        pthread_join(helper[--helpers], NULL);
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

// As Linux has it, without what came after its first version.
struct attributes {
    uint32_t size, policy;
    uint64_t flags;
    int32_t nice;
    uint32_t priority;
    uint64_t runtime, deadline, period; // ns
};

void glint_thread_turns(double seconds)
{
    struct attributes a = {.size = sizeof a};
    if (syscall(SYS_sched_getattr, 0, &a, sizeof a, 0))
        return;
    a.runtime = (uint64_t)(seconds * 1e9);
    a.flags = 0;
    syscall(SYS_sched_setattr, 0, &a, 0);
}

void glint_thread_yield_to_others(int steps)
{
    const id_t thread = (id_t)gettid(); // Linux has a nice for each
    setpriority(PRIO_PROCESS, thread, getpriority(PRIO_PROCESS, thread) + steps);
}
