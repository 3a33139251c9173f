// scene.c - the end of a scene, and its warnings.
#include "protocol/scene_parts.h"

#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

void glint_scene_destroy(struct glint_scene **scene)
{
    if (!*scene)
        return;
    struct glint_arena arena = (*scene)->arena;
    glint_arena_finish(&arena);
    free(*scene);
    *scene = NULL;
}

static bool room_for_warning(struct glint_scene *s)
{
    if (s->warnings < s->warning_capacity)
        return true;
    const uint32_t capacity = s->warning_capacity ? 2 * s->warning_capacity : 8;
    char **more = glint_arena_array(&s->arena, capacity, sizeof *more);
    if (!more)
        return false;
    if (s->warnings)
        memcpy(more, s->warning, s->warnings * sizeof *more);
    s->warning = more;
    s->warning_capacity = capacity;
    return true;
}

// Without memory the warning is lost, never the scene.
void glint_scene_warn(struct glint_scene *scene, const char *format, ...)
{
    char *text = NULL;
    va_list args;
    va_start(args, format);
    const int n = vasprintf(&text, format, args);
    va_end(args);
    if (n < 0)
        return;
    char *kept = room_for_warning(scene) ? glint_arena_string(&scene->arena, text) : NULL;
    if (kept)
        scene->warning[scene->warnings++] = kept;
    free(text);
}

void glint_texture_init(struct glint_texture *t)
{
    *t = (struct glint_texture){.image = GLINT_NONE, .scale = {1, 1}};
}

void glint_material_init(struct glint_material *m)
{
    *m = (struct glint_material){
        .base_color = {1, 1, 1},
        .opacity = 1,
        .alpha_cutoff = 0.5f,
        .roughness = 1,
        .ior = 1.5f,
        .double_sided = true,
        .normal_scale = 1,
        .specular = 1,
        .specular_color = {1, 1, 1},
        .clearcoat_normal_scale = 1,
        .attenuation_color = {1, 1, 1},
        .collimation = 1,
    };
    for (size_t i = 0; i < GLINT_TEXTURE_SLOTS; i++)
        glint_texture_init(glint_texture_of(m, i));
}

void glint_instance_init(struct glint_instance *in)
{
    *in = (struct glint_instance){.node = GLINT_NONE, .skin = GLINT_NONE, .visible = true};
    memcpy(in->transform, glint_identity, sizeof glint_identity);
}

void glint_light_init(struct glint_light *l)
{
    *l = (struct glint_light){
        .node = GLINT_NONE,
        .color = {1, 1, 1},
        .intensity = 1,
        .outer_cone = 0.785398163f,
        .size = {1, 1},
    };
    memcpy(l->transform, glint_identity, sizeof glint_identity);
}

void glint_camera_init(struct glint_camera *c)
{
    *c = (struct glint_camera){
        .node = GLINT_NONE, .yfov = GLINT_DEFAULT_YFOV, .ymag = 1, .focus_distance = 1};
    memcpy(c->transform, glint_identity, sizeof glint_identity);
}

void glint_node_init(struct glint_node *n)
{
    *n = (struct glint_node){.parent = GLINT_NONE, .rotation = {0, 0, 0, 1}, .scale = {1, 1, 1}};
    memcpy(n->transform, glint_identity, sizeof glint_identity);
}
