#include "render/estimate.h"

#include "kernels/gk_film.h"

#include <math.h>
#include <string.h>

#define DARK 0.01       // added to squares of means
#define QUARTILE 0.6745 // of a normal law, in deviations from its middle
#define RARE 2.5        // Hill's index below which events are rare
#define TAIL 0.01       // of the pixels
#define LIFTED 1.1
#define HEAVY 1.4
#define LOOKS_OFF 0.05 // of jobs that may stop too early

// ---- a tile

struct pixel {
    double a[3], b[3]; // means of the halves
    double m[3], v[3]; // of both, and its variance
};

static double square(double x)
{
    return x * x;
}

static double largest(const double c[3])
{
    return fmax(fmax(c[0], fmax(c[1], c[2])), 0.0);
}

// The share of half A times that of half B.
static double weight_of(const struct glint_estimate_source *in)
{
    const double share = (double)glint_film_half(in->first, in->samples, 0) / in->samples;
    return share * (1.0 - share);
}

static void load_halves(struct pixel *p, const struct glint_estimate_source *in, uint32_t i)
{
    const uint32_t na = glint_film_half(in->first, in->samples, 0), nb = in->samples - na;
    for (uint32_t c = 0; c < 3; c++) {
        p->a[c] = glint_film_mean(in->planes, in->wide, 0, c, i, na);
        p->b[c] = glint_film_mean(in->planes, in->wide, 1, c, i, nb);
        p->m[c] = (na * p->a[c] + nb * p->b[c]) / in->samples;
        p->v[c] = weight_of(in) * square(p->a[c] - p->b[c]);
    }
}

static double variance_of_batches(const struct glint_estimate_source *in, uint32_t c, uint32_t i,
                                  double mean)
{
    double sum = 0.0;
    for (uint32_t k = 0; k < GK_BATCHES; k++) {
        const uint32_t n = glint_film_part(in->first, in->samples, GK_BATCHES, k);
        sum += n * square(glint_film_batch_mean(in->batches, in->wide, k, c, i, n) - mean);
    }
    return sum / ((GK_BATCHES - 1.0) * in->samples);
}

static void load(struct pixel *p, const struct glint_estimate_source *in, uint32_t i)
{
    load_halves(p, in, i);
    for (uint32_t c = 0; in->batches && in->samples >= GK_BATCHES && c < 3; c++)
        p->v[c] = variance_of_batches(in, c, i, p->m[c]);
}

// ---- what a mean is taken for

struct means {
    double of[3][GK_TILE_SIDE + 2][GK_TILE_SIDE + 2]; // by pixel, within an edge that mirrors them
};

// The row or column of 0..side - 1 that stands at i, one further out on either side.
static uint32_t mirrored(uint32_t i, uint32_t side)
{
    if (side == 1)
        return 0;
    return i == 0 ? 1 : i == side + 1 ? side - 2 : i - 1;
}

static void load_means(struct means *out, const struct glint_estimate_source *in, uint32_t w,
                       uint32_t h)
{
    struct pixel p;
    for (uint32_t i = 0; i < (w + 2) * (h + 2); i++) {
        const uint32_t x = i % (w + 2), y = i / (w + 2);
        load_halves(&p, in, mirrored(y, h) * GK_TILE_SIDE + mirrored(x, w));
        for (uint32_t c = 0; c < 3; c++)
            out->of[c][y][x] = p.m[c];
    }
}

static void order(double *low, double *high)
{
    const double a = *low, b = *high;
    *low = a < b ? a : b;
    *high = a < b ? b : a;
}

static void order_four(double v[4])
{
    order(&v[0], &v[1]);
    order(&v[2], &v[3]);
    order(&v[0], &v[2]);
    order(&v[1], &v[3]);
    order(&v[1], &v[2]);
}

// Source: Batcher 1968, the odd-even merge of twice four. Spelled out, for it runs for every pixel of
// every pass.
static void order_eight(double v[8])
{
    order_four(v);
    order_four(v + 4);
    order(&v[0], &v[4]);
    order(&v[1], &v[5]);
    order(&v[2], &v[6]);
    order(&v[3], &v[7]);
    order(&v[2], &v[4]);
    order(&v[3], &v[5]);
    order(&v[1], &v[2]);
    order(&v[3], &v[4]);
    order(&v[5], &v[6]);
}

