#include "tests/bench/bench.h"

#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static int by_value(const void *a, const void *b)
{
    const double x = *(const double *)a, y = *(const double *)b;
    return x < y ? -1 : x > y;
}

double bench_median(double *x, size_t n)
{
    qsort(x, n, sizeof *x, by_value);
    return n % 2 ? x[n / 2] : 0.5 * (x[n / 2 - 1] + x[n / 2]);
}

#define RESAMPLES 2000

struct bench_ratio bench_ratio_of(const double *a, const double *b, size_t pairs)
{
    double ratio[256], drawn[256], medians[RESAMPLES];
    uint32_t random = 12345;
    for (size_t i = 0; i < pairs; i++)
        ratio[i] = b[i] / a[i];
    for (int r = 0; r < RESAMPLES; r++) {
        for (size_t i = 0; i < pairs; i++) {
            random = random * 1664525u + 1013904223u;
            drawn[i] = ratio[(random >> 8) % pairs];
        }
        medians[r] = bench_median(drawn, pairs);
    }
    qsort(medians, RESAMPLES, sizeof *medians, by_value);
    return (struct bench_ratio){bench_median(ratio, pairs), medians[RESAMPLES / 40],
                                medians[RESAMPLES - 1 - RESAMPLES / 40]};
}

void bench_pairs(double (*run_a)(void *), double (*run_b)(void *), void *user, double *a, double *b,
                 size_t pairs)
{
    for (size_t i = 0; i < pairs; i++) {
        if (i % 2 == 0) {
            a[i] = run_a(user);
            b[i] = run_b(user);
        } else {
            b[i] = run_b(user);
            a[i] = run_a(user);
        }
    }
}

#define APPEND(...) used += (size_t)snprintf(text + used, sizeof text - used, __VA_ARGS__)

const char *bench_balls_scene(unsigned segments)
{
    static char text[16384];
    size_t used = 0;
    APPEND("{\"materials\":{"
           "\"wall\":{\"base_color\":[0.75,0.75,0.75],\"roughness\":0.8},"
           "\"lamp\":{\"base_color\":[0,0,0],\"ior\":1,\"emission\":[12,11,10],\"double_sided\":"
           "false},"
           "\"m0\":{\"base_color\":[0.95,0.7,0.3],\"roughness\":0.25,\"metallic\":1},"
           "\"m1\":{\"base_color\":[0.9,0.9,0.95],\"roughness\":0.1,\"metallic\":1},"
           "\"m2\":{\"base_color\":[0.3,0.4,0.8],\"roughness\":0.3},"
           "\"m3\":{\"base_color\":[0.8,0.3,0.5],\"roughness\":0.15},"
           "\"m4\":{\"base_color\":[0.6,0.7,0.3],\"roughness\":0.5},"
           "\"m5\":{\"base_color\":[0.5,0.3,0.2],\"roughness\":0.35,\"metallic\":0.5}},"
           "\"meshes\":{\"room\":{\"primitive\":\"box\",\"size\":[10,10,14]},"
           "\"lamp\":{\"primitive\":\"quad\",\"size\":[1.5,1.5]}");
    for (int i = 0; i < 18; i++) // a mesh each: nothing is instanced
        APPEND(",\"ball%d\":{\"primitive\":\"sphere\",\"radius\":%g,\"segments\":%u}", i,
               1.2 + 0.001 * i, segments);
    APPEND("},\"instances\":{\"room\":{\"mesh\":\"room\",\"material\":\"wall\"}");
    for (int i = 0; i < 18; i++)
        APPEND(",\"ball%d\":{\"mesh\":\"ball%d\",\"material\":\"m%d\",\"transform\":{"
               "\"translation\":[%g,%g,%g]}}",
               i, i, i * 5 % 6, -3.0 + 3.0 * (i % 3), -3.6 + 3.6 * (i / 9) + 0.3 * (i % 2),
               -4.2 + 3.0 * (i / 3 % 3));
    for (int i = 0; i < 4; i++)
        APPEND(",\"lamp%d\":{\"mesh\":\"lamp\",\"material\":\"lamp\",\"transform\":{"
               "\"translation\":[%g,4.95,%g],"
               "\"rotation\":[0.70710678,0,0,0.70710678]}}",
               i, i % 2 ? 2.2 : -2.2, i / 2 ? 2.2 : -2.2);
    APPEND("},\"cameras\":{\"eye\":{\"yfov\":0.9,\"transform\":{\"translation\":[0,0,6.9]}}}}");
    return text;
}

const char *bench_million_scene(void)
{
    return bench_balls_scene(224);
}
