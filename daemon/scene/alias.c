#include "scene/alias.h"

#include <math.h>
#include <stdlib.h>

static double total_of(const double *weight, uint32_t n)
{
    double total = 0.0;
    for (uint32_t i = 0; i < n; i++)
        total += weight[i];
    return total;
}

bool glint_alias_build(const double *weight, uint32_t n, float *keep, uint32_t *other,
                       size_t stride)
{
    double *share = malloc(n * sizeof *share);
    uint32_t *stack = malloc(n * sizeof *stack); // small ones from the bottom, large from the top
    if (!share || !stack) {
        free(share);
        free(stack);
        return false;
    }
    const double total = total_of(weight, n);
    uint32_t small = 0, large = n;
    for (uint32_t i = 0; i < n; i++) {
        share[i] = total > 0.0 ? weight[i] / total * n : 1.0;
        if (share[i] < 1.0)
            stack[small++] = i;
        else
            stack[--large] = i;
    }
    while (small > 0 && large < n) {
        const uint32_t s = stack[--small], l = stack[large];
        keep[s * stride] = (float)share[s];
        other[s * stride] = l;
        share[l] -= 1.0 - share[s];
        if (share[l] < 1.0) {
            large++;
            stack[small++] = l;
        }
    }
    while (large < n) {
        keep[stack[large] * stride] = 1.0f;
        other[stack[large] * stride] = stack[large];
        large++;
    }
    while (small > 0) { // only by rounding
        small--;
        keep[stack[small] * stride] = 1.0f;
        other[stack[small] * stride] = stack[small];
    }
    free(share);
    free(stack);
    return true;
}

void glint_alias_round(float *keep, const uint32_t *other, uint32_t n, size_t stride,
                       double *probability)
{
    for (uint32_t i = 0; i < n; i++)
        probability[i] = 0.0;
    for (uint32_t i = 0; i < n; i++) {
        const double k = ceil(keep[i * stride] * 0x1p24) * 0x1p-24;
        keep[i * stride] = (float)k;
        probability[i] += k / n;
        probability[other[i * stride]] += (1.0 - k) / n;
    }
}
