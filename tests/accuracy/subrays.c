#define GK_MICROFACET 1
#define GK_INSTANCES 1

#include "tests/accuracy/subrays.h"

#include "kernels/gk_light.h"
#include "kernels/gk_sampler.h"
#include "kernels/gk_surface.h"
#include "kernels/gk_wave.h"
#include "scene/geometry.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

struct subrays {
    const struct gk_frame *frame;
    const glint_geometry *geometry;
    struct gk_resident scene;
    bool mirror[SUBRAYS_KEYS];
    float *wave; // [GK_COLUMNS][SUBRAYS]
};

// Where a sub-ray is after its reflection.
struct ends {
    float weight[SUBRAYS]; // of what it brings; the rest stays with the mirror
    uint32_t key[SUBRAYS]; // of what it hits
    uint32_t count[SUBRAYS_KEYS];
};

static const void *table(const glint_resident *scene, enum glint_table which)
{
    return glint_buffer_host(glint_resident_table(scene, which));
}

static void find_mirrors(struct subrays *s, const glint_resident *scene, const char *mirrors)
{
    const struct glint_matte_key *key;
    const uint32_t keys = glint_resident_mattes(scene, &key);
    if (keys > SUBRAYS_KEYS) {
        fprintf(stderr, "strips: too many names\n");
        exit(1);
    }
    for (uint32_t k = GK_MATTE_BACKGROUND + 1; k < keys; k++)
        s->mirror[k] = strncmp(key[k].name[GLINT_MATTE_OBJECT], mirrors, strlen(mirrors)) == 0;
}

struct subrays *subrays_create(glint_resident *scene, const glint_render *render,
                               const char *mirrors)
{
    struct subrays *s = calloc(1, sizeof *s);
    if (!s)
        exit(1);
    find_mirrors(s, scene, mirrors);
    s->frame = glint_buffer_host(render->view->frame);
    s->geometry = render->view->wave_job.geometry;
    s->scene.triangle = table(scene, GLINT_TABLE_TRIANGLES);
    s->scene.instance = table(scene, GLINT_TABLE_INSTANCES);
    s->scene.material = table(scene, GLINT_TABLE_MATERIALS);
    s->scene.energy = table(scene, GLINT_TABLE_ENERGY);
    s->wave = calloc((size_t)GK_COLUMNS * SUBRAYS, sizeof *s->wave);
    if (!s->wave)
        exit(1);
    for (uint32_t i = 0; i < SUBRAYS; i++)
        s->wave[GK_COL_MASK * SUBRAYS + i] = gk_as_f32(UINT32_MAX);
    return s;
}

void subrays_destroy(struct subrays *s)
{
    free(s->wave);
    free(s);
}

// 0..1, never 1; a function of where it is used.
static float uniform(uint32_t pixel, uint32_t ray, uint32_t use)
{
    const uint32_t bits = gk_mix32(gk_mix32(gk_mix32(pixel) ^ ray) + use);
    return (float)(bits >> 8) * 0x1p-24f;
}

static void store_ray(struct subrays *s, uint32_t i, struct gk_vec o, struct gk_vec d)
{
    const float value[] = {o.x, o.y, o.z, d.x, d.y, d.z, INFINITY};
    for (uint32_t c = 0; c < 7; c++)
        s->wave[(GK_COL_OX + c) * SUBRAYS + i] = value[c];
    s->wave[GK_COL_GEOMETRY * SUBRAYS + i] = gk_as_f32(GK_NONE);
    s->wave[GK_COL_INSTANCE * SUBRAYS + i] = gk_as_f32(GK_NONE);
}

static struct gk_vec column(const float v[3])
{
    return gk_vec(v[0], v[1], v[2]);
}

static void aim(struct subrays *s, uint32_t x, uint32_t y)
{
    const uint32_t pixel = y << 16 | x;
    const struct gk_frame *f = s->frame;
    for (uint32_t i = 0; i < SUBRAYS; i++) {
        const float u = ((float)(i % SUBRAYS_SIDE) + uniform(pixel, i, 0)) / SUBRAYS_SIDE;
        const float v = ((float)(i / SUBRAYS_SIDE) + uniform(pixel, i, 1)) / SUBRAYS_SIDE;
        const struct gk_vec through =
            gk_along(gk_along(column(f->corner), column(f->right), (float)x + u), column(f->down),
                     (float)y + v);
        store_ray(s, i, column(f->origin), gk_normalise(through));
    }
    glint_geometry_trace_wave(s->geometry, s->wave, SUBRAYS, SUBRAYS);
}

static uint32_t load(const struct subrays *s, uint32_t c, uint32_t i)
{
    return gk_as_u32(s->wave[c * SUBRAYS + i]);
}

static uint32_t key_of(const struct subrays *s, uint32_t i)
{
    const uint32_t geometry = load(s, GK_COL_GEOMETRY, i), instance = load(s, GK_COL_INSTANCE, i);
    if (geometry == GK_NONE)
        return GK_MATTE_BACKGROUND;
    return s->scene.instance[instance != GK_NONE ? instance : geometry].matte;
}

