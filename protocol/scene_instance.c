// scene_instance.c - what stands where, and what it belongs to.
#include "protocol/scene_parts.h"

// The object that the instance names, one with the instance's id, or a new one of that id.
static uint32_t object_of(struct glint_scene_reader *r, const struct glint_json *at,
                          const struct glint_instance *in)
{
    const struct glint_json named = glint_json_member(at, "object");
    if (named.value)
        return glint_scene_reference(&named, &r->objects, "object");
    const uint32_t same = glint_ids_find(&r->objects, in->id);
    if (same != GLINT_NONE)
        return same;
    struct glint_object *o = &r->scene->object[r->scene->objects];
    *o = (struct glint_object){in->id, in->id, glint_arena_string(&r->scene->arena, "")};
    if (!o->asset)
        glint_scene_no_memory(r);
    return r->scene->objects++;
}

static void check_skin(const struct glint_json *at, const struct glint_mesh *mesh,
                       const struct glint_skin *skin)
{
    if (!mesh->joint)
        glint_json_fault(at, "the mesh \"%.80s\" has no joints and weights", mesh->id);
    else if (mesh->joint_end > skin->joints)
        glint_json_fault(at, "the mesh \"%.80s\" names joint %u; the skin has %u", mesh->id,
                         mesh->joint_end - 1, skin->joints);
}

// For a mesh and a skin without faults of their own.
static void read_deformation(struct glint_scene_reader *r, const struct glint_json *at,
                             struct glint_instance *in)
{
    const struct glint_json skin = glint_json_member(at, "skin");
    const struct glint_mesh *mesh = &r->scene->mesh[in->mesh];
    if (in->skin != GLINT_NONE && r->scene->skin[in->skin].joints)
        check_skin(&skin, mesh, &r->scene->skin[in->skin]);
    glint_mesh_read_weights(r, at, "weights", mesh->targets, &in->weight);
}

void glint_instance_read(struct glint_scene_reader *r, const struct glint_json *at,
                         struct glint_instance *out)
{
    const struct glint_json mesh = glint_json_member(at, "mesh");
    const struct glint_json material = glint_json_member(at, "material");
    const struct glint_json node = glint_json_member(at, "node");
    const struct glint_json skin = glint_json_member(at, "skin");
    const struct glint_json transform = glint_json_member(at, "transform");
    char *id = out->id;
    glint_instance_init(out);
    out->id = id;
    out->mesh = out->material = GLINT_NONE;
    glint_fields_read(at, glint_instance_fields, &r->scene->arena, out);
    if (glint_json_require(&mesh))
        out->mesh = glint_scene_reference(&mesh, &r->meshes, "mesh");
    if (glint_json_require(&material))
        out->material = glint_scene_reference(&material, &r->materials, "material");
    out->object = object_of(r, at, out);
    out->node = glint_scene_reference(&node, &r->nodes, "node");
    out->skin = glint_scene_reference(&skin, &r->skins, "skin");
    glint_transform_read(&transform, out->transform);
    if (out->mesh < r->scene->meshes && r->scene->mesh[out->mesh].vertices)
        read_deformation(r, at, out);
}
