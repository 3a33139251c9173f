#include "scene/polygon.h"

#include <math.h>
#include <stdbool.h>
#include <string.h>

struct flat {
    double x[GLINT_POLYGON_EARS], y[GLINT_POLYGON_EARS];
    uint32_t left[GLINT_POLYGON_EARS]; // corners that are not cut off yet
    uint32_t count;
};

static void fan(uint32_t count, uint32_t (*out)[3])
{
    for (uint32_t i = 0; i + 2 < count; i++) {
        const uint32_t corner[3] = {0, i + 1, i + 2};
        memcpy(out[i], corner, sizeof corner);
    }
}

// Newell's normal: right for polygons that are concave or not quite flat.
static void normal_of(const float (*p)[3], uint32_t count, double n[3])
{
    memset(n, 0, 3 * sizeof *n);
    for (uint32_t i = 0; i < count; i++) {
        const float *a = p[i], *b = p[(i + 1) % count];
        for (int k = 0; k < 3; k++) {
            const int u = (k + 1) % 3, v = (k + 2) % 3;
            n[k] += ((double)a[u] - b[u]) * ((double)a[v] + b[v]);
        }
    }
}

// Seen along its normal's largest axis so that it turns counter-clockwise.
static void flatten(struct flat *f, const float (*p)[3], uint32_t count)
{
    double n[3];
    normal_of(p, count, n);
    int axis = fabs(n[1]) > fabs(n[0]) ? 1 : 0;
    axis = fabs(n[2]) > fabs(n[axis]) ? 2 : axis;
    const int u = (axis + 1) % 3, v = (axis + 2) % 3;
    f->count = count;
    for (uint32_t i = 0; i < count; i++) {
        f->x[i] = n[axis] < 0 ? -(double)p[i][u] : p[i][u];
        f->y[i] = p[i][v];
        f->left[i] = i;
    }
}

static double turn(const struct flat *f, uint32_t a, uint32_t b, uint32_t c)
{
    return (f->x[b] - f->x[a]) * (f->y[c] - f->y[a]) - (f->y[b] - f->y[a]) * (f->x[c] - f->x[a]);
}

static bool same(const struct flat *f, uint32_t a, uint32_t b)
{
    return f->x[a] == f->x[b] && f->y[a] == f->y[b];
}

// The corner at position i of what is left can be cut off: it is convex and no other lies in it.
static bool is_ear(const struct flat *f, uint32_t i)
{
    const uint32_t n = f->count;
    const uint32_t a = f->left[(i + n - 1) % n], b = f->left[i], c = f->left[(i + 1) % n];
    if (turn(f, a, b, c) <= 0)
        return false;
    for (uint32_t k = 0; k < n; k++) {
        const uint32_t p = f->left[k];
        if (p == a || p == b || p == c || same(f, p, a) || same(f, p, b) || same(f, p, c))
            continue;
        if (turn(f, a, b, p) >= 0 && turn(f, b, c, p) >= 0 && turn(f, c, a, p) >= 0)
            return false;
    }
    return true;
}

// From the second corner on: of a convex polygon a fan about the first is cut.
static bool cut_ear(struct flat *f, uint32_t out[3])
{
    for (uint32_t k = 1; k <= f->count; k++) {
        const uint32_t i = k % f->count;
        if (!is_ear(f, i))
            continue;
        out[0] = f->left[(i + f->count - 1) % f->count];
        out[1] = f->left[i];
        out[2] = f->left[(i + 1) % f->count];
        f->count--;
        memmove(f->left + i, f->left + i + 1, (f->count - i) * sizeof *f->left);
        return true;
    }
    return false;
}

void glint_polygon_cut(const float (*point)[3], uint32_t count, uint32_t (*out)[3])
{
    struct flat f;
    fan(count, out);
    if (count == 3 || count > GLINT_POLYGON_EARS)
        return;
    flatten(&f, point, count);
    uint32_t cut = 0;
    while (f.count > 3 && cut_ear(&f, out[cut]))
        cut++;
    // What is left crosses itself or has no area: a fan of it.
    for (uint32_t i = 0; i + 2 < f.count; i++) {
        const uint32_t corner[3] = {f.left[0], f.left[i + 1], f.left[i + 2]};
        memcpy(out[cut + i], corner, sizeof corner);
    }
}
