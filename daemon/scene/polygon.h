// polygon.h - polygons of mesh files to triangles.
//
// Thread-safety: reentrant.
#ifndef GLINT_SCENE_POLYGON_H
#define GLINT_SCENE_POLYGON_H

#include <stdint.h>

#define GLINT_POLYGON_EARS 256u // corners up to which concave ones are cut well

// Cuts the polygon with corners point[0..count) into count - 2 triangles of corner numbers, in the
// polygon's own sense of rotation. out: [count - 2][3]. Up to GLINT_POLYGON_EARS corners ears are
// cut, so that a concave one is filled as it was drawn; beyond, and where none is found because it
// crosses itself, it becomes a fan. The cost is at most cubic in GLINT_POLYGON_EARS, else linear.
void glint_polygon_cut(const float (*point)[3], uint32_t count, uint32_t (*out)[3]);

#endif
