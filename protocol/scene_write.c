// scene_write.c - the canonical native JSON.
//
// Equal scenes give equal bytes: fixed order of members, every default spelled out, one way to
// write a number. One item on a line.
#include "protocol/scene_parts.h"

#include <assert.h>
#include <stdlib.h>

struct writer {
    const struct glint_scene *scene;
    struct glint_text text;
    struct glint_packing packing;
    bool failed;
};

static void open_member(struct glint_text *t, const char *key)
{
    glint_text_key(t, key);
    glint_text_add(t, "{");
}

static void text_member(struct glint_text *t, const char *key, const char *value)
{
    glint_text_key(t, key);
    glint_text_string(t, value);
}

static void floats_member(struct glint_text *t, const char *key, const float *value, size_t count)
{
    glint_text_key(t, key);
    glint_text_floats(t, value, count);
}

static void transform_member(struct glint_text *t, const float m[16])
{
    floats_member(t, "transform", m, 16);
}

static void write_image(struct writer *w, uint32_t i)
{
    const struct glint_image *image = &w->scene->image[i];
    char hash[65] = "";
    if (!image->asset[0])
        w->failed |= !glint_pack_image(&w->packing, image, hash);
    text_member(&w->text, "asset", image->asset[0] ? image->asset : hash);
    glint_fields_write(&w->text, glint_image_fields, image);
}

static void write_texture(struct writer *w, const char *name, const struct glint_texture *texture)
{
    if (texture->image == GLINT_NONE)
        return;
    open_member(&w->text, name);
    text_member(&w->text, "image", w->scene->image[texture->image].id);
    glint_fields_write(&w->text, glint_texture_fields, texture);
    glint_text_add(&w->text, "}");
}

static void write_material(struct writer *w, uint32_t i)
{
    struct glint_material *m = &w->scene->material[i];
    glint_fields_write(&w->text, glint_material_fields, m);
    for (size_t k = 0; k < GLINT_TEXTURE_SLOTS; k++)
        write_texture(w, glint_texture_slots[k].name, glint_texture_of(m, k));
}

// The names whose bits are set, of which the first is `first`.
static void names_member(struct glint_text *t, const char *key, const char *const *names,
                         unsigned first, unsigned set)
{
    glint_text_key(t, key);
    glint_text_add(t, "[");
    for (unsigned k = 0; names[k]; k++) {
        if (!(set & first << k))
            continue;
        glint_text_item(t);
        glint_text_string(t, names[k]);
    }
    glint_text_add(t, "]");
}

static void write_targets(struct glint_text *t, const struct glint_mesh *m, unsigned has)
{
    glint_text_print(t, ",\"targets\":%u", m->targets);
    names_member(t, "target_attributes", glint_target_attribute_names, GLINT_MESH_TARGET_NORMAL,
                 has);
    glint_text_key(t, "target_weights");
    glint_text_add(t, "[");
    for (uint32_t i = 0; i < m->targets; i++) {
        glint_text_item(t);
        glint_text_float(t, m->target_weight ? m->target_weight[i] : 0);
    }
    glint_text_add(t, "]");
}

static void write_mesh(struct writer *w, uint32_t i)
{
    const struct glint_mesh *m = &w->scene->mesh[i];
    const unsigned has = glint_mesh_attributes(m);
    char hash[65] = "";
    if (!m->asset[0])
        w->failed |= !glint_pack_mesh(&w->packing, m, hash);
    text_member(&w->text, "asset", m->asset[0] ? m->asset : hash);
    glint_text_print(&w->text, ",\"vertices\":%u,\"triangles\":%u", m->vertices, m->triangles);
    names_member(&w->text, "attributes", glint_mesh_attribute_names, 1, has);
    if (m->targets)
        write_targets(&w->text, m, has);
}

static void write_object(struct writer *w, uint32_t i)
{
    glint_fields_write(&w->text, glint_object_fields, &w->scene->object[i]);
}

static void node_member(struct writer *w, const char *key, uint32_t node)
{
    if (node != GLINT_NONE)
        text_member(&w->text, key, w->scene->node[node].id);
}

static void write_node(struct writer *w, uint32_t i)
{
    const struct glint_node *n = &w->scene->node[i];
    glint_fields_write(&w->text, glint_node_fields, n);
    node_member(w, "parent", n->parent);
    if (n->matrix) {
        transform_member(&w->text, n->transform);
        return;
    }
    open_member(&w->text, "transform");
    floats_member(&w->text, "translation", n->translation, 3);
    floats_member(&w->text, "rotation", n->rotation, 4);
    floats_member(&w->text, "scale", n->scale, 3);
    glint_text_add(&w->text, "}");
}

static void write_skin(struct writer *w, uint32_t i)
{
    const struct glint_skin *skin = &w->scene->skin[i];
    char hash[65] = "";
    if (!skin->asset[0])
        w->failed |= !glint_pack_skin(&w->packing, skin, hash);
    glint_text_key(&w->text, "joints");
    glint_text_add(&w->text, "[");
    for (uint32_t j = 0; j < skin->joints; j++) {
        glint_text_item(&w->text);
        glint_text_string(&w->text, w->scene->node[skin->joint[j]].id);
    }
    glint_text_add(&w->text, "]");
    text_member(&w->text, "asset", skin->asset[0] ? skin->asset : hash);
}

