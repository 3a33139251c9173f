#include "http/frames.h"

#include <pthread.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define KEY_BYTES 256

struct slot {
    char key[KEY_BYTES];
    struct glint_blob *blob; // NULL: free
    uint64_t used;           // tick of the last use
};

struct glint_frames {
    pthread_mutex_t mutex;
    size_t slots, max_bytes, bytes;
    uint64_t tick;
    struct slot slot[]; // [slots]
};

glint_status glint_frames_create(glint_frames **out, size_t slots, size_t bytes,
                                 struct glint_error *err)
{
    *out = calloc(1, sizeof **out + slots * sizeof(struct slot));
    if (!*out)
        return glint_fail(err, GLINT_E_NOMEM, "", "no memory for the cache of frames");
    (*out)->slots = slots;
    (*out)->max_bytes = bytes;
    pthread_mutex_init(&(*out)->mutex, NULL);
    return GLINT_OK;
}

static void drop(glint_frames *f, struct slot *s)
{
    f->bytes -= s->blob->size;
    glint_blob_release(&s->blob);
}

void glint_frames_destroy(glint_frames **frames)
{
    glint_frames *f = *frames;
    *frames = NULL;
    if (!f)
        return;
    for (size_t i = 0; i < f->slots; i++)
        if (f->slot[i].blob)
            drop(f, &f->slot[i]);
    pthread_mutex_destroy(&f->mutex);
    free(f);
}

static struct slot *find(glint_frames *f, const char *key)
{
    for (size_t i = 0; i < f->slots; i++)
        if (f->slot[i].blob && !strcmp(f->slot[i].key, key))
            return &f->slot[i];
    return NULL;
}

struct glint_blob *glint_frames_find(glint_frames *frames, const char *key)
{
    pthread_mutex_lock(&frames->mutex);
    struct slot *s = find(frames, key);
    if (s)
        s->used = ++frames->tick;
    struct glint_blob *blob = s ? glint_blob_retain(s->blob) : NULL;
    pthread_mutex_unlock(&frames->mutex);
    return blob;
}

// A free slot once there is room for `bytes`: drops what was not used for longest.
static struct slot *make_room(glint_frames *f, size_t bytes)
{
    for (;;) {
        struct slot *free_slot = NULL, *oldest = NULL;
        for (size_t i = 0; i < f->slots; i++) {
            struct slot *s = &f->slot[i];
            if (!s->blob)
                free_slot = s;
            else if (!oldest || s->used < oldest->used)
                oldest = s;
        }
        if (free_slot && f->bytes + bytes <= f->max_bytes)
            return free_slot;
        drop(f, oldest);
    }
}

void glint_frames_keep(glint_frames *frames, const char *key, struct glint_blob *blob)
{
    if (blob->size > frames->max_bytes || strlen(key) >= KEY_BYTES)
        return;
    pthread_mutex_lock(&frames->mutex);
    if (!find(frames, key)) {
        struct slot *s = make_room(frames, blob->size);
        strcpy(s->key, key);
        s->blob = glint_blob_retain(blob);
        s->used = ++frames->tick;
        frames->bytes += blob->size;
    }
    pthread_mutex_unlock(&frames->mutex);
}
