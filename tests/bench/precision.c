// precision - what each exact twin of a precision costs: CPU time of the exact one over that of the
// other, in interleaved pairs. One scene a call: SCENE.{json,glb,gltf}.
//
//   float64      accuracy.precision float64 over float32: sums of paths and of the film
//   robust       accuracy.traversal robust over fast
//   watertight   accuracy.traversal watertight over fast
//   float        a frame with colour as float over one with half, encoded; bytes likewise
//   fixed        deposits of coverage in fixed point over the same in double precision
#include "base/clock.h"
#include "protocol/exr.h"
#include "tests/bench/waves.h"
#include "tests/kernel/matte_double.h"
#include "tests/render/offline.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { PAIRS = 15, COLUMNS = 20, ROWS = 12, DEPOSITS = 400000, SLOTS = 12 };

struct bench {
    struct offline o;
    struct glint_posed rest;
    glint_worker *worker;
    const struct glint_frame *frame;
};

// ---- dials

static glint_render *make(struct bench *b, const char *dial)
{
    struct glint_error err = {0};
    char text[256];
    glint_render *render = NULL;
    snprintf(text, sizeof text,
             "{\"scene\":\"s\",\"resolution\":[%d,%d],\"stop\":{\"samples\":1024},"
             "\"accuracy\":{%s}}",
             COLUMNS * 16, ROWS * 16, dial);
    struct glint_job *job = offline_job(text);
    if (glint_render_create(&render, b->o.devices, b->rest.resident, b->rest.pose, job, &err))
        offline_die("render", &err);
    glint_job_destroy(&job);
    return render;
}

static void print_ratio(const char *name, struct bench_ratio r)
{
    printf(",\"%s\":{\"ratio\":%.4f,\"low\":%.4f,\"high\":%.4f}", name, r.median, r.low, r.high);
    fflush(stdout);
}

static void compare(struct bench *b, const char *name, double (*first)(void *),
                    double (*second)(void *))
{
    double cost_a[PAIRS], cost_b[PAIRS];
    first(b);
    second(b);
    bench_pairs(first, second, b, cost_a, cost_b, PAIRS);
    print_ratio(name, bench_ratio_of(cost_a, cost_b, PAIRS));
}

static void compare_dial(struct bench *b, const char *name, const char *other, const char *exact)
{
    print_ratio(name,
                bench_waves_ratio(b->worker, make(b, other), make(b, exact), COLUMNS, ROWS, PAIRS));
}

// ---- output

static double encode(const struct glint_frame *frame, bool floats, size_t *size)
{
    const double start = glint_thread_cpu();
    const struct glint_exr_options options = {.compression = GLINT_EXR_ZIP, .floats = floats};
    struct glint_error err = {0};
    uint8_t *bytes;
    if (glint_exr_write(frame, &options, &bytes, size, NULL, &err))
        offline_die("frame", &err);
    free(bytes);
    return glint_thread_cpu() - start;
}

static double encode_half(void *user)
{
    size_t size;
    return encode(((struct bench *)user)->frame, false, &size);
}

static double encode_float(void *user)
{
    size_t size;
    return encode(((struct bench *)user)->frame, true, &size);
}

static void compare_output(struct bench *b)
{
    char text[256];
    size_t half, whole;
    snprintf(text, sizeof text,
             "{\"scene\":\"s\",\"resolution\":[%d,%d],\"stop\":{\"samples\":4},"
             "\"outputs\":[\"beauty\"]}",
             COLUMNS * 16, ROWS * 16);
    struct glint_frame *frame = offline_frame_posed(&b->o, &b->rest, text, 0);
    b->frame = frame;
    compare(b, "float", encode_half, encode_float);
    encode(frame, false, &half);
    encode(frame, true, &whole);
    printf(",\"float_bytes\":%.4f", (double)whole / (double)half);
    glint_frame_destroy(&frame);
}

// ---- mattes

// The same keys and weights for both; nine keys, so that nothing is evicted.
static uint32_t next(uint32_t *random)
{
    return *random = *random * 1664525u + 1013904223u;
}

static double deposit_double(void *user)
{
    (void)user;
    static struct matte_double table[256][SLOTS];
    const double start = glint_thread_cpu();
    uint32_t random = 1;
    memset(table, 0, sizeof table);
    for (uint32_t i = 0; i < DEPOSITS; i++) {
        const uint32_t key = 1 + (next(&random) >> 28) % 9;
        matte_double_deposit(table[i & 255], SLOTS, key, (double)(next(&random) >> 8) * 0x1p-24);
    }
    return glint_thread_cpu() - start;
}

static double deposit_fixed(void *user)
{
    (void)user;
    static uint64_t table[256][SLOTS + 1];
    const double start = glint_thread_cpu();
    uint32_t random = 1;
    memset(table, 0, sizeof table);
    struct gk_matte_lost lost = {0, 0};
    for (uint32_t i = 0; i < DEPOSITS; i++) {
        const uint32_t key = 1 + (next(&random) >> 28) % 9;
        const uint32_t units = gk_matte_units((float)(next(&random) >> 8) * 0x1p-24f);
        gk_matte_deposit(table[i & 255], SLOTS, key, 0, units, GK_MATTE_USS, random, &lost);
    }
    return glint_thread_cpu() - start;
}

int main(int argc, char **argv)
{
    if (argc != 2)
        return fprintf(stderr, "usage: precision SCENE\n"), 64;
    struct bench b = {0};
    const char *name = strrchr(argv[1], '/');
    offline_start(&b.o, 1);
    b.rest = offline_load_posed(&b.o, argv[1]);
    b.worker = glint_devices_worker(b.o.devices, 0);
    glint_worker_enter(b.worker);
    printf("{\"bench\":\"precision\",\"scene\":\"%s\",\"pairs\":%d", name ? name + 1 : argv[1],
           PAIRS);
    compare_dial(&b, "float64", "\"precision\":\"float32\"", "\"precision\":\"float64\"");
    compare_dial(&b, "robust", "\"traversal\":\"fast\"", "\"traversal\":\"robust\"");
    compare_dial(&b, "watertight", "\"traversal\":\"fast\"", "\"traversal\":\"watertight\"");
    compare_output(&b);
    compare(&b, "fixed", deposit_double, deposit_fixed);
    puts("}");
    glint_resident_release(&b.rest.resident);
    offline_finish(&b.o);
    return 0;
}
