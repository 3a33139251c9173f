// ranking.h - from the slot table of a pixel to the ranked IDs of one Cryptomatte layer.
//
// Source: Cryptomatte 1.2.0, "Ranking Pixel Filter"; several keys of one layer may share an ID.
#ifndef GLINT_RENDER_RANKING_H
#define GLINT_RENDER_RANKING_H

#include "protocol/cryptomatte.h"
#include "render/render.h"

#define GLINT_MAX_SLOTS 32

// Fills rank[slots] with the IDs that cover the pixel, sorted, coverage over `samples`. Returns
// their number.
uint32_t glint_ranking(const glint_resident *scene, const uint64_t *table, uint32_t slots,
                       enum glint_matte_layer layer, uint32_t samples,
                       struct glint_cryptomatte_rank *rank);

// The manifest of every name that the scene has in a layer; malloc'd, NULL without memory.
char *glint_ranking_manifest(const glint_resident *scene, enum glint_matte_layer layer);

// "CryptoObject" and so on.
const char *glint_render_matte_type(enum glint_matte_layer layer);

#endif
