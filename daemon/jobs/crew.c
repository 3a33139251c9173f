#include "jobs/crew.h"

#include "base/clock.h"
#include "base/thread.h"
#include "jobs/checkpoint.h"

#include <assert.h>
#include <stdio.h>
#include <stdlib.h>

#define MOVER_ORDERS 256
#define WORKER_NICE 5      // who waits for an event or an answer does not wait for a slice
#define WORKER_TURN 0.0035 // seconds, less than a tick: it is waited for in the worst case

struct order {
    struct glint_entry *entry; // alive while a slice of it is out
    struct glint_slice slice;
};

// For the preparer, the finisher or the mover.
struct preparation {
    struct glint_entry *entry, *gone; // entry NULL: `view` and `revision` are to be released
    glint_revision *revision;         // retained
    struct glint_look *look;          // retained, or NULL
    glint_view *view;
    glint_render *render; // to be destroyed
};

struct member {
    glint_queue *orders, *inbox;
    enum glint_message_kind answers;
    glint_devices *devices;
    glint_store *store;
    uint32_t index;
    pthread_t thread;
    bool started;
};

struct glint_crew {
    uint32_t workers;
    struct member preparer, finisher, mover; // their orders are struct preparation
    struct member worker[];                  // [workers]; orders are struct order
};

static void *work(void *arg)
{
    const struct member *m = arg;
    glint_worker *worker = glint_devices_worker(m->devices, m->index);
    glint_thread_yield_to_others(WORKER_NICE);
    glint_thread_turns(WORKER_TURN);
    glint_worker_enter(worker);
    for (struct order order; glint_queue_pop(m->orders, &order);) {
        struct glint_message answer = {.kind = GLINT_MESSAGE_RETURNED,
                                       .entry = order.entry,
                                       .worker = m->index,
                                       .slice = order.slice};
        const double start = glint_now(), cpu = glint_thread_cpu();
        answer.status = glint_render_run(order.entry->render, worker, &order.slice, &answer.error);
        answer.seconds = glint_now() - start;
        answer.cpu_seconds = glint_thread_cpu() - cpu;
        if (!glint_queue_push(m->inbox, &answer))
            glint_error_finish(&answer.error);
    }
    return NULL;
}

void glint_crew_drop(struct glint_message *answer)
{
    glint_view_release(&answer->view);
    glint_render_destroy(&answer->render);
    glint_revision_release(&answer->revision);
    glint_error_finish(&answer->error);
    glint_entry_release(&answer->entry);
}

// What the order's job shows: its own revision or, of a live job, the newest of the scene's name.
static glint_revision *choose_revision(const struct member *m, const struct preparation *order)
{
    glint_revision *newest = NULL;
    const struct glint_job *job = order->entry->job;
    if (job->live && !glint_store_get(m->store, job->scene, &newest, NULL))
        return newest;
    return glint_revision_retain(order->revision);
}

// A job that goes on from a film begins with that.
static glint_status begin(const struct member *m, struct glint_entry *entry,
                          const struct glint_job *job, const struct glint_posed *posed,
                          struct glint_message *answer)
{
    const bool anew = !glint_checkpoint_exists(entry);
    const glint_status st = (anew ? glint_render_sketch : glint_render_create)(
        &answer->render, m->devices, posed->resident, posed->pose, job, &answer->error);
    if (!st && !anew)
        glint_checkpoint_restore(entry, answer->render);
    return st;
}

// Makes the render or, where there is one, its next view.
static glint_status make(const struct member *m, const struct preparation *order,
                         glint_render *render, struct glint_message *answer)
{
    const struct glint_job job = glint_look_apply(order->look, order->entry->job);
    struct glint_posed posed;
    answer->revision = choose_revision(m, order);
    glint_status st = glint_revision_pose(answer->revision, &job, &posed, &answer->error);
    if (st)
        return st;
    st = render ? glint_render_move(&answer->view, render, posed.resident, posed.pose, &job,
                                    &answer->error)
                : begin(m, order->entry, &job, &posed, answer);
    glint_resident_release(&posed.resident);
    glint_revision_weigh(answer->revision); // a structure may have been built
    return st;
}

static void finish(struct preparation *order)
{
    glint_render_destroy(&order->render);
    glint_view_release(&order->view);
    glint_revision_release(&order->revision);
    glint_look_release(&order->look);
}

static void *prepare(void *arg)
{
    const struct member *m = arg;
    for (struct preparation order; glint_queue_pop(m->orders, &order);) {
        struct glint_entry *entry = order.entry;
        glint_entry_release_all(order.gone);
        struct glint_message answer = {.kind = m->answers, .entry = entry};
        // Relaxed: a hint that saves work; the scheduler decides what becomes of the answer.
        if (!atomic_load_explicit(&entry->abandoned, memory_order_relaxed))
            answer.status = make(m, &order, NULL, &answer);
        if (atomic_load_explicit(&entry->abandoned, memory_order_relaxed))
            glint_render_destroy(&answer.render);
        finish(&order);
        if (!glint_queue_push(m->inbox, &answer))
            glint_crew_drop(&answer);
    }
    return NULL;
}

