// shapes.h - triangle meshes made from a few numbers: bodies of revolution, rings, rounded boxes.
//
// Every body is closed and wound counter-clockwise seen from outside; normals are smooth except
// across edges sharper than GLINT_SHAPE_CREASE.
//
// Thread-safety: reentrant. Running out of memory ends the program: there is nothing to save.
#ifndef GLINT_DEMO_SHAPES_H
#define GLINT_DEMO_SHAPES_H

#include <stddef.h>
#include <stdint.h>

#define GLINT_SHAPE_CREASE 0.6 // radians

struct glint_shape {
    double *position, *normal; // [vertices][3]
    uint32_t *index;           // [triangles][3]
    size_t vertices, triangles, vertex_capacity, triangle_capacity;
};

void glint_shape_finish(struct glint_shape *shape);

// The outline of a body of revolution: (radius, height), from the bottom up on its outside.
struct glint_profile {
    double point[256][2];
    size_t points;
};
void glint_profile_add(struct glint_profile *profile, double radius, double height);

// An arc about (radius, height) from angle `from` to `to` (0: outward, pi/2: up) in `steps` pieces.
void glint_profile_arc(struct glint_profile *profile, double radius, double height, double size,
                       double from, double to, int steps);

// Turns the outline about +y from angle `from` to `to` (0: +z, pi/2: +x) in `segments` pieces.
// Closed where the outline begins and ends on the axis, or is closed itself, and the turn is full.
void glint_shape_lathe(struct glint_shape *out, const struct glint_profile *profile, double from,
                       double to, int segments);

// The outline as a sheet, its first number along z, `width` wide about x = 0; facing the side that a
// body of revolution has outside. Smooth all over.
void glint_shape_extrude(struct glint_shape *out, const struct glint_profile *profile,
                         double width);

// A square sheet of height(x, z) about the origin, `size` wide, in steps x steps pieces.
void glint_shape_field(struct glint_shape *out, double size, int steps,
                       void (*at)(double x, double z, double *height, double normal[3]));

// Fills between the outline and the height `base`, in the half plane at `angle`; side 1: facing
// larger angles, -1: smaller ones.
void glint_shape_cap(struct glint_shape *out, const struct glint_profile *profile, double angle,
                     double base, int side);

// A ring about +y.
void glint_shape_torus(struct glint_shape *out, double major, double minor, int around, int across);

// A box centred on the origin, its edges rounded with `radius` in `steps` pieces for 45 degrees.
void glint_shape_box(struct glint_shape *out, const double size[3], double radius, int steps);

// A sphere of radius 1 with gentle bumps, another for each seed.
void glint_shape_pebble(struct glint_shape *out, uint32_t seed, int segments);

#endif
