// gk_cut.h - keeps the arithmetic that finds an entry of a table apart from the look-up of it.
//
// Where a processor has no gathers, or LLVM does not use them (AVX2), its vectoriser makes each lane's
// look-ups one by one, and with them all that their addresses are made of, back to the beginning of
// the basic block: random numbers, coordinates, the light grid. A store that never happens, under a
// condition that the compiler cannot know, ends the block between the two: the arithmetic stays in
// vectors, and of the look-up only its last addition is done lane by lane. Under GK_CUTS only.
#ifndef GK_CUT_H
#define GK_CUT_H

#include "kernels/gk_types.h"

struct gk_cut {
#ifdef GK_CUTS
    GK_GLOBAL gk_f32 *at; // of the item
#endif
    gk_i32 never; // 0
};

GK_INLINE struct gk_cut gk_cut_none(void)
{
    struct gk_cut cut;
#ifdef GK_CUTS
    cut.at = 0;
#endif
    cut.never = 0;
    return cut;
}

#ifdef GK_CUTS
#define GK_CUT(cut)  \
    if ((cut).never) \
    *(cut).at = 0.0f
#else
#define GK_CUT(cut) (void)(cut)
#endif

#endif
