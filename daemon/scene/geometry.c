#include "scene/geometry.h"

#include "kernels/gk_sampler.h"
#include "kernels/gk_wave.h"

#include <embree3/rtcore.h>
#include <stdatomic.h>
#include <stdlib.h>
#include <string.h>

struct glint_geometry {
    RTCDevice device; // its own, so that its memory can be counted
    RTCScene scene;
    RTCScene *template_scene;
    uint32_t templates, capacity;
    bool robust;
    glint_geometry_hole *hole;
    const void *user;
    _Atomic int64_t bytes;
};

static bool count_memory(void *user, ssize_t bytes, bool post)
{
    (void)post;
    glint_geometry *g = user;
    atomic_fetch_add_explicit(&g->bytes, bytes, memory_order_relaxed);
    return true;
}

static glint_status refused(const glint_geometry *g, struct glint_error *err)
{
    const enum RTCError code = rtcGetDeviceError(g->device);
    if (code == RTC_ERROR_NONE)
        return GLINT_OK;
    const glint_status status = code == RTC_ERROR_OUT_OF_MEMORY ? GLINT_E_NOMEM : GLINT_E_DEVICE;
    return glint_fail(err, status, "", "Embree refused the geometry (error %d)", (int)code);
}

static RTCScene scene_create(const glint_geometry *g)
{
    RTCScene scene = rtcNewScene(g->device);
    rtcSetSceneFlags(scene, g->robust ? RTC_SCENE_FLAG_ROBUST : RTC_SCENE_FLAG_NONE);
    rtcSetSceneBuildQuality(scene, RTC_BUILD_QUALITY_HIGH);
    return scene;
}

glint_status glint_geometry_create(glint_geometry **out, bool robust, glint_geometry_hole *hole,
                                   const void *user, struct glint_error *err)
{
    *out = NULL;
    glint_geometry *g = calloc(1, sizeof *g);
    if (!g)
        return glint_fail(err, GLINT_E_NOMEM, "", "no memory for a geometry");
    g->robust = robust;
    g->hole = hole;
    g->user = user;
    g->device = rtcNewDevice(NULL);
    if (!g->device) {
        free(g);
        return glint_fail(err, GLINT_E_DEVICE, "", "Embree has no device");
    }
    rtcSetDeviceMemoryMonitorFunction(g->device, count_memory, g);
    g->scene = scene_create(g);
    *out = g;
    return GLINT_OK;
}

void glint_geometry_destroy(glint_geometry **geometry)
{
    glint_geometry *g = *geometry;
    *geometry = NULL;
    if (!g)
        return;
    rtcReleaseScene(g->scene);
    for (uint32_t i = 0; i < g->templates; i++)
        rtcReleaseScene(g->template_scene[i]);
    free(g->template_scene);
    rtcReleaseDevice(g->device);
    free(g);
}

// Component k of hit i in a packet of n, in the order of struct RTCHitN: Ng, u, v, primitive,
// geometry, instance. (Embree's own accessors are C++.)
enum { HIT_U = 3, HIT_V = 4, HIT_PRIMITIVE = 5, HIT_GEOMETRY = 6, HIT_INSTANCE = 7 };

// Word k of ray i in a packet of n, in the order of struct RTCRayN.
enum { RAY_ID = 10 };

// Of a ray's key and the primitive: several surfaces on a ray are passed independently.
static uint32_t chance_of(uint32_t key, uint32_t row, uint32_t primitive)
{
    return gk_mix32(key ^ gk_mix32(row * 0x9e3779b9u + gk_mix32(primitive + 0x7f4a7c15u)));
}

static void drop_holes(const struct RTCFilterFunctionNArguments *args, uint32_t salt)
{
    const uint32_t *ray = (const uint32_t *)args->ray;
    const glint_geometry *g = args->geometryUserPtr;
    const float *number = (const float *)args->hit;
    const uint32_t *word = (const uint32_t *)args->hit;
    const unsigned n = args->N;
    for (unsigned i = 0; i < n; i++) {
        if (args->valid[i] != -1)
            continue;
        const uint32_t instance = word[HIT_INSTANCE * n + i];
        const uint32_t geometry = word[HIT_GEOMETRY * n + i];
        const uint32_t row = instance != RTC_INVALID_GEOMETRY_ID ? instance : geometry;
        const uint32_t primitive = word[HIT_PRIMITIVE * n + i];
        const uint32_t chance = chance_of(ray[RAY_ID * n + i] ^ salt, row, primitive);
        if (g->hole(g->user, row, primitive, number[HIT_U * n + i], number[HIT_V * n + i], chance))
            args->valid[i] = 0;
    }
}

static void drop_seen_holes(const struct RTCFilterFunctionNArguments *args)
{
    drop_holes(args, 0);
}

// The shadow ray of a vertex has the key of the next ray from there, and other chances.
static void drop_shadow_holes(const struct RTCFilterFunctionNArguments *args)
{
    drop_holes(args, 0x5bd1e995u);
}

