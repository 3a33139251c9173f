// Devices, programs, buffers and launches, with kernels of the test's own.
#include "device/device.h"
#include "device/program.h"

#include <math.h>
#include <pthread.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include <cmocka.h>

#define WORKERS 3u
#define ITEMS 4096u

static const char source[] =
    "#pragma OPENCL FP_CONTRACT OFF\n"
    "__kernel void fill(__global uint *out, uint first, uint value)\n"
    "{\n"
    "    out[first + get_global_id(0)] = value + get_global_id(0);\n"
    "}\n"
    "__kernel void multiply_add(__global const float *x, __global float *out)\n"
    "{\n"
    "    out[0] = x[0] * x[1] + x[2];\n"
    "    out[1] = fma(x[0], x[1], x[2]);\n"
    "}\n"
    "__kernel void divide(__global const float *x, __global float *out)\n"
    "{\n"
    "    const float q = x[0] / x[1];\n"
    "    out[0] = q;\n"
    "    out[1] = q != q;\n"
    "}\n"
    "__kernel void absent(__global const float *x, __global float *out)\n"
    "{\n"
    "    out[0] = x ? 1.0f : 2.0f;\n"
    "}\n"
    "#ifdef GK_THREE\n"
    "__kernel void three(__global uint *out) { out[0] = 3u; }\n"
    "#endif\n";

struct fixture {
    glint_devices *devices;
    glint_program *program;
    glint_buffer *in, *out;
};

static int open_devices(void **state)
{
    struct fixture *f = calloc(1, sizeof *f);
    struct glint_error err = {0};
    *state = f;
    if (!f || glint_devices_create(&f->devices, WORKERS, getenv("GLINT_TEST_CACHE"), &err) ||
        glint_program_build(&f->program, f->devices, source, "", &err) ||
        glint_buffer_create(&f->in, f->devices, 64, &err) ||
        glint_buffer_create(&f->out, f->devices, WORKERS * ITEMS * sizeof(uint32_t), &err))
        fail_msg("%s", glint_error_text(&err));
    return 0;
}

static int close_devices(void **state)
{
    struct fixture *f = *state;
    glint_buffer_destroy(&f->in);
    glint_buffer_destroy(&f->out);
    glint_program_release(&f->program);
    glint_devices_destroy(&f->devices);
    free(f);
    return 0;
}

static void launch_pair(struct fixture *f, const char *kernel, const float *x, size_t count)
{
    memcpy(glint_buffer_host(f->in), x, count * sizeof *x);
    const struct glint_arg args[] = {{.buffer = f->in}, {.buffer = f->out}};
    struct glint_error err = {0};
    if (glint_launch(glint_devices_worker(f->devices, 0), f->program, kernel, 1, 1, args, 2, &err))
        fail_msg("%s", glint_error_text(&err));
}

static void contraction_is_left_to_the_source(void **state)
{
    struct fixture *f = *state;
    // x*x = 1 + 2^-11 + 2^-24 rounds to 1 + 2^-11; only fma keeps the last term.
    const float x = 1 + 0x1p-12f;
    launch_pair(f, "multiply_add", (const float[]){x, x, -(1 + 0x1p-11f)}, 3);
    const float *out = glint_buffer_host(f->out);
    assert_true(out[0] == 0.0f);
    assert_true(out[1] == 0x1p-24f);
}

static void infinity_and_nan_are_values(void **state)
{
    struct fixture *f = *state;
    const float *out = glint_buffer_host(f->out);
    launch_pair(f, "divide", (const float[]){1, 0}, 2);
    assert_true(isinf(out[0]) && out[1] == 0);
    launch_pair(f, "divide", (const float[]){0, 0}, 2);
    assert_true(isnan(out[0]) && out[1] == 1);
}

static void denormals_are_zero_in_kernels(void **state)
{
    struct fixture *f = *state;
    const float *out = glint_buffer_host(f->out);
    launch_pair(f, "divide", (const float[]){0x1p-126f, 2}, 2); // a denormal result
    assert_true(out[0] == 0.0f);
    launch_pair(f, "divide", (const float[]){0x1p-127f, 0x1p-127f}, 2); // denormal operands: 0/0
    assert_true(isnan(out[0]));
}

static void *divide_on_this_thread(void *arg)
{
    glint_worker_enter(arg);
    volatile float small = 0x1p-126f, two = 2;
    static float quotient;
    quotient = small / two;
    return &quotient;
}

