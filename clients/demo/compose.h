// compose.h - the parts of the demo scene.
//
// The middle is a round stage of black lacquer. Behind it and at its sides rise shelves of plaster
// in arcs, with many hundreds of small named things on them, and behind these a wall without a
// horizon. On the stage stand glass and metal.
#ifndef GLINT_DEMO_COMPOSE_H
#define GLINT_DEMO_COMPOSE_H

#include "document.h"

#define FLOOR (-0.06) // metres; the stage's top is 0
#define STAGE_RADIUS 1.3
#define SHELVES 13
#define SHELF_DEPTH 0.165
#define SHELF_RISE 0.095
#define SHELF_EDGE 0.012 // radius of the rounded edges

void glint_compose_shelves(struct glint_document *d);
void glint_compose_still_life(struct glint_document *d);
void glint_compose_light(struct glint_document *d);

#endif