// What a pixel's neighbours within the tile say of its mean: their median, and the variance of a law with
// their quartiles, which lie as far off as the geometric mean of both does. Beside a lamp that is no
// more than the darker ones differ.
struct law {
    double middle, variance;
};

static void ask(struct law *out, const struct means *m, uint32_t c, uint32_t x, uint32_t y)
{
    const double(*row)[GK_TILE_SIDE + 2] = &m->of[c][y];
    double v[8] = {row[0][x],     row[0][x + 1], row[0][x + 2], row[1][x],
                   row[1][x + 2], row[2][x],     row[2][x + 1], row[2][x + 2]};
    order_eight(v);
    out->middle = 0.5 * (v[3] + v[4]);
    const double up = 0.5 * (v[5] + v[6]) - out->middle, down = out->middle - 0.5 * (v[1] + v[2]);
    out->variance = up * down / square(QUARTILE);
}

// Where a mean of that variance is looked for by who knows the middle of the law that it was drawn from.
// The law's own variance is what the mean is off by more than noise makes it, and `least` at the least.
static double taken_for(double mean, double variance, double middle, double least)
{
    const double off = mean - middle, own = fmax(square(off) - variance, least);
    return variance > 0.0 ? mean - off * variance / (variance + own) : mean;
}

static double relative_of(double variance, double mean)
{
    return variance / (square(mean) + DARK);
}

static void count_tail(struct glint_tile_estimate *out, double v)
{
    const double bin = floor(GLINT_TAIL_STEPS * log2(v)) + GLINT_TAIL_BINS / 2;
    const int at = (int)fmin(fmax(bin, 0.0), GLINT_TAIL_BINS - 1.0);
    out->tail[at] += out->tail[at] < UINT8_MAX;
}

// Adds a pixel whose neighbours have those means; its relative variance.
static double add_pixel(struct glint_tile_estimate *out, const struct pixel *p,
                        const struct law law[3], double weight)
{
    const double ta = 1.0 / (1.0 + largest(p->a)), tb = 1.0 / (1.0 + largest(p->b));
    double relative = 0.0, linear = 0.0;
    for (int c = 0; c < 3; c++) {
        const double m = p->m[c], v = p->v[c];
        relative += relative_of(v, taken_for(m, v, law[c].middle, law[c].variance));
        out->most += relative_of(v, taken_for(m, v, law[c].middle, 0.0));
        out->own += relative_of(v, m);
        linear += p->v[c];
        out->tone += weight * square(p->a[c] * ta - p->b[c] * tb);
    }
    out->relative += relative;
    out->linear += linear;
    if (linear > 0.0)
        count_tail(out, linear);
    return relative;
}

void glint_estimate_tile(struct glint_tile_estimate *out, const struct glint_estimate_source *in,
                         uint32_t w, uint32_t h)
{
    struct pixel p;
    struct means means;
    memset(out, 0, sizeof *out);
    load_means(&means, in, w, h);
    for (uint32_t y = 0; y < h; y++) {
        double left = 0.0;
        for (uint32_t x = 0; x < w; x++) {
            load(&p, in, y * GK_TILE_SIDE + x);
            struct law law[3];
            for (uint32_t c = 0; c < 3; c++)
                ask(&law[c], &means, c, x, y);
            const double v = add_pixel(out, &p, law, weight_of(in));
            if (x % 2)
                out->spread += square(v - left);
            else if (x + 1 == w)
                out->spread += v * v;
            left = v;
        }
    }
}

// ---- a film

// The upper end of the interval that holds in 19 of 20 cases around an index of `taken` values: their
// mean excess has a gamma law. Source: Wilson and Hilferty 1931.
static double tail_end(double index, double taken)
{
    const double root = 1.0 - 1.0 / (9.0 * taken) + glint_normal_quantile(0.95) / sqrt(9.0 * taken);
    return index * root * root * root;
}

