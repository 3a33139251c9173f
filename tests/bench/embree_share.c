// embree_share - how much of a render's time is the tracing that nobody could avoid.
//
// Records the rays of real waves in their own order and replays them with each of Embree's calls;
// the fastest is the limit. Ratio: its CPU time over that of the whole render of the same waves.
// By default with a picture and primary mattes; --all: with every AOV and mattes through glossy
// lobes.
#include "base/clock.h"
#include "kernels/gk_wave.h"
#include "tests/bench/bench.h"
#include "tests/bench/waves.h"

#include <embree3/rtcore.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define PAIRS 15

typedef struct RTCRayHit ray_hit;
typedef struct RTCRay shadow_ray;

// The rays of all calls, dense, in order; `hit` and `shadow` are overwritten by a replay.
static struct {
    bool on;
    size_t hits, shadows, capacity;
    ray_hit *hit, *hit_kept;
    shadow_ray *shadow, *shadow_kept;
} record;

static struct RTCRay ray_at(const float *wave, uint32_t stride, uint32_t i, int origin, float t)
{
    const float *c = wave + (size_t)origin * stride + i;
    return (struct RTCRay){.org_x = c[0],
                           .org_y = c[stride],
                           .org_z = c[2 * (size_t)stride],
                           .dir_x = c[3 * (size_t)stride],
                           .dir_y = c[4 * (size_t)stride],
                           .dir_z = c[5 * (size_t)stride],
                           .tfar = t,
                           .mask = UINT32_MAX};
}

void __real_glint_geometry_trace_wave(const glint_geometry *g, float *wave, uint32_t stride,
                                      uint32_t n);
void __real_glint_geometry_shadow_wave(const glint_geometry *g, float *wave, uint32_t stride,
                                       uint32_t n);
void __wrap_glint_geometry_trace_wave(const glint_geometry *g, float *wave, uint32_t stride,
                                      uint32_t n);
void __wrap_glint_geometry_shadow_wave(const glint_geometry *g, float *wave, uint32_t stride,
                                       uint32_t n);

void __wrap_glint_geometry_trace_wave(const glint_geometry *g, float *wave, uint32_t stride,
                                      uint32_t n)
{
    for (uint32_t i = 0; record.on && i < n && record.hits < record.capacity; i++) {
        ray_hit r = {.ray = ray_at(wave, stride, i, GK_COL_OX, INFINITY)};
        r.hit.geomID = r.hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
        record.hit_kept[record.hits++] = r;
    }
    __real_glint_geometry_trace_wave(g, wave, stride, n);
}

void __wrap_glint_geometry_shadow_wave(const glint_geometry *g, float *wave, uint32_t stride,
                                       uint32_t n)
{
    for (uint32_t i = 0; record.on && i < n && record.shadows < record.capacity; i++) {
        const float t = wave[(size_t)GK_COL_ST * stride + i];
        if (t > 0.0f)
            record.shadow_kept[record.shadows++] = ray_at(wave, stride, i, GK_COL_SOX, t);
    }
    __real_glint_geometry_shadow_wave(g, wave, stride, n);
}

struct bench {
    struct offline o;
    glint_render *render;
    glint_worker *worker;
    struct glint_slice slice[BENCH_WAVES];
    RTCScene scene;
    int call;      // of Embree's, index into call_name
    uint32_t *soa; // columns of one batch for the Np calls
};

static const char *const call_name[] = {"1", "1M", "Np", "16"};
#define CALLS 4
#define BATCH 4096u

static double run_ours(void *user)
{
    struct bench *b = user;
    return bench_waves_run(b->render, b->worker, b->slice);
}

// Moves `count` rays of `words` words each into columns of BATCH and back.
static void to_columns(const void *rays, size_t words, size_t size, uint32_t *soa, size_t count)
{
    for (size_t i = 0; i < count; i++)
        for (size_t k = 0; k < words; k++)
            soa[k * BATCH + i] = ((const uint32_t *)((const char *)rays + i * size))[k];
}

static struct RTCRayNp ray_columns(uint32_t *c)
{
    float *f = (float *)c;
    return (struct RTCRayNp){f,
                             f + BATCH,
                             f + 2 * BATCH,
                             f + 3 * BATCH,
                             f + 4 * BATCH,
                             f + 5 * BATCH,
                             f + 6 * BATCH,
                             f + 7 * BATCH,
                             f + 8 * BATCH,
                             c + 9 * BATCH,
                             c + 10 * BATCH,
                             c + 11 * BATCH};
}

