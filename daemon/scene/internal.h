// internal.h - the inside of a resident revision, shared by the files that build it.
#ifndef GLINT_SCENE_INTERNAL_H
#define GLINT_SCENE_INTERNAL_H

#include "kernels/gk_scene.h"
#include "scene/geometry.h"
#include "scene/resident.h"
#include "scene/shape.h"

#include <pthread.h>
#include <stdatomic.h>

// What a triangle record of a mesh holds beside normals and first coordinates; the axes along which
// a texture has an end or is transformed, so that whole periods must stay in its coordinates.
#define GLINT_RECORD_TANGENTS 1u
#define GLINT_RECORD_UV1 2u
#define GLINT_RECORD_COLOURS 4u
#define GLINT_RECORD_FIXED(set, axis) (8u << (2 * (set) + (axis)))

// A mesh as rows draw it: the kept triangles, where their vertices are and where their records lie.
struct glint_kept {
    const struct glint_mesh *mesh;
    struct glint_shape *shape;       // NULL: nothing draws it
    const struct glint_kept *source; // the same of the revision before; only while it is built
    const uint32_t *index;           // [triangles][3]
    uint32_t triangles;
    uint32_t first;        // record of the first
    uint32_t flags;        // GLINT_RECORD_*
    uint32_t uses;         // by visible rows
    uint32_t keys;         // of the arrays below
    const float *position; // [keys][vertices][3]
    const float *normal;   // [keys][vertices][3] or NULL
    const float *tangent;  // [keys][vertices][4] or NULL
    const float *flow;     // [2][vertices][3], a frame earlier and later; NULL: as `position`
    bool deforms;          // vertices are a pose's, not the mesh's
};

// One placed mesh as the renderer sees it: a visible instance of the scene, or the quad of an area
// light. Rows are the indices of gk_instance records.
struct glint_row {
    const struct glint_mesh *mesh;
    uint32_t kept;       // index into glint_resident.kept
    float transform[16]; // to the scene's centre, at the first key
    const float *motion; // [keys of the resident][16] likewise, NULL: stands still
    const float *flow;   // [2][16], a frame earlier and later; NULL: as at the first key
    uint32_t material;   // index into the material records
    uint32_t matte;      // key
    uint32_t triangle;   // first record
    uint32_t instance;   // of the scene, GLINT_NONE: of a light
    bool emits;
};

struct glint_resident {
    _Atomic uint32_t references;
    glint_devices *devices;
    struct glint_scene *scene;
    void (*free_assets)(void *);
    void *assets;
    struct glint_resident *owner; // of `scene`, retained; NULL: this one
    struct glint_pose *pose;      // NULL: the scene as it is
    char revision[65];
    double centre[3];
    double radius;  // of a ball around the centre that holds everything at rest, 0 when empty
    double half[3]; // of a box around the centre that does

    struct glint_row *row;
    uint32_t rows;
    float *motion; // what the rows' members `motion` and `flow` point into
    // [kepts]: the meshes of the scene, the quad of area lights, then what a pose deforms.
    struct glint_kept *kept;
    uint32_t kepts;

    struct glint_mesh quad;        // unit square in xy facing -z, for area lights
    struct glint_matte_key *matte; // [mattes], by key; 0 and 1 unused
    uint32_t mattes;
    struct glint_arena names; // of keys whose own had the ID of another

    pthread_mutex_t building;       // held while a structure is built; before `mutex`
    pthread_mutex_t mutex;          // guards what is built later: the two arrays and `stats`
    glint_geometry *geometry[2][2]; // [enum glint_geometry_kind][robust]
    glint_tracer *tracer;           // of placed bodies, shared by revisions of one origin

    glint_buffer *table[GLINT_TABLES];
    uint32_t triangles, lights, pools;
    struct glint_scene_facts facts;
    struct glint_scene_lighting lighting;
    struct glint_resident_stats stats;
    struct glint_resident_change change;
    bool made; // `change` is what it is: what is built later is no part of it

    const struct glint_resident *from; // only while it is built
};

static inline void *glint_table_host(const struct glint_resident *r, enum glint_table table)
{
    return glint_buffer_host(r->table[table]);
}

// Whether an instance is drawn, and an area light.
bool glint_resident_draws(const struct glint_resident *r, uint32_t instance);
bool glint_resident_shows(const struct glint_resident *r, uint32_t light);

