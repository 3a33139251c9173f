// queue.h - bounded first-in first-out queue of fixed-size messages between threads.
//
// When it is full, offer() refuses and push() waits: the caller chooses, and says so where it
// calls. After close() nothing goes in and what is inside can still be taken out.
//
// Thread-safety: any number of threads at both ends; create and destroy by one, with nobody inside.
#ifndef GLINT_BASE_QUEUE_H
#define GLINT_BASE_QUEUE_H

#include "protocol/status.h"

#include <stdbool.h>

typedef struct glint_queue glint_queue;

// capacity: messages, >= 1. GLINT_E_NOMEM only.
glint_status glint_queue_create(glint_queue **out, size_t capacity, size_t message_bytes,
                                struct glint_error *err);
void glint_queue_destroy(glint_queue **queue);

bool glint_queue_offer(glint_queue *queue, const void *message); // false: full or closed
bool glint_queue_push(glint_queue *queue, const void *message);  // waits for room; false: closed
bool glint_queue_poll(glint_queue *queue, void *message);        // false: empty
bool glint_queue_pop(glint_queue *queue, void *message);         // waits; false: closed and empty
// As pop, but false also once glint_now() has passed `deadline` (INFINITY: never).
bool glint_queue_pop_until(glint_queue *queue, void *message, double deadline);

size_t glint_queue_count(glint_queue *queue); // messages inside now

void glint_queue_close(glint_queue *queue);

#endif
