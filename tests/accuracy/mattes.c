// mattes - what a bounded table of names costs in accuracy, against exact eviction on the same
// deposits: lost coverage, total variation, bias and variance for every policy and number of slots.
//
//   mattes SCENE.json WIDTHxHEIGHT SAMPLES SEEDS [MEMBERS OF mattes]   bias and variance of SEEDS > 1
//
// One line of CSV for each policy, number of slots and kind of coverage. Per pixel and name c is the
// matte, e the exact one of the same seed, d = c - e:
//   lost     mean over pixels and seeds of the coverage that found no slot
//   tv       mean of sum |d| / 2
//   bias     mean over pixels of sum |mean over seeds of d| / 2, which without bias is `noise`:
//   noise    the same of a normal d of the variance that was seen
//   bias2    mean over pixels and names of (mean d)^2 - var d / SEEDS, as it is, may be below 0
//   var      mean over pixels and names of the variance of c over seeds
//   worst    largest |d|
//   within   share of pixels where no |d| is above 1/255
// What files of few ranks leave out of it: ranks.c.
#include "tests/accuracy/replay.h"

#include "protocol/matte_types.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static const uint32_t slot_numbers[] = {4, 6, 8, 12, 16, 24, 32};
static const struct {
    uint32_t policy;
    const char *name;
} policies[] = {{GK_MATTE_DROP, "drop"},   {GK_MATTE_DIRECT_FIRST, "direct_first"},
                {GK_MATTE_USS, "uss"},     {GK_MATTE_USS_DIRECT_FIRST, "uss_direct_first"},
                {GK_MATTE_SPILL, "spill"}, {REPLAY_CHAO, "chao"},
                {REPLAY_BEST, "best"}};
#define COUNT(a) (sizeof(a) / sizeof *(a))
#define SETTINGS (COUNT(slot_numbers) * COUNT(policies))
#define KINDS 2 // seen directly; brought by bounces

// Sums over seeds, of each pixel and key.
struct moments {
    float *c, *c2, *d, *d2; // [pixels][keys]
};

struct line {
    double lost[KINDS], tv[KINDS], worst[KINDS], within[KINDS];
};

struct programme {
    struct offline o;
    struct glint_posed scene;
    struct glint_job *job;
    struct replay replay;
    struct replay_setting setting[SETTINGS];
    struct moments moments[SETTINGS];
    struct line line[SETTINGS];
    uint32_t seeds;
    double excess, units;
    uint32_t frame_pixels;
};

static void list_settings(struct programme *p)
{
    for (size_t k = 0; k < COUNT(policies); k++)
        for (size_t n = 0; n < COUNT(slot_numbers); n++)
            p->setting[k * COUNT(slot_numbers) + n] =
                (struct replay_setting){policies[k].policy, slot_numbers[n], policies[k].name};
    p->replay.setting = p->setting;
    p->replay.settings = SETTINGS;
}

static void make_room(struct programme *p)
{
    const size_t n = (size_t)p->replay.pixels * p->replay.keys;
    for (size_t s = 0; s < SETTINGS && p->seeds > 1 && !p->moments[s].c; s++) {
        struct moments *m = &p->moments[s];
        m->c = calloc(n, sizeof *m->c);
        m->c2 = calloc(n, sizeof *m->c2);
        m->d = calloc(n, sizeof *m->d);
        m->d2 = calloc(n, sizeof *m->d2);
        if (!m->c || !m->c2 || !m->d || !m->d2)
            abort();
    }
}

// A tile reaches beyond the frame where that is no multiple of 16 wide: there nothing is covered.
static bool has_samples(const struct replay *r, uint32_t pixel)
{
    for (uint32_t k = 0; k < r->mattes; k++)
        if (r->exact[(size_t)pixel * r->keys + k])
            return true;
    return false;
}

static void add_moments(struct moments *m, size_t at, double c, double d)
{
    m->c[at] += (float)c;
    m->c2[at] += (float)(c * c);
    m->d[at] += (float)d;
    m->d2[at] += (float)(d * d);
}

static void add_pixel(struct programme *p, size_t s, uint32_t pixel, double unit, double *kept)
{
    const struct replay *r = &p->replay;
    double tv[KINDS] = {0}, worst[KINDS] = {0};
    replay_kept(r, s, pixel, kept);
    for (uint32_t k = 0; k < r->keys; k++) {
        const size_t at = (size_t)pixel * r->keys + k;
        const double c = kept[k] * unit, d = c - (double)r->exact[at] * unit;
        const int kind = k >= r->mattes;
        if (p->seeds > 1)
            add_moments(&p->moments[s], at, c, d);
        tv[kind] += 0.5 * fabs(d);
        worst[kind] = fmax(worst[kind], fabs(d));
    }
    for (int kind = 0; kind < KINDS; kind++) {
        p->line[s].lost[kind] += kept[r->keys + (uint32_t)kind] * unit;
        p->line[s].tv[kind] += tv[kind];
        p->line[s].worst[kind] = fmax(p->line[s].worst[kind], worst[kind]);
        p->line[s].within[kind] += worst[kind] <= 1.0 / 255;
    }
}