static RTCGeometry mesh_create(glint_geometry *g, const struct glint_geometry_mesh *mesh)
{
    RTCGeometry geometry = rtcNewGeometry(g->device, RTC_GEOMETRY_TYPE_TRIANGLE);
    float *position = rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0,
                                              RTC_FORMAT_FLOAT3, 12, mesh->vertices);
    uint32_t *index = rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3,
                                              12, mesh->triangles);
    if (position && index) {
        memcpy(position, mesh->position, (size_t)mesh->vertices * 12);
        memcpy(index, mesh->index, (size_t)mesh->triangles * 12);
    }
    rtcSetGeometryBuildQuality(geometry, RTC_BUILD_QUALITY_HIGH);
    if (mesh->cutout) {
        rtcSetGeometryUserData(geometry, g);
        rtcSetGeometryIntersectFilterFunction(geometry, drop_seen_holes);
        rtcSetGeometryOccludedFilterFunction(geometry, drop_shadow_holes);
    }
    rtcCommitGeometry(geometry);
    return geometry;
}

glint_status glint_geometry_add_mesh(glint_geometry *g, uint32_t row,
                                     const struct glint_geometry_mesh *mesh,
                                     struct glint_error *err)
{
    RTCGeometry geometry = mesh_create(g, mesh);
    rtcAttachGeometryByID(g->scene, geometry, row);
    rtcReleaseGeometry(geometry);
    return refused(g, err);
}

glint_status glint_geometry_add_template(glint_geometry *g, const struct glint_geometry_mesh *mesh,
                                         uint32_t *index, struct glint_error *err)
{
    if (g->templates == g->capacity) {
        const uint32_t capacity = g->capacity ? 2 * g->capacity : 64;
        RTCScene *grown = realloc(g->template_scene, capacity * sizeof *grown);
        if (!grown)
            return glint_fail(err, GLINT_E_NOMEM, "", "no memory for %u templates", capacity);
        g->template_scene = grown;
        g->capacity = capacity;
    }
    RTCScene scene = scene_create(g);
    RTCGeometry geometry = mesh_create(g, mesh);
    rtcAttachGeometryByID(scene, geometry, 0);
    rtcReleaseGeometry(geometry);
    rtcCommitScene(scene);
    *index = g->templates;
    g->template_scene[g->templates++] = scene;
    return refused(g, err);
}

glint_status glint_geometry_place(glint_geometry *g, uint32_t row, uint32_t template_index,
                                  const float transform[16], struct glint_error *err)
{
    RTCGeometry geometry = rtcNewGeometry(g->device, RTC_GEOMETRY_TYPE_INSTANCE);
    rtcSetGeometryInstancedScene(geometry, g->template_scene[template_index]);
    rtcSetGeometryTransform(geometry, 0, RTC_FORMAT_FLOAT4X4_COLUMN_MAJOR, transform);
    rtcCommitGeometry(geometry);
    rtcAttachGeometryByID(g->scene, geometry, row);
    rtcReleaseGeometry(geometry);
    return refused(g, err);
}

glint_status glint_geometry_commit(glint_geometry *g, struct glint_error *err)
{
    rtcCommitScene(g->scene);
    return refused(g, err);
}

uint64_t glint_geometry_bytes(const glint_geometry *g)
{
    const int64_t bytes = atomic_load_explicit(&g->bytes, memory_order_relaxed);
    return bytes > 0 ? (uint64_t)bytes : 0;
}

void *glint_geometry_native(const glint_geometry *g)
{
    return g->scene;
}

#define COLUMN(k) (wave + (size_t)(k)*stride)
#define COLUMN_U32(k) ((uint32_t *)COLUMN(k))

void glint_geometry_trace_wave(const glint_geometry *g, float *wave, uint32_t stride, uint32_t n)
{
    struct RTCIntersectContext context;
    rtcInitIntersectContext(&context); // incoherent: the coherent flag costs 27-51 % on waves
    struct RTCRayHitNp rays = {
        .ray = {COLUMN(GK_COL_OX), COLUMN(GK_COL_OY), COLUMN(GK_COL_OZ), COLUMN(GK_COL_ZERO),
                COLUMN(GK_COL_DX), COLUMN(GK_COL_DY), COLUMN(GK_COL_DZ), COLUMN(GK_COL_TIME),
                COLUMN(GK_COL_T), COLUMN_U32(GK_COL_MASK), COLUMN_U32(GK_COL_PASSAGE),
                COLUMN_U32(GK_COL_ZERO)},
        .hit = {COLUMN(GK_COL_NX),
                COLUMN(GK_COL_NY),
                COLUMN(GK_COL_NZ),
                COLUMN(GK_COL_U),
                COLUMN(GK_COL_V),
                COLUMN_U32(GK_COL_PRIMITIVE),
                COLUMN_U32(GK_COL_GEOMETRY),
                {COLUMN_U32(GK_COL_INSTANCE)}},
    };
    rtcIntersectNp(g->scene, &context, &rays, n);
}

void glint_geometry_shadow_wave(const glint_geometry *g, float *wave, uint32_t stride, uint32_t n)
{
    struct RTCIntersectContext context;
    rtcInitIntersectContext(&context);
    struct RTCRayNp rays = {
        COLUMN(GK_COL_SOX),      COLUMN(GK_COL_SOY),         COLUMN(GK_COL_SOZ),
        COLUMN(GK_COL_ZERO),     COLUMN(GK_COL_SDX),         COLUMN(GK_COL_SDY),
        COLUMN(GK_COL_SDZ),      COLUMN(GK_COL_TIME),        COLUMN(GK_COL_ST),
        COLUMN_U32(GK_COL_MASK), COLUMN_U32(GK_COL_PASSAGE), COLUMN_U32(GK_COL_ZERO)};
    rtcOccludedNp(g->scene, &context, &rays, n);
}
