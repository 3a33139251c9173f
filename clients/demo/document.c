#include "document.h"

#include <math.h>

void glint_document_init(struct glint_document *d)
{
    d->root = cJSON_CreateObject();
    d->images = cJSON_AddObjectToObject(d->root, "images");
    d->materials = cJSON_AddObjectToObject(d->root, "materials");
    d->meshes = cJSON_AddObjectToObject(d->root, "meshes");
    d->objects = cJSON_AddObjectToObject(d->root, "objects");
    d->instances = cJSON_AddObjectToObject(d->root, "instances");
    d->lights = cJSON_AddObjectToObject(d->root, "lights");
    d->cameras = cJSON_AddObjectToObject(d->root, "cameras");
}

void glint_document_finish(struct glint_document *d)
{
    cJSON_Delete(d->root);
    *d = (struct glint_document){0};
}

cJSON *glint_document_number(double value)
{
    return cJSON_CreateNumber(round(value * 1e5) / 1e5 + 0.0); // + 0.0: no -0
}

cJSON *glint_document_numbers(const double *value, size_t count)
{
    cJSON *list = cJSON_CreateArray();
    for (size_t i = 0; i < count; i++)
        cJSON_AddItemToArray(list, glint_document_number(value[i]));
    return list;
}

cJSON *glint_document_material(struct glint_document *d, const char *id,
                               const struct glint_look *look)
{
    cJSON *m = cJSON_AddObjectToObject(d->materials, id);
    cJSON_AddItemToObject(m, "base_color", glint_document_numbers(look->color, 3));
    cJSON_AddItemToObject(m, "roughness", glint_document_number(look->roughness));
    if (look->metallic > 0)
        cJSON_AddItemToObject(m, "metallic", glint_document_number(look->metallic));
    if (look->transmission > 0)
        cJSON_AddItemToObject(m, "transmission", glint_document_number(look->transmission));
    if (look->ior > 0)
        cJSON_AddItemToObject(m, "ior", glint_document_number(look->ior));
    return m;
}

void glint_document_mesh(struct glint_document *d, const char *id, struct glint_shape *shape)
{
    cJSON *mesh = cJSON_AddObjectToObject(d->meshes, id);
    cJSON_AddItemToObject(mesh, "positions",
                          glint_document_numbers(shape->position, 3 * shape->vertices));
    cJSON_AddItemToObject(mesh, "normals",
                          glint_document_numbers(shape->normal, 3 * shape->vertices));
    cJSON *indices = cJSON_AddArrayToObject(mesh, "indices");
    for (size_t i = 0; i < 3 * shape->triangles; i++)
        cJSON_AddItemToArray(indices, cJSON_CreateNumber(shape->index[i]));
    glint_shape_finish(shape);
}

void glint_document_sphere(struct glint_document *d, const char *id, int segments)
{
    cJSON *mesh = cJSON_AddObjectToObject(d->meshes, id);
    cJSON_AddStringToObject(mesh, "primitive", "sphere");
    cJSON_AddNumberToObject(mesh, "segments", segments);
}

// a after b
static void multiply(const double a[4], const double b[4], double out[4])
{
    const double q[4] = {a[3] * b[0] + a[0] * b[3] + a[1] * b[2] - a[2] * b[1],
                         a[3] * b[1] - a[0] * b[2] + a[1] * b[3] + a[2] * b[0],
                         a[3] * b[2] + a[0] * b[1] - a[1] * b[0] + a[2] * b[3],
                         a[3] * b[3] - a[0] * b[0] - a[1] * b[1] - a[2] * b[2]};
    for (int i = 0; i < 4; i++)
        out[i] = q[i];
}

static cJSON *rotation(const struct glint_place *p)
{
    double q[4] = {0, 0, sin(p->roll / 2), cos(p->roll / 2)};
    multiply((double[]){sin(p->lean / 2), 0, 0, cos(p->lean / 2)}, q, q);
    multiply((double[]){0, sin(p->turn / 2), 0, cos(p->turn / 2)}, q, q);
    cJSON *list = cJSON_CreateArray();
    for (int i = 0; i < 4; i++) // more digits: its length must be 1
        cJSON_AddItemToArray(list, cJSON_CreateNumber(round(q[i] * 1e9) / 1e9 + 0.0));
    return list;
}

void glint_document_put(struct glint_document *d, const char *name, const char *mesh,
                        const char *material, const char *asset, const struct glint_place *place)
{
    cJSON *object = cJSON_AddObjectToObject(d->objects, name);
    cJSON_AddStringToObject(object, "asset", asset);
    cJSON *instance = cJSON_AddObjectToObject(d->instances, name);
    cJSON_AddStringToObject(instance, "object", name);
    cJSON_AddStringToObject(instance, "mesh", mesh);
    cJSON_AddStringToObject(instance, "material", material);
    cJSON *transform = cJSON_AddObjectToObject(instance, "transform");
    cJSON_AddItemToObject(transform, "translation", glint_document_numbers(place->at, 3));
    cJSON_AddItemToObject(transform, "rotation", rotation(place));
    cJSON_AddItemToObject(transform, "scale", glint_document_numbers(place->scale, 3));
}

static void unit(double v[3])
{
    const double length = sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);
    for (int i = 0; i < 3; i++)
        v[i] /= length;
}

static void cross(const double a[3], const double b[3], double out[3])
{
    out[0] = a[1] * b[2] - a[2] * b[1];
    out[1] = a[2] * b[0] - a[0] * b[2];
    out[2] = a[0] * b[1] - a[1] * b[0];
}

cJSON *glint_document_aim(const double from[3], const double to[3])
{
    double x[3], y[3], z[3] = {from[0] - to[0], from[1] - to[1], from[2] - to[2]};
    unit(z);
    cross((double[]){0, 1, 0}, z, x);
    unit(x);
    cross(z, x, y);
    const double m[16] = {x[0], x[1], x[2], 0, y[0],    y[1],    y[2],    0,
                          z[0], z[1], z[2], 0, from[0], from[1], from[2], 1};
    cJSON *list = cJSON_CreateArray();
    for (int i = 0; i < 16; i++)
        cJSON_AddItemToArray(list, cJSON_CreateNumber(round(m[i] * 1e7) / 1e7 + 0.0));
    return list;
}
