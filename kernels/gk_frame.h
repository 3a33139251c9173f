// gk_frame.h - what holds for every sample of a job: one constant buffer.
#ifndef GK_FRAME_H
#define GK_FRAME_H

#include "kernels/gk_types.h"

#define GK_CAMERA_KEYS 9

struct gk_frame {
    gk_f32 origin[3];  // of the camera, relative to the scene's centre
    gk_f32 right[3];   // world vector across one pixel on the plane at distance 1
    gk_f32 down[3];    // world vector down one pixel
    gk_f32 corner[3];  // from the origin to the top left corner of the image on that plane
    gk_f32 forward[3]; // unit view axis
    gk_f32 lens_right[3], lens_up[3]; // scaled by the lens radius; 0: pinhole
    gk_f32 focus;                     // metres along `forward`
    gk_u32 has_lens;
    gk_u32 seed;
    gk_u32 max_bounces;
    gk_u32 roulette_start; // bounces before roulette by the share alone; GK_NONE: never
    gk_f32 filter_width;   // pixels, box
    gk_u32 lights;         // entries of the light table
    gk_f32 environment[3]; // constant radiance, or factor of the image
    gk_u32 env_width, env_height, env_cell_width, env_cell_height;
    gk_f32 env_cos, env_sin;    // of its rotation
    gk_f32 env_choice;          // probability that a light sample goes to the environment image
    gk_u32 has_env_image;       // else `environment` is the radiance everywhere
    gk_u32 has_blackman_harris; // else the filter is a box
    gk_u32 frame;
    gk_u32 is_orthographic; // then right, down and corner are in metres, rays along `forward`
    // origin, right, down, corner, forward at each motion key, the first ones again; under
    // GK_CAMERA_MOTION
    gk_f32 camera_key[GK_CAMERA_KEYS][15];
    gk_u32 motion_segments; // between the keys of what moves, 0: nothing does
    gk_u32 light_stride;    // lights from one key to the next, 0: they stand still
    gk_f32 medium_density;  // 1/m
    gk_f32 medium_albedo[3];
    gk_f32 medium_g;
    gk_f32 medium_low[3],
        medium_high[3]; // its box, relative to the scene's centre; may be infinite
    gk_u32 solid;       // GK_COL_SOLID and GK_COL_NESTED at the camera
    gk_u32 nested[4];
    gk_f32 weight; // of a camera ray: radiance is given as in open space, n^2 less than in a solid
    gk_f32 to_after[12],
        to_before[12]; // to (x w, y w, w) in pixels, y down; row-major, a frame off
    gk_f32 grid_origin[3], grid_scale[3]; // light grid: least corner, cells per metre
    gk_u32 grid_size[3], grid_clusters;   // cells along each axis; 0 clusters: no grid
    gk_u32 grid_members, grid_owners;     // words of its table (gk_light_grid.h)
    // Mattes through bounces (gk_transport.h):
    gk_f32 matte_alpha;
    gk_f32 matte_slope, matte_radius; // of a camera sample's cone where it starts
    gk_u32 matte_bins;      // classes by the way from the camera: up to 1 m, 2 m, 4 m, .., beyond
    gk_u32 matte_flags;     // GK_MATTES_*
    gk_u32 roulette_little; // bounces before that of paths that carry little; GK_NONE: never
    gk_u32 grid_many;       // 1: sixteen candidates for a light, and not four
    gk_u32 unused;
};
GK_LAYOUT(gk_frame, 960);

#define GK_MATTES_GLOSSY 1u       // else the weight is 1 of a delta, 0 of anything else
#define GK_MATTES_CLAMP 2u        // Eq. 6, else Eq. 5
#define GK_MATTES_EQ3 4u          // in the place of Eq. 2
#define GK_MATTES_CUT 8u          // diffuse_cut
#define GK_MATTES_ENVIRONMENT 16u // what leaves the scene covers the background, else it is dropped
#define GK_MATTES_CLASSES 32u     // one class for reflection, one for refraction
#define GK_MATTES_OPAQUE 64u      // Eq. 8

// Where the lanes of one launch lie in the image.
// A lane is sample * pixels + pixel; pixels are tiles of 16x16 side by side, row-major in a tile.
struct gk_wave_rect {
    gk_u32 x, y;         // first pixel in the display window
    gk_u32 x_end, y_end; // first pixel beyond the region
    gk_u32 tiles_log2;   // log2 of the tiles in a row
    gk_u32 pixels_log2;  // log2 of the pixels of one sample
    gk_u32 sample;       // index of the first sample
    gk_u32 spread_log2;  // log2 of the pixels from one of the block to the next
    gk_u32 coarser;      // 1: those in even columns of even rows have had the sample; 0: none has
    gk_u32 parts_log2;   // log2 of the sequences that samples alternate between
    gk_u32 pad[2];
};
GK_LAYOUT(gk_wave_rect, 48);

#endif
