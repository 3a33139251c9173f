// light_grid.h - the table of gk_light_grid.h: which lights to choose where.
#ifndef GLINT_SCENE_LIGHT_GRID_H
#define GLINT_SCENE_LIGHT_GRID_H

#include "kernels/gk_scene.h"
#include "protocol/status.h"
#include "scene/resident.h"

struct glint_light_grid_order {
    const struct gk_light *light; // [lights]
    const double *power;          // [lights], >= 0: how often the power table takes each
    uint32_t lights;
    const double *half; // [3] of the scene's box, whose middle is the origin
};

// From how many emitters on a grid pays.
#define GLINT_LIGHT_GRID_LEAST 17u

// Builds the words (malloc'd) and the grid members of *lighting. Probabilities are those of the
// rounded tables, to a few ulp; every light of power > 0 has one > 0 in every cell.
//   GLINT_E_NOMEM
glint_status glint_light_grid_build(uint32_t **words, size_t *count,
                                    struct glint_scene_lighting *lighting,
                                    const struct glint_light_grid_order *order,
                                    struct glint_error *err);

#endif
