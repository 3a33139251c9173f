// gltf_materials.c - metallic-roughness materials.
//
// Source: glTF 2.0, "Materials"; KHR_materials_emissive_strength.
#include "scene/gltf_file.h"

#include <stdio.h>
#include <string.h>

static const char *const known[] = {
    "KHR_materials_clearcoat",    "KHR_materials_emissive_strength",
    "KHR_materials_ior",          "KHR_materials_specular",
    "KHR_materials_transmission", "KHR_materials_unlit",
    "KHR_materials_volume",       NULL,
};

static void read_base(struct glint_gltf *g, const struct glint_json *at, struct glint_material *m)
{
    const struct glint_json pbr = glint_gltf_object(at, "pbrMetallicRoughness");
    const struct glint_json factor = glint_json_member(&pbr, "baseColorFactor");
    const struct glint_json metallic = glint_json_member(&pbr, "metallicFactor");
    const struct glint_json roughness = glint_json_member(&pbr, "roughnessFactor");
    float rgba[4] = {1, 1, 1, 1};
    glint_json_floats(&factor, 4, 0, 1, rgba);
    memcpy(m->base_color, rgba, sizeof m->base_color);
    m->opacity = rgba[3];
    glint_json_float(&metallic, 0, 1, &m->metallic);
    glint_json_float(&roughness, 0, 1, &m->roughness);
    m->base_color_texture = glint_gltf_texture_member(g, &pbr, "baseColorTexture", m->name);
    m->metallic_roughness_texture =
        glint_gltf_texture_member(g, &pbr, "metallicRoughnessTexture", m->name);
}

static void read_alpha(const struct glint_json *at, struct glint_material *m)
{
    static const char *const modes[] = {"OPAQUE", "MASK", "BLEND", NULL};
    static const enum glint_alpha_mode mode_of[] = {GLINT_ALPHA_OPAQUE, GLINT_ALPHA_MASK,
                                                    GLINT_ALPHA_BLEND};
    const struct glint_json mode = glint_json_member(at, "alphaMode");
    const struct glint_json cutoff = glint_json_member(at, "alphaCutoff");
    int choice = 0;
    glint_json_choice(&mode, modes, &choice);
    glint_json_float(&cutoff, 0, 1e6f, &m->alpha_cutoff);
    m->alpha_mode = mode_of[choice];
}

static void read_normal(struct glint_gltf *g, const struct glint_json *at, struct glint_material *m)
{
    const struct glint_json info = glint_gltf_object(at, "normalTexture");
    const struct glint_json scale = glint_json_member(&info, "scale");
    glint_json_float(&scale, -1e6f, 1e6f, &m->normal_scale);
    m->normal_texture = glint_gltf_texture(g, &info, m->name);
}

static void read_emission(struct glint_gltf *g, const struct glint_json *at,
                          struct glint_material *m)
{
    const struct glint_json factor = glint_json_member(at, "emissiveFactor");
    struct glint_json hold[2];
    float strength = 1;
    glint_json_floats(&factor, 3, 0, 1, m->emission);
    if (glint_gltf_extension(at, "KHR_materials_emissive_strength", hold)) {
        const struct glint_json s = glint_json_member(&hold[1], "emissiveStrength");
        glint_json_float(&s, 0, GLINT_MAX_RADIANCE, &strength);
    }
    for (int i = 0; i < 3; i++)
        m->emission[i] *= strength;
    m->emission_texture = glint_gltf_texture_member(g, at, "emissiveTexture", m->name);
}

// Appends a material with the defaults of glTF and a name; NULL without memory.
static struct glint_material *add(struct glint_gltf *g, const char *name)
{
    struct glint_material *m = &g->scene->material[g->scene->materials];
    glint_material_init(m);
    m->metallic = 1;
    m->double_sided = false;
    m->name = glint_arena_string(&g->scene->arena, name);
    m->id = glint_gltf_names_id(&g->ids[GLTF_ID_MATERIAL], &g->scene->arena, name);
    if (!m->name || !m->id) {
        glint_gltf_nomem(g);
        return NULL;
    }
    g->scene->materials++;
    return m;
}

static void read_material(struct glint_gltf *g, uint32_t i)
{
    const struct glint_json at = glint_gltf_item(g, GLTF_MATERIALS, i);
    const struct glint_json sided = glint_json_member(&at, "doubleSided");
    const char *name = glint_gltf_name(g, &at);
    char number[24];
    snprintf(number, sizeof number, "material_%u", i);
    struct glint_material *m = add(g, *name ? name : number);
    if (!m)
        return;
    glint_json_bool(&sided, &m->double_sided);
    read_base(g, &at, m);
    read_alpha(&at, m);
    read_normal(g, &at, m);
    read_emission(g, &at, m);
    glint_gltf_read_surface(g, &at, m);
    glint_gltf_ignored(g, &at, "material", m->name, known);
}

static bool prepare(struct glint_gltf *g)
{
    const uint32_t images = g->list[GLTF_IMAGES].count, textures = g->list[GLTF_TEXTURES].count;
    const uint32_t materials = g->list[GLTF_MATERIALS].count;
    g->image = glint_arena_array(&g->scratch, images + 1, sizeof *g->image);
    g->image_read = glint_arena_array(&g->scratch, images + 1, sizeof *g->image_read);
    g->texture = glint_arena_array(&g->scratch, textures + 1, sizeof *g->texture);
    g->texture_read = glint_arena_array(&g->scratch, textures + 1, sizeof *g->texture_read);
    g->scene->image = glint_arena_array(&g->scene->arena, images + 1, sizeof *g->scene->image);
    g->scene->material =
        glint_arena_array(&g->scene->arena, materials + 1, sizeof *g->scene->material);
    g->default_material = GLINT_NONE;
    return (g->image && g->image_read && g->texture && g->texture_read && g->scene->image &&
            g->scene->material) ||
           glint_gltf_nomem(g);
}

void glint_gltf_read_materials(struct glint_gltf *g)
{
    if (!prepare(g))
        return;
    for (uint32_t i = 0; i < g->list[GLTF_MATERIALS].count; i++)
        read_material(g, i);
}

uint32_t glint_gltf_material(struct glint_gltf *g, uint32_t material)
{
    if (material != GLINT_NONE)
        return material;
    if (g->default_material == GLINT_NONE && add(g, "default"))
        g->default_material = g->scene->materials - 1;
    return g->default_material;
}
