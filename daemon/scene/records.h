// records.h - filling the shading records of one mesh. For records.c and tangents.c only.
#ifndef GLINT_SCENE_RECORDS_H
#define GLINT_SCENE_RECORDS_H

#include "scene/internal.h"

// Of k->triangles triangles at a key.
glint_status glint_records_fill_tangents(struct gk_tangent *out, const struct glint_kept *k,
                                         uint32_t key, struct glint_error *err);

#endif
