// surface.h - surfaces and directions for tests of gk_bsdf.h, with reflection and refraction compiled
// in; the layers over them where GK_SPECULAR and so on are defined before.
#ifndef GLINT_TESTS_KERNEL_SURFACE_H
#define GLINT_TESTS_KERNEL_SURFACE_H

#define GK_MICROFACET 1
#define GK_TRANSMISSION 1

#include "kernels/gk_bsdf.h"
#include "scene/energy.h"
#include "tests/kernel/check.h"

struct layers {
    float specular, color[3];               // KHR_materials_specular
    float coat, coat_roughness, coat_slope; // its normal is (slope, 0, 1), normalised
    float collimation;
};

struct material {
    const char *name;
    float base, metallic, transmission, roughness, ior;
    int thin, leaving; // leaving: wo lies inside
#ifdef GK_CLEARCOAT
    const struct layers *layers; // NULL: without
#endif
};

static inline const struct layers *layers_of(const struct material *m)
{
    static const struct layers none = {1, {1, 1, 1}, 0, 0, 0, 1};
#ifdef GK_CLEARCOAT
    return m->layers ? m->layers : &none;
#else
    (void)m;
    return &none;
#endif
}

// Reflectance of a dielectric in double. Source: Fresnel's equations, as printed in textbooks.
static inline double exact_fresnel(double cos_i, double eta)
{
    const double sin2 = (1 - cos_i * cos_i) / (eta * eta);
    if (eta == 1)
        return 0; // at a cosine of 0 too
    if (sin2 >= 1)
        return 1;
    const double cos_t = sqrt(1 - sin2);
    const double s = (cos_i - eta * cos_t) / (cos_i + eta * cos_t);
    const double p = (eta * cos_i - cos_t) / (eta * cos_i + cos_t);
    return 0.5 * (s * s + p * p);
}

static inline double exact_fresnel_mean(double eta)
{
    double sum = 0;
    for (int i = 0; i < 2000; i++) {
        const double c = (i + 0.5) / 2000;
        sum += 2 * c * exact_fresnel(c, eta) / 2000;
    }
    return sum;
}

// Unit vector at azimuth `turn` (of 1), rounded once.
static inline struct gk_vec direction(double cosine, double turn)
{
    const double r = sqrt(fmax(0, 1 - cosine * cosine));
    return gk_vec((float)(r * cos(2 * M_PI * turn)), (float)(r * sin(2 * M_PI * turn)),
                  (float)cosine);
}

// What is known of an index: the white part of the energy table, behind it those of a transmitting
// interface, and the mean reflectance.
struct index_tables {
    float ior, energy[(2 + GK_ENERGY_PARTS) * GK_ENERGY_PART], fresnel_mean;
};

// Those of the index asked for last are kept: most tests draw a million surfaces of few indices.
static inline const struct index_tables *tables_of(float ior)
{
    static struct index_tables t;
    if (ior == t.ior)
        return &t;
    memcpy(t.energy, glint_energy_white(), GK_ENERGY_PART * sizeof *t.energy);
    memcpy(t.energy + GK_ENERGY_COAT, glint_energy_interface(1.5f),
           GK_ENERGY_PART * sizeof *t.energy);
    memcpy(t.energy + 2 * GK_ENERGY_PART, glint_energy_glass(ior),
           GK_ENERGY_PARTS * GK_ENERGY_PART * sizeof *t.energy);
    t.fresnel_mean = (float)exact_fresnel_mean(ior);
    t.ior = ior;
    return &t;
}

static inline void add_layers(struct gk_surface *s, const struct layers *l)
{
    s->specular = l->specular;
    s->specular_color = gk_vec(l->color[0], l->color[1], l->color[2]);
    s->collimation = l->collimation;
    s->coat.weight = l->coat;
    s->coat.alpha = l->coat_roughness * l->coat_roughness;
    s->coat.frame = gk_onb_make(gk_normalise(gk_vec(l->coat_slope, 0, 1)));
}

static inline struct gk_surface make_surface_at(const struct material *m, struct gk_vec wo)
{
    const struct index_tables *tables = tables_of(m->ior);
    struct gk_surface s = {0};
    s.base = gk_splat(m->base);
    s.metallic = m->metallic;
    s.transmission = m->transmission;
    s.alpha = m->roughness * m->roughness;
    s.eta = m->leaving ? 1.0f / m->ior : m->ior;
    s.inside = m->leaving;
    s.fresnel_mean = tables->fresnel_mean;
    s.thin = m->thin;
    s.energy = (struct gk_energy_table){tables->energy, gk_cut_none()};
    s.interface = 2 * GK_ENERGY_PART;
    add_layers(&s, layers_of(m));
    gk_surface_prepare(&s, wo);
    return s;
}

static inline struct gk_surface make_surface(const struct material *m, float cos_o)
{
    return make_surface_at(m, direction(cos_o, 0.2));
}

static inline struct gk_vec random_direction(uint64_t *seed)
{
    return direction(2 * check_uniform(seed) - 1, check_uniform(seed));
}

static inline struct gk_vec random_upper(uint64_t *seed)
{
    return direction(0.001 + 0.999 * check_uniform(seed), check_uniform(seed));
}

static inline struct gk_bsdf_sample draw(const struct gk_surface *s, struct gk_vec wo,
                                         uint64_t *seed)
{
    const float u_lobe = check_uniform(seed), u = check_uniform(seed);
    return gk_bsdf_sample(s, wo, u_lobe, u, check_uniform(seed));
}

// f |cos| / pdf of a sample, as the integrator forms it; 0 for a rejected one.
static inline double sample_weight(const struct gk_surface *s, struct gk_vec wo,
                                   const struct gk_bsdf_sample *sample)
{
    if (sample->delta)
        return gk_mean3(sample->weight);
    const struct gk_bsdf_value value = gk_bsdf_eval(s, wo, sample->wi);
    return value.pdf > 1e-30f ? gk_mean3(value.f) / value.pdf : 0;
}

#endif
