#include "http/watch.h"

#include "base/clock.h"
#include "base/thread.h"

#include <math.h>
#include <stdbool.h>
#include <stdlib.h>
#include <sys/epoll.h>
#include <sys/eventfd.h>
#include <sys/socket.h>
#include <time.h>
#include <unistd.h>

#define MIN_ROUND_SECONDS 0.002
#define MAX_ROUND_SECONDS 0.250
#define TURN_SECONDS 0.0025 // what a round takes; shorter than a worker's
#define MAX_EVENTS 64
#define WAKE 0 // no client has this number

struct client {
    struct client *next, *previous;
    uint64_t number;
    int fd;
    double deadline; // on glint_now()'s clock
    bool ended;      // sends nothing more
    void (*left)(void *user), (*reads)(void *user);
    void *user;
};

struct glint_watch {
    void (*round)(void *user);
    void *user;
    int poll, event;
    pthread_t thread;
    bool started, stop; // stop: under `mutex`
    pthread_mutex_t mutex;
    struct client *first;
    uint64_t last_number;
    uint32_t clients;
};

static struct client *find(glint_watch *w, uint64_t number)
{
    struct client *c = w->first;
    while (c && c->number != number)
        c = c->next;
    return c;
}

// Tells whoever attends. Otherwise the library is to find out: it takes a short read for the last
// one and so misses an end of file that came with the last bytes. This raises another event; what
// was sent before can still be read, and answered.
static void end_of_client(struct client *c)
{
    void (*left)(void *) = c->left;
    c->left = NULL;
    if (left)
        left(c->user);
    else
        shutdown(c->fd, SHUT_RD);
}

static void look_after(glint_watch *w)
{
    const double now = glint_now();
    for (struct client *c = w->first; c; c = c->next) {
        if (c->ended)
            end_of_client(c);
        if (now > c->deadline) {
            c->deadline = INFINITY;
            shutdown(c->fd, SHUT_RDWR); // the library reads an end of file and closes
        }
    }
}

// Returns true if there is something for a round to do.
static bool take_event(glint_watch *w, uint64_t number, uint32_t events)
{
    struct client *c = number == WAKE ? NULL : find(w, number);
    if (!c)
        return number == WAKE;
    c->ended |= (events & (EPOLLRDHUP | EPOLLHUP | EPOLLERR)) != 0;
    const bool reads = events & EPOLLOUT && c->reads && !c->ended;
    if (reads)
        c->reads(c->user);
    return reads;
}

// Waits for events until `until`. Returns true if there was a wake.
static bool wait_for_events(glint_watch *w, double until)
{
    struct epoll_event event[MAX_EVENTS];
    const double seconds = fmax(until - glint_now(), 0);
    int n = epoll_wait(w->poll, event, MAX_EVENTS, (int)ceil(seconds * 1e3));
    bool woken = false;
    pthread_mutex_lock(&w->mutex);
    for (; n > 0; n = n == MAX_EVENTS ? epoll_wait(w->poll, event, MAX_EVENTS, 0) : 0)
        for (int i = 0; i < n; i++)
            woken |= take_event(w, event[i].data.u64, event[i].events);
    look_after(w);
    pthread_mutex_unlock(&w->mutex);
    return woken;
}

// What comes meanwhile is taken together then: each by itself would wake this thread.
static void let_gather(double until)
{
    const double seconds = until - glint_now();
    if (seconds > 0)
        nanosleep(&(struct timespec){.tv_nsec = (long)(seconds * 1e9)}, NULL);
}

static bool stopped(glint_watch *w)
{
    pthread_mutex_lock(&w->mutex);
    const bool stop = w->stop;
    pthread_mutex_unlock(&w->mutex);
    return stop;
}

static void *serve(void *arg)
{
    glint_watch *w = arg;
    double last = glint_now();
    glint_thread_turns(TURN_SECONDS);
    while (!stopped(w)) {
        bool woken = wait_for_events(w, last + MAX_ROUND_SECONDS);
        if (woken) { // the others that follow at once share its round
            let_gather(last + MIN_ROUND_SECONDS);
            wait_for_events(w, 0);
        }
        if (!woken && glint_now() < last + MAX_ROUND_SECONDS)
            continue;
        uint64_t wakes;
        const bool drained = read(w->event, &wakes, sizeof wakes) == sizeof wakes;
        (void)drained; // either way the round sees every change made so far
        last = glint_now();
        w->round(w->user);
    }
    return NULL;
}

