#include "scene/geometry.h"

#include "kernels/gk_sampler.h"
#include "kernels/gk_wave.h"

#include <embree3/rtcore.h>
#include <math.h>
#include <pthread.h>
#include <stdatomic.h>
#include <stdlib.h>
#include <string.h>

struct glint_tracer {
    atomic_uint references;
    RTCDevice device;
    pthread_mutex_t mutex; // held while something is built or released: `bytes` tells what it took
    _Atomic int64_t bytes;
};

// A scene of Embree's and what it holds.
struct structure {
    atomic_uint references;
    glint_tracer *tracer;
    RTCScene scene;
    struct glint_geometry_build build;
    int64_t bytes;
};
struct glint_body {
    struct structure s;
};
struct glint_world {
    struct structure s;
    uint32_t *ring; // owned, glint_world_tie()
};

struct glint_geometry {
    glint_world *world;
    glint_geometry_hole *hole;
    const void *user;
};

static bool count_memory(void *user, ssize_t bytes, bool post)
{
    (void)post;
    glint_tracer *t = user;
    atomic_fetch_add_explicit(&t->bytes, bytes, memory_order_relaxed);
    return true;
}

static glint_status refused(const glint_tracer *t, struct glint_error *err)
{
    const enum RTCError code = rtcGetDeviceError(t->device);
    if (code == RTC_ERROR_NONE)
        return GLINT_OK;
    const glint_status status = code == RTC_ERROR_OUT_OF_MEMORY ? GLINT_E_NOMEM : GLINT_E_DEVICE;
    return glint_fail(err, status, "", "Embree refused the geometry (error %d)", (int)code);
}

glint_status glint_tracer_create(glint_tracer **out, struct glint_error *err)
{
    *out = NULL;
    glint_tracer *t = calloc(1, sizeof *t);
    if (!t)
        return glint_fail(err, GLINT_E_NOMEM, "", "no memory for a tracer");
    t->device = rtcNewDevice(NULL);
    if (!t->device) {
        free(t);
        return glint_fail(err, GLINT_E_DEVICE, "", "Embree has no device");
    }
    atomic_init(&t->references, 1);
    pthread_mutex_init(&t->mutex, NULL);
    rtcSetDeviceMemoryMonitorFunction(t->device, count_memory, t);
    *out = t;
    return GLINT_OK;
}

glint_tracer *glint_tracer_retain(glint_tracer *tracer)
{
    atomic_fetch_add_explicit(&tracer->references, 1, memory_order_relaxed);
    return tracer;
}

// Acquire-release, here and below: the last holder sees all that the others did before it frees.
static bool last(atomic_uint *references)
{
    return atomic_fetch_sub_explicit(references, 1, memory_order_acq_rel) == 1;
}

void glint_tracer_release(glint_tracer **tracer)
{
    glint_tracer *t = *tracer;
    *tracer = NULL;
    if (!t || !last(&t->references))
        return;
    rtcReleaseDevice(t->device);
    pthread_mutex_destroy(&t->mutex);
    free(t);
}

// ---- structures

static int64_t bytes_now(glint_tracer *t)
{
    return atomic_load_explicit(&t->bytes, memory_order_relaxed);
}

static enum RTCBuildQuality quality(const struct structure *s)
{
    static const enum RTCBuildQuality of[] = {[GLINT_GEOMETRY_FINE] = RTC_BUILD_QUALITY_HIGH,
                                              [GLINT_GEOMETRY_BRISK] = RTC_BUILD_QUALITY_MEDIUM,
                                              [GLINT_GEOMETRY_QUICK] = RTC_BUILD_QUALITY_LOW};
    return of[s->build.quality];
}

