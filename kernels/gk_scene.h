// gk_scene.h - a resident scene as kernels read it.
//
// Lengths are metres relative to the scene's own centre, directions are world space. All records
// are immutable while a revision lives.
#ifndef GK_SCENE_H
#define GK_SCENE_H

#include "kernels/gk_types.h"

#define GK_NONE 0xffffffffu

#define GK_TRIANGLE_UV1 1u      // has a gk_uv1; else its second texture coordinates are 0
#define GK_TRIANGLE_COLOURED 2u // has a gk_colour; else its vertex colours are 1

#define GK_TRIANGLE_CURVATURE \
    0xffff0000u // upper half of the mean curvature's bits, 1/m of the mesh

// Shading record of one triangle; its vertices are Embree's business.
struct gk_triangle {
    gk_f32 normal[9]; // at the three vertices, in the space of the mesh; all zero: flat
    gk_f32 uv[6];
    gk_u32 flags; // GK_TRIANGLE_*, and in the upper half the curvature
};
GK_LAYOUT(gk_triangle, 64);

// Second texture coordinates, present only under GK_UV1; record i is triangle i's.
struct gk_uv1 {
    gk_f32 uv[6];
    gk_f32 unused[2];
};
GK_LAYOUT(gk_uv1, 32);

// Vertex colours, present only under GK_VERTEX_COLOURS: linear rgb and opacity; record i is
// triangle i's.
struct gk_colour {
    gk_f32 rgba[12]; // [3 vertices][4]
};
GK_LAYOUT(gk_colour, 48);

// Tangent-space records, present only under GK_NORMAL_MAPS; w is the sign of the bitangent.
struct gk_tangent {
    gk_f32 tangent[12]; // [3 vertices][4]
};
GK_LAYOUT(gk_tangent, 48);

#define GK_INSTANCE_TRANSFORMED \
    1u                          // its linear part is not the identity: normals go through `normal`
#define GK_INSTANCE_MIRRORED 2u // it turns the winding of triangles

struct gk_instance {
    gk_u32 triangle; // first record of its mesh
    gk_u32 material;
    gk_u32 matte; // index of its (object, material, asset); 1 is the background
    gk_u32 flags;
    gk_f32 normal[9]; // inverse transpose up to a positive factor, row-major
    gk_u32 light;     // gk_light of its first triangle, the others follow; GK_NONE: emits nothing
    gk_u32 mover;     // its gk_mover, GK_NONE: it stands still
    gk_f32 shrink;    // metres of its mesh to one of the world, a mean of all directions
};
GK_LAYOUT(gk_instance, 64);

// How an instance moves while the shutter is open, under GK_MOTION. A path has a time in 0..1 of the
// shutter; there are gk_frame.motion_segments segments of equal length, linear in between.
struct gk_mover {
    gk_u32 turn;   // gk_turn of the first key, the others follow; GK_NONE: `normal` holds always
    gk_u32 stride; // triangle (and tangent) records from one key to the next; 0: does not deform
    gk_u32 flow;   // gk_flow of its first triangle, under GK_FLOW; GK_NONE: the mesh is at rest
    gk_u32 unused;
};
GK_LAYOUT(gk_mover, 16);

struct gk_turn {
    gk_f32 normal[9]; // inverse transpose up to a positive factor, one for all keys, row-major
    gk_f32 unused[3];
};
GK_LAYOUT(gk_turn, 48);

// Where a triangle's vertices are a frame earlier and a frame later, relative to the scene's centre.
struct gk_flow {
    gk_f32 before[9], after[9];
    gk_f32 unused[2];
};
GK_LAYOUT(gk_flow, 80);

#define GK_MATERIAL_THIN 1u
#define GK_MATERIAL_TWO_SIDED_EMISSION 2u
#define GK_MATERIAL_CULLED 4u    // opaque and single-sided: the camera does not see its back
#define GK_MATERIAL_BLEND 8u     // shows the share opacity x alpha of itself
#define GK_MATERIAL_ABSORBS 16u  // `attenuation` is not zero
#define GK_MATERIAL_SPECULAR 32u // specular or specular_color differ from 1, or have a texture
#define GK_MATERIAL_COATED 64u

