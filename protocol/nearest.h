// nearest.h - the name that a mistyped one was probably meant to be.
//
// Thread-safety: reentrant.
#ifndef GLINT_PROTOCOL_NEAREST_H
#define GLINT_PROTOCOL_NEAREST_H

// The one of the NULL-terminated names that the fewest slips of the hand lead to: a letter too many,
// too few, another one, or two exchanged (optimal string alignment). NULL: each would take more than
// one slip for every three letters.
const char *glint_nearest(const char *const *names, const char *typed);

#endif