// Source: Hill 1975. Logarithms are spread evenly over a bin.
static double tail_index(const uint64_t count[GLINT_TAIL_BINS])
{
    const double octave = log(2.0) / GLINT_TAIL_STEPS;
    uint64_t all = 0;
    for (int b = 0; b < GLINT_TAIL_BINS; b++)
        all += count[b];
    const double wanted = TAIL * (double)all;
    double taken = 0.0, sum = 0.0, low = GLINT_TAIL_BINS;
    for (int b = GLINT_TAIL_BINS; b-- > 0 && taken < wanted;) {
        const double n = fmin((double)count[b], wanted - taken);
        const double share = count[b] ? n / (double)count[b] : 0.0; // the upper part of the bin
        sum += n * (b + 1 - 0.5 * share);
        taken += n;
        low = b + 1 - share;
    }
    const double excess = taken > 0.0 ? (sum / taken - low) * octave : 0.0;
    return taken >= 1.0 && excess > 0.0 ? tail_end(1.0 / excess, taken) : NAN;
}

static uint32_t cell_of(uint32_t tile, uint32_t columns, uint32_t rows)
{
    const uint64_t x = tile % columns, y = tile / columns;
    const uint32_t wide = columns < GLINT_ESTIMATE_CELLS ? columns : GLINT_ESTIMATE_CELLS;
    const uint32_t high = rows < GLINT_ESTIMATE_CELLS ? rows : GLINT_ESTIMATE_CELLS;
    return (uint32_t)(y * high / rows) * wide + (uint32_t)(x * wide / columns);
}

void glint_estimate_film(struct glint_film_estimate *out, const struct glint_tile_estimate *tile,
                         uint32_t columns, uint32_t rows, uint64_t pixels)
{
    uint64_t tail[GLINT_TAIL_BINS] = {0};
    double relative = 0.0, own = 0.0, most = 0.0, spread = 0.0, linear = 0.0, tone = 0.0;
    memset(out, 0, sizeof *out);
    for (uint32_t t = 0; t < columns * rows; t++) {
        const uint32_t cell = cell_of(t, columns, rows);
        out->cells = cell >= out->cells ? cell + 1 : out->cells;
        out->relative[cell] += tile[t].relative;
        out->spread[cell] += tile[t].spread;
        relative += tile[t].relative;
        own += tile[t].own;
        most += tile[t].most;
        spread += tile[t].spread;
        linear += tile[t].linear;
        tone += tile[t].tone;
        for (int b = 0; b < GLINT_TAIL_BINS; b++)
            tail[b] += tile[t].tail[b];
    }
    out->whole = (struct glint_estimate){.error = sqrt(relative / (3.0 * (double)pixels)),
                                         .spread = relative > 0.0 ? sqrt(spread) / relative : 0.0,
                                         .linear = sqrt(linear / (3.0 * (double)pixels)),
                                         .tone_mapped = sqrt(tone / (double)pixels),
                                         .tail = tail_index(tail),
                                         .lift = own > 0.0 ? fmax(sqrt(most / own), 1.0) : 1.0};
}

// ---- what it means

double glint_normal_quantile(double p)
{
    double low = -10.0, high = 10.0;
    for (int i = 0; i < 60; i++) {
        const double x = 0.5 * (low + high);
        if (0.5 * erfc(-x * M_SQRT1_2) < p)
            low = x;
        else
            high = x;
    }
    return 0.5 * (low + high);
}

// `spread` is that of the error's square: of its logarithm, twice that of the error's.
static double end(const struct glint_estimate *e, double z)
{
    return e->error * exp(0.5 * z * e->spread);
}

void glint_estimate_interval(const struct glint_estimate *e, double interval[2])
{
    const double z = glint_normal_quantile(0.95);
    interval[0] = end(e, -z);
    interval[1] = end(e, z);
}

double glint_estimate_upper(const struct glint_estimate *e, uint32_t look)
{
    return end(e, glint_normal_quantile(1.0 - LOOKS_OFF / look / (look + 1.0)));
}

bool glint_estimate_rare(const struct glint_estimate *e)
{
    return e->tail < RARE || e->lift > LIFTED;
}

bool glint_estimate_heavy(const struct glint_estimate *e)
{
    return e->tail < RARE || e->lift > HEAVY;
}

uint32_t glint_estimate_look(uint32_t samples)
{
    uint32_t look = 1;
    double next = 16.0;
    for (; next < samples; look++)
        next = ceil(next * 1.189207 / 16.0) * 16.0;
    return samples > 0 && next == samples ? look : 0;
}
