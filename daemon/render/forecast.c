#include "render/forecast.h"

#include "kernels/gk_sampler.h"

#include <math.h>
#include <stdlib.h>

#define FEWEST_POINTS 5
#define FEWEST_SAMPLES 16
#define RECENT 4.0       // the slope is that of the checkpoints since a quarter of the samples
#define USUAL_SLOPE 1.05 // of scenes there
#define SLOPE_SPREAD 0.1
#define LAST_POWER 1.03 // of scenes after many samples
#define LAST_SPREAD 0.1
#define KEPT 0.6 // of what the power is over the last, an octave later
#define KEPT_SPREAD 0.15
#define SLOPE_AGE 1.0   // octaves: from the middle of those checkpoints until now
#define SLOW_POWER 0.85 // no error falls slower: samples do not see all of it yet
#define UNKNOWN_SPREAD 0.2
#define LEAST_SPREAD 0.01

// ---- the slope of the last octaves: log(V / n^g) = level - slope * log(n / n_now)

struct line {
    double level, slope, slope_spread;
};

struct equation {
    double one, x, y;
};

static struct equation equation_of(const struct glint_convergence_point *p,
                                   const struct glint_forecast_input *in)
{
    const double spread = isfinite(p->spread) ? fmax(p->spread, LEAST_SPREAD) : UNKNOWN_SPREAD;
    const double x = -log((double)p->samples / in->samples);
    return (struct equation){1.0 / spread, x / spread, 2.0 * log(p->error) / spread};
}

// What the checkpoint before does not say already.
static struct equation news(const struct equation *e, const struct equation *before, double ratio)
{
    const double scale = 1.0 / sqrt(1.0 - ratio * ratio);
    return (struct equation){scale * (e->one - ratio * before->one),
                             scale * (e->x - ratio * before->x),
                             scale * (e->y - ratio * before->y)};
}

static bool usable(const struct glint_convergence_point *p, const struct glint_forecast_input *in)
{
    return p->error > 0.0 && p->samples <= in->samples && p->samples * RECENT >= in->samples;
}

// Sums of products of the equations.
struct sums {
    double one_one, one_x, x_x, one_y, x_y;
};

static void add(struct sums *s, const struct equation *e)
{
    s->one_one += e->one * e->one;
    s->one_x += e->one * e->x;
    s->x_x += e->x * e->x;
    s->one_y += e->one * e->y;
    s->x_y += e->x * e->y;
}

static struct sums gather(const struct glint_forecast_input *in)
{
    const struct glint_convergence_point now = {
        .samples = in->samples, .error = in->now->whole.error, .spread = in->now->whole.spread};
    struct sums s = {0};
    struct equation last = {0};
    uint32_t last_samples = 0;
    for (uint32_t i = 0; i <= in->points; i++) {
        const struct glint_convergence_point *p = i < in->points ? &in->curve[i] : &now;
        if (!usable(p, in) || p->samples == last_samples)
            continue;
        const struct equation e = equation_of(p, in);
        const double ratio = (double)last_samples / p->samples;
        const struct equation n = news(&e, &last, ratio);
        add(&s, &n);
        last = e;
        last_samples = p->samples;
    }
    return s;
}

static bool fit(struct line *out, const struct glint_forecast_input *in)
{
    const double now = in->now->whole.error, weight = 1.0 / (SLOPE_SPREAD * SLOPE_SPREAD);
    if (!(now > 0.0) || in->points < FEWEST_POINTS || in->samples < FEWEST_SAMPLES)
        return false;
    struct sums s = gather(in);
    s.x_x += weight;
    s.x_y += weight * USUAL_SLOPE;
    const double rest = s.x_x - s.one_x * s.one_x / s.one_one;
    out->slope = (s.x_y - s.one_x * s.one_y / s.one_one) / rest;
    out->level = 2.0 * log(now); // earlier points only say how steep it is
    out->slope_spread = sqrt(1.0 / rest);
    return true;
}

// Octaves until the logarithm of E^2 has fallen by `fall`: by Newton, from where the last power would
// be there. The power is last + over keeps^x after x octaves.
static double octaves_for(double fall, double last, double over, double keeps)
{
    const double ln2 = log(2.0), rate = -log(keeps);
    double x = fall / (ln2 * last);
    for (int i = 0; i < 20 && x > 0.0; i++) {
        const double kept = exp(-rate * x);
        x -= (last * x + over * (1.0 - kept) / rate - fall / ln2) / (last + over * kept);
    }
    return x > 0.0 ? x : fmin(fall / (ln2 * (last + over)), 0.0);
}

// ---- draws

struct dice {
    uint32_t state;
};

static uint32_t roll(struct dice *d)
{
    return gk_mix32(++d->state * 0x9e3779b9u);
}

// The sum of twelve uniform numbers, 16 bits each, is normal as far as intervals of 98 % go.
static double roll_normal(struct dice *d)
{
    double sum = 0.0;
    for (int i = 0; i < 6; i++) {
        const uint32_t bits = roll(d);
        sum += (bits & 0xffffu) + (bits >> 16) + 1.0;
    }
    return sum / 65536.0 - 6.0;
}

