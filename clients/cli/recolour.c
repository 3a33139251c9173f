#include "recolour.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#define REACH 2       // pixels around an edge pixel that tell of it
#define DARKEST 0.01  // no gain over a hundred: darker surfaces show reflections, not a colour
#define WHOLE 0.9999f // coverage from which on a pixel is the matte's alone

// T F = own F + lead F_j
struct transform {
    double own[3], lead[3]; // of the component itself, of the leading one
    int j;
};

static bool usable(float coverage)
{
    return coverage > 0; // false for NAN
}

static bool finite_at(float *const plane[3], size_t i)
{
    return isfinite(plane[0][i]) && isfinite(plane[1][i]) && isfinite(plane[2][i]);
}

// Weight of a pixel among its neighbours: edges, which hold the background too, hardly count.
static double weight(float coverage)
{
    const double a = fmin(coverage, 1), a2 = a * a, a4 = a2 * a2;
    return a4 * a4;
}

// Mean over the pixels that the matte covers by `least`; false: there are none.
static bool mean_of(const struct glint_recolour *r, const float *matte, float *const plane[3],
                    float least, struct glint_rgb *out)
{
    double total = 0;
    *out = (struct glint_rgb){{0}};
    for (size_t i = 0; i < (size_t)r->width * r->height; i++) {
        if (!usable(matte[i]) || matte[i] < least || !finite_at(plane, i))
            continue;
        const double w = weight(matte[i]);
        for (int k = 0; k < 3; k++)
            out->c[k] += w * fmax(plane[k][i], 0);
        total += w;
    }
    for (int k = 0; k < 3 && total > 0; k++)
        out->c[k] /= total;
    return total > 0;
}

// Of the pixels that are the matte's alone, where it has any.
static bool mean(const struct glint_recolour *r, const float *matte, float *const plane[3],
                 struct glint_rgb *out)
{
    return mean_of(r, matte, plane, WHOLE, out) || mean_of(r, matte, plane, 0, out);
}

static int leading(struct glint_rgb colour)
{
    int j = colour.c[1] > colour.c[0] ? 1 : 0;
    return colour.c[2] > colour.c[j] ? 2 : j;
}

static struct glint_rgb old_colour(const struct glint_recolour *r, bool *by_albedo)
{
    struct glint_rgb a;
    *by_albedo = r->albedo[0] && mean(r, r->direct, r->albedo, &a);
    if (*by_albedo) {
        const int j = leading(a);
        a.c[j] = fmax(a.c[j], DARKEST);
        return a;
    }
    mean(r, r->matte, r->picture, &a);
    const double now = glint_rgb_luminance(a), then = glint_rgb_luminance(r->colour);
    for (int k = 0; k < 3; k++)
        a.c[k] = now > 0 ? a.c[k] * then / now : 0;
    return a;
}

static struct transform make_transform(struct glint_rgb old, struct glint_rgb new)
{
    struct transform t = {.j = leading(old)};
    const double a = old.c[t.j];
    if (a <= 0) // black becomes black
        return t;
    for (int k = 0; k < 3; k++) {
        const double share = old.c[k] / a;
        t.own[k] = new.c[k] * share / a; // c_k u_k / a_k without the division by a_k
        t.lead[k] = new.c[k] * (1 - share * share) / a;
    }
    return t;
}

// F at a pixel that other things share.
static void estimate(const struct glint_recolour *r, const float *matte, float *const plane[3],
                     size_t x, size_t y, double f[3])
{
    const size_t left = x < REACH ? 0 : x - REACH, top = y < REACH ? 0 : y - REACH;
    double sum[3] = {0}, total = 0;
    for (size_t v = top; v <= y + REACH && v < r->height; v++)
        for (size_t u = left; u <= x + REACH && u < r->width; u++) {
            const size_t i = v * r->width + u;
            if (!usable(matte[i]) || !finite_at(plane, i))
                continue;
            const double dx = (double)u - (double)x, dy = (double)v - (double)y;
            const double w = weight(matte[i]) / (1 + dx * dx + dy * dy);
            for (int k = 0; k < 3; k++)
                sum[k] += w * plane[k][i];
            total += w;
        }
    for (int k = 0; k < 3; k++)
        f[k] = total > 0 ? sum[k] / total : 0;
}

static void change_pixel(const struct glint_recolour *r, const float *matte,
                         const struct transform *t, float *const in[3], float *const out[3],
                         size_t x, size_t y)
{
    const size_t i = y * r->width + x;
    const double alpha = fmin(matte[i], 1);
    double f[3];
    if (alpha < WHOLE)
        estimate(r, matte, in, x, y, f);
    for (int k = 0; k < 3; k++)
        f[k] = alpha < WHOLE ? fmin(f[k], in[k][i] / alpha) : in[k][i];
    for (int k = 0; k < 3; k++)
        out[k][i] = (float)(in[k][i] + alpha * (t->own[k] * f[k] + t->lead[k] * f[t->j] - f[k]));
}

// Edges look at their neighbours as they were.
static glint_status change(const struct glint_recolour *r, const float *matte,
                           const struct transform *t, float *const plane[3],
                           struct glint_error *err)
{
    const size_t pixels = (size_t)r->width * r->height;
    float *copy = malloc(3 * pixels * sizeof *copy);
    if (!copy)
        return glint_fail(err, GLINT_E_NOMEM, "", "no memory for %zu pixels", pixels);
    float *const in[3] = {copy, copy + pixels, copy + 2 * pixels};
    for (int k = 0; k < 3; k++)
        memcpy(in[k], plane[k], pixels * sizeof *copy);
    for (size_t y = 0; y < r->height; y++)
        for (size_t x = 0; x < r->width; x++)
            if (usable(matte[y * r->width + x]))
                change_pixel(r, matte, t, in, plane, x, y);
    free(copy);
    return GLINT_OK;
}

// The albedo under what both mattes have.
static glint_status change_albedo(const struct glint_recolour *r, const struct transform *t,
                                  struct glint_error *err)
{
    const size_t pixels = (size_t)r->width * r->height;
    float *both = malloc(pixels * sizeof *both);
    if (!both)
        return glint_fail(err, GLINT_E_NOMEM, "", "no memory for %zu pixels", pixels);
    for (size_t i = 0; i < pixels; i++)
        both[i] = fminf(r->direct[i], r->matte[i]);
    const glint_status st = change(r, both, t, r->albedo, err);
    free(both);
    return st;
}

glint_status glint_recolour(const struct glint_recolour *r, struct glint_recoloured *out,
                            struct glint_error *err)
{
    *out = (struct glint_recoloured){0};
    for (size_t i = 0; i < (size_t)r->width * r->height; i++)
        out->covered += usable(r->matte[i]) ? fmin(r->matte[i], 1) : 0;
    if (out->covered <= 0)
        return GLINT_OK;
    out->old = old_colour(r, &out->by_albedo);
    const struct transform t = make_transform(out->old, r->colour);
    glint_status status = change(r, r->matte, &t, r->picture, err);
    if (!status && r->albedo[0])
        status = change_albedo(r, &t, err);
    return status;
}
