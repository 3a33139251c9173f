// gltf_cameras.c - perspective and orthographic cameras; Assimp does not keep yfov.
//
// How wide the picture is belongs to the job: aspectRatio and xmag are not read.
#include "scene/gltf_file.h"

#include <math.h>
#include <stdio.h>

#define PI_BELOW 3.14159250f // the largest float below pi
#define SMALLEST 1e-6f       // radians, metres

static const char *name_of(struct glint_gltf *g, const struct glint_json *at, uint32_t node)
{
    const char *name = g->node[node].name;
    if (!*name)
        name = glint_gltf_name(g, at);
    char number[24];
    snprintf(number, sizeof number, "camera_%u", node);
    return glint_arena_string(&g->scene->arena, *name ? name : number);
}

static bool read_perspective(const struct glint_json *at, struct glint_camera *c)
{
    const struct glint_json lens = glint_gltf_object(at, "perspective");
    const struct glint_json yfov = glint_json_member(&lens, "yfov");
    return glint_json_require(&lens) && glint_json_require(&yfov) &&
           glint_json_float(&yfov, SMALLEST, PI_BELOW, &c->yfov);
}

static bool read_orthographic(const struct glint_json *at, struct glint_camera *c)
{
    const struct glint_json lens = glint_gltf_object(at, "orthographic");
    const struct glint_json ymag = glint_json_member(&lens, "ymag");
    c->projection = GLINT_ORTHOGRAPHIC;
    if (!glint_json_require(&lens) || !glint_json_require(&ymag) ||
        !glint_json_float(&ymag, -GLINT_MAX_COORDINATE, GLINT_MAX_COORDINATE, &c->ymag))
        return false;
    c->ymag = fabsf(c->ymag);
    return c->ymag >= SMALLEST || glint_json_fault(&ymag, "%g shows nothing", (double)c->ymag);
}

static bool read_lens(const struct glint_json *at, struct glint_camera *c)
{
    static const char *const types[] = {"perspective", "orthographic", NULL};
    const struct glint_json type = glint_json_member(at, "type");
    int choice = 0;
    if (!glint_json_require(&type) || !glint_json_choice(&type, types, &choice))
        return false;
    return choice ? read_orthographic(at, c) : read_perspective(at, c);
}

static void add_camera(struct glint_gltf *g, const struct glint_json *at, uint32_t node)
{
    struct glint_camera *c = &g->scene->camera[g->scene->cameras];
    glint_camera_init(c);
    c->name = (char *)name_of(g, at, node);
    if (!c->name) {
        glint_gltf_nomem(g);
        return;
    }
    if (!read_lens(at, c))
        return;
    if (!glint_gltf_place(g, node, c->transform, &c->node)) {
        glint_gltf_note(g, "camera without direction",
                        "camera \"%.200s\" has no place or direction and is left out", c->name);
        return;
    }
    c->id = glint_gltf_names_id(&g->ids[GLTF_ID_CAMERA], &g->scene->arena, c->name);
    if (c->id)
        g->scene->cameras++;
    else
        glint_gltf_nomem(g);
}

void glint_gltf_read_cameras(struct glint_gltf *g)
{
    g->scene->camera =
        glint_arena_array(&g->scene->arena, g->reached + 2, sizeof *g->scene->camera);
    if (!g->scene->camera) {
        glint_gltf_nomem(g);
        return;
    }
    for (uint32_t k = 0; k < g->reached; k++) {
        const struct glint_json node = glint_gltf_item(g, GLTF_NODES, g->order[k]);
        const uint32_t camera = glint_gltf_index(g, &node, "camera", GLTF_CAMERAS);
        if (camera == GLINT_NONE)
            continue;
        const struct glint_json at = glint_gltf_item(g, GLTF_CAMERAS, camera);
        add_camera(g, &at, g->order[k]);
    }
}
