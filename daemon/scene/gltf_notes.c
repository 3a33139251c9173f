// gltf_notes.c - warnings about what a file has and the scene cannot show.
#include "scene/gltf_file.h"

#include <stdarg.h>
#include <stdio.h>
#include <string.h>

#define IN_FULL 8u     // of one group
#define MAX_NOTES 400u // of all groups

void glint_gltf_note(struct glint_gltf *g, const char *group, const char *format, ...)
{
    uint32_t *seen = glint_gltf_names_at(&g->noted, &g->scratch, group);
    if (!seen || ++*seen > IN_FULL || ++g->notes > MAX_NOTES)
        return;
    char text[1024];
    va_list args;
    va_start(args, format);
    vsnprintf(text, sizeof text, format, args);
    va_end(args);
    glint_scene_warn(g->scene, "%s", text);
}

static bool listed(const char *const *known, const char *name)
{
    while (*known && strcmp(*known, name) != 0)
        known++;
    return *known != NULL;
}

void glint_gltf_ignored(struct glint_gltf *g, const struct glint_json *object, const char *what,
                        const char *name, const char *const *known)
{
    const struct glint_json extensions = glint_gltf_object(object, "extensions");
    if (!extensions.value)
        return;
    for (const cJSON *e = extensions.value->child; e; e = e->next) {
        char group[160];
        if (listed(known, e->string))
            continue;
        snprintf(group, sizeof group, "%.100s on a %s", e->string, what);
        glint_gltf_note(g, group, "%.100s on %s \"%.200s\" is ignored", e->string, what, name);
    }
}

void glint_gltf_note_the_rest(struct glint_gltf *g)
{
    // lights are read elsewhere; who made the file does not show
    static const char *const known[] = {"KHR_lights_punctual", "KHR_xmp", "KHR_xmp_json_ld", NULL};
    glint_gltf_ignored(g, &g->root, "file", "glTF", known);
    if (g->newer)
        glint_gltf_note(g, "version", "the file asks for glTF %.20s; it is read as 2.0", g->newer);
    if (g->trailing)
        glint_gltf_note(g, "trailing bytes", "%zu bytes after the end of the GLB are ignored",
                        g->trailing);
}

void glint_gltf_notes_end(struct glint_gltf *g)
{
    for (uint32_t i = 0; i < g->noted.capacity; i++) {
        const struct glint_gltf_name *n = &g->noted.slot[i];
        if (n->text && n->value > IN_FULL && g->notes++ <= MAX_NOTES)
            glint_scene_warn(g->scene, "%s: %u more like this", n->text, n->value - IN_FULL);
    }
    if (g->notes > MAX_NOTES)
        glint_scene_warn(g->scene, "the file has more that is ignored than is listed here");
}
