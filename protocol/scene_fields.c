// scene_fields.c - the plain members of every part of a native scene.
#include "protocol/scene_parts.h"

// The largest floats below pi and pi / 2 rounded up: an angle given as pi / 2 is allowed.
#define BELOW_PI 3.14159250f
#define HALF_PI 1.57079637f
#define FAR 1e12
#define BRIGHT 1e20

static const char *const wraps[] = {"repeat", "clamp", "mirror", NULL};
static const char *const alpha_modes[] = {"opaque", "mask", NULL};
static const char *const image_formats[] = {"rgba8", "rgba16f", NULL};
static const char *const light_types[] = {"point", "spot", "sun", "area", NULL};

const struct glint_field glint_image_fields[] = {
    GLINT_FIELD_KNOWN("asset"),
    GLINT_FIELD_KNOWN("data"),
    GLINT_FIELD(UINT, struct glint_image, width, .low = 1, .high = GLINT_MAX_IMAGE_SIDE),
    GLINT_FIELD(UINT, struct glint_image, height, .low = 1, .high = GLINT_MAX_IMAGE_SIDE),
    GLINT_FIELD(CHOICE, struct glint_image, format, .choices = image_formats),
    {0},
};

const struct glint_field glint_texture_fields[] = {
    GLINT_FIELD_KNOWN("image"),
    GLINT_FIELD(CHOICE, struct glint_texture, wrap_u, .choices = wraps),
    GLINT_FIELD(CHOICE, struct glint_texture, wrap_v, .choices = wraps),
    {0},
};

const struct glint_field glint_material_fields[] = {
    GLINT_FIELD(STRING, struct glint_material, name),
    GLINT_FIELD(FLOAT, struct glint_material, base_color, .count = 3, .high = 1),
    GLINT_FIELD(FLOAT, struct glint_material, opacity, .high = 1),
    GLINT_FIELD(CHOICE, struct glint_material, alpha_mode, .choices = alpha_modes),
    GLINT_FIELD(FLOAT, struct glint_material, alpha_cutoff, .high = 1e6),
    GLINT_FIELD(FLOAT, struct glint_material, metallic, .high = 1),
    GLINT_FIELD(FLOAT, struct glint_material, roughness, .high = 1),
    GLINT_FIELD(FLOAT, struct glint_material, ior, .low = 1, .high = 10),
    GLINT_FIELD(FLOAT, struct glint_material, transmission, .high = 1),
    GLINT_FIELD(BOOL, struct glint_material, thin),
    GLINT_FIELD(BOOL, struct glint_material, double_sided),
    GLINT_FIELD(FLOAT, struct glint_material, emission, .count = 3, .high = BRIGHT),
    GLINT_FIELD(FLOAT, struct glint_material, normal_scale, .low = -1e6, .high = 1e6),
    GLINT_FIELD_KNOWN("base_color_texture"),
    GLINT_FIELD_KNOWN("metallic_roughness_texture"),
    GLINT_FIELD_KNOWN("normal_map"),
    GLINT_FIELD_KNOWN("emission_texture"),
    {0},
};

const struct glint_field glint_object_fields[] = {
    GLINT_FIELD(STRING, struct glint_object, name),
    GLINT_FIELD(STRING, struct glint_object, asset),
    {0},
};

const struct glint_field glint_instance_fields[] = {
    GLINT_FIELD_KNOWN("mesh"),
    GLINT_FIELD_KNOWN("material"),
    GLINT_FIELD_KNOWN("object"),
    GLINT_FIELD_KNOWN("transform"),
    GLINT_FIELD(BOOL, struct glint_instance, visible),
    {0},
};

const struct glint_field glint_light_fields[] = {
    {.name = "type",
     .kind = GLINT_FIELD_CHOICE,
     .offset = offsetof(struct glint_light, kind),
     .choices = light_types},
    GLINT_FIELD(STRING, struct glint_light, name),
    GLINT_FIELD(FLOAT, struct glint_light, color, .count = 3, .high = BRIGHT),
    GLINT_FIELD(FLOAT, struct glint_light, intensity, .high = BRIGHT),
    GLINT_FIELD(FLOAT, struct glint_light, inner_cone, .high = HALF_PI),
    GLINT_FIELD(FLOAT, struct glint_light, outer_cone, .low = 1e-6, .high = HALF_PI),
    GLINT_FIELD(FLOAT, struct glint_light, size, .count = 2, .low = 1 / FAR, .high = FAR),
    GLINT_FIELD_KNOWN("transform"),
    {0},
};

const struct glint_field glint_camera_fields[] = {
    GLINT_FIELD(STRING, struct glint_camera, name),
    GLINT_FIELD(FLOAT, struct glint_camera, yfov, .low = 1e-6, .high = BELOW_PI),
    GLINT_FIELD(FLOAT, struct glint_camera, lens_radius, .high = FAR),
    GLINT_FIELD(FLOAT, struct glint_camera, focus_distance, .low = 1 / FAR, .high = FAR),
    GLINT_FIELD_KNOWN("transform"),
    {0},
};

const struct glint_field glint_environment_fields[] = {
    GLINT_FIELD(FLOAT, struct glint_environment, radiance, .count = 3, .high = BRIGHT),
    GLINT_FIELD_KNOWN("image"),
    GLINT_FIELD(FLOAT, struct glint_environment, rotation, .low = -1e6, .high = 1e6),
    {0},
};

const struct glint_texture_slot glint_texture_slots[4] = {
    {"base_color_texture", offsetof(struct glint_material, base_color_texture)},
    {"metallic_roughness_texture", offsetof(struct glint_material, metallic_roughness_texture)},
    {"normal_map", offsetof(struct glint_material, normal_texture)},
    {"emission_texture", offsetof(struct glint_material, emission_texture)},
};

struct glint_texture *glint_texture_of(struct glint_material *m, size_t slot)
{
    return (struct glint_texture *)((char *)m + glint_texture_slots[slot].offset);
}
