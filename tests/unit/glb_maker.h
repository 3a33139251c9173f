// glb_maker.h - small GLB files made by the tests' own code.
#ifndef GLINT_TESTS_UNIT_GLB_MAKER_H
#define GLINT_TESTS_UNIT_GLB_MAKER_H

#include <stddef.h>
#include <stdint.h>

// A GLB with this JSON, in which each ' stands for ", and this binary chunk (none if bin is NULL).
// malloc'd; a test without memory ends.
uint8_t *glb_make(const char *json, const void *bin, size_t bin_bytes, size_t *size);

// The binary chunk of glb_quad(): a unit square in the xy plane, two triangles.
struct glb_quad {
    float position[12], normal[12], uv[8];
    uint16_t index[6], pad[2];
};
extern const struct glb_quad glb_quad_data;

// Accessors 0 position, 1 normal, 2 uv, 3 index of glb_quad_data.
#define GLB_QUAD                                                                                   \
    "'asset':{'version':'2.0'},'buffers':[{'byteLength':144}],'bufferViews':["                     \
    "{'buffer':0,'byteLength':48},{'buffer':0,'byteOffset':48,'byteLength':48},"                   \
    "{'buffer':0,'byteOffset':96,'byteLength':32},{'buffer':0,'byteOffset':128,'byteLength':12}]," \
    "'accessors':[{'bufferView':0,'componentType':5126,'count':4,'type':'VEC3'},"                  \
    "{'bufferView':1,'componentType':5126,'count':4,'type':'VEC3'},"                               \
    "{'bufferView':2,'componentType':5126,'count':4,'type':'VEC2'},"                               \
    "{'bufferView':3,'componentType':5123,'count':6,'type':'SCALAR'}]"
#define GLB_QUAD_PRIMITIVE "'attributes':{'POSITION':0,'NORMAL':1,'TEXCOORD_0':2},'indices':3"
#define GLB_QUAD_MESH "'meshes':[{'name':'square','primitives':[{" GLB_QUAD_PRIMITIVE "}]}]"

// {GLB_QUAD, rest} over glb_quad_data.
uint8_t *glb_quad(const char *rest, size_t *size);

#endif