static void denormals_are_zero_on_a_worker_thread(void **state)
{
    struct fixture *f = *state;
    pthread_t thread;
    void *quotient;
    assert_int_equal(
        pthread_create(&thread, NULL, divide_on_this_thread, glint_devices_worker(f->devices, 1)),
        0);
    assert_int_equal(pthread_join(thread, &quotient), 0);
    assert_true(*(float *)quotient == 0.0f);
}

static void an_absent_buffer_is_a_null_pointer(void **state)
{
    struct fixture *f = *state;
    const struct glint_arg args[] = {{.buffer = NULL}, {.buffer = f->out}};
    assert_int_equal(glint_launch(glint_devices_worker(f->devices, 0), f->program, "absent", 1, 1,
                                  args, 2, NULL),
                     GLINT_OK);
    assert_true(*(float *)glint_buffer_host(f->out) == 2.0f);
}

struct job {
    struct fixture *f;
    glint_program *program;
    uint32_t worker;
    glint_status status;
};

static void join_workers(struct fixture *f, glint_program *program, void *(*body)(void *),
                         struct job job[WORKERS])
{
    pthread_t thread[WORKERS];
    for (uint32_t i = 0; i < WORKERS; i++) {
        job[i] = (struct job){.f = f, .program = program, .worker = i};
        assert_int_equal(pthread_create(&thread[i], NULL, body, &job[i]), 0);
    }
    for (uint32_t i = 0; i < WORKERS; i++)
        assert_int_equal(pthread_join(thread[i], NULL), 0);
}

static void *fill_own_part(void *arg)
{
    struct job *job = arg;
    glint_worker *worker = glint_devices_worker(job->f->devices, job->worker);
    const uint32_t first = job->worker * ITEMS, value = 1000 * job->worker;
    const struct glint_arg args[] = {
        {.buffer = job->f->out},
        {.value = &first, .size = sizeof first},
        {.value = &value, .size = sizeof value},
    };
    glint_worker_enter(worker);
    for (int i = 0; i < 200 && !job->status; i++)
        job->status = glint_launch(worker, job->program, "fill", ITEMS, 64, args, 3, NULL);
    return NULL;
}

static void workers_write_one_buffer_side_by_side(void **state)
{
    struct fixture *f = *state;
    struct job job[WORKERS];
    memset(glint_buffer_host(f->out), 0, glint_buffer_bytes(f->out));
    join_workers(f, f->program, fill_own_part, job);
    const uint32_t *out = glint_buffer_host(f->out);
    for (uint32_t i = 0; i < WORKERS; i++) {
        assert_int_equal(job[i].status, GLINT_OK);
        for (uint32_t k = 0; k < ITEMS; k++)
            assert_int_equal(out[i * ITEMS + k], 1000 * i + k);
    }
}

#define MANY 24

static void *launch_ever_larger(void *arg)
{
    struct job *job = arg;
    const struct glint_arg args[] = {{.buffer = job->f->out}};
    char name[16];
    for (size_t items = 64; items <= ITEMS; items *= 2)
        for (int k = 0; k < MANY && !job->status; k++) {
            snprintf(name, sizeof name, "kernel%d", (k + 13 * (int)job->worker) % MANY);
            job->status = glint_launch(glint_devices_worker(job->f->devices, job->worker),
                                       job->program, name, items, 64, args, 1, NULL);
        }
    return NULL;
}

// PoCL 3.1 ends the process when launches of a kernel it is about to load again run side by side;
// it keeps 128 and here 168 are loaded.
static void workers_that_launch_ever_larger_do_not_disturb_each_other(void **state)
{
    struct fixture *f = *state;
    char *text = NULL;
    size_t size;
    FILE *out = open_memstream(&text, &size);
    for (int k = 0; k < MANY; k++)
        fprintf(out, "__kernel void kernel%d(__global uint *out) { out[0] = %du; }\n", k, k);
    assert_int_equal(fclose(out), 0);
    glint_program *program;
    struct job job[WORKERS];
    assert_int_equal(glint_program_build(&program, f->devices, text, "", NULL), GLINT_OK);
    for (int round = 0; round < 3; round++) {
        join_workers(f, program, launch_ever_larger, job);
        for (uint32_t i = 0; i < WORKERS; i++)
            assert_int_equal(job[i].status, GLINT_OK);
    }
    glint_program_release(&program);
    free(text);
}

