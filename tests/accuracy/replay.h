// replay.h - one render's deposits, given to many tables at once.
//
// Deposits do not depend on what tables do with them, so one render shows what every policy and every
// number of slots would have kept. The program is linked with
// --wrap=glint_run_deposit_pixels and --wrap=glint_carried_deposit.
//
// Threads: tables of a tile are touched by the worker that holds it; the rest by main.
#ifndef GLINT_TESTS_REPLAY_H
#define GLINT_TESTS_REPLAY_H

#include "tests/render/offline.h"

#include "kernels/gk_matte_spill.h"

// Policies of this program alone.
#define REPLAY_CHAO 100u // see replay_chao.c
#define REPLAY_BEST \
    101u // the names with most, known beforehand: no table of so many slots does better
#define REPLAY_MAX_SLOTS 32u
#define REPLAY_WORDS (REPLAY_MAX_SLOTS + GK_MATTE_LOST_WORDS + GK_MATTE_SPILL_WORDS)

struct replay_setting {
    uint32_t policy, slots; // GK_MATTE_* or REPLAY_*
    const char *name;       // of the policy
};

struct replay {
    const struct replay_setting *setting;
    size_t settings;
    uint32_t pixels, columns; // of whole tiles; tiles in a row
    uint32_t mattes, keys;    // of each class; of all
    uint64_t *table; // [settings][pixels][REPLAY_WORDS], of which a setting uses what it needs
    uint64_t *exact; // [pixels][keys]
    uint64_t *chao;  // [settings][pixels]: what its bounced slots stand for
};

// Renders `job`, whose mattes are exact, with its deposits given to all settings. What was in the
// tables before is gone. The render is the caller's.
glint_render *replay_render(struct replay *r, const struct offline *o,
                            const struct glint_posed *scene, const struct glint_job *job);
void replay_finish(struct replay *r);

uint64_t *replay_table(const struct replay *r, size_t setting, uint32_t pixel);

// Units that a setting has of each key, and [keys] and [keys + 1] what it lost of either kind.
void replay_kept(const struct replay *r, size_t setting, uint32_t pixel, double *out);

// One deposit into a table of the policy REPLAY_CHAO.
void replay_chao(uint64_t *table, uint64_t *total, uint32_t slots, uint32_t key, uint64_t amount,
                 uint32_t random, struct gk_matte_lost *lost);

#endif
