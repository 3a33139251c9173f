// gltf_moving.c - one buffer view and one accessor for each member.
#include "tests/unit/gltf_moving.h"

#include "scene/gltf.h"
#include "tests/unit/gltf_expect.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>
#include <stdio.h>
#include <stdlib.h>

const struct gltf_moving gltf_moving_data = {
    .quad =
        {
            .position = {0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0},
            .normal = {0, 0, 1, 0, 0, 1, 0, 0, 1, 0, 0, 1},
            .uv = {0, 1, 1, 1, 1, 0, 0, 0},
            .index = {0, 1, 2, 0, 2, 3},
        },
    .time = {0, 0.5f, 2},
    .move = {{0, 0, 0}, {1, 2, 3}, {4, 5, 6}},
    .turn = {{0, 0, 0, 1}, {0, 0, 1, 0}, {0.6f, 0, 0, 0.8f}},
    .curve = {{{1, 0, 0}, {1, 1, 1}, {2, 0, 0}},
              {{3, 0, 0}, {2, 2, 2}, {4, 0, 0}},
              {{5, 0, 0}, {3, 3, 3}, {6, 0, 0}}},
    .weigh = {{0, 1}, {0.5f, 0.5f}, {1, 0}},
    .turn16 = {{0, 0, 0, 32767}, {0, 0, 32767, 0}, {32767, 0, 0, -32768}},
    .bind = {{1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1},
             {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, -1, 0, 1}},
    .joint = {{0, 9, 9, 9}, {0, 1, 0, 0}, {1, 0, 0, 0}, {1, 1, 1, 1}},
    .weight = {{1, 0, 0, 0}, {1, 1, 0, 0}, {2, 0, 0, 0}, {0, 0, 0, 0}},
    .displace = {{{0, 0, 1}, {0, 0, 1}, {0, 0, 1}, {0, 0, 1}},
                 {{0, 0, 0}, {0, 0, 0}, {0, 2, 0}, {0, 2, 0}}},
    .color = {{255, 0, 51, 102}, {0, 255, 0, 255}, {0, 0, 255, 255}, {255, 255, 255, 0}},
};

static const struct {
    size_t offset;
    unsigned type, count;
    const char *shape;
} member[] = {
#define MEMBER(NAME, TYPE, COUNT, SHAPE)                       \
    {                                                          \
        offsetof(struct gltf_moving, NAME), TYPE, COUNT, SHAPE \
    }
    MEMBER(quad.position, 5126, 4, "\"VEC3\""),
    MEMBER(quad.normal, 5126, 4, "\"VEC3\""),
    MEMBER(quad.uv, 5126, 4, "\"VEC2\""),
    MEMBER(quad.index, 5123, 6, "\"SCALAR\""),
    MEMBER(time, 5126, 3, "\"SCALAR\""),
    MEMBER(move, 5126, 3, "\"VEC3\""),
    MEMBER(turn, 5126, 3, "\"VEC4\""),
    MEMBER(curve, 5126, 9, "\"VEC3\""),
    MEMBER(weigh, 5126, 6, "\"SCALAR\""),
    MEMBER(turn16, 5122, 3, "\"VEC4\",\"normalized\":true"),
    MEMBER(bind, 5126, 2, "\"MAT4\""),
    MEMBER(joint, 5121, 4, "\"VEC4\""),
    MEMBER(weight, 5126, 4, "\"VEC4\""),
    MEMBER(displace[0], 5126, 4, "\"VEC3\""),
    MEMBER(displace[1], 5126, 4, "\"VEC3\""),
    MEMBER(color, 5121, 4, "\"VEC4\",\"normalized\":true"),
#undef MEMBER
};
#define MEMBERS (sizeof member / sizeof *member)

static void print(FILE *out, const char *rest)
{
    fprintf(out,
            "{\"asset\":{\"version\":\"2.0\"},\"buffers\":[{\"byteLength\":%zu}],\"bufferViews\":[",
            sizeof(struct gltf_moving));
    for (size_t i = 0; i < MEMBERS; i++)
        fprintf(out, "%s{\"buffer\":0,\"byteOffset\":%zu,\"byteLength\":%zu}", i ? "," : "",
                member[i].offset,
                (i + 1 < MEMBERS ? member[i + 1].offset : sizeof(struct gltf_moving)) -
                    member[i].offset);
    fprintf(out, "],\"accessors\":[");
    for (size_t i = 0; i < MEMBERS; i++)
        fprintf(out, "%s{\"bufferView\":%zu,\"componentType\":%u,\"count\":%u,\"type\":%s}",
                i ? "," : "", i, member[i].type, member[i].count, member[i].shape);
    fprintf(out, "],%s}", rest);
}

uint8_t *gltf_moving_glb(const char *rest, const struct gltf_moving *data, size_t *size)
{
    char *json = NULL;
    size_t length;
    FILE *out = open_memstream(&json, &length);
    assert_non_null(out);
    print(out, rest);
    fclose(out);
    uint8_t *glb = glb_make(json, data ? data : &gltf_moving_data, sizeof *data, size);
    free(json);
    return glb;
}

struct glint_scene *gltf_moving(const char *rest)
{
    size_t size;
    struct glint_error err = {0};
    struct glint_scene *scene;
    uint8_t *glb = gltf_moving_glb(rest, NULL, &size);
    if (glint_gltf_import(&scene, glb, size, NULL, &err))
        fail_msg("%s: %s", err.count ? err.fault[0].pointer : "", glint_error_text(&err));
    free(glb);
    return scene;
}

void gltf_refuse_moving(const char *rest, const struct gltf_moving *data, const char *pointer,
                        const char *word)
{
    size_t size;
    uint8_t *glb = gltf_moving_glb(rest, data, &size);
    gltf_refused(glb, size, GLINT_E_RANGE, pointer, word);
}