// Lists what may be drawn; keeps what is, from r->from where it is there.
glint_status glint_resident_list_kept(struct glint_resident *r, struct glint_error *err);
glint_status glint_resident_keep(struct glint_resident *r, struct glint_error *err);
void glint_kept_forget(struct glint_resident *r); // where they came from
uint32_t glint_kept_of(const struct glint_resident *r, uint32_t instance);
glint_status glint_resident_find_centre(struct glint_resident *r, struct glint_error *err);

glint_status glint_resident_build_rows(struct glint_resident *r, struct glint_error *err);
glint_status glint_resident_build_mattes(struct glint_resident *r, struct glint_error *err);
// Gives keys other names where two that differ have one ID, but for clashes made by somebody who means
// to: then some stay. Without memory for a name it stays, too.
glint_status glint_resident_tell_mattes_apart(struct glint_resident *r, struct glint_error *err);
glint_status glint_resident_build_records(struct glint_resident *r, struct glint_error *err);
glint_status glint_resident_build_instances(struct glint_resident *r, struct glint_error *err);
glint_status glint_resident_build_materials(struct glint_resident *r, struct glint_error *err);
glint_status glint_resident_build_textures(struct glint_resident *r, struct glint_error *err);
glint_status glint_resident_build_lights(struct glint_resident *r, struct glint_error *err);
glint_status glint_resident_build_environment(struct glint_resident *r, struct glint_error *err);
// Builds a structure into r->geometry; with r->building where others have r by now.
glint_status glint_resident_build_geometry(struct glint_resident *r, enum glint_geometry_kind kind,
                                           bool robust, struct glint_error *err);
// For glint_world_tie(): rows of one mesh with the bits of one transform, or of one motion.
glint_status glint_ties_find(uint32_t **ring, const struct glint_resident *r,
                             struct glint_error *err);

// The buffer of r->from becomes that of r.
void glint_share_table(struct glint_resident *r, enum glint_table table);
// The same where the two hold equal bytes.
bool glint_share_equal_table(struct glint_resident *r, enum glint_table table);
// Takes over what makes up a part where everything that it is made from is equal.
bool glint_share_textures(struct glint_resident *r);
bool glint_share_lights(struct glint_resident *r);
bool glint_share_environment(struct glint_resident *r);
// Whether the poses of every moment that may differ from rest come of the same nodes and animations.
bool glint_share_motion(const struct glint_resident *r);
// Views of the structures of r->from where every row is in its place; else a placed one anew, where
// r->from has one.
glint_status glint_share_geometry(struct glint_resident *r, struct glint_error *err);
// Takes over every table that was made anew and is equal, and says what became of each part.
void glint_share_settle(struct glint_resident *r);

// Index of the texture record for a use of an image, GK_NONE for no texture.
uint32_t glint_resident_texture(const struct glint_resident *r, const struct glint_texture *use);

// Sets ends[axis] where a texture of the material reads uv set `uv_set` so that even whole numbers
// may not be taken off coordinates along that axis: it is clamped, or its transform does not map
// periods to periods.
void glint_material_note_ends(const struct glint_material *m, uint32_t uv_set, bool ends[2]);

// What kernels see as the opacity of a row's triangle at barycentrics (u, v): factor, texture and
// vertex colour. Not of area lights. Any thread, once the records are built.
float glint_resident_opacity(const struct glint_resident *r, uint32_t row, uint32_t primitive,
                             float u, float v);

// Mean luminance of a texture record over a triangle record.
double glint_resident_emission(const struct glint_resident *r, uint32_t texture, uint32_t triangle);

// Keys of everything that moves, 1: nothing does.
static inline uint32_t glint_resident_keys(const struct glint_resident *r)
{
    return r->pose ? r->pose->keys : 1;
}

// The kept triangles of a row's mesh.
struct glint_kept *glint_row_kept(const struct glint_resident *r, const struct glint_row *row);

// World position of a vertex of the row's mesh at a motion key, relative to the centre.
void glint_row_vertex(const struct glint_resident *r, const struct glint_row *row, uint32_t key,
                      uint32_t vertex, double out[3]);
// Whether anything of it differs between motion keys.
bool glint_row_moves(const struct glint_resident *r, const struct glint_row *row);
bool glint_row_mirrors(const struct glint_row *row);

#endif
