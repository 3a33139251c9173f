#include "base/queue.h"

#include "base/thread.h"

#include <assert.h>
#include <math.h>
#include <pthread.h>
#include <stdlib.h>
#include <string.h>

struct glint_queue {
    pthread_mutex_t mutex;
    pthread_cond_t filled, emptied;
    size_t capacity, bytes; // messages, bytes of one
    size_t first, count;    // messages inside: first, first + 1, ... modulo capacity
    bool closed;
    unsigned char *message; // [capacity][bytes]
};

static void init_locks(glint_queue *q)
{
    glint_condition_init(&q->filled);
    glint_condition_init(&q->emptied);
    pthread_mutex_init(&q->mutex, NULL);
}

glint_status glint_queue_create(glint_queue **out, size_t capacity, size_t message_bytes,
                                struct glint_error *err)
{
    assert(out && capacity && message_bytes);
    *out = NULL;
    glint_queue *q = calloc(1, sizeof *q);
    unsigned char *message = calloc(capacity, message_bytes);
    if (!q || !message) {
        free(q);
        free(message);
        return glint_fail(err, GLINT_E_NOMEM, "", "no memory for a queue of %zu messages",
                          capacity);
    }
    q->capacity = capacity;
    q->bytes = message_bytes;
    q->message = message;
    init_locks(q);
    *out = q;
    return GLINT_OK;
}

void glint_queue_destroy(glint_queue **queue)
{
    glint_queue *q = *queue;
    if (!q)
        return;
    pthread_cond_destroy(&q->filled);
    pthread_cond_destroy(&q->emptied);
    pthread_mutex_destroy(&q->mutex);
    free(q->message);
    free(q);
    *queue = NULL;
}

static void put(glint_queue *q, const void *message)
{
    memcpy(q->message + (q->first + q->count) % q->capacity * q->bytes, message, q->bytes);
    q->count++;
    pthread_cond_signal(&q->filled);
}

static bool take(glint_queue *q, void *message)
{
    if (!q->count)
        return false;
    memcpy(message, q->message + q->first * q->bytes, q->bytes);
    q->first = (q->first + 1) % q->capacity;
    q->count--;
    pthread_cond_signal(&q->emptied);
    return true;
}

bool glint_queue_offer(glint_queue *q, const void *message)
{
    pthread_mutex_lock(&q->mutex);
    const bool room = !q->closed && q->count < q->capacity;
    if (room)
        put(q, message);
    pthread_mutex_unlock(&q->mutex);
    return room;
}

bool glint_queue_push(glint_queue *q, const void *message)
{
    pthread_mutex_lock(&q->mutex);
    while (!q->closed && q->count == q->capacity)
        pthread_cond_wait(&q->emptied, &q->mutex);
    const bool open = !q->closed;
    if (open)
        put(q, message);
    pthread_mutex_unlock(&q->mutex);
    return open;
}

bool glint_queue_poll(glint_queue *q, void *message)
{
    pthread_mutex_lock(&q->mutex);
    const bool taken = take(q, message);
    pthread_mutex_unlock(&q->mutex);
    return taken;
}

bool glint_queue_pop(glint_queue *q, void *message)
{
    return glint_queue_pop_until(q, message, INFINITY);
}

bool glint_queue_pop_until(glint_queue *q, void *message, double deadline)
{
    pthread_mutex_lock(&q->mutex);
    while (!q->count && !q->closed && glint_condition_wait(&q->filled, &q->mutex, deadline)) {
    }
    const bool taken = take(q, message);
    pthread_mutex_unlock(&q->mutex);
    return taken;
}

void glint_queue_close(glint_queue *q)
{
    pthread_mutex_lock(&q->mutex);
    q->closed = true;
    pthread_cond_broadcast(&q->filled);
    pthread_cond_broadcast(&q->emptied);
    pthread_mutex_unlock(&q->mutex);
}

size_t glint_queue_count(glint_queue *queue)
{
    pthread_mutex_lock(&queue->mutex);
    const size_t count = queue->count;
    pthread_mutex_unlock(&queue->mutex);
    return count;
}
