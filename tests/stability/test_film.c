// The film: sums over millions of samples, rejected samples, resuming, order of slices.
#include "tests/stability/stable.h"

#include "kernels/gk_film.h"
#include "kernels/gk_wave.h"
#include "render/hold.h"

#include <math.h>
#include <pthread.h>
#include <stdlib.h>
#include <string.h>

static struct offline o;

#define UNIT 0x1p-24

// ---- sums on the host, from the header that kernels use

static double addend(int kind, uint64_t *seed)
{
    switch (kind) {
    case 0:
        return 1.0; // a plain sum stops at 2^24
    case 1:
        return (float)0.05; // vanishes at 2^20
    case 2:
        return (float)stable_random(seed);
    default:
        return (float)ldexp(stable_random(seed),
                            (int)(stable_random(seed) * 40) - 20); // 12 decades
    }
}

static void sums_of_millions_keep_four_units(void **state)
{
    (void)state;
    static const uint32_t count[] = {1000000, 20000000, 1000000, 1000000};
    for (int kind = 0; kind < 4; kind++) {
        float sum[GK_SUM_PLANES * GK_TILE_PIXELS] = {0};
        double exact = 0.0, lost = 0.0; // Kahan in double: exact to far below u
        uint64_t seed = 11;
        for (uint32_t i = 0; i < count[kind]; i++) {
            const double x = addend(kind, &seed), y = x - lost, t = exact + y;
            lost = t - exact - y;
            exact = t;
            gk_film_add(sum, 3, (float)x);
        }
        const double total = (double)sum[3] + sum[3 + GK_TILE_PIXELS] + sum[3 + 2 * GK_TILE_PIXELS];
        print_message("# kind %d: %.3g u\n", kind, (total / exact - 1.0) / UNIT);
        assert_true(fabs(total / exact - 1.0) <= 4.0 * UNIT);
    }
}

// ---- the accumulation kernel

#define LANES 256u

struct bench {
    glint_program *program;
    glint_buffer *wave, *film;
};

static void bench_open(struct bench *b, const char *options)
{
    struct glint_error err = {0};
    if (glint_program_get(&b->program, o.devices, options, &err) ||
        glint_buffer_create(&b->wave, o.devices, GK_COLUMNS * LANES * 4, &err) ||
        glint_buffer_create(&b->film, o.devices, GK_PLANES_BASE * GK_TILE_PIXELS * 4, &err))
        offline_die("film", &err);
    memset(glint_buffer_host(b->wave), 0, GK_COLUMNS * LANES * 4);
    memset(glint_buffer_host(b->film), 0, GK_PLANES_BASE * GK_TILE_PIXELS * 4);
}

static void bench_close(struct bench *b)
{
    glint_buffer_destroy(&b->wave);
    glint_buffer_destroy(&b->film);
    glint_program_release(&b->program);
}

static void bench_add(const struct bench *b)
{
    const uint32_t stride = LANES, zero = 0;
    const struct glint_arg args[] = {{.buffer = b->wave},         {.value = &stride, .size = 4},
                                     {.value = &zero, .size = 4}, {.buffer = b->film},
                                     {.value = &zero, .size = 4}, {.value = &zero, .size = 4}};
    struct glint_error err = {0};
    if (glint_launch(glint_devices_spare(o.devices), b->program, "accumulate_colour", LANES, 64,
                     args, 6, &err))
        offline_die("accumulate_colour", &err);
}

static float *column(const struct bench *b, int index)
{
    return (float *)glint_buffer_host(b->wave) + (size_t)index * LANES;
}