// Members that a path reads together are neighbours, as in gk_light and gk_texture: see GK_READ().
struct gk_material {
    gk_f32 base[3];
    gk_f32 metallic;
    gk_f32 emission[3]; // radiance
    gk_f32 roughness;   // perceptual
    gk_f32 ior;         // >= 1
    gk_f32 transmission;
    gk_f32 fresnel_mean; // hemispherical mean of the dielectric Fresnel reflectance from outside
    gk_u32 energy;       // first entry of its interface in the table of gk_energy.h
    gk_u32 base_texture; // GK_NONE: none, as of all textures
    gk_u32 flags;
    gk_u32 normal_texture;
    gk_f32 normal_scale;
    gk_u32 rough_texture, emission_texture;
    gk_f32 opacity, cutoff; // a hole where opacity x texture alpha < cutoff; cutoff 0: none
    gk_u32 interior;        // rank among the nested dielectrics by (priority, index), 1.., 0: none
    gk_u32 ranked;          // not of this material: the one whose rank is this record's index + 1
    gk_f32 attenuation[3];  // absorption in the solid, 1/m
    gk_f32 collimation;
    gk_f32 specular;
    gk_f32 specular_color[3];
    gk_f32 coat, coat_roughness, coat_normal_scale;
    gk_u32 specular_texture, specular_color_texture, transmission_texture;
    gk_u32 coat_texture, coat_rough_texture, coat_normal_texture;
    gk_u32 unused[9];
};
GK_LAYOUT(gk_material, 192);

#define GK_WRAP_REPEAT 0u
#define GK_WRAP_CLAMP 1u
#define GK_WRAP_MIRROR 2u
#define GK_TEXTURE_NEAREST 16u     // flags: wrap_u | wrap_v << 2 | these; no interpolation
#define GK_TEXTURE_UV1 32u         // reads the second coordinates
#define GK_TEXTURE_TRANSFORMED 64u // `transform` is not the identity

// 8-bit RGBA texels in tiles of 8x8, row-major inside a tile and over tiles.
struct gk_texture {
    gk_u32 width, height;
    gk_u32 offset; // of the first texel in its pool
    gk_u32 flags;
    gk_u32 pool;  // 0..3
    gk_u32 image; // of the scene, to find a record again
    gk_u32 unused[4];
    gk_f32 transform[6]; // row-major 2x3, of (u, v, 1)
};
GK_LAYOUT(gk_texture, 64);

#define GK_LIGHT_TRIANGLE 0u
#define GK_LIGHT_POINT 1u // a spot is a point with a cone
#define GK_LIGHT_SUN 2u
#define GK_LIGHT_ENVIRONMENT 3u
#define GK_LIGHT_KIND 7u
#define GK_LIGHT_TURNED 8u // of a mirrored triangle: a goes to its third vertex, b to its second

struct gk_light {
    gk_f32 a[3]; // triangle: edge to the second vertex; spot: axis
    gk_f32
        b[3]; // triangle: edge to the third; spot: cos of the outer cone, 1/(cos in - cos out), -
    gk_f32 p[3];     // triangle: first vertex; point: position; sun: direction towards it
    gk_u32 kind;     // GK_LIGHT_* | GK_LIGHT_TURNED | two-sided << 4
    gk_f32 L[3];     // triangle: radiance before texture; point: W/sr; sun: W/m^2
    gk_u32 triangle; // record, GK_NONE for other kinds
    gk_u32 material; // of a triangle whose emission is textured, else GK_NONE
    gk_f32 choice;   // probability that the alias table chooses it
};
GK_LAYOUT(gk_light, 64);

// Walker's alias method: entry i is taken with probability `keep`, else `other`.
struct gk_alias {
    gk_f32 keep;
    gk_u32 other;
};
GK_LAYOUT(gk_alias, 8);

// One texel of the equirectangular environment.
struct gk_env_texel {
    gk_f32 L[3];
    gk_f32 unused;
};
GK_LAYOUT(gk_env_texel, 16);

// One cell of the grid that the environment is sampled by, with its alias entry.
struct gk_env_cell {
    gk_f32 keep;
    gk_u32 other;
    gk_f32 pdf; // over the unit square of (u, v), mean 1, > 0
    gk_f32 unused;
};
GK_LAYOUT(gk_env_cell, 16);

#endif