// What the logarithm of a picture's E^2 may be off.
static double roll_level(struct dice *d, const struct glint_film_estimate *e)
{
    double sum = 0.0, moved = 0.0;
    if (e->cells < GLINT_ESTIMATE_CELLS)
        return roll_normal(d) * e->whole.spread;
    for (uint32_t c = 0; c < e->cells; c++) {
        sum += e->relative[c];
        moved += roll(d) >> 31 ? sqrt(e->spread[c]) : -sqrt(e->spread[c]);
    }
    return sum > 0.0 ? log(fmax(1.0 + moved / sum, 0.01)) : 0.0;
}

// Both the estimate now and the true error then are those of pictures that chance made.
static double draw(struct dice *d, const struct line *l, const struct glint_forecast_input *in)
{
    const double last = fmax(LAST_POWER + LAST_SPREAD * roll_normal(d), 0.8);
    const double slope = fmin(fmax(l->slope + l->slope_spread * roll_normal(d), last), 2.0);
    const double keeps = fmin(fmax(KEPT + KEPT_SPREAD * roll_normal(d), 0.1), 0.95);
    const double over = (slope - last) * pow(keeps, SLOPE_AGE);
    const double level = l->level + roll_level(d, in->now) + roll_level(d, in->now);
    const double wanted = log(in->target * in->target - in->bias * in->bias);
    return in->samples * exp2(octaves_for(level - wanted, last, over, keeps));
}

static int ascending(const void *a, const void *b)
{
    const double p = *(const double *)a, q = *(const double *)b;
    return (p > q) - (p < q);
}

bool glint_forecast_draw(double *samples, const struct glint_forecast_input *in)
{
    struct dice dice = {in->samples};
    struct line line;
    if (!(in->target > in->bias) || !fit(&line, in))
        return false;
    for (int i = 0; i < GLINT_FORECAST_DRAWS; i++)
        samples[i] = draw(&dice, &line, in);
    qsort(samples, GLINT_FORECAST_DRAWS, sizeof *samples, ascending);
    return true;
}

// ---- the answer

static void take_quantiles(double out[3], const double *draw, int draws)
{
    out[0] = draw[draws / 2];
    out[1] = draw[draws / 20];
    out[2] = draw[draws - 1 - draws / 20];
}

// Each draw at the pace of one of the last passes.
static void take_seconds(struct glint_forecast *out, const double *samples,
                         const struct glint_forecast_input *in)
{
    double pace[GLINT_FORECAST_PACES], seconds[GLINT_FORECAST_DRAWS];
    for (uint32_t i = 0; i < in->paces; i++)
        pace[i] = in->pace[i];
    for (int i = 0; in->paces && i < GLINT_FORECAST_DRAWS; i++)
        seconds[i] = fmax(samples[i] - in->samples, 0.0) * pace[(uint32_t)i % in->paces];
    if (!in->paces)
        return;
    qsort(seconds, GLINT_FORECAST_DRAWS, sizeof *seconds, ascending);
    take_quantiles(out->seconds, seconds, GLINT_FORECAST_DRAWS);
    qsort(pace, in->paces, sizeof *pace, ascending);
    out->seconds[0] = fmax(out->samples[0] - in->samples, 0.0) * pace[in->paces / 2];
}

// Of the logarithm of E^2 at two checkpoints, what the later one's samples have of the earlier one's.
static double spread_of_fall(double before, double now, double ratio)
{
    return sqrt(fmax(before * before + now * now - 2.0 * ratio * before * now, 0.0));
}

// Over the last two octaves the square of the error fell less than samples grew, by more than chance
// makes of it in one case of twenty.
static bool falls_slowly(const struct glint_forecast_input *in)
{
    const struct glint_estimate *now = &in->now->whole;
    for (uint32_t i = in->points; i-- > 0;) {
        const struct glint_convergence_point *p = &in->curve[i];
        const double ratio = (double)p->samples / in->samples;
        if (!(p->error > 0.0) || ratio > 1.0 / RECENT)
            continue;
        const double chance =
            isfinite(p->spread) ? spread_of_fall(p->spread, now->spread, ratio) : 0.0;
        return 2.0 * log(p->error / now->error) + glint_normal_quantile(0.95) * chance <
               -SLOW_POWER * log(ratio);
    }
    return false;
}

void glint_forecast_make(struct glint_forecast *out, const struct glint_forecast_input *in)
{
    double samples[GLINT_FORECAST_DRAWS];
    *out = GLINT_NO_FORECAST;
    out->target = in->target;
    out->reachable = in->target > in->bias;
    if (!glint_forecast_draw(samples, in))
        return;
    take_quantiles(out->samples, samples, GLINT_FORECAST_DRAWS);
    take_seconds(out, samples, in);
    out->reachable = out->samples[1] <= in->limit;
    out->lower_bound = glint_estimate_heavy(&in->now->whole) || falls_slowly(in);
}