// Leaves the tracer locked: structure_close() is next.
static void structure_open(struct structure *s, glint_tracer *tracer,
                           const struct glint_geometry_build *build)
{
    pthread_mutex_lock(&tracer->mutex);
    atomic_init(&s->references, 1);
    s->tracer = glint_tracer_retain(tracer);
    s->build = *build;
    s->bytes = -bytes_now(tracer);
    s->scene = rtcNewScene(tracer->device);
    rtcSetSceneFlags(s->scene, build->robust ? RTC_SCENE_FLAG_ROBUST : RTC_SCENE_FLAG_NONE);
    rtcSetSceneBuildQuality(s->scene, quality(s));
}

static glint_status structure_close(struct structure *s, glint_status st, struct glint_error *err)
{
    if (!st) {
        rtcCommitScene(s->scene);
        st = refused(s->tracer, err);
    }
    s->bytes += bytes_now(s->tracer);
    pthread_mutex_unlock(&s->tracer->mutex);
    return st;
}

// True when it is gone: the memory of the structure itself is the caller's.
static bool structure_release(struct structure *s)
{
    if (!last(&s->references))
        return false;
    pthread_mutex_lock(&s->tracer->mutex);
    rtcReleaseScene(s->scene);
    pthread_mutex_unlock(&s->tracer->mutex);
    glint_tracer_release(&s->tracer);
    return true;
}

static uint64_t structure_bytes(const struct structure *s)
{
    return s->bytes > 0 ? (uint64_t)s->bytes : 0;
}

// ---- holes

// A query of a geometry; Embree hands the context on to the filter. salt: of its rays' chances.
struct query {
    struct RTCIntersectContext context;
    const glint_geometry *geometry;
    uint32_t salt;
};

// The shadow ray of a vertex has the key of the next ray from there, and other chances.
enum { SEEN = 0, SHADOW = 0x5bd1e995 };

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

static void drop_holes(const struct RTCFilterFunctionNArguments *args)
{
    const struct query *q = (const struct query *)args->context;
    const glint_geometry *g = q->geometry;
    const uint32_t *ray = (const uint32_t *)args->ray;
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
        const uint32_t chance = chance_of(ray[RAY_ID * n + i] ^ q->salt, row, primitive);
        if (g->hole(g->user, row, primitive, number[HIT_U * n + i], number[HIT_V * n + i], chance))
            args->valid[i] = 0;
    }
}

// ---- bodies and worlds

static void copy_vertices(float *out, const float *in, const struct glint_geometry_mesh *mesh)
{
    for (size_t i = 0; i < mesh->vertices; i++)
        for (int k = 0; k < 3; k++)
            out[3 * i + k] = in[3 * i + k] - mesh->origin[k];
}

static void fill_vertices(RTCGeometry geometry, const struct glint_geometry_mesh *mesh)
{
    rtcSetGeometryTimeStepCount(geometry, mesh->keys);
    for (uint32_t k = 0; k < mesh->keys; k++) {
        float *out = rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, k, RTC_FORMAT_FLOAT3,
                                             12, mesh->vertices);
        if (out)
            copy_vertices(out, mesh->position + (size_t)k * mesh->vertices * 3, mesh);
    }
}

static void attach_mesh(const struct structure *s, uint32_t row,
                        const struct glint_geometry_mesh *mesh)
{
    RTCGeometry geometry = rtcNewGeometry(s->tracer->device, RTC_GEOMETRY_TYPE_TRIANGLE);
    fill_vertices(geometry, mesh);
    uint32_t *index = rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3,
                                              12, mesh->triangles);
    if (index)
        memcpy(index, mesh->index, (size_t)mesh->triangles * 12);
    rtcSetGeometryBuildQuality(geometry, quality(s));
    if (mesh->holes) {
        rtcSetGeometryIntersectFilterFunction(geometry, drop_holes);
        rtcSetGeometryOccludedFilterFunction(geometry, drop_holes);
    }
    rtcCommitGeometry(geometry);
    rtcAttachGeometryByID(s->scene, geometry, row);
    rtcReleaseGeometry(geometry);
}

