// obj_file.h - an OBJ file as it is read, and the steps that turn it into a scene. For obj*.c and
// mtl*.c only.
//
// Sources: Wavefront, "Object Files (.obj)" and "Material Library Files (.mtl)", 1995; the physical
// parameters Pr, Pm, Pc, Pcr and norm as Blender and others write them.
#ifndef GLINT_SCENE_OBJ_FILE_H
#define GLINT_SCENE_OBJ_FILE_H

#include "scene/gltf_file.h" // sets of names
#include "scene/model.h"
#include "scene/words.h"

// Numbers of positions, coordinates and normals, from 0; GLINT_NONE: not given.
struct glint_obj_corner {
    uint32_t position, uv, normal;
};

struct glint_obj_triangle {
    uint32_t part, smooth; // smoothing group, 0: none
    struct glint_obj_corner corner[3];
};

// The triangles of one object and material.
struct glint_obj_part {
    uint32_t object, material; // into the lists below
    uint32_t triangles;
};

struct glint_obj_floats {
    float *value;
    uint32_t count, capacity; // of tuples
};

struct glint_obj_list {
    struct glint_gltf_names index; // name -> number + 1
    const char **name;
    uint32_t count, capacity;
};

struct glint_obj {
    struct glint_model model;
    struct glint_files *files; // NULL: there cannot be any
    struct glint_arena scratch;
    struct glint_words words;
    uint32_t positions, uvs, normals; // in the whole file
    struct glint_obj_floats position, color, uv, normal;
    bool has_color;
    struct glint_obj_list objects, materials, libraries;
    uint32_t object, material, smooth; // of the next face
    struct glint_obj_part *part;
    uint32_t parts, part_capacity, current; // current: GLINT_NONE until a face needs it
    struct glint_gltf_names part_index;
    struct glint_obj_triangle *triangle;
    uint32_t triangles, triangle_capacity;
    struct glint_obj_corner *corner; // of the face being read
    uint32_t corners, corner_capacity;
    float (*point)[3];
    uint32_t (*cut)[3];
    uint32_t point_capacity, cut_capacity;
    uint32_t *scene_material; // of each name in `materials`
    uint32_t *scene_object;   // of each name in `objects`, GLINT_NONE: it has no faces
    uint32_t left_out;        // lines, points, faces of less than three corners
    uint32_t unknown;         // lines that begin with no word of OBJ
};

// The number of a name in the list, GLINT_NONE without memory.
uint32_t glint_obj_list_add(struct glint_obj *o, struct glint_obj_list *list,
                            struct glint_word name);

// A warning for the user; what a file says may be in it.
void glint_obj_warn(struct glint_obj *o, const char *format, ...)
    __attribute__((format(printf, 2, 3)));

// obj_meshes.c: vertices of smoothing groups get normals, parts become meshes.
void glint_obj_smooth(struct glint_obj *o);
void glint_obj_make_meshes(struct glint_obj *o);

// mtl.c: fills scene_material from the libraries.
void glint_obj_read_materials(struct glint_obj *o);

#endif
