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

static void transform_member(struct glint_text *t, const float m[16])
{
    glint_text_key(t, "transform");
    glint_text_floats(t, m, 16);
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

static void write_material(struct writer *w, uint32_t i)
{
    struct glint_material *m = &w->scene->material[i];
    glint_fields_write(&w->text, glint_material_fields, m);
    for (size_t k = 0; k < 4; k++) {
        const struct glint_texture *texture = glint_texture_of(m, k);
        if (texture->image == GLINT_NONE)
            continue;
        open_member(&w->text, glint_texture_slots[k].name);
        text_member(&w->text, "image", w->scene->image[texture->image].id);
        glint_fields_write(&w->text, glint_texture_fields, texture);
        glint_text_add(&w->text, "}");
    }
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
    glint_text_key(&w->text, "attributes");
    glint_text_add(&w->text, "[");
    for (unsigned k = 0; glint_mesh_attribute_names[k]; k++) {
        if (!(has & 1u << k))
            continue;
        glint_text_item(&w->text);
        glint_text_string(&w->text, glint_mesh_attribute_names[k]);
    }
    glint_text_add(&w->text, "]");
}

static void write_object(struct writer *w, uint32_t i)
{
    glint_fields_write(&w->text, glint_object_fields, &w->scene->object[i]);
}

static void write_instance(struct writer *w, uint32_t i)
{
    const struct glint_instance *in = &w->scene->instance[i];
    text_member(&w->text, "mesh", w->scene->mesh[in->mesh].id);
    text_member(&w->text, "material", w->scene->material[in->material].id);
    text_member(&w->text, "object", w->scene->object[in->object].id);
    glint_fields_write(&w->text, glint_instance_fields, in);
    transform_member(&w->text, in->transform);
}

static void write_light(struct writer *w, uint32_t i)
{
    glint_fields_write(&w->text, glint_light_fields, &w->scene->light[i]);
    transform_member(&w->text, w->scene->light[i].transform);
}

void glint_camera_write(struct glint_text *t, const struct glint_camera *camera)
{
    glint_fields_write(t, glint_camera_fields, camera);
    transform_member(t, camera->transform);
}

static void write_camera(struct writer *w, uint32_t i)
{
    glint_camera_write(&w->text, &w->scene->camera[i]);
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

static void write_all(struct writer *w)
{
    const struct glint_scene *s = w->scene;
    glint_text_add(&w->text, "{");
    write_collection(w, "images", s->images, s->image, sizeof *s->image, write_image);
    write_collection(w, "materials", s->materials, s->material, sizeof *s->material,
                     write_material);
    write_collection(w, "meshes", s->meshes, s->mesh, sizeof *s->mesh, write_mesh);
    write_collection(w, "objects", s->objects, s->object, sizeof *s->object, write_object);
    write_collection(w, "instances", s->instances, s->instance, sizeof *s->instance,
                     write_instance);
    write_collection(w, "lights", s->lights, s->light, sizeof *s->light, write_light);
    write_collection(w, "cameras", s->cameras, s->camera, sizeof *s->camera, write_camera);
    if (s->has_environment)
        write_environment(w);
    glint_text_add(&w->text, "}\n");
}

glint_status glint_scene_write(const struct glint_scene *scene, char **text, size_t *length,
                               struct glint_asset **asset, size_t *assets, struct glint_error *err)
{
    assert(scene && text && length && asset && assets);
    struct writer w = {.scene = scene, .packing = {*asset, *assets, *assets}};
    write_all(&w);
    *text = glint_text_take(&w.text, length);
    *asset = w.packing.asset;
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
