// resident.h - a scene revision as the renderer wants it: geometry in Embree, shading records,
// lights, textures and tables in shared buffers. Immutable; counted.
//
// Threads: create by a loader; retain/release and the queries by any thread.
#ifndef GLINT_SCENE_RESIDENT_H
#define GLINT_SCENE_RESIDENT_H

#include "device/device.h"
#include "protocol/film.h"
#include "protocol/scene.h"
#include "scene/facts.h"
#include "scene/pose.h"

typedef struct glint_resident glint_resident;

// What became of one part of a resident scene, beside the revision that it was made from.
enum glint_part {
    GLINT_PART_MESHES,      // kept triangles and their records
    GLINT_PART_TEXTURES,    // pools and texture records
    GLINT_PART_MATERIALS,   // material records
    GLINT_PART_INSTANCES,   // rows, mattes, movers
    GLINT_PART_LIGHTS,      // light table and its grid
    GLINT_PART_ENVIRONMENT, // texels and cells
    GLINT_PART_BVH,         // traversal structures of meshes
    GLINT_PART_PLACEMENT,   // the top-level structure over them
    GLINT_PARTS
};
extern const char *const glint_part_name[GLINT_PARTS];

enum glint_part_fate {
    GLINT_KEPT,     // made of the same
    GLINT_LATER,    // made of other things, when a job asks for it
    GLINT_UPLOADED, // written again
    GLINT_REBUILT
};

struct glint_resident_change {
    enum glint_part_fate fate[GLINT_PARTS];
    double seconds[GLINT_PARTS];
    uint32_t items[GLINT_PARTS]; // meshes, textures, ... made anew
};

// Builds from `scene`, which must have been completed (camera, environment). Takes `scene` on
// success, unless it is that of `from`: then `from` lives as long as what is made. The assets that it
// borrows must live until `free_assets(assets)` is called, when the last reference goes (may be
// NULL).
struct glint_resident_order {
    struct glint_scene *scene;
    void (*free_assets)(void *);
    void *assets;
    // Where what moves is; NULL: everything as the scene has it. Borrowed for the call.
    const struct glint_pose *pose;
    // The revision before, whose parts are shared where the scene has them unchanged; NULL: none.
    // Borrowed: what is shared is counted.
    const glint_resident *from;
};
glint_status glint_resident_create(glint_resident **out, glint_devices *devices,
                                   const struct glint_resident_order *order,
                                   struct glint_error *err);
// What was made anew and what was shared. Structures that `from` has for live jobs are made at once,
// those of batch jobs and of moments of an animation when one asks for them: GLINT_LATER where these
// will differ.
const struct glint_resident_change *glint_resident_change(const glint_resident *resident);
glint_resident *glint_resident_retain(glint_resident *resident);
void glint_resident_release(glint_resident **resident);

const struct glint_scene *glint_resident_scene(const glint_resident *resident);

// The revision that frames name in their header: 64 hex digits, set once by whoever publishes it,
// "" before.
void glint_resident_set_revision(glint_resident *resident, const char *revision);
const char *glint_resident_revision(const glint_resident *resident);

struct glint_resident_stats {
    uint64_t triangles, instanced_triangles; // stored, and as seen with instances expanded
    uint64_t geometry_bytes, bvh_bytes, record_bytes, texture_bytes, light_bytes;
    double geometry_seconds, bvh_seconds, texture_seconds, light_seconds;
    uint32_t lights;  // emitters of all kinds
    uint32_t dropped; // degenerate triangles left out
};
void glint_resident_stats(const glint_resident *resident, struct glint_resident_stats *out);

// What the scene contains, as far as the effects table asks.
const struct glint_scene_facts *glint_resident_facts(const glint_resident *resident);

// Numbers for the frame constants.
struct glint_scene_lighting {
    uint32_t lights;      // entries of the light table
    float environment[3]; // radiance, or factor of the image
    uint32_t env_width, env_height, env_cell_width, env_cell_height;
    float env_rotation;    // radians
    float env_choice;      // share of light samples that go to the environment image
    uint32_t light_stride; // entries of the light table from one motion key to the next, 0: still
    float grid_origin[3];  // light grid: least corner, relative to the centre; cells per metre
    float grid_scale[3];
    uint32_t grid_size[3]; // cells along each axis, 0: no grid
    uint32_t grid_clusters;
    bool grid_many;                     // sixteen candidates for a light, and not four
    uint32_t grid_members, grid_owners; // words of the light cells' table
};
const struct glint_scene_lighting *glint_resident_lighting(const glint_resident *resident);

// Segments of the motion keys, 0: nothing moves while the shutter is open.
uint32_t glint_resident_segments(const glint_resident *resident);

// The scene's own centre: positions in records and rays are relative to it.
void glint_resident_centre(const glint_resident *resident, double centre[3]);

// Buffers by purpose, never NULL (tables that a scene does not need hold one dummy entry).
enum glint_table {
    GLINT_TABLE_TRIANGLES,
    GLINT_TABLE_TANGENTS,
    GLINT_TABLE_UV1,
    GLINT_TABLE_COLOURS,
    GLINT_TABLE_INSTANCES,
    GLINT_TABLE_MOVERS,
    GLINT_TABLE_TURNS,
    GLINT_TABLE_FLOWS,
    GLINT_TABLE_MATERIALS,
    GLINT_TABLE_TEXTURES,
    GLINT_TABLE_POOL0,
    GLINT_TABLE_POOL1,
    GLINT_TABLE_POOL2,
    GLINT_TABLE_POOL3,
    GLINT_TABLE_DECODE,
    GLINT_TABLE_LIGHTS,
    GLINT_TABLE_ALIAS,
    GLINT_TABLE_LIGHT_CELLS,
    GLINT_TABLE_ENERGY,
    GLINT_TABLE_ENV_TEXELS,
    GLINT_TABLE_ENV_CELLS,
    GLINT_TABLES
};
glint_buffer *glint_resident_table(const glint_resident *resident, enum glint_table table);

// Traversal structures. Flat: one level, of the highest quality, all but often drawn large meshes
// baked into the world; what batch jobs trace. Placed: a structure for each mesh, shared between
// revisions, under a top level of instances; what live jobs trace, because a moved object costs a
// new top level only. Each is built when it is first asked for; that which batch jobs trace at once,
// unless the scene is large.
struct glint_geometry;
enum glint_geometry_kind { GLINT_GEOMETRY_FLAT, GLINT_GEOMETRY_PLACED };
glint_status glint_resident_geometry(glint_resident *resident, enum glint_geometry_kind kind,
                                     bool robust, const struct glint_geometry **out,
                                     struct glint_error *err);
// One like the flat one, built in an eighth of the time: for pictures that are thrown away, as rays
// that meet an edge or several surfaces at once may find another than those of the flat one do. The
// caller's, to be destroyed before the scene is released.
glint_status glint_resident_sketch(glint_resident *resident, bool robust,
                                   struct glint_geometry **out, struct glint_error *err);
// Whether structures take long enough to be sketched.
bool glint_resident_is_large(const glint_resident *resident);
// Whether it is built by now.
bool glint_resident_has_geometry(const glint_resident *resident, enum glint_geometry_kind kind,
                                 bool robust);
// Matte keys of the slot tables: 1 is the background, 2.. are the scene's (object, material, asset)
// triples, hidden ones too; then the names that no instance uses, in keys that nothing has. Returns
// the number of keys, the two first included.
uint32_t glint_resident_mattes(const glint_resident *resident, const struct glint_matte_key **keys);

#endif
