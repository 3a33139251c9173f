#include "fake_state.h"

#include <stdio.h>

struct fake_state fake = {.mutex = PTHREAD_MUTEX_INITIALIZER, .changed = PTHREAD_COND_INITIALIZER};

void fake_lock(void)
{
    pthread_mutex_lock(&fake.mutex);
}

void fake_unlock(void)
{
    pthread_cond_broadcast(&fake.changed);
    pthread_mutex_unlock(&fake.mutex);
}

void fake_must(bool holds, const char *rule)
{
    if (holds)
        return;
    if (fake.broken++ < 5) // one is enough, a thousand drown it
        fprintf(stderr, "# broken: %s\n", rule);
}

glint_devices *fake_devices(uint32_t workers)
{
    fake.devices = (struct glint_devices){.workers = workers};
    for (uint32_t i = 0; i < workers; i++)
        fake.devices.worker[i].index = i;
    return &fake.devices;
}

void fake_reset(void)
{
    fake_lock();
    fake_must(!fake.renders, "a render outlives its test");
    for (size_t i = 0; i < MAX_SEED; i++)
        fake.behaviour[i] = (struct behaviour){0};
    fake_must(!fake.views, "a view outlives its test");
    fake.gate_closed = fake.prepare_held = fake.create_held = fake.move_held = fake.deaf = false;
    fake.moves = fake.restarts = 0;
    fake.let = 0;
    fake.creates = 0;
    fake.begins = 0;
    fake_unlock();
}

void fake_close_gate(void)
{
    fake_lock();
    fake.gate_closed = true;
    fake_unlock();
}

void fake_open_gate(void)
{
    fake_lock();
    fake.gate_closed = false;
    fake_unlock();
}

void fake_deafen(void)
{
    fake_lock();
    fake.deaf = true;
    fake_unlock();
}

void fake_let(unsigned slices)
{
    fake_lock();
    fake.let += slices;
    fake_unlock();
}

void fake_hold_prepare(bool held)
{
    fake_lock();
    fake.prepare_held = held;
    fake_unlock();
}

void fake_hold_create(bool held)
{
    fake_lock();
    fake.create_held = held;
    fake_unlock();
}

void fake_wait_create(void)
{
    fake_lock();
    while (!fake.creates_waiting)
        pthread_cond_wait(&fake.changed, &fake.mutex);
    fake_unlock();
}

void fake_fail_slice(uint32_t seed)
{
    fake_lock();
    fake.behaviour[seed].fail_slice = true;
    fake_unlock();
}

void fake_fail_create(uint32_t seed, glint_status status, unsigned times)
{
    fake_lock();
    fake.behaviour[seed].create_status = status;
    fake.behaviour[seed].create_failures = times;
    fake_unlock();
}

void fake_fail_move(uint32_t seed)
{
    fake_lock();
    fake.behaviour[seed].fail_move = true;
    fake_unlock();
}

void fake_hold_move(bool held)
{
    fake_lock();
    fake.move_held = held;
    fake_unlock();
}

void fake_wait_moves(uint32_t count)
{
    fake_lock();
    while (fake.moves < count)
        pthread_cond_wait(&fake.changed, &fake.mutex);
    fake_unlock();
}

uint32_t fake_moves(void)
{
    fake_lock();
    const uint32_t count = fake.moves;
    fake_unlock();
    return count;
}

float fake_wait_restarts(uint32_t count)
{
    fake_lock();
    while (fake.restarts < count)
        pthread_cond_wait(&fake.changed, &fake.mutex);
    const float last = fake.fov;
    fake_unlock();
    return last;
}

uint32_t fake_restarts(void)
{
    fake_lock();
    const uint32_t count = fake.restarts;
    fake_unlock();
    return count;
}

int fake_views(void)
{
    fake_lock();
    const int count = fake.views;
    fake_unlock();
    return count;
}

void fake_stick(uint32_t seed)
{
    fake_lock();
    fake.behaviour[seed].stuck = true;
    fake_unlock();
}

void fake_sketch(uint32_t seed)
{
    fake_lock();
    fake.behaviour[seed].sketch = true;
    fake_unlock();
}

void fake_slice_seconds(uint32_t seed, double seconds)
{
    fake_lock();
    fake.behaviour[seed].seconds = seconds;
    fake_unlock();
}

void fake_begun(size_t count, uint32_t *seed)
{
    fake_lock();
    while (fake.begins < count)
        pthread_cond_wait(&fake.changed, &fake.mutex);
    for (size_t i = 0; seed && i < count; i++)
        seed[i] = fake.begun[i];
    fake_unlock();
}

size_t fake_begun_now(void)
{
    fake_lock();
    const size_t count = fake.begins;
    fake_unlock();
    return count;
}

uint32_t fake_creates(void)
{
    fake_lock();
    const uint32_t count = fake.creates;
    fake_unlock();
    return count;
}

void fake_wait_creates(uint32_t count)
{
    fake_lock();
    while (fake.creates < count)
        pthread_cond_wait(&fake.changed, &fake.mutex);
    fake_unlock();
}

int fake_renders(void)
{
    fake_lock();
    const int count = fake.renders;
    fake_unlock();
    return count;
}

int fake_broken(void)
{
    fake_lock();
    const int count = fake.broken;
    fake_unlock();
    return count;
}