static void add_seed(struct programme *p)
{
    const double unit = 1.0 / ((double)GK_MATTE_ONE * p->job->stop.samples);
    double *kept = malloc((p->replay.keys + GK_MATTE_LOST_WORDS) * sizeof *kept);
    make_room(p);
    p->frame_pixels = 0;
    for (uint32_t pixel = 0; pixel < p->replay.pixels; pixel++) {
        if (!has_samples(&p->replay, pixel))
            continue;
        p->frame_pixels++;
        for (size_t s = 0; s < SETTINGS; s++)
            add_pixel(p, s, pixel, unit, kept);
    }
    free(kept);
}

static void run_seed(struct programme *p, uint32_t seed)
{
    p->job->seed = seed;
    glint_render *render = replay_render(&p->replay, &p->o, &p->scene, p->job);
    struct glint_render_state state;
    glint_render_state(render, &state);
    p->excess += (double)state.count[GLINT_COUNT_CLAMPED];
    p->units += (double)GK_MATTE_ONE * (double)state.camera_rays;
    add_seed(p);
    glint_render_destroy(&render);
    fprintf(stderr, "seed %u of %u\n", seed + 1, p->seeds);
}

struct spread {
    double bias, noise, bias2, var;
};

static double variance(double sum, double squares, double n)
{
    return n > 1 ? fmax(0.0, squares - sum * sum / n) / (n - 1) : 0.0;
}

static void spread_of(const struct programme *p, size_t s, int kind, struct spread *out)
{
    const struct replay *r = &p->replay;
    const double n = p->seeds;
    const uint32_t first = kind ? r->mattes : 0, end = kind ? r->keys : r->mattes;
    *out = (struct spread){NAN, NAN, NAN, NAN};
    if (p->seeds < 2)
        return;
    *out = (struct spread){0};
    for (uint32_t pixel = 0; pixel < r->pixels; pixel++)
        for (uint32_t k = first; k < end; k++) {
            const size_t at = (size_t)pixel * r->keys + k;
            const double mean = p->moments[s].d[at] / n;
            const double v = variance(p->moments[s].d[at], p->moments[s].d2[at], n);
            out->bias += 0.5 * fabs(mean);
            out->noise += 0.5 * sqrt(2.0 / M_PI * v / n);
            out->bias2 += mean * mean - v / n;
            out->var += variance(p->moments[s].c[at], p->moments[s].c2[at], n);
        }
    const double names = (double)p->frame_pixels * (end - first);
    out->bias /= p->frame_pixels;
    out->noise /= p->frame_pixels;
    out->bias2 /= names;
    out->var /= names;
}

static void print_line(const struct programme *p, const char *scene, size_t s, int kind)
{
    static const char *const name[KINDS] = {"primary", "bounced"};
    const struct line *l = &p->line[s];
    const double n = (double)p->frame_pixels * p->seeds;
    struct spread spread;
    spread_of(p, s, kind, &spread);
    printf("%s,%s,%u,%s,%.3e,%.3e,%.3e,%.3e,%.3e,%.3e,%.4f,%.6f\n", scene, p->setting[s].name,
           p->setting[s].slots, name[kind], l->lost[kind] / n, l->tv[kind] / n, spread.bias,
           spread.noise, spread.bias2, spread.var, l->worst[kind], l->within[kind] / n);
}

static const char *scene_name(const char *path)
{
    static char name[64];
    const char *slash = strrchr(path, '/');
    snprintf(name, sizeof name, "%s", slash ? slash + 1 : path);
    char *dot = strchr(name, '.');
    if (dot)
        *dot = '\0';
    return name;
}

static struct glint_job *job_of(const char *resolution, int samples, const char *mattes)
{
    char text[512];
    int size[2];
    if (sscanf(resolution, "%dx%d", &size[0], &size[1]) != 2)
        exit(64);
    snprintf(text, sizeof text,
             "{\"scene\":\"s\",\"resolution\":[%d,%d],\"stop\":{\"samples\":%d},"
             "\"outputs\":[\"beauty\",\"crypto_object\"],"
             "\"mattes\":{\"through\":\"glossy\",\"eviction\":\"exact\"%s%s}}",
             size[0], size[1], samples, *mattes ? "," : "", mattes);
    return offline_job(text);
}

int main(int argc, char **argv)
{
    static struct programme p;
    if (argc < 5)
        return fprintf(stderr, "usage: mattes SCENE.json WxH SAMPLES SEEDS [MEMBERS]\n"), 64;
    offline_start(&p.o, 0);
    p.scene = offline_load_posed(&p.o, argv[1]);
    p.job = job_of(argv[2], atoi(argv[3]), argc > 5 ? argv[5] : "");
    p.seeds = (uint32_t)atoi(argv[4]);
    list_settings(&p);
    for (uint32_t seed = 0; seed < p.seeds; seed++)
        run_seed(&p, seed);
    puts("scene,policy,slots,kind,lost,tv,bias,noise,bias2,var,worst,within");
    for (size_t s = 0; s < SETTINGS; s++)
        for (int kind = 0; kind < KINDS; kind++)
            print_line(&p, scene_name(argv[1]), s, kind);
    printf("%s,clamped,,,%.3e,,,,,,,\n", scene_name(argv[1]), p.excess / p.units);
    replay_finish(&p.replay);
    for (size_t s = 0; s < SETTINGS; s++) {
        free(p.moments[s].c);
        free(p.moments[s].c2);
        free(p.moments[s].d);
        free(p.moments[s].d2);
    }
    glint_job_destroy(&p.job);
    glint_resident_release(&p.scene.resident);
    offline_finish(&p.o);
    return 0;
}
