// film_capture.c - a film at one moment, while workers go on.
#include "render/film_parts.h"

#include <stdlib.h>
#include <string.h>

void glint_film_capture_begin(glint_film *f)
{
    pthread_mutex_lock(&f->capture);
}

uint32_t glint_film_capture_mark(glint_film *f)
{
    pthread_mutex_lock(&f->mutex);
    for (size_t i = 0; i < (size_t)f->columns * f->rows; i++) {
        struct glint_tile *t = &f->tile[i];
        t->wanted = true;
        t->late = t->written;
        f->late += t->late;
    }
    f->captured_epoch = f->epoch;
    const uint32_t captures = ++f->captures;
    pthread_mutex_unlock(&f->mutex);
    return captures;
}

void glint_film_capture_late(glint_film *f, struct glint_tile *t)
{
    f->late -= t->late;
    t->late = false;
}

void glint_film_capture_settle(glint_film *f)
{
    pthread_mutex_lock(&f->mutex);
    while (f->late)
        pthread_cond_wait(&f->changed, &f->mutex);
    pthread_mutex_unlock(&f->mutex);
}

// Under the mutex: what is in the tile now was captured.
static void captured(glint_film *f, struct glint_tile *t)
{
    t->wanted = t->copying = false;
    t->copied = glint_tile_state(t, f->captured_epoch);
    pthread_cond_broadcast(&f->changed);
}

// Under the mutex: whether there is anything to copy.
static bool holds_any(const glint_film *f, const struct glint_tile *t)
{
    const struct glint_film_state state = glint_tile_state(t, f->captured_epoch);
    return state.samples || state.step;
}

struct glint_film_state glint_film_capture_take(glint_film *f, uint32_t tile, uint32_t *memory)
{
    struct glint_tile *t = &f->tile[tile];
    pthread_mutex_lock(&f->mutex);
    while (t->copying)
        pthread_cond_wait(&f->changed, &f->mutex);
    const bool here = t->wanted && holds_any(f, t);
    t->readers += here;
    uint32_t *copy = t->copy;
    t->copy = NULL;
    pthread_mutex_unlock(&f->mutex);
    if (here)
        glint_film_copy(f, tile, memory);
    else if (copy)
        memcpy(memory, copy, glint_film_tile_bytes(f));
    free(copy);
    pthread_mutex_lock(&f->mutex);
    t->readers -= here;
    if (t->wanted)
        captured(f, t);
    const struct glint_film_state state = t->copied;
    pthread_mutex_unlock(&f->mutex);
    return state;
}

void glint_film_capture_end(glint_film *f)
{
    pthread_mutex_lock(&f->mutex);
    for (size_t i = 0; i < (size_t)f->columns * f->rows; i++) {
        struct glint_tile *t = &f->tile[i];
        while (t->copying)
            pthread_cond_wait(&f->changed, &f->mutex);
        t->wanted = false;
        free(t->copy);
        t->copy = NULL;
    }
    pthread_cond_broadcast(&f->changed);
    pthread_mutex_unlock(&f->mutex);
    pthread_mutex_unlock(&f->capture);
}

// Without memory the worker waits for the reader to take the tile.
static void copy_tile(glint_film *f, uint32_t tile)
{
    struct glint_tile *t = &f->tile[tile];
    const bool empty = !holds_any(f, t);
    t->copying = true;
    pthread_mutex_unlock(&f->mutex);
    uint32_t *copy = empty ? NULL : malloc(glint_film_tile_bytes(f));
    if (copy)
        glint_film_copy(f, tile, copy);
    pthread_mutex_lock(&f->mutex);
    t->copy = copy;
    t->copying = false;
    if (copy || empty)
        captured(f, t);
    pthread_cond_broadcast(&f->changed);
    if (t->wanted)
        pthread_cond_wait(&f->changed, &f->mutex);
}

// The first of the tiles that is wanted or being read, or `none`.
static uint32_t first_wanted(const glint_film *f, uint32_t column, uint32_t row, uint32_t right,
                             uint32_t bottom, uint32_t none)
{
    for (uint32_t y = row; y < bottom; y++)
        for (uint32_t x = column; x < right; x++)
            if (f->tile[y * f->columns + x].wanted || f->tile[y * f->columns + x].readers)
                return y * f->columns + x;
    return none;
}

// All tiles of a block are in one state: marked together, once none is wanted.
uint32_t glint_film_capture_before_write(glint_film *f, uint32_t column, uint32_t row,
                                         uint32_t right, uint32_t bottom)
{
    const uint32_t none = f->columns * f->rows;
    uint32_t tile;
    pthread_mutex_lock(&f->mutex);
    while ((tile = first_wanted(f, column, row, right, bottom, none)) != none)
        if (f->tile[tile].readers)
            pthread_cond_wait(&f->changed, &f->mutex);
        else
            copy_tile(f, tile);
    for (uint32_t y = row; y < bottom; y++)
        for (uint32_t x = column; x < right; x++)
            f->tile[y * f->columns + x].written = true;
    const uint32_t captures = f->captures;
    pthread_mutex_unlock(&f->mutex);
    return captures;
}
