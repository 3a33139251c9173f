#include "scene/light_clusters.h"

#include <math.h>
#include <string.h>

static void add(struct glint_shine *to, const struct glint_shine *s)
{
    to->power += s->power;
    to->square += s->square;
    to->mean += s->mean;
    to->sun += s->sun;
    for (int k = 0; k < 3; k++) {
        to->moment[k] += s->moment[k];
        to->linear[k] += s->linear[k];
    }
    for (int k = 0; k < 6; k++)
        to->quadric[k] += s->quadric[k];
}

// A lobe that no sum of lobes cancels: intensity full ((axis.w + 0.6) / 1.6)^2, near to a clamped
// cosine and nowhere negative.
static void lobe(struct glint_shine *s, const double axis[3], double full)
{
    static const int row[6] = {0, 1, 2, 0, 0, 1}, column[6] = {0, 1, 2, 1, 2, 2};
    const double scale = full / (1.6 * 1.6);
    s->mean = scale * (0.36 + 1.0 / 3.0);
    for (int k = 0; k < 3; k++)
        s->linear[k] = scale * 1.2 * axis[k];
    for (int k = 0; k < 6; k++)
        s->quadric[k] = scale * (axis[row[k]] * axis[column[k]] - (k < 3 ? 1.0 / 3.0 : 0.0));
}

// |axis.w|, likewise from above: full (1 + 2 (axis.w)^2) / 3.
static void two_lobes(struct glint_shine *s, const double axis[3], double full)
{
    lobe(s, axis, full * 1.6 * 1.6 * 2.0 / 3.0);
    s->mean = full * (1.0 + 2.0 / 3.0) / 3.0;
    for (int k = 0; k < 3; k++)
        s->linear[k] = 0.0;
}

static void shine_of_triangle(struct glint_shine *s, const struct gk_light *l, double power,
                              double at[3])
{
    double n[3];
    for (int k = 0; k < 3; k++) {
        const int a = (k + 1) % 3, b = (k + 2) % 3;
        n[k] = (double)l->a[a] * l->b[b] - (double)l->a[b] * l->b[a];
        at[k] = l->p[k] + (l->a[k] + l->b[k]) / 3.0;
    }
    const double length = sqrt(n[0] * n[0] + n[1] * n[1] + n[2] * n[2]);
    for (int k = 0; k < 3; k++)
        n[k] = length > 0.0 ? n[k] / length : 0.0;
    if (l->kind >> 4)
        two_lobes(s, n, power / (2.0 * M_PI));
    else
        lobe(s, n, power / M_PI);
}

// A beam is seen from few places, and there it is bright: between its mean and its peak.
static void shine_of_point(struct glint_shine *s, const struct gk_light *l, double power)
{
    const double share = 0.5 * (1.0 - fmax(l->b[0], -1.0)); // of the sphere
    const double axis[3] = {l->a[0], l->a[1], l->a[2]};
    if (share >= 1.0)
        s->mean = power / (4.0 * M_PI);
    else
        lobe(s, axis, power / (4.0 * M_PI * pow(fmax(share, 1e-6), 0.75)));
}

struct glint_shine glint_light_shine(const struct gk_light *l, double power)
{
    struct glint_shine s = {.power = power};
    double at[3] = {l->p[0], l->p[1], l->p[2]};
    const uint32_t kind = l->kind & GK_LIGHT_KIND;
    if (kind == GK_LIGHT_SUN) {
        s.sun = s.power = 0.2126 * l->L[0] + 0.7152 * l->L[1] + 0.0722 * l->L[2];
        return s;
    }
    if (kind == GK_LIGHT_TRIANGLE)
        shine_of_triangle(&s, l, power, at);
    else
        shine_of_point(&s, l, power);
    for (int k = 0; k < 3; k++) {
        s.moment[k] = power * at[k];
        s.square += power * at[k] * at[k];
    }
    if (kind == GK_LIGHT_TRIANGLE) // the triangle's own variance: (|a|^2 + |b|^2 - a.b) / 18
        for (int k = 0; k < 3; k++)
            s.square +=
                power / 18.0 *
                ((double)l->a[k] * l->a[k] + (double)l->b[k] * l->b[k] - (double)l->a[k] * l->b[k]);
    return s;
}

// How much is lost by taking the cluster for one light: its power times its spread in space, and in
// direction as if `scale` metres went with it.
static double spread(const struct glint_shine *s, double scale)
{
    if (s->power <= 0.0 || s->sun > 0.0)
        return s->power;
    double square = s->square / s->power, mean = 0.0, turn = 0.0;
    for (int k = 0; k < 3; k++) {
        mean += s->moment[k] * s->moment[k];
        turn += s->linear[k] * s->linear[k];
    }
    const double scatter = s->mean > 0.0 ? fmax(1.0 - turn / (3.0 * s->mean * s->mean), 0.0) : 0.0;
    square = fmax(square - mean / (s->power * s->power), 0.0);
    return s->power * (square + scatter * scale * scale);
}

