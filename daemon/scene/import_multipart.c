// import_multipart.c - a scene in several files: which of them is the scene, and which are left.
#include "scene/form.h"
#include "scene/import_child.h"

#include <string.h>
#include <strings.h>

#define MAX_EXTRA 8u // warnings of files that nothing names

static const struct {
    const char *extension;
    enum glint_scene_type type;
} kinds[] = {
    {".gltf", GLINT_SCENE_GLTF}, {".glb", GLINT_SCENE_GLB}, {".obj", GLINT_SCENE_OBJ},
    {".ply", GLINT_SCENE_PLY},   {".stl", GLINT_SCENE_STL},
};

// GLINT_SCENE_TYPES: it is no scene.
static enum glint_scene_type type_of(const char *name)
{
    const char *dot = strrchr(name, '.');
    for (size_t i = 0; dot && i < sizeof kinds / sizeof *kinds; i++)
        if (!strcasecmp(dot, kinds[i].extension))
            return kinds[i].type;
    return GLINT_SCENE_TYPES;
}

static struct glint_file *find_scene(struct glint_files *files, struct glint_error *err)
{
    struct glint_file *scene = NULL;
    for (uint32_t i = 0; i < files->count; i++) {
        struct glint_file *file = &files->file[i];
        if (type_of(file->name) == GLINT_SCENE_TYPES)
            continue;
        if (scene) {
            glint_fail(err, GLINT_E_RANGE, "", "\"%.200s\" and \"%.200s\": one scene is expected",
                       scene->name, file->name);
            return NULL;
        }
        scene = file;
    }
    if (!scene)
        glint_fail(err, GLINT_E_RANGE, "",
                   "none of the %u files is a scene: .gltf, .glb, .obj, .ply, .stl", files->count);
    return scene;
}

static void note_the_rest(struct glint_scene *scene, const struct glint_files *files)
{
    uint32_t extra = 0;
    for (uint32_t i = 0; i < files->count; i++)
        if (!files->file[i].used && extra++ < MAX_EXTRA)
            glint_scene_warn(scene, "the file \"%.200s\" is not used", files->file[i].name);
    if (extra > MAX_EXTRA)
        glint_scene_warn(scene, "%u more files are not used", extra - MAX_EXTRA);
}

glint_status glint_import_multipart(struct glint_import_work *w, struct glint_error *err)
{
    struct glint_files files = {0};
    glint_status st = glint_form_read(&files, &w->arena, w->boundary, w->bytes, w->size, err);
    struct glint_file *file = st ? NULL : find_scene(&files, err);
    if (!file)
        return err->status;
    file->used = true;
    st = glint_import_file(w, type_of(file->name), file->bytes, file->size, &files, err);
    if (st)
        return st;
    note_the_rest(w->scene, &files);
    return glint_scene_complete_file(w->scene, err);
}