// Of the finisher and the mover.
static void *move(void *arg)
{
    const struct member *m = arg;
    for (struct preparation order; glint_queue_pop(m->orders, &order); finish(&order)) {
        if (!order.entry)
            continue;
        struct glint_message answer = {.kind = m->answers, .entry = order.entry};
        // Relaxed: as above. A move is not asked for twice.
        if (m->answers == GLINT_MESSAGE_MOVED ||
            !atomic_load_explicit(&order.entry->abandoned, memory_order_relaxed))
            answer.status = make(m, &order, order.entry->render, &answer);
        if (!glint_queue_push(m->inbox, &answer))
            glint_crew_drop(&answer);
    }
    return NULL;
}

static glint_status start(struct member *m, const char *name, size_t orders, size_t order_bytes,
                          void *(*run)(void *), struct glint_error *err)
{
    glint_status st = glint_queue_create(&m->orders, orders, order_bytes, err);
    if (!st)
        st = glint_thread_start(&m->thread, name, run, m, err);
    m->started = !st;
    return st;
}

static void stop(struct member *m)
{
    if (m->started) {
        glint_queue_close(m->orders);
        pthread_join(m->thread, NULL);
    }
    glint_queue_destroy(&m->orders);
}

glint_status glint_crew_create(glint_crew **out, glint_devices *devices, glint_store *store,
                               glint_queue *inbox, struct glint_error *err)
{
    *out = NULL;
    const uint32_t workers = glint_devices_workers(devices);
    glint_crew *crew = calloc(1, sizeof *crew + workers * sizeof crew->worker[0]);
    if (!crew)
        return glint_fail(err, GLINT_E_NOMEM, "", "no memory for %u workers", workers);
    crew->workers = workers;
    const struct member any = {.inbox = inbox, .devices = devices, .store = store};
    crew->preparer = crew->finisher = crew->mover = any;
    crew->preparer.answers = GLINT_MESSAGE_PREPARED;
    crew->finisher.answers = GLINT_MESSAGE_FINISHED;
    crew->mover.answers = GLINT_MESSAGE_MOVED;
    glint_status st =
        start(&crew->preparer, "prepare", 1, sizeof(struct preparation), prepare, err);
    if (!st)
        st = start(&crew->finisher, "finish", 1, sizeof(struct preparation), move, err);
    if (!st)
        st = start(&crew->mover, "move", MOVER_ORDERS, sizeof(struct preparation), move, err);
    for (uint32_t i = 0; !st && i < workers; i++) {
        char name[24];
        snprintf(name, sizeof name, "worker %u", i);
        crew->worker[i] = (struct member){.inbox = inbox, .devices = devices, .index = i};
        st = start(&crew->worker[i], name, GLINT_CREW_DEPTH, sizeof(struct order), work, err);
    }
    if (st)
        glint_crew_destroy(&crew);
    *out = crew;
    return st;
}

void glint_crew_destroy(glint_crew **crew)
{
    glint_crew *c = *crew;
    if (!c)
        return;
    for (uint32_t i = 0; i < c->workers; i++)
        stop(&c->worker[i]);
    stop(&c->preparer);
    stop(&c->finisher);
    stop(&c->mover);
    free(c);
    *crew = NULL;
}

uint32_t glint_crew_workers(const glint_crew *crew)
{
    return crew->workers;
}

void glint_crew_run(glint_crew *crew, uint32_t worker, struct glint_entry *entry,
                    const struct glint_slice *slice)
{
    const struct order order = {entry, *slice};
    const bool room = glint_queue_offer(crew->worker[worker].orders, &order);
    assert(room);
    (void)room;
}

bool glint_crew_recall(glint_crew *crew, uint32_t worker, struct glint_entry **entry,
                       struct glint_slice *slice)
{
    struct order order;
    if (!glint_queue_poll(crew->worker[worker].orders, &order))
        return false;
    *entry = order.entry;
    *slice = order.slice;
    return true;
}

static struct preparation about(struct glint_entry *entry, struct glint_entry *gone)
{
    return (struct preparation){.entry = glint_entry_retain(entry),
                                .gone = gone,
                                .revision = glint_revision_retain(entry->revision),
                                .look = glint_look_retain(entry->look)};
}

static void must_take(struct member *m, const struct preparation *order)
{
    const bool room = glint_queue_offer(m->orders, order);
    assert(room);
    (void)room;
}

void glint_crew_prepare(glint_crew *crew, struct glint_entry *entry, struct glint_entry *gone)
{
    const struct preparation order = about(entry, gone);
    must_take(&crew->preparer, &order);
}

void glint_crew_finish(glint_crew *crew, struct glint_entry *entry)
{
    const struct preparation order = about(entry, NULL);
    must_take(&crew->finisher, &order);
}

void glint_crew_move(glint_crew *crew, struct glint_entry *entry)
{
    const struct preparation order = about(entry, NULL);
    glint_queue_push(crew->mover.orders, &order); // waits, if ever, while something is released
}

void glint_crew_discard(glint_crew *crew, glint_render **render)
{
    struct preparation order = {.render = *render};
    *render = NULL;
    if (!glint_queue_offer(crew->mover.orders, &order))
        finish(&order);
}

void glint_crew_dispose(glint_crew *crew, glint_view **view, glint_revision **revision)
{
    struct preparation order = {.view = *view, .revision = *revision};
    *view = NULL;
    *revision = NULL;
    if (!order.view && !order.revision)
        return;
    if (!crew || !glint_queue_offer(crew->mover.orders, &order))
        finish(&order);
}
