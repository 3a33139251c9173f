// scenes.h - the scenes that can be asked for by name, and what they have in common.
//
// Thread-safety: each document has one owner.
#ifndef GLINT_DEMO_SCENES_H
#define GLINT_DEMO_SCENES_H

#include "document.h"

void glint_scene_strips(struct glint_document *d);
void glint_scene_plant(struct glint_document *d);
void glint_scene_water(struct glint_document *d);
void glint_scene_forty(struct glint_document *d);
void glint_scene_cluster(struct glint_document *d);

// A square area light at `from` that faces the origin. radiance: W/sr/m^2; size: metres.
void glint_scene_light(struct glint_document *d, const double from[3], double radiance,
                       double size);

// The same grey radiance from everywhere.
void glint_scene_sky(struct glint_document *d, double radiance);

// yfov: radians.
void glint_scene_camera(struct glint_document *d, const double from[3], const double to[3],
                        double yfov);

#endif