glint_status glint_body_create(glint_body **out, glint_tracer *tracer,
                               const struct glint_geometry_mesh *mesh,
                               const struct glint_geometry_build *build, struct glint_error *err)
{
    glint_body *b = calloc(1, sizeof *b);
    *out = NULL;
    if (!b)
        return glint_fail(err, GLINT_E_NOMEM, "", "no memory for a mesh");
    structure_open(&b->s, tracer, build);
    attach_mesh(&b->s, 0, mesh);
    const glint_status st = structure_close(&b->s, refused(tracer, err), err);
    if (st)
        glint_body_release(&b);
    *out = b;
    return st;
}

void glint_body_release(glint_body **body)
{
    if (*body && structure_release(&(*body)->s))
        free(*body);
    *body = NULL;
}

uint64_t glint_body_bytes(const glint_body *body)
{
    return structure_bytes(&body->s);
}

glint_status glint_world_create(glint_world **out, glint_tracer *tracer,
                                const struct glint_geometry_build *build, glint_world_fill *fill,
                                void *user, struct glint_error *err)
{
    glint_world *w = calloc(1, sizeof *w);
    *out = NULL;
    if (!w)
        return glint_fail(err, GLINT_E_NOMEM, "", "no memory for a scene");
    structure_open(&w->s, tracer, build);
    const glint_status st = structure_close(&w->s, fill(w, user, err), err);
    if (st)
        glint_world_release(&w);
    *out = w;
    return st;
}

glint_world *glint_world_retain(glint_world *world)
{
    atomic_fetch_add_explicit(&world->s.references, 1, memory_order_relaxed);
    return world;
}

void glint_world_release(glint_world **world)
{
    if (*world && structure_release(&(*world)->s)) {
        free((*world)->ring);
        free(*world);
    }
    *world = NULL;
}

uint64_t glint_world_bytes(const glint_world *world)
{
    return structure_bytes(&world->s);
}

uint64_t glint_world_tracer_bytes(const glint_world *world)
{
    const int64_t bytes = bytes_now(world->s.tracer);
    return bytes > 0 ? (uint64_t)bytes : 0;
}

glint_status glint_world_add_mesh(glint_world *world, uint32_t row,
                                  const struct glint_geometry_mesh *mesh, struct glint_error *err)
{
    attach_mesh(&world->s, row, mesh);
    return refused(world->s.tracer, err);
}

glint_status glint_world_place(glint_world *world, uint32_t row, glint_body *body,
                               const float *transform, uint32_t keys, struct glint_error *err)
{
    RTCGeometry geometry = rtcNewGeometry(world->s.tracer->device, RTC_GEOMETRY_TYPE_INSTANCE);
    rtcSetGeometryInstancedScene(geometry, body->s.scene);
    rtcSetGeometryTimeStepCount(geometry, keys);
    for (uint32_t k = 0; k < keys; k++)
        rtcSetGeometryTransform(geometry, k, RTC_FORMAT_FLOAT4X4_COLUMN_MAJOR, transform + 16 * k);
    rtcCommitGeometry(geometry);
    rtcAttachGeometryByID(world->s.scene, geometry, row);
    rtcReleaseGeometry(geometry);
    return refused(world->s.tracer, err);
}

void glint_world_tie(glint_world *world, uint32_t *ring)
{
    world->ring = ring;
}

// ---- views

glint_geometry *glint_geometry_create(glint_world *world, glint_geometry_hole *hole,
                                      const void *user)
{
    glint_geometry *g = calloc(1, sizeof *g);
    if (g)
        *g = (glint_geometry){glint_world_retain(world), hole, user};
    return g;
}

void glint_geometry_destroy(glint_geometry **geometry)
{
    if (*geometry)
        glint_world_release(&(*geometry)->world);
    free(*geometry);
    *geometry = NULL;
}

glint_world *glint_geometry_world(const glint_geometry *geometry)
{
    return geometry->world;
}

void *glint_geometry_native(const glint_geometry *g)
{
    return g->world->s.scene;
}

