// subrays.h - what brute force says of a pixel that sees a rough mirror: 4096 sub-rays through its
// footprint, each reflected once by the lobe where it hits, and what they hit then.
//
// The geometry, normals and lobes are the renderer's; its paths, cones and weights have no part.
// Two readings of how much of a matte the reflector hands on:
//   coverage  all: a matte is the share of the sub-rays that end on it
//   share     the weight of a sub-ray is the share of the sub-rays that end where it does
#ifndef GLINT_TESTS_ACCURACY_SUBRAYS_H
#define GLINT_TESTS_ACCURACY_SUBRAYS_H

#include "tests/render/offline.h"

#define SUBRAYS_SIDE 64
#define SUBRAYS (SUBRAYS_SIDE * SUBRAYS_SIDE)
#define SUBRAYS_KEYS 64 // matte keys of a scene, at most

enum subrays_reading { SUBRAYS_COVERAGE, SUBRAYS_SHARE, SUBRAYS_READINGS };

struct subrays_pixel {
    float part[SUBRAYS_READINGS][SUBRAYS_KEYS]; // of the pixel, by matte key
    uint32_t first;                             // key that all sub-rays hit first, 0: no one mirror
    float curvature;                            // there, 1/m; > 0: it bulges
    float distance;                             // to the second hit, a mean; inf: most hit nothing
};

struct subrays;

// render: of the scene, for its camera. mirrors: how the names of the objects to look at begin. Ends
// the program where the scene has too many keys.
struct subrays *subrays_create(glint_resident *scene, const glint_render *render,
                               const char *mirrors);
void subrays_destroy(struct subrays *s);

// A pixel whose first hits are not all of one of these objects has no parts.
void subrays_look(struct subrays *s, uint32_t x, uint32_t y, struct subrays_pixel *out);

#endif
