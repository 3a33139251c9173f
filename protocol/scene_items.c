// scene_items.c - images, materials, lights, cameras, media and the environment of a native scene.
#include "protocol/scene_parts.h"

// ---- images

// Infinities, NaN and negative values would spread into pixels and into the sampling tables.
static bool radiance_halves(const struct glint_json *at, const uint16_t *half, size_t count)
{
    unsigned bad = 0;
    for (size_t i = 0; i < count; i++)
        bad |= (half[i] & 0x7c00u) == 0x7c00u || half[i] > 0x8000u;
    if (!bad)
        return true;
    size_t i = 0;
    while ((half[i] & 0x7c00u) != 0x7c00u && half[i] <= 0x8000u)
        i++;
    return glint_json_fault(at, "channel %zu of pixel %zu is negative or not finite", i % 4, i / 4);
}

void glint_image_read(struct glint_scene_reader *r, const struct glint_json *at,
                      struct glint_image *out)
{
    static const char *const required[] = {"asset", "width", "height", "format"};
    const struct glint_json data = glint_json_member(at, "data");
    if (data.value) {
        glint_json_fault(&data, "encoded pixels are only taken where scenes are imported");
        return;
    }
    bool fine = glint_fields_read(at, glint_image_fields, &r->scene->arena, out);
    for (size_t i = 0; i < sizeof required / sizeof *required; i++) {
        const struct glint_json member = glint_json_member(at, required[i]);
        fine &= glint_json_require(&member);
    }
    if (!fine)
        return;
    const struct glint_json asset = glint_json_member(at, "asset");
    const uint64_t pixels = (uint64_t)out->width * out->height;
    out->pixels = glint_scene_asset(r, &asset, pixels * (out->format == GLINT_IMAGE_RGBA8 ? 4 : 8),
                                    out->asset);
    if (out->pixels && out->format == GLINT_IMAGE_RGBA16F && !glint_trust_image(r, out) &&
        glint_scene_charge(r, &asset, pixels * 8))
        radiance_halves(&asset, out->pixels, pixels * 4);
}

// ---- materials

static void texture_read(struct glint_scene_reader *r, const struct glint_json *at,
                         struct glint_texture *out)
{
    if (!at->value || !glint_fields_read(at, glint_texture_fields, &r->scene->arena, out))
        return;
    const struct glint_json image = glint_json_member(at, "image");
    if (glint_json_require(&image))
        out->image = glint_scene_reference(&image, &r->images, "image");
}

void glint_material_read(struct glint_scene_reader *r, const struct glint_json *at,
                         struct glint_material *out)
{
    char *id = out->id;
    glint_material_init(out);
    out->id = out->name = id;
    glint_fields_read(at, glint_material_fields, &r->scene->arena, out);
    for (size_t i = 0; i < GLINT_TEXTURE_SLOTS; i++) {
        const struct glint_json texture = glint_json_member(at, glint_texture_slots[i].name);
        texture_read(r, &texture, glint_texture_of(out, i));
    }
}

// ---- lights, cameras, media, environment

void glint_light_read(struct glint_scene_reader *r, const struct glint_json *at,
                      struct glint_light *out)
{
    const struct glint_json type = glint_json_member(at, "type");
    const struct glint_json node = glint_json_member(at, "node");
    const struct glint_json transform = glint_json_member(at, "transform");
    const struct glint_json inner = glint_json_member(at, "inner_cone");
    char *id = out->id;
    glint_light_init(out);
    out->id = out->name = id;
    bool fine = glint_fields_read(at, glint_light_fields, &r->scene->arena, out);
    fine &= glint_json_require(&type);
    out->node = glint_scene_reference(&node, &r->nodes, "node");
    fine &= glint_transform_read(&transform, out->transform);
    if (fine && out->kind == GLINT_LIGHT_SPOT && out->inner_cone >= out->outer_cone)
        glint_json_fault(&inner, "%g is not below the outer cone, %g", out->inner_cone,
                         out->outer_cone);
}

static bool read_camera_node(const struct glint_json *at, const struct glint_ids *nodes,
                             uint32_t *out)
{
    if (nodes)
        *out = glint_scene_reference(at, nodes, "node");
    else if (at->value)
        return glint_json_fault(at, "a job's camera stands in the world, on no node");
    return true;
}

bool glint_camera_read(const struct glint_json *at, const char *id, const struct glint_ids *nodes,
                       struct glint_arena *arena, struct glint_camera *out)
{
    const struct glint_json node = glint_json_member(at, "node");
    const struct glint_json transform = glint_json_member(at, "transform");
    const struct glint_json yfov = glint_json_member(at, "yfov");
    const struct glint_json ymag = glint_json_member(at, "ymag");
    char *own = glint_arena_string(arena, id);
    glint_camera_init(out);
    out->id = out->name = own;
    bool fine = glint_fields_read(at, glint_camera_fields, arena, out);
    fine &= glint_json_require(out->projection == GLINT_ORTHOGRAPHIC ? &ymag : &yfov);
    fine &= read_camera_node(&node, nodes, &out->node);
    fine &= glint_transform_read(&transform, out->transform);
    if (fine)
        glint_transform_rigid(out->transform);
    if (!own)
        glint_fail(at->err, GLINT_E_NOMEM, "", "no memory for a camera");
    return fine && own;
}

static void read_box(const struct glint_json *at, struct glint_medium *out)
{
    const float far = GLINT_MAX_COORDINATE;
    out->bounded = at->value != NULL;
    if (!glint_json_floats(at, 6, -far, far, out->box))
        return;
    for (int k = 0; out->bounded && k < 3; k++)
        if (out->box[k] >= out->box[3 + k])
            glint_json_fault(at, "number %d, %g, is not below number %d, %g", k, out->box[k], 3 + k,
                             out->box[3 + k]);
}

void glint_medium_read(struct glint_scene_reader *r, const struct glint_json *at,
                       struct glint_medium *out)
{
    const struct glint_json density = glint_json_member(at, "density");
    const struct glint_json box = glint_json_member(at, "box");
    *out = (struct glint_medium){.id = out->id, .albedo = {1, 1, 1}};
    glint_fields_read(at, glint_medium_fields, &r->scene->arena, out);
    glint_json_require(&density);
    read_box(&box, out);
    if (r->scene->media) // read so far
        glint_json_fault(at, "a scene has one medium at most");
}

void glint_environment_read(struct glint_scene_reader *r, const struct glint_json *at,
                            struct glint_environment *out)
{
    const struct glint_json image = glint_json_member(at, "image");
    *out = (struct glint_environment){{1, 1, 1}, GLINT_NONE, 0};
    glint_fields_read(at, glint_environment_fields, &r->scene->arena, out);
    out->image = glint_scene_reference(&image, &r->images, "image");
}
