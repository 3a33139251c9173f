// thread.h - threads with a name, and signals left to main.
//
// Thread-safety: any thread.
#ifndef GLINT_BASE_THREAD_H
#define GLINT_BASE_THREAD_H

#include "protocol/status.h"

#include <pthread.h>

// Starts a thread with every signal blocked. name: shown by ps and debuggers, cut to 15 bytes.
// GLINT_E_CAPACITY: the system gives no more threads.
glint_status glint_thread_start(pthread_t *out, const char *name, void *(*run)(void *), void *arg,
                                struct glint_error *err);

// Lets other threads of this process and machine go first from now on, by so many steps of nice.
// Where the system forbids it, nothing changes.
void glint_thread_yield_to_others(int steps);

#endif
