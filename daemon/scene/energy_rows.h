// energy_rows.h - the integrals behind a part of the table of gk_energy.h, a row at a time. Private to
// scene/ and to the program that makes the usual ones when the daemon is built.
//
// Thread-safety: reentrant; rows are independent of each other.
#ifndef GLINT_SCENE_ENERGY_ROWS_H
#define GLINT_SCENE_ENERGY_ROWS_H

#include "kernels/gk_energy.h"

#define GLINT_ENERGY_STEPS 640 // 1.5 is step 128

// Which step in (ior - 1) / (ior + 1) an interface is taken for; *taken: the ior of that step.
int glint_energy_step(float ior, float *taken);

// Row y, of GK_ENERGY_SIDE, of a part and its mean. ior 0: of a white reflector.
void glint_energy_part_row(float *part, float ior, int y);

// Row y of the parts of a transmitting interface that come after its first.
void glint_energy_glass_row(float *parts, float ior, int y);

// Of a white reflector and of the interfaces that most scenes ask for: made with the daemon.
#define GLINT_ENERGY_USUALS 3
extern const float glint_energy_usual_ior[GLINT_ENERGY_USUALS];
extern const float glint_energy_usual_white[GK_ENERGY_PART];
extern const float glint_energy_usual_glass[GLINT_ENERGY_USUALS][GK_ENERGY_PARTS * GK_ENERGY_PART];

#endif
