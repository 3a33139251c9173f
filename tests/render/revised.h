// revised.h - a scene that differs from another in one thing.
#ifndef GLINT_TESTS_REVISED_H
#define GLINT_TESTS_REVISED_H

#include "tests/render/offline.h"

// Members and values of its text.
struct revised_edit {
    const char *red;   // colour of a material
    const char *place; // of the ball
    const char *cube;  // members of an instance
    const char *box;   // of a mesh
    const char *lamp;  // intensity
    const char *sky;
    const char *more; // meshes
};
extern const struct revised_edit revised_base;

// Malloc'd. first_texel: of the texture of the cube and the floor.
char *revised_text(const struct revised_edit *e, float first_texel);

// The scene of a text, which is freed; from: the revision before it, or NULL. Ends the program where
// it cannot be loaded.
glint_resident *revised_load(char *text, const glint_resident *from);

struct glint_frame *revised_show(glint_resident *r, bool live);

// Bits of the parts that were made anew.
#define REVISED_PART(p) (1u << GLINT_PART_##p)
unsigned revised_made(const glint_resident *r);

#endif
