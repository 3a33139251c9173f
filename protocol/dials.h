// dials.h - every accuracy dial: its exact setting and the approximations of it that exist.
//
// The accuracy programme, GET /v1, the job parser and the plan walk this table; nothing in it is
// listed a second time. The first setting of a row is the exact one.
#ifndef GLINT_PROTOCOL_DIALS_H
#define GLINT_PROTOCOL_DIALS_H

#include <stddef.h>

enum glint_dial {
    GLINT_DIAL_GI,           // path, none
    GLINT_DIAL_TRANSPARENCY, // traced
    GLINT_DIAL_PRIMARY,      // full
    GLINT_DIAL_THROUGH,      // mattes.through: glossy, delta, none
    GLINT_DIAL_VARIANCE,     // mattes.variance: exact, eq3
    GLINT_DIAL_COVERAGE,     // mattes.coverage: redistribute, opaque_full
    GLINT_DIAL_PATH_IDS,     // mattes.path_ids: list, previous
    GLINT_DIAL_EVICTION,     // mattes.eviction: exact, drop, direct_first, uss, .., spill
    GLINT_DIAL_PRECISION,    // float64, float32
    GLINT_DIAL_TRAVERSAL,    // watertight, robust, fast
    GLINT_DIAL_ROULETTE,     // none, throughput
    GLINT_DIAL_LIGHTS,       // spatial, power, uniform
    GLINT_DIAL_MICROFACET,   // multiple, single
    GLINT_DIAL_COUNT
};

#define GLINT_MAX_SETTINGS 6

// Settings by name, where code asks for one.
enum { GLINT_TRAVERSAL_WATERTIGHT, GLINT_TRAVERSAL_ROBUST, GLINT_TRAVERSAL_FAST };
enum { GLINT_PATH_IDS_LIST, GLINT_PATH_IDS_PREVIOUS };
enum { GLINT_THROUGH_GLOSSY, GLINT_THROUGH_DELTA, GLINT_THROUGH_NONE };
enum {
    GLINT_EVICTION_EXACT,
    GLINT_EVICTION_DROP,
    GLINT_EVICTION_DIRECT_FIRST,
    GLINT_EVICTION_USS,
    GLINT_EVICTION_USS_DIRECT_FIRST,
    GLINT_EVICTION_SPILL
};

struct glint_dial_row {
    const char *name;                            // member name in the job
    const char *parent;                          // "accuracy" or "mattes"
    const char *setting[GLINT_MAX_SETTINGS + 1]; // NULL-terminated, exact first
    unsigned char unbiased; // bit i: setting i has the same expectation as the exact one
    const char *source;     // where the approximation comes from
};

struct glint_preset {
    const char *name;
    unsigned char setting[GLINT_DIAL_COUNT];
};

extern const struct glint_dial_row glint_dial_table[GLINT_DIAL_COUNT];
extern const struct glint_preset glint_preset_table[]; // NULL name ends it; [0] is the default
extern const size_t glint_preset_count;

// Index of the named setting in its row, or -1.
int glint_dial_setting(enum glint_dial dial, const char *setting);

#endif
