// bounced.h - shots of small scenes with mattes through bounces, and what one rough vertex hands on,
// by quadrature in double precision.
#ifndef GLINT_TESTS_BOUNCED_H
#define GLINT_TESTS_BOUNCED_H

#include "tests/kernel/surface.h"
#include "tests/render/things.h"

// scene, job: JSON with ' for ".
void bounced_take(struct shot *s, const char *scene, const char *job);

// Mean over the pixels, and its standard error as they tell it.
double bounced_mean(const struct shot *s, const char *type, const char *name, double *error);

// Eq. 4 as ALGORITHMS has it: the variance of a lobe by its density.
double plain_variance(double pdf);

// Eq. 5 to 7 of the first rough vertex. spread: the way over the radius of the cone where it ends.
double plain_weight(double variance, double spread, double alpha, bool cut);

// A plane without end over a vertex, and the cone that leaves the vertex.
struct ceiling {
    struct material material;
    double height;        // metres
    double cosine;        // of the view
    double radius, slope; // of the cone
    double alpha;
    bool cut;
    bool shared; // the material has a lobe beyond the surface as well: its density is less for that
};

// The integral of W f cos over the directions that see the plane.
double ceiling_share(const struct ceiling *c);

#endif
