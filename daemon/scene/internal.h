// internal.h - the inside of a resident revision, shared by the files that build it.
#ifndef GLINT_SCENE_INTERNAL_H
#define GLINT_SCENE_INTERNAL_H

#include "kernels/gk_scene.h"
#include "scene/geometry.h"
#include "scene/resident.h"

#include <pthread.h>
#include <stdatomic.h>

// One placed mesh as the renderer sees it: a visible instance of the scene, or the quad of an area
// light. Rows are the indices of gk_instance records.
struct glint_row {
    const struct glint_mesh *mesh;
    float transform[16];     // to the scene's centre
    uint32_t material;       // index into the material records
    uint32_t matte;          // key
    uint32_t triangle;       // first record
    uint32_t template_index; // GLINT_NONE: baked into world space
    bool emits;
};

// Where triangles of a mesh went: the kept ones, in order.
struct glint_kept {
    uint32_t *index; // [triangles][3]
    uint32_t triangles;
    uint32_t first; // record of the first, for templates
    uint32_t template_index;
    uint32_t uses; // by visible rows
    bool prepared;
};

struct glint_resident {
    _Atomic uint32_t references;
    glint_devices *devices;
    struct glint_scene *scene;
    struct glint_resident *owner; // of `scene`, retained; NULL: this one
    void (*free_assets)(void *);
    void *assets;
    char revision[65];
    double centre[3];
    double radius; // of a ball around the centre that holds everything, 0 when empty

    struct glint_row *row;
    uint32_t rows;
    struct glint_kept *kept; // [scene->meshes + 1], the last for area lights

    struct glint_mesh quad;        // unit square in xy facing -z, for area lights
    struct glint_matte_key *matte; // [mattes], by key; 0 and 1 unused
    uint32_t mattes;

    pthread_mutex_t mutex; // guards the lazily built robust geometry
    glint_geometry *geometry[2];

    glint_buffer *table[GLINT_TABLES];
    uint32_t triangles, lights, pools;
    struct glint_scene_facts facts;
    struct glint_scene_lighting lighting;
    struct glint_resident_stats stats;
    struct glint_resident_change change;
};

static inline void *glint_table_host(const struct glint_resident *r, enum glint_table table)
{
    return glint_buffer_host(r->table[table]);
}

glint_status glint_resident_build_rows(struct glint_resident *r, struct glint_error *err);
glint_status glint_resident_build_records(struct glint_resident *r, struct glint_error *err);
glint_status glint_resident_build_materials(struct glint_resident *r, struct glint_error *err);
glint_status glint_resident_build_textures(struct glint_resident *r, struct glint_error *err);
glint_status glint_resident_build_lights(struct glint_resident *r, struct glint_error *err);
glint_status glint_resident_build_environment(struct glint_resident *r, struct glint_error *err);
glint_status glint_resident_build_geometry(struct glint_resident *r, bool robust,
                                           glint_geometry **out, struct glint_error *err);

// Index of the texture record for a use of an image, GK_NONE for no texture.
uint32_t glint_resident_texture(const struct glint_resident *r, const struct glint_texture *use,
                                bool srgb);

// Sets ends[axis] where a texture of the material reads uv set `uv_set` so that even whole numbers
// may not be taken off coordinates along that axis: it is clamped, or its transform does not map
// periods to periods.
void glint_material_note_ends(const struct glint_material *m, uint32_t uv_set, bool ends[2]);

// What kernels see as the opacity of a row's triangle at barycentrics (u, v): factor, texture and
// vertex colour. Not of area lights. Any thread, once the records are built.
float glint_resident_opacity(const struct glint_resident *r, uint32_t row, uint32_t primitive,
                             float u, float v);

// The kept triangles of a row's mesh.
struct glint_kept *glint_row_kept(const struct glint_resident *r, const struct glint_row *row);

// World position of a vertex relative to the centre, in double precision.
void glint_row_point(const struct glint_row *row, const float p[3], double out[3]);
// Rotation part of the row's normal matrix (inverse transpose), row-major.
void glint_row_normal_matrix(const struct glint_row *row, double m[9]);
double glint_row_determinant(const struct glint_row *row);

#endif
