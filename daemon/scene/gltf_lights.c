// gltf_lights.c - KHR_lights_punctual, which Assimp turns into other units.
//
// 1 cd is taken as 1 W/sr and 1 lx as 1 W/m^2 (design: light units).
#include "scene/gltf_file.h"

#include <stdio.h>

#define HALF_PI 1.57079637f // pi / 2 rounded up: the angle itself is allowed

static bool read_cone(const struct glint_json *at, struct glint_light *l)
{
    const struct glint_json spot = glint_gltf_object(at, "spot");
    const struct glint_json inner = glint_json_member(&spot, "innerConeAngle");
    const struct glint_json outer = glint_json_member(&spot, "outerConeAngle");
    if (!glint_json_require(&spot) || !glint_json_float(&inner, 0, HALF_PI, &l->inner_cone) ||
        !glint_json_float(&outer, 1e-6f, HALF_PI, &l->outer_cone))
        return false;
    return l->inner_cone < l->outer_cone ||
           glint_json_fault(&spot, "the inner cone of %g is not inside of the outer of %g",
                            (double)l->inner_cone, (double)l->outer_cone);
}

static bool read_light(struct glint_gltf *g, const struct glint_json *at, struct glint_light *l)
{
    static const char *const types[] = {"point", "spot", "directional", NULL};
    static const enum glint_light_kind kinds[] = {GLINT_LIGHT_POINT, GLINT_LIGHT_SPOT,
                                                  GLINT_LIGHT_SUN};
    const struct glint_json type = glint_json_member(at, "type");
    const struct glint_json color = glint_json_member(at, "color");
    const struct glint_json intensity = glint_json_member(at, "intensity");
    int choice = -1;
    if (!glint_json_require(&type) || !glint_json_choice(&type, types, &choice) ||
        !glint_json_floats(&color, 3, 0, GLINT_MAX_RADIANCE, l->color) ||
        !glint_json_float(&intensity, 0, GLINT_MAX_RADIANCE, &l->intensity))
        return false;
    l->kind = kinds[choice];
    if (glint_json_member(at, "range").value)
        glint_gltf_note(g, "range of a light", "range of light \"%.200s\" is ignored", l->name);
    return l->kind != GLINT_LIGHT_SPOT || read_cone(at, l);
}

static void add_light(struct glint_gltf *g, const struct glint_json *at, uint32_t node)
{
    const struct glint_gltf_node *n = &g->node[node];
    struct glint_light *l = &g->scene->light[g->scene->lights];
    glint_light_init(l);
    const char *name = *n->name ? n->name : glint_gltf_name(g, at);
    char number[24];
    snprintf(number, sizeof number, "light_%u", node);
    l->name = glint_arena_string(&g->scene->arena, *name ? name : number);
    l->id = glint_gltf_names_id(&g->ids[GLTF_ID_LIGHT], &g->scene->arena, *name ? name : number);
    if (!l->name || !l->id) {
        glint_gltf_nomem(g);
        return;
    }
    if (!read_light(g, at, l))
        return;
    if (glint_gltf_place(g, node, l->transform, &l->node))
        g->scene->lights++;
    else
        glint_gltf_note(g, "light without direction",
                        "light \"%.200s\" has no place or direction and is left out", l->name);
}

static bool list_lights(struct glint_gltf *g, struct glint_json hold[2], struct glint_gltf_list *l)
{
    size_t count = 0;
    if (glint_gltf_extension(&g->root, "KHR_lights_punctual", hold)) {
        l->at = glint_json_member(&hold[1], "lights");
        glint_json_length(&l->at, &count);
    }
    l->item = glint_arena_array(&g->scratch, count + 1, sizeof *l->item);
    g->scene->light = glint_arena_array(&g->scene->arena, g->reached + 1, sizeof *g->scene->light);
    if (!l->item || !g->scene->light)
        return glint_gltf_nomem(g);
    for (const cJSON *c = count ? l->at.value->child : NULL; c; c = c->next)
        l->item[l->count++] = c;
    return true;
}

static void read_node(struct glint_gltf *g, const struct glint_gltf_list *l, uint32_t i)
{
    const struct glint_json node = glint_gltf_item(g, GLTF_NODES, i);
    struct glint_json use[2];
    if (!glint_gltf_extension(&node, "KHR_lights_punctual", use))
        return;
    const struct glint_json index = glint_json_member(&use[1], "light");
    uint32_t light = 0;
    if (!glint_json_require(&index) || !glint_json_uint(&index, 0, UINT32_MAX, &light))
        return;
    if (light >= l->count) {
        glint_json_fault(&index, "%u: the file has %u lights", light, l->count);
        return;
    }
    const struct glint_json at = glint_json_item(&l->at, l->item[light], light);
    add_light(g, &at, i);
}

void glint_gltf_read_lights(struct glint_gltf *g)
{
    struct glint_json hold[2];
    struct glint_gltf_list l = {0};
    if (!list_lights(g, hold, &l))
        return;
    for (uint32_t k = 0; k < g->reached; k++)
        read_node(g, &l, g->order[k]);
}
