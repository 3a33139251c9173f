// mtl.h - material libraries of OBJ files: what a file says, before it is made a material.
#ifndef GLINT_SCENE_MTL_H
#define GLINT_SCENE_MTL_H

#include "scene/obj_file.h"

enum glint_mtl_map {
    GLINT_MTL_DIFFUSE,
    GLINT_MTL_OPACITY,
    GLINT_MTL_EMISSION,
    GLINT_MTL_ROUGHNESS,
    GLINT_MTL_METALLIC,
    GLINT_MTL_NORMAL,
    GLINT_MTL_BUMP, // heights, or normals as some programs have it
    GLINT_MTL_MAPS
};

struct glint_mtl_texture {
    const char *path; // NULL: none
    uint32_t line;
    float offset[2], scale[2], bump;
    bool clamp;
};

// Numbers are NaN where the file does not say.
struct glint_mtl {
    struct glint_word name;
    const char *file; // that it is in
    float kd[3], ks[3], ke[3], tf[3];
    float ns, ni, d, tr;
    float pr, pm, pc, pcr;
    float illum;
    struct glint_mtl_texture map[GLINT_MTL_MAPS];
};

struct glint_mtl_list {
    struct glint_mtl *item; // malloc'd
    uint32_t count, capacity;
};

// mtl.c: appends the materials of one library. Paths are in o's scratch arena.
bool glint_mtl_read(struct glint_obj *o, struct glint_mtl_list *list,
                    const struct glint_file *file);

// mtl_material.c: fills the material in.
void glint_mtl_convert(struct glint_obj *o, const struct glint_mtl *from,
                       struct glint_material *to);

// mtl_images.c: textures of a material. Pictures are decoded once each.
struct glint_mtl_images {
    struct glint_obj *obj;
    struct glint_pixels *pixels;  // of each file
    bool *decoded;                // tried, and .pixels is NULL where that failed
    struct glint_gltf_names made; // images of the scene by what they are made of: number + 1
};
bool glint_mtl_images_start(struct glint_mtl_images *images, struct glint_obj *o,
                            uint32_t materials);
void glint_mtl_images_finish(struct glint_mtl_images *images);
void glint_mtl_textures(struct glint_mtl_images *images, const struct glint_mtl *from,
                        struct glint_material *to);

#endif
