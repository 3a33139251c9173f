// gltf.c - the steps of a glTF import, in order.
#include "scene/gltf.h"

#include "scene/gltf_file.h"

#include <stdlib.h>

#define FPS 24.0f // a file says nothing of frames

static void read_scene(struct glint_gltf *g)
{
    static void (*const steps[])(struct glint_gltf *) = {
        glint_gltf_read_nodes,         glint_gltf_read_animations, glint_gltf_read_skins,
        glint_gltf_make_frames,        glint_gltf_read_materials,  glint_gltf_read_meshes,
        glint_gltf_drop_idle_channels, glint_gltf_read_lights,     glint_gltf_read_cameras,
        glint_gltf_note_the_rest,
    };
    for (size_t i = 0; i < sizeof steps / sizeof *steps; i++) {
        // without nodes and their frames nothing else can be read; others report faults together
        if ((i == 1 || i == 4) && g->err->status)
            return;
        if (g->err->status == GLINT_E_NOMEM)
            return;
        steps[i](g);
    }
    glint_gltf_notes_end(g);
}

glint_status glint_gltf_import(struct glint_scene **out, const uint8_t *bytes, size_t size,
                               struct glint_files *files, struct glint_error *err)
{
    *out = NULL;
    struct glint_error own = {0};
    struct glint_gltf g = {.err = err ? err : &own, .files = files};
    glint_status st = glint_gltf_split(&g, bytes, size);
    if (!st)
        st = glint_gltf_open(&g);
    if (!st) {
        g.scene = calloc(1, sizeof *g.scene);
        st = g.scene ? GLINT_OK : glint_fail(g.err, GLINT_E_NOMEM, "", "no memory for a scene");
    }
    if (!st) {
        g.scene->fps = FPS;
        read_scene(&g);
        st = g.err->status;
    }
    glint_gltf_close(&g);
    if (st)
        glint_scene_destroy(&g.scene);
    glint_error_finish(&own);
    *out = g.scene;
    return st;
}