static struct gk_vec three(const struct subrays *s, uint32_t c, uint32_t i)
{
    return gk_vec(s->wave[c * SUBRAYS + i], s->wave[(c + 1) * SUBRAYS + i],
                  s->wave[(c + 2) * SUBRAYS + i]);
}

// The hit of sub-ray i, which has one.
static struct gk_hit hit_of(const struct subrays *s, uint32_t i)
{
    const struct gk_raw_hit raw = {.primitive = load(s, GK_COL_PRIMITIVE, i),
                                   .geometry = load(s, GK_COL_GEOMETRY, i),
                                   .instance = load(s, GK_COL_INSTANCE, i),
                                   .u = s->wave[GK_COL_U * SUBRAYS + i],
                                   .v = s->wave[GK_COL_V * SUBRAYS + i],
                                   .ng = three(s, GK_COL_NX, i)};
    return gk_hit_decode(&s->scene, raw, three(s, GK_COL_DX, i));
}

// Sub-ray i goes on from its hit by the lobe there. Returns the mean of f cos / pdf, 0: it does not.
static float reflect(struct subrays *s, uint32_t pixel, uint32_t i)
{
    const struct gk_hit hit = hit_of(s, i);
    const struct gk_vec d = three(s, GK_COL_DX, i);
    const float t = s->wave[GK_COL_T * SUBRAYS + i];
    const struct gk_onb onb = gk_onb_make(hit.ns);
    struct gk_vec wo = gk_to_local(onb, gk_negate(d));
    wo.z = fmaxf(wo.z, 1e-6f);
    const struct gk_surface surface = gk_hit_surface(&s->scene, &hit, onb, wo);
    const struct gk_bsdf_sample sample = gk_bsdf_sample(&surface, wo, uniform(pixel, i, 2),
                                                        uniform(pixel, i, 3), uniform(pixel, i, 4));
    const struct gk_bsdf_value value = gk_bsdf_eval(&surface, wo, sample.wi);
    const struct gk_vec wi = gk_normalise(gk_to_world(onb, sample.wi));
    const struct gk_vec p = gk_along(three(s, GK_COL_OX, i), d, t);
    store_ray(s, i, gk_along(p, hit.ng, gk_point_error(p, t)), wi);
    if (gk_dot(wi, hit.ng) <= 0.0f || sample.wi.z <= 0.0f)
        return 0.0f;
    return sample.delta ? gk_mean3(sample.weight)
                        : (value.pdf > 1e-30f ? gk_mean3(value.f) / value.pdf : 0.0f);
}

static void bounce(struct subrays *s, uint32_t pixel, struct ends *e)
{
    memset(e->count, 0, sizeof e->count);
    for (uint32_t i = 0; i < SUBRAYS; i++)
        e->weight[i] = reflect(s, pixel, i);
    glint_geometry_trace_wave(s->geometry, s->wave, SUBRAYS, SUBRAYS);
    for (uint32_t i = 0; i < SUBRAYS; i++) {
        e->key[i] = key_of(s, i);
        e->count[e->key[i]]++;
    }
}

static void add_up(const struct ends *e, struct subrays_pixel *out)
{
    for (uint32_t i = 0; i < SUBRAYS; i++) {
        const float same = (float)e->count[e->key[i]] / SUBRAYS;
        const float carried[] = {e->weight[i], e->weight[i] * same};
        for (int r = 0; r < SUBRAYS_READINGS; r++) {
            out->part[r][e->key[i]] += carried[r] / SUBRAYS;
            out->part[r][out->first] += (1.0f - carried[r]) / SUBRAYS;
        }
    }
}

static float mean_distance(const struct subrays *s)
{
    double sum = 0.0;
    uint32_t hits = 0;
    for (uint32_t i = 0; i < SUBRAYS; i++)
        if (load(s, GK_COL_GEOMETRY, i) != GK_NONE) {
            sum += s->wave[GK_COL_T * SUBRAYS + i];
            hits++;
        }
    return hits > SUBRAYS / 2 ? (float)(sum / hits) : INFINITY;
}

void subrays_look(struct subrays *s, uint32_t x, uint32_t y, struct subrays_pixel *out)
{
    static struct ends ends;
    const uint32_t middle = SUBRAYS / 2 + SUBRAYS_SIDE / 2;
    memset(out, 0, sizeof *out);
    aim(s, x, y);
    out->first = s->mirror[key_of(s, 0)] ? key_of(s, 0) : 0;
    for (uint32_t i = 1; i < SUBRAYS && out->first; i++)
        out->first = key_of(s, i) == out->first ? out->first : 0;
    if (!out->first)
        return;
    const struct gk_hit hit = hit_of(s, middle);
    out->curvature = gk_hit_curvature(&s->scene, &hit);
    bounce(s, y << 16 | x, &ends);
    out->distance = mean_distance(s);
    add_up(&ends, out);
}
