// thread.h - threads with a name, and signals left to main.
//
// Thread-safety: any thread.
#ifndef GLINT_BASE_THREAD_H
#define GLINT_BASE_THREAD_H

#include "protocol/status.h"

#include <pthread.h>
#include <stdbool.h>
#include <stddef.h>

// Starts a thread with every signal blocked. name: shown by ps and debuggers, cut to 15 bytes.
// GLINT_E_CAPACITY: the system gives no more threads.
glint_status glint_thread_start(pthread_t *out, const char *name, void *(*run)(void *), void *arg,
                                struct glint_error *err);

// Calls each(user, i) for all i below count, which are independent of each other, by the caller and
// threads of this name for the other cores; the caller does all where there are none. All calls have
// returned when this does.
void glint_thread_each(const char *name, size_t count, void (*each)(void *user, size_t i),
                       void *user);

// A condition whose deadlines are times of glint_now(), which no change of the wall clock moves.
void glint_condition_init(pthread_cond_t *out);
// With the mutex. False once the deadline has passed; true, perhaps for no reason, before. One that
// is infinite never does.
bool glint_condition_wait(pthread_cond_t *condition, pthread_mutex_t *mutex, double deadline);

// Lets other threads of this process and machine go first from now on, by so many steps of nice.
// Where the system forbids it, nothing changes.
void glint_thread_yield_to_others(int steps);

// Asks for turns of this length, up to 0.1 s: who is woken takes the place of a thread with longer ones
// at once, where it would else wait for a tick of the clock, 4 ms. From Linux 6.12 on; before, nothing
// changes.
void glint_thread_turns(double seconds);

#endif
