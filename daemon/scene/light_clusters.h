// light_clusters.h - groups of lights that shine alike, and what a group sends where.
//
// The intensity of a light over directions is taken for a quadratic polynomial of the direction
// (compare Ramamoorthi and Hanrahan 2001), nowhere negative: such intensities add up.
#ifndef GLINT_SCENE_LIGHT_CLUSTERS_H
#define GLINT_SCENE_LIGHT_CLUSTERS_H

#include "kernels/gk_scene.h"

#include <stdbool.h>
#include <stddef.h>

// One light, or the sum of many. Every member but power^-1 moments is linear in the emission.
struct glint_shine {
    double power;      // sum of weights; a sun's is its own irradiance
    double moment[3];  // of position
    double square;     // of |position|^2
    double mean;       // intensity over all directions, W/sr
    double linear[3];  // I(w) = mean + linear.w + w.Q w, Q symmetric without trace
    double quadric[6]; // xx, yy, zz, xy, xz, yz
    double sun;        // W/m^2 of those infinitely far
};

// power: as the alias table has it, > 0.
struct glint_shine glint_light_shine(const struct gk_light *light, double power);

struct glint_cluster {
    struct glint_shine shine;
    uint32_t first, count; // of the order
    double loss;           // of taking it for one light
};

// Splits n lights into at most `most` clusters. order: [n], any permutation of the lights, on return
// those of a cluster side by side; shine: [n] by light. Suns are never with others. Returns the
// number of clusters.
uint32_t glint_light_clusters(struct glint_cluster *out, uint32_t most, uint32_t *order, uint32_t n,
                              const struct glint_shine *shine);

#endif
