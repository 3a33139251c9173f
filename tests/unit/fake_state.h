// fake_state.h - what the stand-in for renders and the test that holds it share: how each job is to
// behave, and what has happened. Whoever touches it has the lock.
#ifndef GLINT_TESTS_FAKE_STATE_H
#define GLINT_TESTS_FAKE_STATE_H

#include "fake_render.h"

#include <pthread.h>

#define MAX_WORKERS 16
#define MAX_SEED 8192
#define MAX_BEGUN 65536

struct glint_worker {
    uint32_t index;
    bool entered;
};

struct glint_devices {
    uint32_t workers;
    struct glint_worker worker[MAX_WORKERS];
};

// How the job with a seed behaves.
struct behaviour {
    bool fail_slice, stuck, fail_move, sketch;
    glint_status create_status;
    unsigned create_failures;
    double seconds;
};

struct fake_state {
    pthread_mutex_t mutex;
    pthread_cond_t changed;
    struct glint_devices devices;
    struct behaviour behaviour[MAX_SEED];
    bool gate_closed, prepare_held, create_held, move_held, deaf;
    unsigned let, creates_waiting;
    uint32_t begun[MAX_BEGUN], creates, moves, restarts;
    size_t begins;
    int renders, views, broken;
    float fov; // of the last restart
};

extern struct fake_state fake;

void fake_lock(void);
void fake_unlock(void); // and wakes whoever waits for a change
void fake_must(bool holds, const char *rule);

#endif
