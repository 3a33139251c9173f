// materials.c - material records, and what they call for.
#include "kernels/gk_energy.h"
#include "kernels/gk_fresnel.h"
#include "kernels/gk_ggx.h"
#include "scene/energy.h"
#include "scene/internal.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

// Hemispherical mean of the dielectric reflectance: 2 Int F(c) c dc, midpoint rule.
static float fresnel_mean(float ior)
{
    const int steps = 4096;
    double sum = 0.0;
    for (int i = 0; i < steps; i++) {
        const double c = (i + 0.5) / steps;
        sum += 2.0 * gk_fresnel_dielectric((float)c, ior) * c;
    }
    return (float)(sum / steps);
}

// Absorption coefficients that leave `color` of white light after `distance`; black is 1e-20 of it.
static bool fill_attenuation(const struct glint_material *m, float out[3])
{
    bool absorbs = false;
    for (int k = 0; k < 3; k++) {
        const double left = fmax((double)m->attenuation_color[k], 1e-20);
        out[k] = m->attenuation_distance > 0.0f
                     ? (float)fmin(-log(left) / (double)m->attenuation_distance, 1e30)
                     : 0.0f;
        absorbs |= out[k] > 0.0f;
    }
    return absorbs;
}

static bool has_specular(const struct glint_material *m)
{
    return m->specular != 1.0f || m->specular_color[0] != 1.0f || m->specular_color[1] != 1.0f ||
           m->specular_color[2] != 1.0f || m->specular_texture.image != GLINT_NONE ||
           m->specular_color_texture.image != GLINT_NONE;
}

static uint32_t flags_of(const struct glint_material *m)
{
    return (m->thin ? GK_MATERIAL_THIN : 0u) |
           (m->double_sided ? GK_MATERIAL_TWO_SIDED_EMISSION : 0u) |
           (m->transmission == 0.0f && !m->double_sided ? GK_MATERIAL_CULLED : 0u) |
           (m->alpha_mode == GLINT_ALPHA_BLEND ? GK_MATERIAL_BLEND : 0u) |
           (has_specular(m) ? GK_MATERIAL_SPECULAR : 0u) |
           (m->clearcoat > 0.0f ? GK_MATERIAL_COATED : 0u);
}

static void fill_textures(const struct glint_resident *r, const struct glint_material *m,
                          struct gk_material *out)
{
    out->base_texture = glint_resident_texture(r, &m->base_color_texture);
    out->rough_texture = glint_resident_texture(r, &m->metallic_roughness_texture);
    out->normal_texture = glint_resident_texture(r, &m->normal_texture);
    out->emission_texture = glint_resident_texture(r, &m->emission_texture);
    out->specular_texture = glint_resident_texture(r, &m->specular_texture);
    out->specular_color_texture = glint_resident_texture(r, &m->specular_color_texture);
    out->transmission_texture = glint_resident_texture(r, &m->transmission_texture);
    out->coat_texture = glint_resident_texture(r, &m->clearcoat_texture);
    out->coat_rough_texture = glint_resident_texture(r, &m->clearcoat_roughness_texture);
    out->coat_normal_texture = glint_resident_texture(r, &m->clearcoat_normal_texture);
}

static void fill(const struct glint_resident *r, const struct glint_material *m,
                 struct gk_material *out)
{
    memset(out, 0, sizeof *out);
    memcpy(out->base, m->base_color, sizeof out->base);
    memcpy(out->emission, m->emission, sizeof out->emission);
    out->metallic = m->metallic;
    out->roughness = m->roughness;
    out->ior = m->ior;
    out->transmission = m->transmission;
    out->fresnel_mean = fresnel_mean(m->ior);
    out->normal_scale = m->normal_scale;
    out->opacity = m->opacity;
    out->cutoff = m->alpha_mode == GLINT_ALPHA_MASK ? m->alpha_cutoff : 0.0f;
    out->collimation = m->collimation;
    out->specular = m->specular;
    memcpy(out->specular_color, m->specular_color, sizeof out->specular_color);
    out->coat = m->clearcoat;
    out->coat_roughness = m->clearcoat_roughness;
    out->coat_normal_scale = m->clearcoat_normal_scale;
    fill_textures(r, m, out);
    out->flags = flags_of(m) | (fill_attenuation(m, out->attenuation) ? GK_MATERIAL_ABSORBS : 0u);
}