glint_status glint_watch_create(glint_watch **out, void (*round)(void *user), void *user,
                                struct glint_error *err)
{
    *out = NULL;
    glint_watch *w = calloc(1, sizeof *w);
    if (!w)
        return glint_fail(err, GLINT_E_NOMEM, "", "no memory for the watcher");
    w->round = round;
    w->user = user;
    pthread_mutex_init(&w->mutex, NULL);
    w->poll = epoll_create1(EPOLL_CLOEXEC);
    w->event = eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK);
    struct epoll_event wake = {.events = EPOLLIN | EPOLLET, .data.u64 = WAKE};
    glint_status st = GLINT_OK;
    if (w->poll < 0 || w->event < 0 || epoll_ctl(w->poll, EPOLL_CTL_ADD, w->event, &wake))
        st = glint_fail(err, GLINT_E_IO, "", "no descriptors for the watcher");
    *out = w; // rounds find it there
    if (!st)
        st = glint_thread_start(&w->thread, "http-watch", serve, w, err);
    w->started = !st;
    if (st)
        glint_watch_destroy(out);
    return st;
}

void glint_watch_destroy(glint_watch **watch)
{
    glint_watch *w = *watch;
    if (!w)
        return;
    if (w->started) {
        pthread_mutex_lock(&w->mutex);
        w->stop = true;
        pthread_mutex_unlock(&w->mutex);
        glint_watch_wake(w);
        pthread_join(w->thread, NULL);
    }
    *watch = NULL; // not before: a last round may wake it
    while (w->first)
        glint_watch_remove(w, w->first->number);
    if (w->poll >= 0)
        close(w->poll);
    if (w->event >= 0)
        close(w->event);
    pthread_mutex_destroy(&w->mutex);
    free(w);
}

void glint_watch_wake(glint_watch *watch)
{
    // Fails only when the counter is full: then a wake is pending anyway.
    eventfd_write(watch->event, 1);
}

static void set_interest(glint_watch *w, const struct client *c, int operation, uint32_t more)
{
    struct epoll_event event = {.events = EPOLLRDHUP | EPOLLET | more, .data.u64 = c->number};
    epoll_ctl(w->poll, operation, c->fd, &event);
}

uint64_t glint_watch_add(glint_watch *watch, int fd, double seconds)
{
    struct client *c = calloc(1, sizeof *c);
    if (!c)
        return 0;
    c->fd = fd;
    c->deadline = glint_now() + seconds;
    pthread_mutex_lock(&watch->mutex);
    c->number = ++watch->last_number;
    c->next = watch->first;
    if (c->next)
        c->next->previous = c;
    watch->first = c;
    watch->clients++;
    const uint64_t number = c->number;
    set_interest(watch, c, EPOLL_CTL_ADD, 0);
    pthread_mutex_unlock(&watch->mutex);
    return number;
}

void glint_watch_remove(glint_watch *watch, uint64_t client)
{
    pthread_mutex_lock(&watch->mutex);
    struct client *c = find(watch, client);
    if (c) {
        epoll_ctl(watch->poll, EPOLL_CTL_DEL, c->fd, NULL);
        *(c->previous ? &c->previous->next : &watch->first) = c->next;
        if (c->next)
            c->next->previous = c->previous;
        watch->clients--;
    }
    pthread_mutex_unlock(&watch->mutex);
    free(c);
}

void glint_watch_deadline(glint_watch *watch, uint64_t client, double seconds)
{
    pthread_mutex_lock(&watch->mutex);
    struct client *c = find(watch, client);
    if (c)
        c->deadline = glint_now() + seconds;
    pthread_mutex_unlock(&watch->mutex);
}

void glint_watch_attend(glint_watch *watch, uint64_t client, void (*left)(void *user),
                        void (*reads)(void *user), void *user)
{
    pthread_mutex_lock(&watch->mutex);
    struct client *c = find(watch, client);
    if (c) {
        c->left = left;
        c->user = user;
        if (!c->reads != !reads)
            set_interest(watch, c, EPOLL_CTL_MOD, reads ? EPOLLOUT : 0);
        c->reads = reads;
    }
    pthread_mutex_unlock(&watch->mutex);
}

uint32_t glint_watch_clients(glint_watch *watch)
{
    pthread_mutex_lock(&watch->mutex);
    const uint32_t n = watch->clients;
    pthread_mutex_unlock(&watch->mutex);
    return n;
}