static void query_init(struct query *q, const glint_geometry *g, uint32_t salt)
{
    rtcInitIntersectContext(&q->context); // incoherent: the coherent flag costs 27-51 % on waves
    q->geometry = g;
    q->salt = salt;
}

#define COLUMN(k) (wave + (size_t)(k)*stride)
#define COLUMN_U32(k) ((uint32_t *)COLUMN(k))

// The first row that lies where the hit one does and has no hole there.
static uint32_t first_of_tie(const glint_geometry *g, uint32_t row, uint32_t primitive, float u,
                             float v, uint32_t key)
{
    const uint32_t *ring = g->world->ring;
    uint32_t first = row;
    for (uint32_t k = ring[row]; k != row; k = ring[k])
        if (k < first && !g->hole(g->user, k, primitive, u, v, chance_of(key, k, primitive)))
            first = k;
    return first;
}

static void settle_ties(const glint_geometry *g, float *wave, uint32_t stride, uint32_t n)
{
    const uint32_t *key = COLUMN_U32(GK_COL_PASSAGE), *primitive = COLUMN_U32(GK_COL_PRIMITIVE);
    for (uint32_t i = 0; i < n; i++) {
        uint32_t *instance = COLUMN_U32(GK_COL_INSTANCE) + i;
        uint32_t *row =
            *instance != RTC_INVALID_GEOMETRY_ID ? instance : COLUMN_U32(GK_COL_GEOMETRY) + i;
        if (*row != RTC_INVALID_GEOMETRY_ID && COLUMN(GK_COL_T)[i] >= 0.0f)
            *row = first_of_tie(g, *row, primitive[i], COLUMN(GK_COL_U)[i], COLUMN(GK_COL_V)[i],
                                key[i]);
    }
}

void glint_geometry_trace_wave(const glint_geometry *g, float *wave, uint32_t stride, uint32_t n)
{
    struct query q;
    query_init(&q, g, SEEN);
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
    rtcIntersectNp(g->world->s.scene, &q.context, &rays, n);
    if (g->world->ring)
        settle_ties(g, wave, stride, n);
}

void glint_geometry_shadow_wave(const glint_geometry *g, float *wave, uint32_t stride, uint32_t n)
{
    struct query q;
    query_init(&q, g, SHADOW);
    struct RTCRayNp rays = {
        COLUMN(GK_COL_SOX),      COLUMN(GK_COL_SOY),         COLUMN(GK_COL_SOZ),
        COLUMN(GK_COL_ZERO),     COLUMN(GK_COL_SDX),         COLUMN(GK_COL_SDY),
        COLUMN(GK_COL_SDZ),      COLUMN(GK_COL_TIME),        COLUMN(GK_COL_ST),
        COLUMN_U32(GK_COL_MASK), COLUMN_U32(GK_COL_PASSAGE), COLUMN_U32(GK_COL_ZERO)};
    rtcOccludedNp(g->world->s.scene, &q.context, &rays, n);
}

// ---- rays at vertices

// Edges that meet in a vertex are rounded each by itself: of rays aimed at one Embree's robust
// traversal lets 1 in 1,700 through. What has met nothing is traced once more, turned aside by more
// than edges are rounded; what it meets then counts next to a vertex alone, so that nothing else is
// seen from aside.
#define ASIDE 0x1p-19f // radians
#define CORNER 0x1p-7f // of a triangle's sides

enum met { NOTHING, SURFACE, VERTEX };

// A direction, by so many radians towards the axis that it is least along.
static void turn(float d[3], float by)
{
    const float x = fabsf(d[0]), y = fabsf(d[1]), z = fabsf(d[2]);
    const int axis = x <= y && x <= z ? 0 : y <= z ? 1 : 2;
    const float along = d[axis];
    for (int k = 0; k < 3; k++)
        d[k] -= by * along * d[k];
    d[axis] += by;
}

