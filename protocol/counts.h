// counts.h - what is counted in every job against the rules that hold for every sample: none is
// negative or no number, coverage is neither made nor lost.
//
// Thread-safety: reentrant.
#ifndef GLINT_PROTOCOL_COUNTS_H
#define GLINT_PROTOCOL_COUNTS_H

#include <stdbool.h>
#include <stdint.h>

enum glint_count {
    // Samples that were rejected: they count as zero and are not drawn again.
    GLINT_COUNT_NAN,      // light that is no number
    GLINT_COUNT_INFINITE, // light beyond every number
    GLINT_COUNT_NEGATIVE, // less than no light
    GLINT_COUNT_NESTED,   // in more nested solids than are known
    // Samples taken as GK_SUM_LARGEST, because they were brighter.
    GLINT_COUNT_BRIGHT,
    // Coverage in units of 2^-16 samples: cut from weights above one; found no slot.
    GLINT_COUNT_CLAMPED,
    GLINT_COUNT_LOST,
    GLINT_COUNTS
};
#define GLINT_REJECTIONS 4         // the first of them
#define GLINT_COUNT_SAMPLE 65536.0 // units of a sample's coverage

extern const char *const glint_count_name[GLINT_COUNTS];

void glint_counts_add(uint64_t sum[GLINT_COUNTS], const uint64_t more[GLINT_COUNTS]);

uint64_t glint_counts_rejected(const uint64_t count[GLINT_COUNTS]);

// At most one sample in 10^6 was rejected.
bool glint_counts_sound(const uint64_t count[GLINT_COUNTS], uint64_t samples);

// Share of the samples' coverage, 0..1, that one of the last two is.
double glint_counts_share(const uint64_t count[GLINT_COUNTS], enum glint_count which,
                          uint64_t samples);

#endif
