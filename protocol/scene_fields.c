// scene_fields.c - the plain members of every part of a native scene.
#include "protocol/scene_parts.h"

// The largest floats below pi and pi / 2 rounded up: an angle given as pi / 2 is allowed.
#define BELOW_PI 3.14159250f
#define HALF_PI 1.57079637f
#define FAR 1e12
#define BRIGHT 1e20
#define LOOSE 1e6 // what has no bound of its own

static const char *const wraps[] = {"repeat", "clamp", "mirror", NULL};
static const char *const filterings[] = {"linear", "nearest", NULL};
static const char *const alpha_modes[] = {"opaque", "mask", "blend", NULL};
static const char *const image_formats[] = {"rgba8", "rgba16f", NULL};
static const char *const light_types[] = {"point", "spot", "sun", "area", NULL};
static const char *const projections[] = {"perspective", "orthographic", NULL};
static const char *const paths[] = {"translation", "rotation", "scale", "weights", NULL};
static const char *const interpolations[] = {"linear", "step", "cubicspline", NULL};

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
    GLINT_FIELD(CHOICE, struct glint_texture, filter, .choices = filterings),
    GLINT_FIELD(UINT, struct glint_texture, uv_set, .high = 1),
    GLINT_FIELD(FLOAT, struct glint_texture, offset, .count = 2, .low = -LOOSE, .high = LOOSE),
    GLINT_FIELD(FLOAT, struct glint_texture, scale, .count = 2, .low = -LOOSE, .high = LOOSE),
    GLINT_FIELD(FLOAT, struct glint_texture, rotation, .low = -LOOSE, .high = LOOSE),
    {0},
};

const struct glint_field glint_material_fields[] = {
    GLINT_FIELD(STRING, struct glint_material, name),
    GLINT_FIELD(FLOAT, struct glint_material, base_color, .count = 3, .high = 1),
    GLINT_FIELD(FLOAT, struct glint_material, opacity, .high = 1),
    GLINT_FIELD(CHOICE, struct glint_material, alpha_mode, .choices = alpha_modes),
    GLINT_FIELD(FLOAT, struct glint_material, alpha_cutoff, .high = LOOSE),
    GLINT_FIELD(FLOAT, struct glint_material, metallic, .high = 1),
    GLINT_FIELD(FLOAT, struct glint_material, roughness, .high = 1),
    GLINT_FIELD(FLOAT, struct glint_material, ior, .low = 1, .high = 10),
    GLINT_FIELD(FLOAT, struct glint_material, transmission, .high = 1),
    GLINT_FIELD(BOOL, struct glint_material, thin),
    GLINT_FIELD(BOOL, struct glint_material, double_sided),
    GLINT_FIELD(FLOAT, struct glint_material, emission, .count = 3, .high = BRIGHT),
    GLINT_FIELD(FLOAT, struct glint_material, normal_scale, .low = -LOOSE, .high = LOOSE),
    GLINT_FIELD(FLOAT, struct glint_material, specular, .high = 1),
    GLINT_FIELD(FLOAT, struct glint_material, specular_color, .count = 3, .high = LOOSE),
    GLINT_FIELD(FLOAT, struct glint_material, clearcoat, .high = 1),
    GLINT_FIELD(FLOAT, struct glint_material, clearcoat_roughness, .high = 1),
    GLINT_FIELD(FLOAT, struct glint_material, clearcoat_normal_scale, .low = -LOOSE, .high = LOOSE),
    GLINT_FIELD(FLOAT, struct glint_material, attenuation_color, .count = 3, .high = 1),
    GLINT_FIELD(FLOAT, struct glint_material, attenuation_distance, .high = FAR),
    GLINT_FIELD(FLOAT, struct glint_material, collimation, .high = 1),
    GLINT_FIELD(UINT, struct glint_material, priority, .high = 255),
    GLINT_FIELD_KNOWN("base_color_texture"),
    GLINT_FIELD_KNOWN("metallic_roughness_texture"),
    GLINT_FIELD_KNOWN("normal_map"),
    GLINT_FIELD_KNOWN("emission_texture"),
    GLINT_FIELD_KNOWN("specular_texture"),
    GLINT_FIELD_KNOWN("specular_color_texture"),
    GLINT_FIELD_KNOWN("transmission_texture"),
    GLINT_FIELD_KNOWN("clearcoat_texture"),
    GLINT_FIELD_KNOWN("clearcoat_roughness_texture"),
    GLINT_FIELD_KNOWN("clearcoat_normal_map"),
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
    GLINT_FIELD_KNOWN("node"),
    GLINT_FIELD_KNOWN("skin"),
    GLINT_FIELD_KNOWN("weights"),
    GLINT_FIELD_KNOWN("transform"),
    GLINT_FIELD(BOOL, struct glint_instance, visible),
    {0},
};

