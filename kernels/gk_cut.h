// gk_cut.h - keeps the arithmetic that finds an entry of a table apart from the look-up of it.
//
// Where a processor has no gathers, or LLVM does not use them (AVX2), its vectoriser makes each lane's
// look-ups one by one, and with them all that their addresses are made of, back to the beginning of
// the basic block: random numbers, coordinates, the light grid. A store that never happens, under a
// condition that the compiler cannot know, ends the block between the two: the arithmetic stays in
// vectors, and of the look-up only its last addition is done lane by lane. It is the place itself that
// would be stored: what only the block behind the cut uses, LLVM moves there. Under GK_NO_GATHERS only.
#ifndef GK_CUT_H
#define GK_CUT_H

#include "kernels/gk_types.h"

struct gk_cut {
#ifdef GK_NO_GATHERS
    GK_GLOBAL gk_f32 *at; // of the item
#endif
    gk_i32 never; // 0
};

GK_INLINE struct gk_cut gk_cut_none(void)
{
    struct gk_cut cut;
#ifdef GK_NO_GATHERS
    cut.at = 0;
#endif
    cut.never = 0;
    return cut;
}

#ifdef GK_NO_GATHERS
#define GK_CUT(cut, word) \
    if ((cut).never)      \
    *(cut).at = gk_as_f32(word)
#else
#define GK_CUT(cut, word) ((void)(cut), (void)(word))
#endif

#endif