static double trace_np(struct bench *b, struct RTCIntersectContext *context)
{
    double seconds = 0.0;
    uint32_t *c = b->soa;
    float *f = (float *)c;
    struct RTCRayHitNp np = {ray_columns(c),
                             {f + 12 * BATCH,
                              f + 13 * BATCH,
                              f + 14 * BATCH,
                              f + 15 * BATCH,
                              f + 16 * BATCH,
                              c + 17 * BATCH,
                              c + 18 * BATCH,
                              {c + 19 * BATCH}}};
    for (size_t i = 0; i < record.hits; i += BATCH) {
        const size_t n = record.hits - i < BATCH ? record.hits - i : BATCH;
        to_columns(record.hit + i, 20, sizeof *record.hit, c, n);
        const double start = glint_thread_cpu();
        rtcIntersectNp(b->scene, context, &np, (unsigned)n);
        seconds += glint_thread_cpu() - start;
    }
    struct RTCRayNp shadow = ray_columns(c);
    for (size_t i = 0; i < record.shadows; i += BATCH) {
        const size_t n = record.shadows - i < BATCH ? record.shadows - i : BATCH;
        to_columns(record.shadow + i, 12, sizeof *record.shadow, c, n);
        const double start = glint_thread_cpu();
        rtcOccludedNp(b->scene, context, &shadow, (unsigned)n);
        seconds += glint_thread_cpu() - start;
    }
    return seconds;
}

static double trace_16(struct bench *b, struct RTCIntersectContext *context)
{
    double seconds = 0.0;
    int valid[16] __attribute__((aligned(64)));
    struct RTCRayHit16 packet[64];
    for (size_t i = 0; i < record.hits + record.shadows; i += 1024) {
        const bool shadows = i >= (record.hits & ~(size_t)1023);
        const size_t at = shadows ? i - (record.hits & ~(size_t)1023) : i;
        const size_t total = shadows ? record.shadows : record.hits & ~(size_t)1023;
        if (at + 1024 > total)
            break;
        memset(valid, -1, sizeof valid);
        for (size_t k = 0; k < 1024; k++)
            for (size_t w = 0; w < (shadows ? 12u : 20u); w++)
                ((uint32_t *)&packet[k / 16])[w * 16 + k % 16] =
                    shadows ? ((const uint32_t *)&record.shadow[at + k])[w]
                            : ((const uint32_t *)&record.hit[at + k])[w];
        const double start = glint_thread_cpu();
        for (int p = 0; p < 64; p++) {
            if (shadows)
                rtcOccluded16(valid, b->scene, context, (struct RTCRay16 *)&packet[p]);
            else
                rtcIntersect16(valid, b->scene, context, &packet[p]);
        }
        seconds += glint_thread_cpu() - start;
    }
    return seconds;
}

static double run_pure(void *user)
{
    struct bench *b = user;
    struct RTCIntersectContext context;
    rtcInitIntersectContext(&context);
    memcpy(record.hit, record.hit_kept, record.hits * sizeof *record.hit);
    memcpy(record.shadow, record.shadow_kept, record.shadows * sizeof *record.shadow);
    if (b->call == 2)
        return trace_np(b, &context);
    if (b->call == 3)
        return trace_16(b, &context);
    const double start = glint_thread_cpu();
    if (b->call == 0) {
        for (size_t i = 0; i < record.hits; i++)
            rtcIntersect1(b->scene, &context, &record.hit[i]);
        for (size_t i = 0; i < record.shadows; i++)
            rtcOccluded1(b->scene, &context, &record.shadow[i]);
    } else {
        for (size_t i = 0; i < record.hits; i += BATCH)
            rtcIntersect1M(b->scene, &context, &record.hit[i],
                           (unsigned)(record.hits - i < BATCH ? record.hits - i : BATCH),
                           sizeof *record.hit);
        for (size_t i = 0; i < record.shadows; i += BATCH)
            rtcOccluded1M(b->scene, &context, &record.shadow[i],
                          (unsigned)(record.shadows - i < BATCH ? record.shadows - i : BATCH),
                          sizeof *record.shadow);
    }
    return glint_thread_cpu() - start;
}

static void *aligned(size_t bytes)
{
    void *p = aligned_alloc(64, (bytes + 63) & ~(size_t)63);
    if (!p)
        exit(1);
    return p;
}

