// revision_parts.h - the inside of a revision, shared by the file that makes it and the one that
// describes it.
#ifndef GLINT_SCENE_REVISION_PARTS_H
#define GLINT_SCENE_REVISION_PARTS_H

#include "scene/revision.h"

#include <pthread.h>

#define GLINT_MAX_POSES 64u

// A pose that a job asked for; the next frame's job may render beside it.
struct glint_cached_pose {
    struct glint_pose_request request;
    struct glint_posed posed; // retained
    uint64_t bytes, used;     // used: the turn in which it was asked for last
};

struct glint_revision {
    atomic_uint references;
    glint_devices *devices;
    struct glint_usage *usage;
    char *name;
    char id[65];
    char created[32];
    struct glint_posed rest;           // owns scene and import
    const struct glint_import *import; // lives as long as `rest`
    glint_keep *keep;                  // NULL: nothing is kept
    char *warnings, *told;             // of a recalled one: JSON as it was told, or NULL
    atomic_int stage;        // enum glint_revision_stage; what loading fills is read after it
    pthread_mutex_t loading; // held by who loads
    struct glint_error why;  // GLINT_REVISION_FAILED
    double parse_seconds;
    struct glint_resident_stats stats; // as it was loaded
    _Atomic uint64_t later_bytes;      // of structures that were built since
    _Atomic uint64_t *resident_bytes;
    pthread_mutex_t mutex; // guards what follows
    struct glint_cached_pose pose[GLINT_MAX_POSES];
    uint32_t poses;
    uint64_t pose_turns;
    _Atomic uint64_t pose_bytes; // also read without
};

enum glint_revision_stage { GLINT_REVISION_RECALLED, GLINT_REVISION_LOADED, GLINT_REVISION_FAILED };

// Of a resident scene, over all kinds.
static inline uint64_t glint_revision_bytes(const struct glint_resident_stats *s)
{
    return s->geometry_bytes + s->bvh_bytes + s->record_bytes + s->texture_bytes + s->light_bytes;
}

#endif
