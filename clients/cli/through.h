// through.h - mattes of a picture by how the light has come: directly, or by bounces.
//
// Thread-safety: reentrant.
#ifndef GLINT_CLI_THROUGH_H
#define GLINT_CLI_THROUGH_H

#include "protocol/frame.h"

// The matte of an ID through the classes that `through` lists with commas: primary, glossy,
// reflection, refraction, depth0 to depth9; NULL: primary. type: of what is seen directly, "Crypto.."
// plane: [height][width], 0..1. Glossy and depth types hold what is seen directly too: of these and
// the primary one the larger counts, the others are added.
// GLINT_E_NOT_FOUND for each class that does not exist or that the picture has not.
glint_status glint_through_matte(const struct glint_frame *frame, const char *type,
                                 const char *through, uint32_t id, float *plane,
                                 struct glint_error *err);

#endif
