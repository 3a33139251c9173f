// palette.h - the colours of the demo scene.
#ifndef GLINT_DEMO_PALETTE_H
#define GLINT_DEMO_PALETTE_H

#include "document.h"

// Ceramic colours in order round the shelves.
#define GLINT_PALETTE_COLORS 18

const char *glint_palette_name(unsigned color);

// Every material of the scene: "ceramic NAME" and "glazed NAME" for each colour, the metals, the
// glasses, what things stand on.
void glint_palette_write(struct glint_document *d);

#endif