// An area light is black but for what it emits.
static void fill_area(const struct glint_light *l, struct gk_material *out)
{
    memset(out, 0, sizeof *out);
    for (int k = 0; k < 3; k++)
        out->emission[k] = l->color[k] * l->intensity;
    out->roughness = 1.0f;
    out->ior = 1.0f;
    out->opacity = out->collimation = out->specular = 1.0f;
    for (int k = 0; k < 3; k++)
        out->specular_color[k] = 1.0f;
    out->base_texture = out->rough_texture = GK_NONE;
    out->normal_texture = out->emission_texture = GK_NONE;
    out->specular_texture = out->specular_color_texture = out->transmission_texture = GK_NONE;
    out->coat_texture = out->coat_rough_texture = out->coat_normal_texture = GK_NONE;
}

// Whether light can be inside of what it bounds, so that its priority matters.
static bool is_nested(const struct glint_material *m)
{
    return m->transmission > 0.0f && !m->thin && m->priority > 0;
}

// Ranks by (priority, index). The record of index k also says which material has rank k + 1.
static void rank_interiors(const struct glint_scene *s, struct gk_material *out)
{
    uint32_t rank = 0;
    for (uint32_t priority = 1; priority <= 255; priority++)
        for (uint32_t i = 0; i < s->materials; i++)
            if (is_nested(&s->material[i]) && s->material[i].priority == priority) {
                out[rank].ranked = i;
                out[i].interior = ++rank;
            }
}

static void note_texture(struct glint_scene_facts *f, const struct glint_resident *r,
                         uint32_t index)
{
    if (index == GK_NONE)
        return;
    const struct gk_texture *t =
        (const struct gk_texture *)glint_table_host(r, GLINT_TABLE_TEXTURES) + index;
    f->textures = true;
    f->uv1 |= (t->flags & GK_TEXTURE_UV1) != 0;
    f->texture_transforms |= (t->flags & GK_TEXTURE_TRANSFORMED) != 0;
    f->nearest_texels |= (t->flags & GK_TEXTURE_NEAREST) != 0;
}

static bool emits(const struct gk_material *m)
{
    return m->emission[0] > 0.0f || m->emission[1] > 0.0f || m->emission[2] > 0.0f;
}

static void note_textures(struct glint_scene_facts *f, const struct glint_resident *r,
                          const struct gk_material *m)
{
    const uint32_t plain[] = {m->base_texture, m->rough_texture, m->normal_texture,
                              m->emission_texture};
    const uint32_t layer[] = {m->specular_texture,     m->specular_color_texture,
                              m->transmission_texture, m->coat_texture,
                              m->coat_rough_texture,   m->coat_normal_texture};
    for (size_t i = 0; i < sizeof plain / sizeof *plain; i++)
        note_texture(f, r, plain[i]);
    for (size_t i = 0; i < sizeof layer / sizeof *layer; i++) {
        note_texture(f, r, layer[i]);
        f->layer_textures |= layer[i] != GK_NONE;
    }
    f->roughness_textures |= m->rough_texture != GK_NONE;
    f->emission_textures |= m->emission_texture != GK_NONE && emits(m);
    f->normal_maps |= m->normal_texture != GK_NONE || m->coat_normal_texture != GK_NONE;
}

// Whether light that is reflected or passes can meet several facets.
static bool is_rough(const struct gk_material *m)
{
    const bool passes = m->transmission > 0.0f, thin = (m->flags & GK_MATERIAL_THIN) != 0;
    const bool facets = m->metallic > 0.0f || m->ior != 1.0f || (passes && thin);
    return (m->roughness * m->roughness >= GK_ALPHA_DELTA && facets) ||
           (passes && 1.0f - m->collimation >= GK_ALPHA_DELTA);
}

static void note_facts(struct glint_scene_facts *f, const struct gk_material *m)
{
    f->rough |= is_rough(m);
    f->specular |= (m->flags & GK_MATERIAL_SPECULAR) != 0 && m->ior != 1.0f;
    f->clearcoat |= (m->flags & GK_MATERIAL_COATED) != 0;
    f->microfacet |= m->metallic > 0.0f || m->ior != 1.0f || m->transmission > 0.0f ||
                     (m->flags & GK_MATERIAL_COATED) != 0;
    f->transmission |= m->transmission > 0.0f;
    f->collimation |= m->transmission > 0.0f && m->collimation < 1.0f;
    f->emission |= emits(m);
    f->cutout |= m->cutoff > 0.0f;
    f->culling |= (m->flags & GK_MATERIAL_CULLED) != 0;
    f->blend |= (m->flags & GK_MATERIAL_BLEND) != 0;
    const bool solid = m->transmission > 0.0f && !(m->flags & GK_MATERIAL_THIN);
    f->solids |= solid && (f->medium || (m->flags & GK_MATERIAL_ABSORBS));
    f->nested |= m->interior > 0;
}