static void write_instance(struct writer *w, uint32_t i)
{
    const struct glint_instance *in = &w->scene->instance[i];
    text_member(&w->text, "mesh", w->scene->mesh[in->mesh].id);
    text_member(&w->text, "material", w->scene->material[in->material].id);
    text_member(&w->text, "object", w->scene->object[in->object].id);
    node_member(w, "node", in->node);
    if (in->skin != GLINT_NONE)
        text_member(&w->text, "skin", w->scene->skin[in->skin].id);
    glint_fields_write(&w->text, glint_instance_fields, in);
    transform_member(&w->text, in->transform);
    if (in->weight)
        floats_member(&w->text, "weights", in->weight, w->scene->mesh[in->mesh].targets);
}

static void write_channel(struct writer *w, const struct glint_animation_channel *c)
{
    char hash[65] = "";
    if (!c->asset[0])
        w->failed |= !glint_pack_channel(&w->packing, c, hash);
    open_member(&w->text, c->id);
    node_member(w, "node", c->node);
    glint_fields_write(&w->text, glint_channel_fields, c);
    text_member(&w->text, "asset", c->asset[0] ? c->asset : hash);
    glint_text_print(&w->text, ",\"keys\":%u}", c->keys);
}

static void write_animation(struct writer *w, uint32_t i)
{
    const struct glint_animation *a = &w->scene->animation[i];
    glint_fields_write(&w->text, glint_animation_fields, a);
    open_member(&w->text, "channels");
    for (uint32_t c = 0; c < a->channels; c++)
        write_channel(w, &a->channel[c]);
    glint_text_add(&w->text, "}");
}

static void write_light(struct writer *w, uint32_t i)
{
    glint_fields_write(&w->text, glint_light_fields, &w->scene->light[i]);
    node_member(w, "node", w->scene->light[i].node);
    transform_member(&w->text, w->scene->light[i].transform);
}

// The angle or height that the projection has no use for is written as its default where it is
// unset, so that a patch can switch the projection alone.
void glint_camera_write(struct glint_text *t, const struct glint_camera *camera)
{
    struct glint_camera c = *camera;
    c.yfov = c.yfov > 0 ? c.yfov : GLINT_DEFAULT_YFOV;
    c.ymag = c.ymag > 0 ? c.ymag : 1;
    glint_fields_write(t, glint_camera_fields, &c);
    transform_member(t, camera->transform);
}

static void write_camera(struct writer *w, uint32_t i)
{
    node_member(w, "node", w->scene->camera[i].node);
    glint_camera_write(&w->text, &w->scene->camera[i]);
}

static void write_medium(struct writer *w, uint32_t i)
{
    const struct glint_medium *m = &w->scene->medium[i];
    glint_fields_write(&w->text, glint_medium_fields, m);
    if (m->bounded)
        floats_member(&w->text, "box", m->box, 6);
}

static void write_collection(struct writer *w, const char *name, uint32_t count, const void *items,
                             size_t item_bytes, void (*write)(struct writer *, uint32_t))
{
    if (!count)
        return;
    glint_text_item(&w->text);
    glint_text_add(&w->text, "\n");
    open_member(&w->text, name);
    for (uint32_t i = 0; i < count; i++) {
        const char *const *id = (const void *)((const char *)items + i * item_bytes);
        glint_text_item(&w->text);
        glint_text_add(&w->text, "\n");
        open_member(&w->text, *id);
        write(w, i);
        glint_text_add(&w->text, "}");
    }
    glint_text_add(&w->text, "}");
}

static void write_environment(struct writer *w)
{
    const struct glint_environment *e = &w->scene->environment;
    glint_text_item(&w->text);
    glint_text_add(&w->text, "\n");
    open_member(&w->text, "environment");
    glint_fields_write(&w->text, glint_environment_fields, e);
    if (e->image != GLINT_NONE)
        text_member(&w->text, "image", w->scene->image[e->image].id);
    glint_text_add(&w->text, "}");
}

#define WRITE(MEMBER, COUNT, ITEM) \
    write_collection(w, #COUNT, s->COUNT, s->MEMBER, sizeof *s->MEMBER, write_##ITEM)

static void write_all(struct writer *w)
{
    const struct glint_scene *s = w->scene;
    glint_text_add(&w->text, "{");
    glint_text_key(&w->text, "fps");
    glint_text_float(&w->text, s->fps > 0 ? s->fps : GLINT_DEFAULT_FPS);
    WRITE(image, images, image);
    WRITE(material, materials, material);
    WRITE(mesh, meshes, mesh);
    WRITE(object, objects, object);
    WRITE(node, nodes, node);
    WRITE(skin, skins, skin);
    WRITE(instance, instances, instance);
    WRITE(animation, animations, animation);
    WRITE(light, lights, light);
    WRITE(camera, cameras, camera);
    WRITE(medium, media, medium);
    if (s->has_environment)
        write_environment(w);
    glint_text_add(&w->text, "}\n");
}

glint_status glint_scene_write(const struct glint_scene *scene, char **text, size_t *length,
                               struct glint_asset **asset, size_t *assets, struct glint_error *err)
{
    assert(scene && text && length && asset && assets);
    struct writer w = {.scene = scene};
    w.failed = !glint_packing_start(&w.packing, *asset, *assets);
    if (!w.failed)
        write_all(&w);
    *text = glint_text_take(&w.text, length);
    *asset = w.packing.asset;
    glint_hashes_finish(&w.packing.there);
    if (*text && !w.failed) {
        *assets = w.packing.count;
        return GLINT_OK;
    }
    free(*text);
    *text = NULL;
    while (w.packing.count > *assets)
        free((void *)w.packing.asset[--w.packing.count].bytes);
    return glint_fail(err, GLINT_E_NOMEM, "", "no memory to write the scene");
}
