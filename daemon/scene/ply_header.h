// ply_header.h - what a PLY file says that it holds.
//
// Source: Greg Turk, "The PLY Polygon File Format", 1994.
#ifndef GLINT_SCENE_PLY_HEADER_H
#define GLINT_SCENE_PLY_HEADER_H

#include "protocol/status.h"
#include "scene/words.h"

#define GLINT_PLY_ELEMENTS 16u
#define GLINT_PLY_PROPERTIES 64u // of one element

enum glint_ply_format { GLINT_PLY_TEXT, GLINT_PLY_LITTLE, GLINT_PLY_BIG };

enum glint_ply_type {
    GLINT_PLY_I8,
    GLINT_PLY_U8,
    GLINT_PLY_I16,
    GLINT_PLY_U16,
    GLINT_PLY_I32,
    GLINT_PLY_U32,
    GLINT_PLY_F32,
    GLINT_PLY_F64
};

struct glint_ply_property {
    struct glint_word name;
    bool list;
    enum glint_ply_type count, type; // of the list's length; of a value
};

struct glint_ply_element {
    struct glint_word name;
    uint32_t count;
    uint32_t properties;
    struct glint_ply_property property[GLINT_PLY_PROPERTIES];
};

struct glint_ply_header {
    enum glint_ply_format format;
    uint32_t elements;
    struct glint_ply_element element[GLINT_PLY_ELEMENTS];
    size_t bytes;   // of the header
    uint32_t lines; // of it
};

uint32_t glint_ply_size(enum glint_ply_type type); // bytes

// Also checks that what the counts claim can be in a file of this size.
//   GLINT_E_SYNTAX  with the line
glint_status glint_ply_header_read(struct glint_ply_header *out, const uint8_t *bytes, size_t size,
                                   struct glint_error *err);

#endif
