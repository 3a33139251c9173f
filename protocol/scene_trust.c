// scene_trust.c - what an earlier parse has checked already.
#include "protocol/scene_parts.h"

#include <string.h>

// ---- meshes

static bool same_mesh(const struct glint_mesh *a, const struct glint_mesh *b)
{
    return strcmp(a->asset, b->asset) == 0 && a->vertices == b->vertices &&
           a->triangles == b->triangles && a->targets == b->targets &&
           glint_mesh_attributes(a) == glint_mesh_attributes(b);
}

static bool index_meshes(struct glint_scene_trust *t)
{
    for (uint32_t i = 0; i < t->scene->meshes; i++)
        if (t->scene->mesh[i].asset[0] && !glint_hashes_add(&t->meshes, t->scene->mesh[i].asset, i))
            return false;
    return true;
}

// The mesh that follows the one found last, or one of the asset's name.
static const struct glint_mesh *find_mesh(struct glint_scene_reader *r, const struct glint_mesh *m)
{
    struct glint_scene_trust *t = &r->trust;
    if (!t->scene || !t->scene->meshes)
        return NULL;
    const uint32_t guess = t->next_mesh < t->scene->meshes ? t->next_mesh : 0;
    uint32_t at = guess;
    if (!same_mesh(m, &t->scene->mesh[guess])) {
        if (!t->meshes.used && !index_meshes(t)) {
            glint_scene_no_memory(r);
            return NULL;
        }
        at = glint_hashes_find(&t->meshes, m->asset);
    }
    if (at == GLINT_NONE || !same_mesh(m, &t->scene->mesh[at]))
        return NULL;
    t->next_mesh = at + 1;
    return &t->scene->mesh[at];
}

// Arrays that the check had to replace are copied; the rest are in the asset.
static bool copy_replaced(struct glint_scene_reader *r, struct glint_mesh *m,
                          const struct glint_mesh *from)
{
    const struct glint_mesh_layout layout = glint_mesh_layout(m, glint_mesh_attributes(m));
    const char *bytes = (const char *)from->position;
    for (size_t i = 0; i < GLINT_MESH_ARRAYS; i++) {
        const void *values = glint_mesh_array(from, i);
        if (!values || values == bytes + layout.at[i])
            continue;
        void *copy = glint_arena_alloc(&r->scene->arena, layout.size[i]);
        if (!copy)
            return glint_scene_no_memory(r);
        glint_mesh_set_array(m, i, memcpy(copy, values, layout.size[i]));
    }
    return true;
}

bool glint_trust_mesh(struct glint_scene_reader *r, struct glint_mesh *mesh)
{
    const struct glint_mesh *from = find_mesh(r, mesh);
    if (!from)
        return false;
    mesh->reach = from->reach;
    mesh->target_reach = from->target_reach;
    mesh->joint_end = from->joint_end;
    copy_replaced(r, mesh, from);
    return true;
}

// ---- images

static bool same_image(const struct glint_image *a, const struct glint_image *b)
{
    return strcmp(a->asset, b->asset) == 0 && a->width == b->width && a->height == b->height &&
           a->format == b->format;
}

static bool index_images(struct glint_scene_trust *t)
{
    for (uint32_t i = 0; i < t->scene->images; i++)
        if (t->scene->image[i].asset[0] &&
            !glint_hashes_add(&t->images, t->scene->image[i].asset, i))
            return false;
    return true;
}

bool glint_trust_image(struct glint_scene_reader *r, const struct glint_image *image)
{
    struct glint_scene_trust *t = &r->trust;
    if (!t->scene || !t->scene->images)
        return false;
    const uint32_t guess = t->next_image < t->scene->images ? t->next_image : 0;
    uint32_t at = guess;
    if (!same_image(image, &t->scene->image[guess])) {
        if (!t->images.used && !index_images(t))
            return !glint_scene_no_memory(r);
        at = glint_hashes_find(&t->images, image->asset);
    }
    if (at == GLINT_NONE || !same_image(image, &t->scene->image[at]))
        return false;
    t->next_image = at + 1;
    return true;
}

void glint_trust_finish(struct glint_scene_trust *trust)
{
    glint_hashes_finish(&trust->meshes);
    glint_hashes_finish(&trust->images);
}
