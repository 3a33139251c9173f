#include "http/offload.h"

#include "base/queue.h"
#include "base/thread.h"

#include <assert.h>
#include <stdlib.h>

#define MAX_THREADS 8

struct glint_offload {
    glint_queue *queue; // of struct glint_task *
    unsigned threads;
    pthread_t thread[MAX_THREADS];
};

static void *serve(void *arg)
{
    struct glint_offload *o = arg;
    struct glint_task *task;
    while (glint_queue_pop(o->queue, &task))
        task->run(task);
    return NULL;
}

glint_status glint_offload_create(glint_offload **out, const char *name, unsigned threads,
                                  size_t capacity, struct glint_error *err)
{
    assert(threads >= 1 && threads <= MAX_THREADS);
    *out = NULL;
    struct glint_offload *o = calloc(1, sizeof *o);
    if (!o)
        return glint_fail(err, GLINT_E_NOMEM, "", "no memory for a pool of threads");
    glint_status st = glint_queue_create(&o->queue, capacity, sizeof(struct glint_task *), err);
    while (!st && o->threads < threads) {
        st = glint_thread_start(&o->thread[o->threads], name, serve, o, err);
        if (!st)
            o->threads++;
    }
    if (st)
        glint_offload_destroy(&o);
    *out = o;
    return st;
}

bool glint_offload_push(glint_offload *offload, struct glint_task *task)
{
    return glint_queue_offer(offload->queue, &task);
}

size_t glint_offload_waiting(glint_offload *offload)
{
    return glint_queue_count(offload->queue);
}

void glint_offload_destroy(glint_offload **offload)
{
    struct glint_offload *o = *offload;
    *offload = NULL;
    if (!o)
        return;
    if (o->queue)
        glint_queue_close(o->queue);
    for (unsigned i = 0; i < o->threads; i++)
        pthread_join(o->thread[i], NULL);
    glint_queue_destroy(&o->queue);
    free(o);
}