// Coordinates that lights are split by: position, and direction as far as they have one.
static double coordinate(const struct glint_shine *s, int axis, double scale)
{
    if (axis < 3)
        return s->moment[axis] / s->power;
    return s->mean > 0.0 ? scale * s->linear[axis - 3] / (1.7 * s->mean) : 0.0;
}

// The axis along which the cluster's lights vary most, and their mean on it.
static int widest(const struct glint_cluster *c, const uint32_t *order,
                  const struct glint_shine *shine, double scale, double *mean)
{
    double sum[6] = {0}, square[6] = {0}, power = 0.0;
    for (uint32_t i = 0; i < c->count; i++) {
        const struct glint_shine *s = &shine[order[c->first + i]];
        power += s->power;
        for (int a = 0; a < 6; a++) {
            const double x = coordinate(s, a, scale);
            sum[a] += s->power * x;
            square[a] += s->power * x * x;
        }
    }
    int best = 0;
    double most = -1.0;
    for (int a = 0; a < 6; a++) {
        const double variance = square[a] / power - sum[a] / power * (sum[a] / power);
        if (variance > most) {
            most = variance;
            best = a;
            *mean = sum[a] / power;
        }
    }
    return best;
}

// Puts the lights below the mean of the widest axis first. Returns their number, 1..count - 1.
static uint32_t part(const struct glint_cluster *c, uint32_t *order,
                     const struct glint_shine *shine, double scale)
{
    double mean = 0.0;
    const int axis = widest(c, order, shine, scale, &mean);
    uint32_t low = 0, high = c->count, *at = order + c->first;
    while (low < high) {
        if (coordinate(&shine[at[low]], axis, scale) < mean) {
            low++;
        } else {
            const uint32_t t = at[--high];
            at[high] = at[low];
            at[low] = t;
        }
    }
    return low > 0 && low < c->count ? low : c->count / 2;
}

static struct glint_cluster cluster_of(const uint32_t *order, uint32_t first, uint32_t count,
                                       const struct glint_shine *shine, double scale)
{
    struct glint_cluster c = {.first = first, .count = count};
    for (uint32_t i = 0; i < count; i++)
        add(&c.shine, &shine[order[first + i]]);
    c.loss = count > 1 ? spread(&c.shine, scale) : -1.0;
    return c;
}

// Suns to the end. Returns the number of the others.
static uint32_t part_suns(uint32_t *order, uint32_t n, const struct glint_shine *shine)
{
    uint32_t low = 0, high = n;
    while (low < high) {
        if (shine[order[low]].sun == 0.0) {
            low++;
        } else {
            const uint32_t t = order[--high];
            order[high] = order[low];
            order[low] = t;
        }
    }
    return low;
}

static struct glint_cluster *worst_of(struct glint_cluster *c, uint32_t n)
{
    struct glint_cluster *worst = c;
    for (uint32_t i = 1; i < n; i++)
        worst = c[i].loss > worst->loss ? &c[i] : worst;
    return worst;
}

uint32_t glint_light_clusters(struct glint_cluster *out, uint32_t most, uint32_t *order, uint32_t n,
                              const struct glint_shine *shine)
{
    const uint32_t near = part_suns(order, n, shine);
    const struct glint_cluster all = cluster_of(order, 0, near, shine, 0.0);
    // Half of how far they spread: opposite directions count as much as opposite walls.
    const double scale = all.count > 1 ? 0.5 * sqrt(fmax(all.loss, 0.0) / all.shine.power) : 1.0;
    uint32_t clusters = 0;
    for (; n <= most && clusters < n; clusters++)
        out[clusters] = cluster_of(order, clusters, 1, shine, scale);
    if (n <= most)
        return n; // each light has its own
    if (near)
        out[clusters++] = cluster_of(order, 0, near, shine, scale);
    if (near < n)
        out[clusters++] = cluster_of(order, near, n - near, shine, scale);
    while (clusters < most) {
        struct glint_cluster *worst = worst_of(out, clusters);
        const struct glint_cluster c = *worst;
        const uint32_t low = part(&c, order, shine, scale);
        *worst = cluster_of(order, c.first, low, shine, scale);
        out[clusters++] = cluster_of(order, c.first + low, c.count - low, shine, scale);
    }
    return clusters;
}
