// gltf_moving.h - the data that the tests of animations, skins and morph targets are made of.
#ifndef GLINT_TESTS_UNIT_GLTF_MOVING_H
#define GLINT_TESTS_UNIT_GLTF_MOVING_H

#include "protocol/scene.h"
#include "tests/unit/glb_maker.h"

// The binary chunk: a unit square, and what can be done to it.
struct gltf_moving {
    struct glb_quad quad;
    float time[3];
    float move[3][3];
    float turn[3][4];
    float curve[3][3][3]; // in-tangent, value, out-tangent of each key
    float weigh[3][2];
    int16_t turn16[3][4]; // normalised
    float bind[2][16];
    uint8_t joint[4][4];
    float weight[4][4];
    float displace[2][4][3];
    uint8_t color[4][4]; // normalised
};
extern const struct gltf_moving gltf_moving_data;

// Accessors, in the order of gltf_moving; those of the square are 0 to 3.
enum {
    MOVING_TIME = 4,
    MOVING_MOVE,
    MOVING_TURN,
    MOVING_CURVE,
    MOVING_WEIGH,
    MOVING_TURN16,
    MOVING_BIND,
    MOVING_JOINT,
    MOVING_WEIGHT,
    MOVING_DISPLACE,
    MOVING_DISPLACE_MORE,
    MOVING_COLOR,
};

// A GLB of {asset, buffers, bufferViews, accessors, rest} over `data`, or over gltf_moving_data.
uint8_t *gltf_moving_glb(const char *rest, const struct gltf_moving *data, size_t *size);
// Its scene; the test fails where it is refused.
struct glint_scene *gltf_moving(const char *rest);
// Its refusal, GLINT_E_RANGE.
void gltf_refuse_moving(const char *rest, const struct gltf_moving *data, const char *pointer,
                        const char *word);

// Two morph targets of a primitive, with the accessors above.
#define TARGETS "'targets':[{'POSITION':13},{'POSITION':14,'NORMAL':13}]"

#endif