static void a_variant_is_built_once(void **state)
{
    struct fixture *f = *state;
    glint_program *same, *other;
    assert_int_equal(glint_program_build(&same, f->devices, source, "", NULL), GLINT_OK);
    assert_ptr_equal(same, f->program);
    assert_int_equal(glint_program_build(&other, f->devices, source, "-DGK_THREE", NULL), GLINT_OK);
    assert_ptr_not_equal(other, f->program);
    assert_string_not_equal(glint_program_key(other), glint_program_key(f->program));
    const struct glint_arg args[] = {{.buffer = f->out}};
    assert_int_equal(
        glint_launch(glint_devices_worker(f->devices, 0), other, "three", 1, 1, args, 1, NULL),
        GLINT_OK);
    assert_int_equal(*(uint32_t *)glint_buffer_host(f->out), 3);
    glint_program_release(&same);
    glint_program_release(&other);
    assert_null(other);
}

static void idle_variants_are_dropped_and_held_ones_stay(void **state)
{
    struct fixture *f = *state;
    char options[32];
    for (int i = 0; i < 40; i++) {
        glint_program *p;
        snprintf(options, sizeof options, "-DNUMBER=%d", i);
        assert_int_equal(
            glint_program_build(&p, f->devices, "__kernel void none(void) {}\n", options, NULL),
            GLINT_OK);
        glint_program_release(&p);
    }
    glint_program *same;
    assert_int_equal(glint_program_build(&same, f->devices, source, "", NULL), GLINT_OK);
    assert_ptr_equal(same, f->program);
    glint_program_release(&same);
}

static void a_broken_kernel_gives_the_build_log(void **state)
{
    struct fixture *f = *state;
    struct glint_error err = {0};
    glint_program *p;
    assert_int_equal(glint_program_build(&p, f->devices,
                                         "#line 7 \"kernels/wrong.cl\"\n"
                                         "__kernel void wrong(void) { not_declared_anywhere(); }\n",
                                         "", &err),
                     GLINT_E_DEVICE);
    assert_null(p);
    assert_non_null(strstr(glint_error_text(&err), "not_declared_anywhere"));
    assert_non_null(strstr(glint_error_text(&err), "kernels/wrong.cl:7"));
    glint_error_finish(&err);
}

static void faulty_launches_are_refused(void **state)
{
    struct fixture *f = *state;
    glint_worker *w = glint_devices_worker(f->devices, 0);
    struct glint_error err = {0};
    assert_int_equal(glint_launch(w, f->program, "missing", 1, 1, NULL, 0, &err), GLINT_E_DEVICE);
    assert_non_null(strstr(glint_error_text(&err), "missing"));
    glint_error_finish(&err);
    const uint16_t narrow = 0;
    const struct glint_arg args[] = {{.buffer = f->out}, {.value = &narrow, .size = sizeof narrow}};
    assert_int_equal(glint_launch(w, f->program, "fill", 1, 1, args, 2, &err), GLINT_E_DEVICE);
    assert_non_null(strstr(glint_error_text(&err), "argument 1"));
    glint_error_finish(&err);
    assert_int_equal(glint_launch(w, f->program, "fill", 0, 64, NULL, 0, NULL), GLINT_OK);
}

static void buffers_are_zeroed_whole_pages(void **state)
{
    struct fixture *f = *state;
    glint_buffer *b;
    assert_int_equal(glint_buffer_create(&b, f->devices, 5000, NULL), GLINT_OK);
    const unsigned char *byte = glint_buffer_host(b);
    assert_int_equal((uintptr_t)byte % (uintptr_t)sysconf(_SC_PAGESIZE), 0);
    assert_int_equal(glint_buffer_bytes(b), 5000);
    for (size_t i = 0; i < 5000; i++)
        assert_int_equal(byte[i], 0);
    glint_buffer_destroy(&b);
    assert_null(b);
    glint_buffer_destroy(&b);
}

static void a_buffer_over_one_gibibyte_is_refused(void **state)
{
    struct fixture *f = *state;
    glint_buffer *b;
    assert_int_equal(glint_buffer_create(&b, f->devices, ((size_t)1 << 30) + 1, NULL),
                     GLINT_E_CAPACITY);
    assert_null(b);
}

