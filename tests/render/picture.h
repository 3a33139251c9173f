// picture.h - small pictures as text, for the textures of test scenes.
#ifndef GLINT_TESTS_PICTURE_H
#define GLINT_TESTS_PICTURE_H

#include "protocol/png.h"

// A data URI of the image as PNG; malloc'd. Ends the program where there is no memory.
char *picture_uri(const struct glint_png_image *image);

// 8x8, opaque white where column + row is even, holes elsewhere.
char *picture_checkerboard(void);

#endif