// 256 pixels of 8192 samples, upon sums of up to 2^20, against double precision, and against the
// same sums on the host, word for word.
static void check_kernel(const char *options, bool wide)
{
    struct bench b;
    double exact[LANES];
    static float host[GK_SUM_PLANES * GK_TILE_PIXELS];
    uint64_t seed = 5;
    bench_open(&b, options);
    float *red = glint_buffer_host(b.film);
    for (uint32_t i = 0; i < LANES; i++) {
        exact[i] = ldexp(1.0, (int)(i % 21));
        if (wide)
            ((double *)(void *)red)[i] = exact[i];
        else
            red[i] = (float)exact[i];
        host[i] = (float)exact[i];
        host[i + GK_TILE_PIXELS] = host[i + 2 * GK_TILE_PIXELS] = 0.0f;
    }
    for (int n = 0; n < 8192; n++) {
        for (uint32_t i = 0; i < LANES; i++) {
            column(&b, GK_COL_LR)[i] = (float)addend(1 + (int)(i % 3), &seed);
            exact[i] += column(&b, GK_COL_LR)[i];
            gk_film_add(host, i, column(&b, GK_COL_LR)[i]);
        }
        bench_add(&b);
    }
    for (uint32_t i = 0; i < LANES; i++) {
        const double total =
            wide ? ((double *)(void *)red)[i] : (double)red[i] + red[i + GK_TILE_PIXELS];
        assert_true(fabs(total / exact[i] - 1.0) <= 4.0 * UNIT);
    }
    assert_true(wide || memcmp(red, host, sizeof host) == 0);
    bench_close(&b);
}

static void kernel_loses_nothing_in_either_precision(void **state)
{
    (void)state;
    check_kernel("", false);
    check_kernel("-DGK_FILM_FP64", true);
}

// Adds what 4096 shadow rays bring to each of 256 lanes, takes the samples into the film, and
// compares with double precision: the largest relative error, in u.
static double path_error(const char *options, bool wide)
{
    struct bench b;
    double exact[LANES] = {0}, largest = 0.0;
    uint64_t seed = 9;
    bench_open(&b, options);
    const uint32_t stride = LANES;
    const struct glint_arg args[] = {{.buffer = b.wave}, {.value = &stride, .size = 4}};
    struct glint_error err = {0};
    for (uint32_t i = 0; i < LANES; i++) {
        memcpy(&column(&b, GK_COL_SLANE)[i], &i, 4);
        column(&b, GK_COL_ST)[i] = 1.0f;
    }
    for (int k = 0; k < 4096; k++) {
        for (uint32_t i = 0; i < LANES; i++)
            exact[i] += column(&b, GK_COL_SR)[i] = (float)stable_random(&seed);
        if (glint_launch(glint_devices_spare(o.devices), b.program, "add_unoccluded", LANES, 64,
                         args, 2, &err))
            offline_die("add_unoccluded", &err);
    }
    bench_add(&b);
    const float *red = glint_buffer_host(b.film);
    for (uint32_t i = 0; i < LANES; i++) {
        const double sum = wide ? ((const double *)(const void *)red)[i] : red[i];
        largest = fmax(largest, fabs(sum / exact[i] - 1.0) / UNIT);
    }
    bench_close(&b);
    return largest;
}

// Of n = 4096 roundings: n u is the bound in floats, where some tens are usual, and n^2 u^2, 1 u, of
// pairs of floats, where their random signs leave a millionth of that.
static void a_path_s_sum_rounds_in_floats_and_not_in_double(void **state)
{
    (void)state;
    const double narrow = path_error("", false), wide = path_error("-DGK_FILM_FP64", true);
    print_message("# of 4096 terms: %.3g u in floats, %.3g u in double\n", narrow, wide);
    assert_true(narrow > 1.0 && narrow <= 4096.0);
    assert_true(wide <= 0x1p-10);
}

static void sample_that_is_not_finite_counts_as_zero_and_is_counted(void **state)
{
    (void)state;
    static const float bad[3] = {NAN, INFINITY, -INFINITY};
    struct bench b;
    bench_open(&b, "");
    for (int c = 0; c < 3; c++)
        for (uint32_t i = 0; i < LANES; i++)
            column(&b, GK_COL_LR + c)[i] = i % 9 == 3u * (uint32_t)c ? bad[i / 9 % 3] : 0.5f;
    bench_add(&b);
    bench_add(&b);
    const float *film = glint_buffer_host(b.film);
    const uint32_t *rejected = (const uint32_t *)film + GK_PLANE_REJECTED * GK_TILE_PIXELS;
    for (uint32_t i = 0; i < LANES; i++) {
        const bool refused = i % 3 == 0 && i % 9 <= 6;
        assert_int_equal(rejected[i], refused ? 2 : 0);
        for (int c = 0; c < 3; c++)
            assert_float_equal(film[GK_SUM_PLANES * c * GK_TILE_PIXELS + (int)i],
                               refused ? 0.0 : 1.0, 0.0);
    }
    bench_close(&b);
}

