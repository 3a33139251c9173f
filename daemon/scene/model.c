#include "scene/model.h"

#include "protocol/utf8.h"
#include "scene/gltf_file.h" // ids are made as those of a glTF are

#include <math.h>
#include <stdlib.h>
#include <string.h>

#define DEFAULT_GREY 0.8f // as most programs that write these files show what has no material

struct glint_model_ids {
    struct glint_gltf_names object, mesh, instance, material, image;
};

bool glint_model_nomem(struct glint_model *m)
{
    if (m->err->status != GLINT_E_NOMEM)
        glint_fail(m->err, GLINT_E_NOMEM, "", "no memory to read the file");
    return false;
}

bool glint_model_start(struct glint_model *m, struct glint_error *err)
{
    *m = (struct glint_model){.err = err};
    m->scene = calloc(1, sizeof *m->scene);
    m->ids = calloc(1, sizeof *m->ids);
    return (m->scene && m->ids) || glint_model_nomem(m);
}

glint_status glint_model_finish(struct glint_model *m, struct glint_scene **out)
{
    if (m->ids) {
        glint_gltf_names_finish(&m->ids->object);
        glint_gltf_names_finish(&m->ids->mesh);
        glint_gltf_names_finish(&m->ids->instance);
        glint_gltf_names_finish(&m->ids->material);
        glint_gltf_names_finish(&m->ids->image);
    }
    free(m->ids);
    if (m->err->status)
        glint_scene_destroy(&m->scene);
    *out = m->scene;
    return m->err->status;
}

bool glint_model_room(struct glint_model *m, uint32_t objects, uint32_t meshes, uint32_t materials)
{
    struct glint_scene *s = m->scene;
    s->object = glint_arena_array(&s->arena, objects + 1u, sizeof *s->object);
    s->mesh = glint_arena_array(&s->arena, meshes + 1u, sizeof *s->mesh);
    s->instance = glint_arena_array(&s->arena, meshes + 1u, sizeof *s->instance);
    s->material = glint_arena_array(&s->arena, materials + 1u, sizeof *s->material);
    return (s->object && s->mesh && s->instance && s->material) || glint_model_nomem(m);
}

static char *make_name(struct glint_model *m, const char *name)
{
    char *copy = glint_arena_string(&m->scene->arena, *name ? name : "default");
    if (!copy)
        glint_model_nomem(m);
    else
        glint_utf8_clean(copy);
    return copy;
}

static char *make_id(struct glint_model *m, struct glint_gltf_names *ids, const char *name)
{
    char *id = glint_gltf_names_id(ids, &m->scene->arena, *name ? name : "default");
    if (!id)
        glint_model_nomem(m);
    return id;
}

uint32_t glint_model_material(struct glint_model *m, const char *name)
{
    struct glint_scene *s = m->scene;
    struct glint_material *material = &s->material[s->materials];
    glint_material_init(material);
    for (int i = 0; i < 3; i++)
        material->base_color[i] = DEFAULT_GREY;
    material->id = make_id(m, &m->ids->material, name);
    material->name = make_name(m, name);
    return material->id && material->name ? s->materials++ : GLINT_NONE;
}

uint32_t glint_model_object(struct glint_model *m, const char *name)
{
    struct glint_scene *s = m->scene;
    struct glint_object *object = &s->object[s->objects];
    object->id = make_id(m, &m->ids->object, name);
    object->name = make_name(m, name);
    object->asset = glint_arena_string(&s->arena, "");
    return object->id && object->name && object->asset ? s->objects++ : GLINT_NONE;
}

struct glint_mesh *glint_model_mesh(struct glint_model *m, uint32_t object, uint32_t material,
                                    const char *name)
{
    struct glint_scene *s = m->scene;
    struct glint_mesh *mesh = &s->mesh[s->meshes];
    struct glint_instance *instance = &s->instance[s->instances];
    glint_instance_init(instance);
    mesh->id = make_id(m, &m->ids->mesh, name);
    instance->id = make_id(m, &m->ids->instance, name);
    instance->object = object;
    instance->material = material;
    instance->mesh = s->meshes;
    if (!mesh->id || !instance->id)
        return NULL;
    s->meshes++;
    s->instances++;
    return mesh;
}

char *glint_model_image_id(struct glint_model *m, const char *name)
{
    return make_id(m, &m->ids->image, name);
}

bool glint_model_grow(struct glint_model *m, void **array, uint32_t count, uint32_t *capacity,
                      size_t size)
{
    if (count < *capacity)
        return true;
    if (*capacity > UINT32_MAX / 4)
        return glint_model_nomem(m);
    const uint32_t more = *capacity ? 2 * *capacity : 256;
    void *grown = realloc(*array, more * size);
    if (!grown)
        return glint_model_nomem(m);
    *array = grown;
    *capacity = more;
    return true;
}

// ---- vertices

float glint_model_linear(float value)
{
    return value <= 0.04045f ? value / 12.92f : powf((value + 0.055f) / 1.055f, 2.4f);
}

static bool normalise(float v[3])
{
    const double length = sqrt((double)v[0] * v[0] + (double)v[1] * v[1] + (double)v[2] * v[2]);
    if (!(length > 1e-30 && isfinite(length)))
        return false;
    for (int i = 0; i < 3; i++)
        v[i] = (float)(v[i] / length);
    return true;
}

// Unit, or +z for a triangle without area.
static void face_normal(const struct glint_mesh *m, const uint32_t *t, float out[3])
{
    const float *a = m->position + (size_t)t[0] * 3, *b = m->position + (size_t)t[1] * 3;
    const float *c = m->position + (size_t)t[2] * 3;
    double u[3], v[3], n[3];
    for (int i = 0; i < 3; i++) {
        u[i] = (double)b[i] - a[i];
        v[i] = (double)c[i] - a[i];
    }
    for (int i = 0; i < 3; i++)
        n[i] = u[(i + 1) % 3] * v[(i + 2) % 3] - u[(i + 2) % 3] * v[(i + 1) % 3];
    const double length = sqrt(n[0] * n[0] + n[1] * n[1] + n[2] * n[2]);
    for (int i = 0; i < 3; i++)
        out[i] = length > 0 ? (float)(n[i] / length) : (float)(i == 2);
}

void glint_model_clean_normals(struct glint_mesh *mesh)
{
    static const float zero[3], up[3] = {0, 0, 1};
    float *normal = (float *)mesh->normal;
    for (size_t i = 0; i < mesh->vertices; i++)
        if (!normalise(normal + i * 3))
            memset(normal + i * 3, 0, sizeof zero);
    for (size_t k = 0; k < (size_t)mesh->triangles * 3; k++) {
        float *n = normal + (size_t)mesh->index[k] * 3;
        if (!memcmp(n, zero, sizeof zero))
            face_normal(mesh, mesh->index + k / 3 * 3, n);
    }
    for (size_t i = 0; i < mesh->vertices; i++) // in no triangle
        if (!memcmp(normal + i * 3, zero, sizeof zero))
            memcpy(normal + i * 3, up, sizeof up);
}
