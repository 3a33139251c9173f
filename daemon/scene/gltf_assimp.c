// gltf_assimp.c - the geometry of a file through Assimp.
//
// Assimp gets a GLB of its own with one mesh per geometry, named by its number, whose accessors
// are packed floats and 32-bit indices. From the file itself, Assimp 5.2 would take normalised
// integers for floats, read sparse indices in the wrong width, drop triangles with an index out of
// range without a word, and rename meshes.
#include "scene/gltf_file.h"

#include <assimp/cimport.h>
#include <assimp/postprocess.h>
#include <assimp/scene.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

struct part {
    const struct glint_gltf_accessor *accessor;
    size_t offset, bytes; // in the binary chunk
};

struct batch {
    struct glint_gltf *g;
    const struct glint_gltf_geometry *geometry;
    uint32_t first, count, parts;
    struct part *part;
    size_t bin_bytes;
    uint8_t *glb;
    size_t glb_bytes;
};

static bool is_index(const struct batch *b, uint32_t i)
{
    return b->part[i].accessor->components == 1;
}

static bool list_parts(struct batch *b)
{
    b->part = calloc((size_t)b->count * GLTF_ASSEMBLED, sizeof *b->part);
    if (!b->part)
        return glint_gltf_nomem(b->g);
    for (uint32_t i = 0; i < b->count; i++)
        for (int k = 0; k < GLTF_ASSEMBLED; k++) {
            const struct glint_gltf_accessor *a = &b->geometry[b->first + i].part[k];
            if (!a->count)
                continue;
            const size_t bytes = (size_t)a->count * a->components * 4;
            b->part[b->parts++] = (struct part){a, b->bin_bytes, bytes};
            b->bin_bytes += bytes;
        }
    return true;
}

static void print_meshes(const struct batch *b, FILE *out)
{
    static const char *const name[] = {"POSITION", "NORMAL", "TANGENT"};
    uint32_t next = 0;
    for (uint32_t i = 0; i < b->count; i++) {
        const struct glint_gltf_geometry *geometry = &b->geometry[b->first + i];
        fprintf(out, "%s{\"name\":\"%u\",\"primitives\":[{\"mode\":%u,\"attributes\":{",
                i ? "," : "", b->first + i, geometry->mode);
        for (int k = 0; k < GLTF_INDEX; k++)
            if (geometry->part[k].count) {
                fprintf(out, "%s\"%s\":%u", k ? "," : "", name[k], next);
                next++;
            }
        fprintf(out, "}");
        if (geometry->part[GLTF_INDEX].count)
            fprintf(out, ",\"indices\":%u", next++);
        fprintf(out, "}]}");
    }
}

static void print_json(const struct batch *b, FILE *out)
{
    static const char *const type[] = {"", "SCALAR", "VEC2", "VEC3", "VEC4"};
    fprintf(out, "{\"asset\":{\"version\":\"2.0\"},\"scene\":0,\"scenes\":[{\"nodes\":[");
    for (uint32_t i = 0; i < b->count; i++)
        fprintf(out, "%s%u", i ? "," : "", i);
    fprintf(out, "]}],\"nodes\":[");
    for (uint32_t i = 0; i < b->count; i++)
        fprintf(out, "%s{\"mesh\":%u}", i ? "," : "", i);
    fprintf(out, "],\"meshes\":[");
    print_meshes(b, out);
    fprintf(out, "],\"accessors\":[");
    for (uint32_t i = 0; i < b->parts; i++)
        fprintf(out, "%s{\"bufferView\":%u,\"componentType\":%d,\"count\":%u,\"type\":\"%s\"}",
                i ? "," : "", i, is_index(b, i) ? GLTF_U32 : GLTF_F32, b->part[i].accessor->count,
                type[b->part[i].accessor->components]);
    fprintf(out, "],\"bufferViews\":[");
    for (uint32_t i = 0; i < b->parts; i++)
        fprintf(out, "%s{\"buffer\":0,\"byteOffset\":%zu,\"byteLength\":%zu}", i ? "," : "",
                b->part[i].offset, b->part[i].bytes);
    fprintf(out, "],\"buffers\":[{\"byteLength\":%zu}]}", b->bin_bytes);
}

static bool fill_part(struct batch *b, uint32_t i, uint8_t *bin)
{
    void *to = bin + b->part[i].offset;
    const struct glint_gltf_accessor *a = b->part[i].accessor;
    return is_index(b, i) ? glint_gltf_accessor_indices(b->g, a, to)
                          : glint_gltf_accessor_floats(b->g, a, to);
}

static void put_u32(uint8_t *at, size_t value)
{
    for (int i = 0; i < 4; i++)
        at[i] = (uint8_t)(value >> (8 * i));
}

static bool make_glb(struct batch *b, const char *json, size_t length)
{
    const size_t padded = (length + 3) / 4 * 4;
    b->glb_bytes = 28 + padded + b->bin_bytes;
    b->glb = b->glb_bytes <= UINT32_MAX ? malloc(b->glb_bytes) : NULL;
    if (!b->glb)
        return glint_gltf_nomem(b->g);
    memcpy(b->glb, "glTF", 4);
    put_u32(b->glb + 4, 2);
    put_u32(b->glb + 8, b->glb_bytes);
    put_u32(b->glb + 12, padded);
    memcpy(b->glb + 16, "JSON", 4);
    memset(b->glb + 20, ' ', padded);
    memcpy(b->glb + 20, json, length);
    put_u32(b->glb + 20 + padded, b->bin_bytes);
    memcpy(b->glb + 24 + padded, "BIN", 4);
    for (uint32_t i = 0; i < b->parts; i++)
        if (!fill_part(b, i, b->glb + 28 + padded))
            return false;
    return true;
}