// ---- renders that are interrupted

static const char *const scene_text =
    "{'materials':{'grey':{'base_color':[0.6,0.5,0.4]},'glass':{'transmission':1,'roughness':0.2},"
    "'lamp':{'base_color':[0,0,0],'emission':[5,4,3]}},"
    "'meshes':{'room':{'primitive':'box','size':[4,4,8]},'s':{'primitive':'sphere','segments':24},'"
    "q':{'primitive':'quad'}},"
    "'instances':{'r':{'mesh':'room','material':'grey'},'s':{'mesh':'s','material':'glass'},"
    "'l':{'mesh':'q','material':'lamp','transform':{'translation':[0,1.9,1],'rotation':[1,0,0,1]}}}"
    ","
    "'cameras':{'eye':{'yfov':0.9,'transform':{'translation':[0,0,3.5]}}}}";

static glint_render *begin(glint_resident *scene, unsigned samples)
{
    struct glint_error err = {0};
    char *text = stable_text(
        "{'scene':'s','outputs':['beauty','variance','crypto_object','depth','normal'],"
        "'resolution':[80,48],'max_bounces':4,'mattes':{'through':'glossy'},'stop':{'samples':%u}}",
        samples);
    struct glint_job *job = offline_job(text);
    glint_render *render = NULL;
    if (glint_render_create(&render, o.devices, scene, NULL, job, &err))
        offline_die("render", &err);
    glint_job_destroy(&job);
    free(text);
    return render;
}

static void run_slice(glint_render *render, struct glint_slice *slice)
{
    struct glint_error err = {0};
    atomic_uint hold = GLINT_HOLD_WAITING;
    slice->hold = &hold;
    if (glint_render_run(render, glint_devices_worker(o.devices, 0), slice, &err))
        offline_die("slice", &err);
    assert_false(glint_hold_revoke(&hold)); // it has written
}

static void *revoke_while_it_is_traced(void *hold)
{
    while (!glint_hold_revoke(hold))
        if (atomic_load((atomic_uint *)hold) == GLINT_HOLD_WRITING)
            return NULL;
    return hold;
}

// It is taken away before the worker takes it up, or while it is traced: which is the system's
// choice. Whether it was done.
static bool run_in_vain(glint_render *render, struct glint_slice *slice)
{
    struct glint_render_state before, after;
    atomic_uint hold = GLINT_HOLD_WAITING;
    pthread_t other;
    void *revoked;
    slice->hold = &hold;
    glint_render_state(render, &before);
    pthread_create(&other, NULL, revoke_while_it_is_traced, &hold);
    const glint_status st =
        glint_render_run(render, glint_devices_worker(o.devices, 0), slice, NULL);
    pthread_join(other, &revoked);
    glint_render_state(render, &after);
    assert_int_equal(st, revoked ? GLINT_E_BUSY : GLINT_OK);
    if (!revoked)
        return true;
    assert_int_equal(before.camera_rays, after.camera_rays);
    assert_int_equal(before.bounce_rays, after.bounce_rays);
    return false;
}

static struct glint_frame *frame_of(glint_render *render)
{
    struct glint_error err = {0};
    struct glint_frame *frame = NULL;
    const uint32_t outputs = GLINT_OUT_BEAUTY | GLINT_OUT_VARIANCE | GLINT_OUT_CRYPTO_OBJECT |
                             GLINT_OUT_DEPTH | GLINT_OUT_NORMAL;
    if (glint_render_frame(render, outputs, &frame, NULL, &err))
        offline_die("frame", &err);
    return frame;
}

static struct glint_frame *uninterrupted(glint_resident *scene, unsigned samples)
{
    glint_render *render = begin(scene, samples);
    offline_render(&o, render);
    struct glint_frame *frame = frame_of(render);
    glint_render_destroy(&render);
    return frame;
}