const struct glint_field glint_node_fields[] = {
    GLINT_FIELD(STRING, struct glint_node, name),
    GLINT_FIELD_KNOWN("parent"),
    GLINT_FIELD_KNOWN("transform"),
    {0},
};

const struct glint_field glint_skin_fields[] = {
    GLINT_FIELD_KNOWN("joints"),
    GLINT_FIELD_KNOWN("inverse_bind"),
    GLINT_FIELD_KNOWN("asset"),
    {0},
};

const struct glint_field glint_animation_fields[] = {
    GLINT_FIELD(STRING, struct glint_animation, name),
    GLINT_FIELD_KNOWN("channels"),
    {0},
};

const struct glint_field glint_channel_fields[] = {
    GLINT_FIELD_KNOWN("node"),
    GLINT_FIELD(CHOICE, struct glint_animation_channel, path, .choices = paths),
    GLINT_FIELD(CHOICE, struct glint_animation_channel, interpolation, .choices = interpolations),
    GLINT_FIELD_KNOWN("times"),
    GLINT_FIELD_KNOWN("values"),
    GLINT_FIELD_KNOWN("asset"),
    GLINT_FIELD_KNOWN("keys"),
    {0},
};

const struct glint_field glint_medium_fields[] = {
    GLINT_FIELD(FLOAT, struct glint_medium, density, .high = 1e30),
    GLINT_FIELD(FLOAT, struct glint_medium, albedo, .count = 3, .high = 1),
    GLINT_FIELD(FLOAT, struct glint_medium, g, .low = -1, .high = 1),
    GLINT_FIELD_KNOWN("box"),
    {0},
};

const struct glint_field glint_scene_fields[] = {
    GLINT_FIELD(FLOAT, struct glint_scene, fps, .low = 0.01, .high = 1000),
    GLINT_FIELD_KNOWN("images"),
    GLINT_FIELD_KNOWN("materials"),
    GLINT_FIELD_KNOWN("meshes"),
    GLINT_FIELD_KNOWN("objects"),
    GLINT_FIELD_KNOWN("nodes"),
    GLINT_FIELD_KNOWN("skins"),
    GLINT_FIELD_KNOWN("instances"),
    GLINT_FIELD_KNOWN("animations"),
    GLINT_FIELD_KNOWN("lights"),
    GLINT_FIELD_KNOWN("cameras"),
    GLINT_FIELD_KNOWN("media"),
    GLINT_FIELD_KNOWN("environment"),
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
    GLINT_FIELD_KNOWN("node"),
    GLINT_FIELD_KNOWN("transform"),
    {0},
};

// What a scene's camera has; one in a job has no node.
const struct glint_field glint_camera_fields[] = {
    GLINT_FIELD(STRING, struct glint_camera, name),
    GLINT_FIELD(CHOICE, struct glint_camera, projection, .choices = projections),
    GLINT_FIELD(FLOAT, struct glint_camera, yfov, .low = 1e-6, .high = BELOW_PI),
    GLINT_FIELD(FLOAT, struct glint_camera, ymag, .low = 1 / FAR, .high = FAR),
    GLINT_FIELD(FLOAT, struct glint_camera, lens_radius, .high = FAR),
    GLINT_FIELD(FLOAT, struct glint_camera, focus_distance, .low = 1 / FAR, .high = FAR),
    GLINT_FIELD_KNOWN("node"),
    GLINT_FIELD_KNOWN("transform"),
    {0},
};

const struct glint_field glint_environment_fields[] = {
    GLINT_FIELD(FLOAT, struct glint_environment, radiance, .count = 3, .high = BRIGHT),
    GLINT_FIELD_KNOWN("image"),
    GLINT_FIELD(FLOAT, struct glint_environment, rotation, .low = -LOOSE, .high = LOOSE),
    {0},
};

#define SLOT(NAME, MEMBER)                            \
    {                                                 \
        NAME, offsetof(struct glint_material, MEMBER) \
    }
const struct glint_texture_slot glint_texture_slots[GLINT_TEXTURE_SLOTS] = {
    SLOT("base_color_texture", base_color_texture),
    SLOT("metallic_roughness_texture", metallic_roughness_texture),
    SLOT("normal_map", normal_texture),
    SLOT("emission_texture", emission_texture),
    SLOT("specular_texture", specular_texture),
    SLOT("specular_color_texture", specular_color_texture),
    SLOT("transmission_texture", transmission_texture),
    SLOT("clearcoat_texture", clearcoat_texture),
    SLOT("clearcoat_roughness_texture", clearcoat_roughness_texture),
    SLOT("clearcoat_normal_map", clearcoat_normal_texture),
};

struct glint_texture *glint_texture_of(struct glint_material *m, size_t slot)
{
    return (struct glint_texture *)((char *)m + glint_texture_slots[slot].offset);
}
