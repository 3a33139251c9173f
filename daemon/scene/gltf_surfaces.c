// gltf_surfaces.c - the extensions of materials that the renderer has.
//
// Source: KHR_materials_ior, _transmission, _volume, _specular, _clearcoat, _unlit.
#include "scene/gltf_file.h"

#include <float.h>
#include <math.h>
#include <string.h>

#define INFINITE_IOR 10.0f // the scene's largest
// Reflection of INFINITE_IOR at normal incidence: the square of 9/11.
#define INFINITE_F0 0.669421488f

static void read_ior(struct glint_gltf *g, const struct glint_json *at, struct glint_material *m)
{
    struct glint_json hold[2];
    if (!glint_gltf_extension(at, "KHR_materials_ior", hold))
        return;
    const struct glint_json ior = glint_json_member(&hold[1], "ior");
    float value = 1.5f;
    if (!glint_json_float(&ior, 0, FLT_MAX, &value))
        return;
    if (value > 0 && value < 1) {
        glint_json_fault(&ior, "%g: an index of refraction is at least 1", (double)value);
        return;
    }
    if (value > INFINITE_IOR)
        glint_gltf_note(g, "index of refraction",
                        "the index of refraction of material \"%.200s\" is %g; %g is used", m->name,
                        (double)value, (double)INFINITE_IOR);
    m->ior = value == 0 ? INFINITE_IOR : fminf(value, INFINITE_IOR);
    for (int i = 0; value == 0 && i < 3;
         i++) // stands for infinity: all is reflected but for specular
        m->specular_color[i] /= INFINITE_F0;
}

static void read_specular(struct glint_gltf *g, const struct glint_json *at,
                          struct glint_material *m)
{
    struct glint_json hold[2];
    if (!glint_gltf_extension(at, "KHR_materials_specular", hold))
        return;
    const struct glint_json factor = glint_json_member(&hold[1], "specularFactor");
    const struct glint_json color = glint_json_member(&hold[1], "specularColorFactor");
    glint_json_float(&factor, 0, 1, &m->specular);
    glint_json_floats(&color, 3, 0, GLINT_MAX_COORDINATE, m->specular_color);
    m->specular_texture = glint_gltf_texture_member(g, &hold[1], "specularTexture", m->name);
    m->specular_color_texture =
        glint_gltf_texture_member(g, &hold[1], "specularColorTexture", m->name);
}

static void read_clearcoat(struct glint_gltf *g, const struct glint_json *at,
                           struct glint_material *m)
{
    struct glint_json hold[2];
    if (!glint_gltf_extension(at, "KHR_materials_clearcoat", hold))
        return;
    const struct glint_json factor = glint_json_member(&hold[1], "clearcoatFactor");
    const struct glint_json roughness = glint_json_member(&hold[1], "clearcoatRoughnessFactor");
    const struct glint_json normal = glint_gltf_object(&hold[1], "clearcoatNormalTexture");
    const struct glint_json scale = glint_json_member(&normal, "scale");
    glint_json_float(&factor, 0, 1, &m->clearcoat);
    glint_json_float(&roughness, 0, 1, &m->clearcoat_roughness);
    glint_json_float(&scale, -1e6f, 1e6f, &m->clearcoat_normal_scale);
    m->clearcoat_texture = glint_gltf_texture_member(g, &hold[1], "clearcoatTexture", m->name);
    m->clearcoat_roughness_texture =
        glint_gltf_texture_member(g, &hold[1], "clearcoatRoughnessTexture", m->name);
    m->clearcoat_normal_texture = glint_gltf_texture(g, &normal, m->name);
}

static void read_transmission(struct glint_gltf *g, const struct glint_json *at,
                              struct glint_material *m)
{
    struct glint_json hold[2];
    if (!glint_gltf_extension(at, "KHR_materials_transmission", hold))
        return;
    const struct glint_json factor = glint_json_member(&hold[1], "transmissionFactor");
    glint_json_float(&factor, 0, 1, &m->transmission);
    m->transmission_texture =
        glint_gltf_texture_member(g, &hold[1], "transmissionTexture", m->name);
    m->thin = m->transmission > 0;
}

// Without thickness the surface is a thin wall, and there is nothing to absorb in.
static void read_volume(struct glint_gltf *g, const struct glint_json *at, struct glint_material *m)
{
    struct glint_json hold[2];
    if (!glint_gltf_extension(at, "KHR_materials_volume", hold))
        return;
    const struct glint_json thickness = glint_json_member(&hold[1], "thicknessFactor");
    const struct glint_json distance = glint_json_member(&hold[1], "attenuationDistance");
    const struct glint_json color = glint_json_member(&hold[1], "attenuationColor");
    float thick = 0, metres = 0;
    glint_json_float(&thickness, 0, FLT_MAX, &thick);
    glint_json_float(&distance, 0, FLT_MAX, &metres);
    glint_json_floats(&color, 3, 0, 1, m->attenuation_color);
    if (distance.value && cJSON_IsNumber(distance.value) && distance.value->valuedouble == 0)
        glint_json_fault(&distance, "0: the distance must be above 0");
    if (thick > 0) {
        m->thin = false;
        m->attenuation_distance = metres > GLINT_MAX_COORDINATE ? 0 : metres; // as good as infinite
    }
    if (thick > 0 && glint_json_member(&hold[1], "thicknessTexture").value)
        glint_gltf_note(g, "thicknessTexture",
                        "thicknessTexture of material \"%.200s\" is ignored: its geometry is as "
                        "thick as it is",
                        m->name);
}

// Shows the base colour as it is: emitted, and nothing reflected.
static void read_unlit(struct glint_gltf *g, const struct glint_json *at, struct glint_material *m)
{
    struct glint_json hold[2];
    if (!glint_gltf_extension(at, "KHR_materials_unlit", hold))
        return;
    memcpy(m->emission, m->base_color, sizeof m->emission);
    m->emission_texture = m->base_color_texture;
    memset(m->base_color, 0, sizeof m->base_color);
    m->metallic = 0;
    m->specular = 0;
    m->ior = 1;
    glint_gltf_note(g, "KHR_materials_unlit",
                    "KHR_materials_unlit of material \"%.200s\": its base colour is emitted, and "
                    "lights what is near",
                    m->name);
}

void glint_gltf_read_surface(struct glint_gltf *g, const struct glint_json *at,
                             struct glint_material *m)
{
    read_specular(g, at, m);
    read_ior(g, at, m);
    read_clearcoat(g, at, m);
    read_transmission(g, at, m);
    read_volume(g, at, m);
    read_unlit(g, at, m);
}
