// document.h - a native scene being written: materials, meshes and named things put in places.
//
// Thread-safety: one owner. Running out of memory ends the program.
#ifndef GLINT_DEMO_DOCUMENT_H
#define GLINT_DEMO_DOCUMENT_H

#include "shapes.h"

#include <cjson/cJSON.h>

struct glint_document {
    cJSON *root, *images, *materials, *meshes, *objects, *instances, *lights, *cameras;
};

void glint_document_init(struct glint_document *d);
void glint_document_finish(struct glint_document *d);

// A material; what is not given is added to what comes back.
struct glint_look {
    double color[3], roughness, metallic, transmission, ior;
};
cJSON *glint_document_material(struct glint_document *d, const char *id,
                               const struct glint_look *look);

// Takes the shape's arrays.
void glint_document_mesh(struct glint_document *d, const char *id, struct glint_shape *shape);

// A primitive of the format, with a member "size" or "radius" and "segments".
void glint_document_sphere(struct glint_document *d, const char *id, int segments);

// Where a thing stands: scaled, turned about +y, leaned about +x (or +z), lifted to `at`.
struct glint_place {
    double at[3];
    double turn, lean, roll; // radians about y, x and z: y after x after z
    double scale[3];
};

// An instance and the object of the same name.
void glint_document_put(struct glint_document *d, const char *name, const char *mesh,
                        const char *material, const char *asset, const struct glint_place *place);

// Aims -z of something at `from` towards `to`: its native transform.
cJSON *glint_document_aim(const double from[3], const double to[3]);

cJSON *glint_document_numbers(const double *value, size_t count);

// A number with five decimals, which is what a scene of this size needs.
cJSON *glint_document_number(double value);

#endif
