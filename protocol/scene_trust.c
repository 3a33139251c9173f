// scene_trust.c - what an earlier parse has checked already.
#include "protocol/scene_parts.h"

#include <string.h>

// ---- meshes

static bool same_mesh(const struct glint_mesh *a, const struct glint_mesh *b)
{
    return strcmp(a->asset, b->asset) == 0 && a->vertices == b->vertices &&
           a->triangles == b->triangles && a->targets == b->targets && b->checked &&
           glint_mesh_attributes(a) == glint_mesh_attributes(b);
}

static void take_findings(struct glint_mesh *m, const struct glint_mesh *from)
{
    m->checked = true;
    memcpy(m->low, from->low, sizeof m->low);
    memcpy(m->high, from->high, sizeof m->high);
    m->reach = from->reach;
    m->target_reach = from->target_reach;
    m->joint_end = from->joint_end;
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

// One of this scene itself, whose arrays are in reach: they serve both.
static bool share_own(struct glint_scene_reader *r, struct glint_mesh *m)
{
    const uint32_t at = glint_hashes_find(&r->trust.own_meshes, m->asset);
    const struct glint_mesh *first = m - r->scene->meshes; // those read so far stand before it
    const struct glint_mesh *from = at == GLINT_NONE ? NULL : first + at;
    if (!from || !same_mesh(m, from))
        return false;
    for (size_t i = 0; i < GLINT_MESH_ARRAYS; i++)
        glint_mesh_set_array(m, i, glint_mesh_array(from, i));
    take_findings(m, from);
    return true;
}

bool glint_trust_own_mesh(struct glint_scene_reader *r, const struct glint_mesh *mesh)
{
    return glint_hashes_add(&r->trust.own_meshes, mesh->asset, r->scene->meshes) ||
           glint_scene_no_memory(r);
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
    if (share_own(r, mesh))
        return true;
    const struct glint_mesh *from = find_mesh(r, mesh);
    if (!from)
        return false;
    take_findings(mesh, from);
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
    glint_hashes_finish(&trust->own_meshes);
}