static void render_stopped_at_n_and_run_on_is_one_render(void **state)
{
    (void)state;
    glint_resident *scene = offline_load_text(&o, (const char *)*state);
    glint_render *render = begin(scene, 24);
    struct glint_render_state now = {0};
    struct glint_slice slice;
    while (now.samples < 16 && glint_render_take(render, &slice)) {
        run_slice(render, &slice);
        glint_render_give_back(render, &slice, true);
        glint_render_state(render, &now);
    }
    assert_int_equal(now.samples, 16);
    struct glint_frame *half_way = frame_of(render), *short_job = uninterrupted(scene, 16);
    stable_assert_same(half_way, short_job);
    offline_render(&o, render);
    struct glint_frame *resumed = frame_of(render), *whole = uninterrupted(scene, 24);
    stable_assert_same(resumed, whole);
    struct glint_frame *all[] = {half_way, short_job, resumed, whole};
    for (int i = 0; i < 4; i++)
        glint_frame_destroy(&all[i]);
    glint_render_destroy(&render);
    glint_resident_release(&scene);
}

// All slices of a pass are taken; they come back in reverse, every third taken away while it was
// traced.
static bool run_backwards(glint_render *render)
{
    struct glint_slice slice[256];
    uint32_t n = 0;
    while (n < 256 && glint_render_take(render, &slice[n]))
        n++;
    const bool any = n > 0;
    while (n-- > 0) {
        bool done = n % 3 != 1;
        if (done)
            run_slice(render, &slice[n]);
        else
            done = run_in_vain(render, &slice[n]);
        glint_render_give_back(render, &slice[n], done);
    }
    return any;
}

static void assert_order_changes_nothing(const char *text)
{
    glint_resident *scene = offline_load_text(&o, text);
    glint_render *render = begin(scene, 24);
    while (run_backwards(render))
        ;
    assert_true(glint_render_complete(render));
    struct glint_frame *backwards = frame_of(render), *whole = uninterrupted(scene, 24);
    stable_assert_same(backwards, whole);
    glint_frame_destroy(&backwards);
    glint_frame_destroy(&whole);
    glint_render_destroy(&render);
    glint_resident_release(&scene);
}

static void order_of_slices_and_returned_ones_change_no_bit(void **state)
{
    assert_order_changes_nothing(*state);
}

// What scatters in fog on its way to nothing chose its light by what another ray had hit.
static void order_of_slices_changes_no_bit_in_fog(void **state)
{
    (void)state;
    char *text = stable_text(
        "{'materials':{'grey':{},'lamp':{'base_color':[0,0,0],'emission':[5,4,3]}},"
        "'meshes':{'s':{'primitive':'sphere','segments':12}},"
        "'instances':{'a':{'mesh':'s','material':'grey'},'l':{'mesh':'s','material':'lamp',"
        "'transform':{'translation':[1.5,1,0],'scale':[0.3,0.3,0.3]}}},"
        "'media':{'fog':{'density':0.3}},'environment':{'radiance':[0.1,0.1,0.1]},"
        "'cameras':{'eye':{'yfov':0.9,'transform':{'translation':[0,0,4]}}}}");
    assert_order_changes_nothing(text);
    free(text);
}

static int start(void **state)
{
    offline_start(&o, offline_workers());
    *state = stable_text("%s", scene_text);
    glint_worker_enter(glint_devices_spare(o.devices));
    return 0;
}

static int finish(void **state)
{
    free(*state);
    offline_finish(&o);
    return 0;
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(sums_of_millions_keep_four_units),
        cmocka_unit_test(kernel_loses_nothing_in_either_precision),
        cmocka_unit_test(a_path_s_sum_rounds_in_floats_and_not_in_double),
        cmocka_unit_test(sample_that_is_not_finite_counts_as_zero_and_is_counted),
        cmocka_unit_test(render_stopped_at_n_and_run_on_is_one_render),
        cmocka_unit_test(order_of_slices_and_returned_ones_change_no_bit),
        cmocka_unit_test(order_of_slices_changes_no_bit_in_fog),
    };
    return cmocka_run_group_tests(tests, start, finish);
}