static bool build(struct batch *b)
{
    char *json = NULL;
    size_t length = 0;
    FILE *out = list_parts(b) ? open_memstream(&json, &length) : NULL;
    if (out)
        print_json(b, out);
    const bool printed = out && !ferror(out);
    if (out)
        fclose(out);
    const bool made = printed && json ? make_glb(b, json, length) : glint_gltf_nomem(b->g);
    free(json);
    return made;
}

// Assimp leaves out a triangle with such an index and says nothing.
static bool check_indices(struct batch *b)
{
    const uint8_t *bin = b->glb + b->glb_bytes - b->bin_bytes;
    uint32_t vertices = 0;
    for (uint32_t i = 0; i < b->parts; i++) {
        const uint32_t *index = (const uint32_t *)(bin + b->part[i].offset);
        if (!is_index(b, i)) {
            vertices = b->part[i].accessor->count;
            continue;
        }
        for (uint32_t k = 0; k < b->part[i].accessor->count; k++)
            if (index[k] >= vertices)
                return glint_gltf_accessor_fault(b->g, b->part[i].accessor,
                                                 "index %u is %u, but there are %u vertices", k,
                                                 index[k], vertices);
    }
    return true;
}

static float *copy3(struct glint_arena *arena, const struct aiVector3D *v, uint32_t count)
{
    _Static_assert(sizeof *v == 3 * sizeof(float), "aiVector3D is three floats");
    float *out = glint_arena_array(arena, count, sizeof *v);
    return out ? memcpy(out, v, (size_t)count * sizeof *v) : NULL;
}

// Assimp keeps the bitangent cross(n, t) * w in place of w.
static float *copy_tangents(struct glint_arena *arena, const struct aiMesh *from)
{
    float *out = glint_arena_array(arena, from->mNumVertices, 4 * sizeof *out);
    for (uint32_t i = 0; out && i < from->mNumVertices; i++) {
        const struct aiVector3D n = from->mNormals[i], t = from->mTangents[i];
        const struct aiVector3D b = from->mBitangents[i];
        const float side = (n.y * t.z - n.z * t.y) * b.x + (n.z * t.x - n.x * t.z) * b.y +
                           (n.x * t.y - n.y * t.x) * b.z;
        const float value[4] = {t.x, t.y, t.z, side < 0 ? -1.0f : 1.0f};
        memcpy(out + (size_t)i * 4, value, sizeof value);
    }
    return out;
}

static uint32_t *copy_faces(struct glint_arena *arena, const struct aiMesh *from, uint32_t *count)
{
    uint32_t *out = glint_arena_array(arena, from->mNumFaces, 3 * sizeof *out);
    *count = 0;
    for (uint32_t i = 0; out && i < from->mNumFaces; i++) {
        const struct aiFace *f = &from->mFaces[i];
        if (f->mNumIndices == 3)
            memcpy(out + 3 * (size_t)(*count)++, f->mIndices, 3 * sizeof *out);
    }
    return out;
}

static bool take_mesh(struct batch *b, const struct aiMesh *from)
{
    struct glint_arena *arena = &b->g->scene->arena;
    const uint32_t i = (uint32_t)strtoul(from->mName.data, NULL, 10);
    if (i < b->first || i - b->first >= b->count ||
        from->mNumVertices != b->geometry[i].part[GLTF_POSITION].count)
        return false;
    const struct glint_gltf_accessor *part = b->geometry[i].part;
    struct glint_mesh *m = &b->g->scene->mesh[i];
    const bool normal = part[GLTF_NORMAL].count && from->mNormals;
    const bool tangent = normal && part[GLTF_TANGENT].count && from->mTangents;
    m->vertices = from->mNumVertices;
    m->position = copy3(arena, from->mVertices, m->vertices);
    m->normal = normal ? copy3(arena, from->mNormals, m->vertices) : NULL;
    m->tangent = tangent ? copy_tangents(arena, from) : NULL;
    m->index = copy_faces(arena, from, &m->triangles);
    if (!m->position || !m->index || (normal && !m->normal) || (tangent && !m->tangent))
        return glint_gltf_nomem(b->g);
    if (!m->triangles)
        return false;
    glint_gltf_clean_mesh(b->g, i, &b->geometry[i]);
    return true;
}

static void refuse(struct batch *b, const char *why)
{
    if (!b->g->err->status)
        glint_fail(b->g->err, GLINT_E_RANGE, "/meshes", "the meshes cannot be read: %.200s", why);
}

static void take_meshes(struct batch *b, const struct aiScene *scene)
{
    uint32_t taken = 0;
    for (uint32_t i = 0; i < scene->mNumMeshes; i++)
        taken += take_mesh(b, scene->mMeshes[i]);
    if (taken != b->count)
        refuse(b, "some have no triangles");
}

static void run_assimp(struct batch *b)
{
    const unsigned flags = aiProcess_Triangulate | aiProcess_ValidateDataStructure;
    const struct aiScene *scene =
        aiImportFileFromMemory((const char *)b->glb, (unsigned)b->glb_bytes, flags, "glb");
    if (!scene) {
        const char *why = aiGetErrorString();
        if (strstr(why, "alloc"))
            glint_gltf_nomem(b->g);
        refuse(b, why);
        return;
    }
    take_meshes(b, scene);
    aiReleaseImport(scene);
}

void glint_gltf_assemble(struct glint_gltf *g, const struct glint_gltf_geometry *geometry,
                         uint32_t first, uint32_t count)
{
    struct batch b = {.g = g, .geometry = geometry, .first = first, .count = count};
    if (build(&b) && check_indices(&b))
        run_assimp(&b);
    free(b.glb);
    free(b.part);
}
