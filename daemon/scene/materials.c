// materials.c - material records, and what they call for.
#include "kernels/gk_fresnel.h"
#include "scene/internal.h"

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
    out->base_texture = glint_resident_texture(r, &m->base_color_texture, true);
    out->rough_texture = glint_resident_texture(r, &m->metallic_roughness_texture, false);
    out->normal_texture = glint_resident_texture(r, &m->normal_texture, false);
    out->emission_texture = glint_resident_texture(r, &m->emission_texture, true);
    out->flags =
        (m->thin ? GK_MATERIAL_THIN : 0u) | (m->double_sided ? GK_MATERIAL_TWO_SIDED_EMISSION : 0u);
}

// An area light is black but for what it emits.
static void fill_area(const struct glint_light *l, struct gk_material *out)
{
    memset(out, 0, sizeof *out);
    for (int k = 0; k < 3; k++)
        out->emission[k] = l->color[k] * l->intensity;
    out->roughness = 1.0f;
    out->ior = 1.0f;
    out->base_texture = out->rough_texture = GK_NONE;
    out->normal_texture = out->emission_texture = GK_NONE;
}

static void note_facts(struct glint_scene_facts *f, const struct gk_material *m)
{
    f->microfacet |= m->metallic > 0.0f || m->ior != 1.0f || m->transmission > 0.0f;
    f->transmission |= m->transmission > 0.0f;
    f->textures |=
        m->base_texture != GK_NONE || m->rough_texture != GK_NONE || m->emission_texture != GK_NONE;
    f->normal_maps |= m->normal_texture != GK_NONE;
    f->emission |= m->emission[0] > 0.0f || m->emission[1] > 0.0f || m->emission[2] > 0.0f;
    f->cutout |= m->cutoff > 0.0f;
}

static uint32_t area_lights(const struct glint_scene *s)
{
    uint32_t n = 0;
    for (uint32_t i = 0; i < s->lights; i++)
        n += s->light[i].kind == GLINT_LIGHT_AREA;
    return n;
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
    for (uint32_t i = 0; i < r->rows; i++)
        note_facts(&r->facts, &m[r->row[i].material]);
    r->facts.textures |= r->facts.normal_maps;
    return GLINT_OK;
}