static uint32_t area_lights(const struct glint_scene *s)
{
    uint32_t n = 0;
    for (uint32_t i = 0; i < s->lights; i++)
        n += s->light[i].kind == GLINT_LIGHT_AREA;
    return n;
}

struct parts {
    uint32_t count;
    const float **part;
};

// Place of `count` parts from `first` on, which it adds where they are not there.
static uint32_t place_parts(struct parts *p, const float *first, uint32_t count)
{
    uint32_t k = 1;
    while (k < p->count && p->part[k] != first)
        k++;
    const uint32_t added = k == p->count ? count : 0;
    for (uint32_t i = 0; i < added; i++)
        p->part[p->count++] = first + (size_t)i * GK_ENERGY_PART;
    return k * GK_ENERGY_PART;
}

// Numbers the parts of the energy table: materials with one interface share one. The first part
// is white, the second a coat's. A smooth interface that transmits asks for none.
static void number_parts(const struct glint_scene *s, struct gk_material *m, struct parts *p)
{
    p->count = 2;
    p->part[0] = glint_energy_white();
    p->part[1] = glint_energy_interface(1.5f);
    for (uint32_t i = 0; i < s->materials; i++)
        if (m[i].transmission <= 0.0f)
            m[i].energy = place_parts(p, glint_energy_interface(m[i].ior), 1);
        else if (is_rough(&m[i]))
            m[i].energy = place_parts(p, glint_energy_glass(m[i].ior), GK_ENERGY_PARTS);
}

// Forced effects read it too: where no reflection is rough, it is there, of zeros.
static glint_status build_energy(struct glint_resident *r, struct glint_error *err)
{
    const bool needed = r->facts.rough || r->facts.clearcoat;
    const size_t most = (size_t)r->scene->materials * GK_ENERGY_PARTS + 2;
    struct parts p = {.count = 2, .part = calloc(most, sizeof *p.part)};
    if (!p.part)
        return glint_fail(err, GLINT_E_NOMEM, "", "no memory for %u interfaces",
                          r->scene->materials);
    struct gk_material *m = glint_table_host(r, GLINT_TABLE_MATERIALS);
    if (needed)
        number_parts(r->scene, m, &p);
    const size_t bytes = GK_ENERGY_PART * sizeof(float);
    const glint_status st =
        glint_buffer_create(&r->table[GLINT_TABLE_ENERGY], r->devices, p.count * bytes, err);
    for (uint32_t k = 0; !st && needed && k < p.count; k++)
        memcpy((float *)glint_table_host(r, GLINT_TABLE_ENERGY) + (size_t)k * GK_ENERGY_PART,
               p.part[k], bytes);
    free(p.part);
    return st;
}

glint_status glint_resident_build_materials(struct glint_resident *r, struct glint_error *err)
{
    const struct glint_scene *s = r->scene;
    const size_t records = (size_t)s->materials + area_lights(s) + 1;
    glint_status st = glint_buffer_create(&r->table[GLINT_TABLE_MATERIALS], r->devices,
                                          records * sizeof(struct gk_material), err);
    if (st)
        return st;
    struct gk_material *m = glint_table_host(r, GLINT_TABLE_MATERIALS);
    for (uint32_t i = 0; i < s->materials; i++)
        fill(r, &s->material[i], &m[i]);
    uint32_t next = s->materials;
    for (uint32_t i = 0; i < s->lights; i++)
        if (s->light[i].kind == GLINT_LIGHT_AREA)
            fill_area(&s->light[i], &m[next++]);
    rank_interiors(s, m);
    r->facts.medium = s->media && s->medium[0].density > 0.0f;
    for (uint32_t i = 0; i < r->rows; i++) {
        const uint32_t material = r->row[i].material;
        note_facts(&r->facts, &m[material]);
        note_textures(&r->facts, r, &m[material]);
        r->facts.vertex_colours |= r->row[i].mesh->color && material < s->materials;
    }
    return build_energy(r, err);
}
