// pose_channel.c - the value of an animation channel at a moment (glTF 2.0, appendix C).
#include "scene/pose_work.h"

#include <math.h>
#include <string.h>

// Times of keys are floats: a moment that is a key's to within rounding is at that key.
#define SLACK 2.5e-7

// Index of the last key that is not after `time`, 0 if none.
static uint32_t key_before(const struct glint_animation_channel *c, double time)
{
    uint32_t low = 0, high = c->keys; // time[low] <= time < time[high], but for the ends
    while (high - low > 1) {
        const uint32_t middle = low + (high - low) / 2;
        if (c->time[middle] <= time)
            low = middle;
        else
            high = middle;
    }
    return low;
}

static const float *value_at(const struct glint_animation_channel *c, uint32_t key)
{
    if (c->interpolation == GLINT_INTERPOLATION_CUBICSPLINE)
        return c->value + ((size_t)3 * key + 1) * c->width;
    return c->value + (size_t)key * c->width;
}

static void take(const struct glint_animation_channel *c, uint32_t key, double *out)
{
    const float *value = value_at(c, key);
    for (uint32_t i = 0; i < c->width; i++)
        out[i] = value[i];
}

static bool unit(double q[4])
{
    const double length = sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]);
    if (!(length > 1e-12 && isfinite(length)))
        return false;
    for (int i = 0; i < 4; i++)
        q[i] /= length;
    return true;
}

// The angle from sums and differences: exact near 0, where acos is not.
static void slerp(const double a[4], const double b[4], double f, double out[4])
{
    const double dot = a[0] * b[0] + a[1] * b[1] + a[2] * b[2] + a[3] * b[3];
    const double sign = dot < 0 ? -1 : 1;
    double sum = 0, difference = 0;
    for (int i = 0; i < 4; i++) {
        sum += (a[i] + sign * b[i]) * (a[i] + sign * b[i]);
        difference += (a[i] - sign * b[i]) * (a[i] - sign * b[i]);
    }
    const double angle = 2 * atan2(sqrt(difference), sqrt(sum)), s = sin(angle);
    const double u = s > 1e-6 ? sin((1 - f) * angle) / s : 1 - f;
    const double v = s > 1e-6 ? sin(f * angle) / s : f;
    for (int i = 0; i < 4; i++)
        out[i] = u * a[i] + sign * v * b[i];
}

static bool rotate(const struct glint_animation_channel *c, uint32_t key, double f, double *out)
{
    double a[4], b[4];
    take(c, key, a);
    take(c, key + 1, b);
    if (!unit(a) || !unit(b))
        return false;
    slerp(a, b, f, out);
    return true;
}

// Hermite's spline; tangents are per second.
static void cubic(const struct glint_animation_channel *c, uint32_t key, double f, double *out)
{
    const float *first = value_at(c, key), *second = value_at(c, key + 1);
    const double span = (double)c->time[key + 1] - c->time[key];
    const double g = f * f, h = g * f;
    for (uint32_t i = 0; i < c->width; i++)
        out[i] = (2 * h - 3 * g + 1) * first[i] + span * (h - 2 * g + f) * first[c->width + i] +
                 (3 * g - 2 * h) * second[i] + span * (h - g) * second[(ptrdiff_t)i - c->width];
}

// Between two keys, at the share f of the way.
static bool between(const struct glint_animation_channel *c, uint32_t key, double f, double *out)
{
    if (c->interpolation == GLINT_INTERPOLATION_CUBICSPLINE) {
        cubic(c, key, f, out);
        return true;
    }
    if (c->path == GLINT_PATH_ROTATION)
        return rotate(c, key, f, out);
    const float *a = value_at(c, key), *b = value_at(c, key + 1);
    for (uint32_t i = 0; i < c->width; i++)
        out[i] = a[i] + f * ((double)b[i] - a[i]);
    return true;
}

static bool value(const struct glint_animation_channel *c, struct glint_pose_moment at, double *out)
{
    const bool step = c->interpolation == GLINT_INTERPOLATION_STEP;
    const double slack = step ? (at.before ? -SLACK : SLACK) * fabs(at.time) : 0;
    const double time = at.time + slack;
    const uint32_t key = key_before(c, time);
    if (step || key + 1 == c->keys || time <= c->time[key]) {
        take(c, key, out);
        return true;
    }
    const double span = (double)c->time[key + 1] - c->time[key];
    return between(c, key, (time - c->time[key]) / span, out);
}

bool glint_pose_channel(const struct glint_animation_channel *c, struct glint_pose_moment at,
                        const float *rest, double *out)
{
    const bool found = value(c, at, out);
    if (c->path != GLINT_PATH_ROTATION || (found && unit(out)))
        return true;
    take(c, key_before(c, at.time), out);
    if (unit(out))
        return false;
    for (int i = 0; i < 4; i++)
        out[i] = rest[i];
    return false;
}
