// bench.h - interleaved pairs and their interval.
#ifndef GLINT_BENCH_H
#define GLINT_BENCH_H

#include <stddef.h>

// Ratio b/a of two costs measured in the order A B B A ..., at least 9 pairs: the median over the
// pairs and a bootstrap 95 % interval of it (2000 resamples, fixed seed).
struct bench_ratio {
    double median, low, high;
};
struct bench_ratio bench_ratio_of(const double *a, const double *b, size_t pairs);

// Sorts x[n], n at least 1.
double bench_median(double *x, size_t n);

// Fills a[pairs] and b[pairs] by calling the two in the order A B B A; each returns its cost.
void bench_pairs(double (*run_a)(void *), double (*run_b)(void *), void *user, double *a, double *b,
                 size_t pairs);

// 904 K triangles: a room with 18 finely tessellated balls of rough metal, coated and matt
// materials under four lamps.
extern const char *bench_million_scene(void);

// The same with balls of so many segments: about 18 segments^2 triangles. Valid until the next call
// of either.
extern const char *bench_balls_scene(unsigned segments);

#endif
