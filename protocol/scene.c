// scene.c - the end of a scene, and its warnings.
#include "protocol/scene.h"

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