static void devices_can_be_opened_again_with_another_count(void **state)
{
    (void)state;
    for (uint32_t workers = 1; workers <= 5; workers++) {
        glint_devices *d;
        assert_int_equal(glint_devices_create(&d, workers, NULL, NULL), GLINT_OK);
        assert_int_equal(glint_devices_workers(d), workers);
        assert_int_equal(glint_worker_index(glint_devices_worker(d, workers - 1)), workers - 1);
        assert_true(*glint_devices_name(d) && *glint_devices_version(d));
        glint_devices_destroy(&d);
    }
    glint_devices *d;
    assert_int_equal(glint_devices_create(&d, 257, NULL, NULL), GLINT_E_RANGE);
    assert_null(d);
}

static void embedded_kernels_build(void **state)
{
    struct fixture *f = *state;
    struct glint_error err = {0};
    glint_program *p;
    if (glint_program_get(&p, f->devices, "", &err))
        fail_msg("%s", glint_error_text(&err));
    glint_program_release(&p);
}

#define TEXT(name, text)            \
    {                               \
        name, text, sizeof text - 1 \
    }

static void includes_are_expanded_once_and_keep_line_numbers(void **state)
{
    (void)state;
    const struct glint_source table[] = {
        TEXT("kernels/gk_a.h", "int a;\n#include \"kernels/gk_b.h\"\nint aa;"),
        TEXT("kernels/gk_b.h", "int b;\n"),
        TEXT("kernels/one.cl",
             "#include \"kernels/gk_a.h\"\n#include \"kernels/gk_b.h\"\nint one;\n"),
        TEXT("kernels/two.cl", "#include \"kernels/gk_b.h\"\nint two;\n"),
        {0, 0, 0},
    };
    char *text;
    assert_int_equal(glint_source_expand(&text, table, NULL), GLINT_OK);
    assert_string_equal(text, "#pragma OPENCL FP_CONTRACT OFF\n"
                              "#line 1 \"kernels/one.cl\"\n"
                              "#line 1 \"kernels/gk_a.h\"\nint a;\n"
                              "#line 1 \"kernels/gk_b.h\"\nint b;\n\n"
                              "#line 3 \"kernels/gk_a.h\"\nint aa;\n\n"
                              "#line 2 \"kernels/one.cl\"\n\n"
                              "#line 3 \"kernels/one.cl\"\nint one;\n"
                              "#line 1 \"kernels/two.cl\"\n\n"
                              "#line 2 \"kernels/two.cl\"\nint two;\n");
    free(text);
}

static void a_missing_include_is_named(void **state)
{
    (void)state;
    const struct glint_source table[] = {TEXT("kernels/one.cl", "#include \"kernels/gk_gone.h\"\n"),
                                         {0, 0, 0}};
    struct glint_error err = {0};
    char *text;
    assert_int_equal(glint_source_expand(&text, table, &err), GLINT_E_INTERNAL);
    assert_null(text);
    assert_non_null(strstr(glint_error_text(&err), "kernels/gk_gone.h"));
    glint_error_finish(&err);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(contraction_is_left_to_the_source),
        cmocka_unit_test(infinity_and_nan_are_values),
        cmocka_unit_test(denormals_are_zero_in_kernels),
        cmocka_unit_test(denormals_are_zero_on_a_worker_thread),
        cmocka_unit_test(an_absent_buffer_is_a_null_pointer),
        cmocka_unit_test(workers_write_one_buffer_side_by_side),
        cmocka_unit_test(workers_that_launch_ever_larger_do_not_disturb_each_other),
        cmocka_unit_test(a_variant_is_built_once),
        cmocka_unit_test(idle_variants_are_dropped_and_held_ones_stay),
        cmocka_unit_test(a_broken_kernel_gives_the_build_log),
        cmocka_unit_test(faulty_launches_are_refused),
        cmocka_unit_test(buffers_are_zeroed_whole_pages),
        cmocka_unit_test(a_buffer_over_one_gibibyte_is_refused),
        cmocka_unit_test(devices_can_be_opened_again_with_another_count),
        cmocka_unit_test(embedded_kernels_build),
        cmocka_unit_test(includes_are_expanded_once_and_keep_line_numbers),
        cmocka_unit_test(a_missing_include_is_named),
    };
    return cmocka_run_group_tests(tests, open_devices, close_devices);
}