// What row i meets when it is turned. column: its ray's first; those of a shadow ray are in the same
// order.
static enum met look_aside(struct query *q, const float *wave, size_t stride, int column,
                           uint32_t i, float by, struct RTCRayHit *out)
{
    const float *ray = wave + (size_t)column * stride + i;
    float d[3] = {ray[3 * stride], ray[4 * stride], ray[5 * stride]};
    turn(d, by);
    *out = (struct RTCRayHit){
        .ray = {.org_x = ray[0],
                .org_y = ray[stride],
                .org_z = ray[2 * stride],
                .dir_x = d[0],
                .dir_y = d[1],
                .dir_z = d[2],
                .tfar = ray[6 * stride],
                .time = COLUMN(GK_COL_TIME)[i],
                .mask = COLUMN_U32(GK_COL_MASK)[i],
                .id = COLUMN_U32(GK_COL_PASSAGE)[i]},
        .hit = {.geomID = RTC_INVALID_GEOMETRY_ID, .instID = {RTC_INVALID_GEOMETRY_ID}}};
    rtcIntersect1(q->geometry->world->s.scene, &q->context, out);
    if (out->hit.geomID == RTC_INVALID_GEOMETRY_ID)
        return NOTHING;
    const float u = out->hit.u, v = out->hit.v;
    return fmaxf(1.0f - u - v, fmaxf(u, v)) > 1.0f - CORNER ? VERTEX : SURFACE;
}

// A surface on one side: the vertex is one of an outline, and on the other side.
static bool meets_vertex(struct query *q, const float *wave, size_t stride, int column, uint32_t i,
                         struct RTCRayHit *out)
{
    enum met met = look_aside(q, wave, stride, column, i, ASIDE, out);
    if (met == SURFACE)
        met = look_aside(q, wave, stride, column, i, -ASIDE, out);
    return met == VERTEX;
}

static void take(float *wave, size_t stride, uint32_t i, const struct RTCRayHit *r)
{
    COLUMN(GK_COL_T)[i] = r->ray.tfar;
    COLUMN(GK_COL_NX)[i] = r->hit.Ng_x;
    COLUMN(GK_COL_NY)[i] = r->hit.Ng_y;
    COLUMN(GK_COL_NZ)[i] = r->hit.Ng_z;
    COLUMN(GK_COL_U)[i] = r->hit.u;
    COLUMN(GK_COL_V)[i] = r->hit.v;
    COLUMN_U32(GK_COL_PRIMITIVE)[i] = r->hit.primID;
    COLUMN_U32(GK_COL_GEOMETRY)[i] = r->hit.geomID;
    COLUMN_U32(GK_COL_INSTANCE)[i] = r->hit.instID[0];
}

void glint_geometry_close_wave(const glint_geometry *g, float *wave, uint32_t stride, uint32_t n)
{
    struct query q;
    struct RTCRayHit r;
    query_init(&q, g, SEEN);
    for (uint32_t i = 0; i < n; i++) {
        const bool nothing = COLUMN(GK_COL_T)[i] >= 0.0f &&
                             COLUMN_U32(GK_COL_GEOMETRY)[i] == RTC_INVALID_GEOMETRY_ID;
        if (!nothing || !meets_vertex(&q, wave, stride, GK_COL_OX, i, &r))
            continue;
        take(wave, stride, i, &r);
        if (g->world->ring)
            settle_ties(g, wave + i, stride, 1);
    }
}

void glint_geometry_close_shadows(const glint_geometry *g, float *wave, uint32_t stride, uint32_t n)
{
    struct query q;
    struct RTCRayHit r;
    query_init(&q, g, SHADOW);
    for (uint32_t i = 0; i < n; i++)
        if (COLUMN(GK_COL_ST)[i] > 0.0f && meets_vertex(&q, wave, stride, GK_COL_SOX, i, &r))
            COLUMN(GK_COL_ST)[i] = -INFINITY;
}
