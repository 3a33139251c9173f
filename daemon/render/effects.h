// effects.h - the one table that decides what is simulated.
//
// A row is an effect: what in the scene or job calls for it, which -D compiles it in, which passes
// and film planes it adds, which dial rules it. Program variants, buffers and passes come from here
// and nowhere else. Forcing a row that is not called for may cost time, never change a bit of the
// image; both directions are tested for every row.
#ifndef GLINT_RENDER_EFFECTS_H
#define GLINT_RENDER_EFFECTS_H

#include "protocol/job.h"
#include "scene/resident.h"

// Slots change by compare and swap: the same bits while none is evicted.
#define GLINT_EFFECT_SHARED_TABLES "slot tables shared by work-items"

enum glint_pass {
    GLINT_PASS_GENERATE,
    GLINT_PASS_TRACE,
    GLINT_PASS_SHADE,
    GLINT_PASS_SHADOW,
    GLINT_PASS_UNOCCLUDED,
    GLINT_PASS_COMPACT,
    GLINT_PASS_COLOUR,
    GLINT_PASS_BATCHES,
    GLINT_PASS_AOVS,
    GLINT_PASS_CARRIED,
    GLINT_PASS_COVERAGE,
    GLINT_PASSES
};
extern const char *const glint_pass_name[GLINT_PASSES];

// What rows are asked about.
struct glint_effect_input {
    const struct glint_scene_facts *facts;
    const struct glint_job *job;
    const struct glint_camera *camera;
    bool camera_moves; // while the shutter is open
};

struct glint_effect {
    const char *name;
    const char *cause;    // what calls for it
    const char *define;   // "GK_X" or "GK_X=n", NULL: none
    const char *source;   // paper and equation, or specification
    enum glint_dial dial; // GLINT_DIAL_COUNT: none rules it
    uint32_t passes;      // bits 1 << glint_pass that it adds
    bool (*called)(const struct glint_effect_input *in);
    // Film bytes per pixel that it adds; NULL: none.
    size_t (*film_bytes)(const struct glint_job *job, const struct glint_scene_facts *facts);
    uint32_t tables; // bits 1 << glint_table of the resident buffers that it alone reads
    uint32_t
        carries; // bits 1 << GK_COL_* of path columns, from GK_COL_TIME on, that it alone wants
};

extern const struct glint_effect glint_effect_table[];
extern const size_t glint_effect_count; // at most 64

// Bits of the rows that are called for.
uint64_t glint_effects_called(const struct glint_effect_input *in);

// Bit of a named row, 0 if there is none.
uint64_t glint_effect_bit(const char *name);

#endif