static void record_rays(struct bench *b)
{
    record.capacity = 1u << 21;
    record.hit = aligned(record.capacity * sizeof *record.hit);
    record.hit_kept = aligned(record.capacity * sizeof *record.hit);
    record.shadow = aligned(record.capacity * sizeof *record.shadow);
    record.shadow_kept = aligned(record.capacity * sizeof *record.shadow);
    b->soa = aligned((size_t)BATCH * 20 * 4);
    record.on = true;
    run_ours(b);
    record.on = false;
}

static void fastest_call(struct bench *b)
{
    double best = INFINITY;
    int fastest = 0;
    for (int call = 0; call < CALLS; call++) {
        b->call = call;
        double least = INFINITY;
        for (int i = 0; i < 3; i++)
            least = fmin(least, run_pure(b));
        printf("Embree call %-3s %7.1f ns per closest-hit ray, shadow rays included\n",
               call_name[call], least * 1e9 / (double)record.hits);
        fastest = least < best ? call : fastest;
        best = fmin(best, least);
    }
    b->call = fastest;
}

// What a render is asked for, and the least share that will do.
struct wanted {
    const char *job;
    double median, low;
};
static const struct wanted usual = {"\"outputs\":[\"beauty\",\"crypto_object\"]", 0.80, 0.78};
static const struct wanted all = {
    "\"outputs\":[\"beauty\",\"crypto_object\",\"crypto_material\",\"crypto_asset\",\"depth\","
    "\"normal\",\"albedo\",\"samples\",\"variance\"],\"mattes\":{\"through\":\"glossy\"}",
    0.65, 0.0};

static struct glint_job *job_of(const struct wanted *wanted)
{
    char text[512];
    snprintf(text, sizeof text, "{\"scene\":\"s\",\"resolution\":[256,256],%s}", wanted->job);
    return offline_job(text);
}

static void print_passes(const glint_render *render)
{
    cJSON *plan = glint_render_plan(render);
    const cJSON *pass;
    cJSON_ArrayForEach(pass, cJSON_GetObjectItem(plan, "passes"))
        printf("%5.1f %%  %s\n", 100.0 * cJSON_GetObjectItem(pass, "share")->valuedouble,
               cJSON_GetObjectItem(pass, "pass")->valuestring);
    cJSON_Delete(plan);
}

int main(int argc, char **argv)
{
    struct bench b = {0};
    struct glint_error err = {0};
    const struct glint_geometry *geometry;
    const bool more = argc > 1 && !strcmp(argv[1], "--all");
    const struct wanted *wanted = more ? &all : &usual;
    const char *path = argc > 1 + more ? argv[1 + more] : NULL;
    offline_start(&b.o, 1);
    glint_resident *scene = bench_waves_scene(&b.o, path).resident;
    struct glint_job *job = job_of(wanted);
    if (glint_render_create(&b.render, b.o.devices, scene, NULL, job, &err) ||
        glint_resident_geometry(scene, GLINT_GEOMETRY_FLAT, false, &geometry, &err))
        offline_die("render", &err);
    b.worker = glint_devices_worker(b.o.devices, 0);
    b.scene = glint_geometry_native(geometry);
    glint_worker_enter(b.worker);
    bench_waves_spread(b.slice, 16, 16);
    run_ours(&b);
    record_rays(&b);
    printf("%zu closest-hit and %zu shadow rays of %d waves\n", record.hits, record.shadows,
           BENCH_WAVES);
    fastest_call(&b);
    double ours[PAIRS], pure[PAIRS];
    bench_pairs(run_ours, run_pure, &b, ours, pure, PAIRS);
    const struct bench_ratio r = bench_ratio_of(ours, pure, PAIRS);
    print_passes(b.render);
    const bool pass = r.median >= wanted->median && r.low >= wanted->low;
    printf("{\"bench\":\"embree-share\",\"scene\":\"%s\",\"outputs\":\"%s\",\"ratio\":%.4f,"
           "\"low\":%.4f,\"high\":%.4f,\"pairs\":%d,\"call\":\"%s\","
           "\"ns_per_vertex\":%.1f,\"limit\":%.2f,\"pass\":%s}\n",
           path ? path : "million", more ? "all" : "usual", r.median, r.low, r.high, PAIRS,
           call_name[b.call], ours[0] * 1e9 / (double)record.hits, wanted->median,
           pass ? "true" : "false");
    glint_render_destroy(&b.render);
    glint_job_destroy(&job);
    glint_resident_release(&scene);
    offline_finish(&b.o);
    return pass ? 0 : 1;
}
