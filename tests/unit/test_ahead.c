// Kernels compiled ahead of their first launch: by glint-kernels where it was built, else by a
// script that stands in for it.
#include "device/ahead.h"
#include "device/compiler.h"
#include "device/device.h"
#include "device/listing.h"
#include "device/program.h"
#include "kernels/gk_wave.h"

#include <fcntl.h>
#include <ftw.h>
#include <math.h>
#include <pthread.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cmocka.h>

#define KEY "00000000000000000000000000000000000000000000000000000000000000aa"
#define OTHER "00000000000000000000000000000000000000000000000000000000000000bb"

static char folder[] = "/tmp/glint-ahead-XXXXXX";
static char cache[64], helper[64], counted[64];

// ---- a helper of the test's own

// It makes one file of the options. Of one key it never finishes, of one set of options it refuses.
static const char script[] = "#!/bin/sh\n"
                             "case \"$2\" in\n"
                             "-DSLOW) echo >\"$3/../slow\"; exec sleep 1000 ;;\n"
                             "-DWRONG) echo 'a fault' >&2; exit 2 ;;\n"
                             "-DBROKEN) echo 'no compiler' >&2; exit 1 ;;\n"
                             "esac\n"
                             "mkdir \"$3/kernel\" 2>/dev/null || exit 0\n"
                             "mkdir -p \"$POCL_CACHE_DIR/AA/BB\"\n"
                             "echo \"$2\" >\"$POCL_CACHE_DIR/AA/BB/kernel.so\"\n"
                             "echo once >>\"$COUNTED\"\n";

static void write_file(const char *path, const char *text)
{
    FILE *f = fopen(path, "w");
    assert_non_null(f);
    assert_true(fputs(text, f) >= 0);
    assert_int_equal(fclose(f), 0);
}

static char *in_cache(const char *name)
{
    static char path[256];
    snprintf(path, sizeof path, "%s/%s", cache, name);
    return path;
}

static int open_folder(void **state)
{
    (void)state;
    if (!mkdtemp(folder))
        return -1;
    snprintf(cache, sizeof cache, "%s/cache", folder);
    snprintf(helper, sizeof helper, "%s/helper", folder);
    snprintf(counted, sizeof counted, "%s/counted", folder);
    write_file(helper, script);
    setenv("COUNTED", counted, 1);
    return chmod(helper, 0700);
}

static int close_folder(void **state)
{
    (void)state;
    glint_folder_remove(folder);
    return 0;
}

static int fresh_cache(void **state)
{
    (void)state;
    glint_folder_remove(cache);
    unlink(counted);
    return mkdir(cache, 0700);
}

static glint_ahead *open_ahead(void)
{
    glint_ahead *ahead;
    assert_int_equal(glint_ahead_create(&ahead, cache, helper, NULL), GLINT_OK);
    assert_non_null(ahead);
    return ahead;
}

static long times_made(void)
{
    struct stat s;
    return stat(counted, &s) ? 0 : (long)s.st_size / (long)strlen("once\n");
}

// ---- claims about what is compiled

static void what_is_compiled_is_used_as_it_is(void **state)
{
    (void)state;
    glint_ahead *ahead = open_ahead();
    assert_int_equal(glint_ahead_compile(ahead, KEY, "-DA", NULL), GLINT_OK);
    assert_int_equal(glint_ahead_compile(ahead, KEY, "-DA", NULL), GLINT_OK);
    assert_int_equal(times_made(), 1);
    glint_ahead_destroy(&ahead);
}

static void what_is_torn_is_made_anew(void **state)
{
    (void)state;
    glint_ahead *ahead = open_ahead();
    assert_int_equal(glint_ahead_compile(ahead, KEY, "-DA", NULL), GLINT_OK);
    write_file(in_cache("AA/BB/kernel.so"), "-D");
    assert_false(glint_listing_holds(cache, KEY));
    assert_int_not_equal(access(in_cache("AA/BB/kernel.so"), F_OK), 0);
    assert_int_equal(glint_ahead_compile(ahead, KEY, "-DA", NULL), GLINT_OK);
    assert_true(glint_listing_holds(cache, KEY));
    assert_int_equal(truncate(in_cache("AA/BB/kernel.so"), 0), 0);
    assert_int_equal(glint_ahead_compile(ahead, KEY, "-DA", NULL), GLINT_OK);
    assert_true(glint_listing_holds(cache, KEY));
    assert_int_equal(times_made(), 3);
    glint_ahead_destroy(&ahead);
}

static void a_listing_cannot_name_what_is_outside(void **state)
{
    (void)state;
    static const char *const text[] = {"-DA\n" KEY " ../victim\n",
                                       "-DA\n" KEY " /etc/passwd\n",
                                       "-DA\n" KEY "\n",
                                       "-DA\n",
                                       "-DA",
                                       "-DA\nxyz AA/BB/kernel.so\n",
                                       ""};
    char victim[80];
    snprintf(victim, sizeof victim, "%s/victim", folder);
    write_file(victim, "alive");
    for (size_t i = 0; i < sizeof text / sizeof *text; i++) {
        write_file(in_cache("glint-" KEY), text[i]);
        assert_false(glint_listing_holds(cache, KEY));
        assert_int_equal(access(victim, F_OK), 0);
    }
    assert_false(glint_listing_holds(cache, OTHER));
}

struct seen {
    int count;
    char options[64];
    double unused;
};

static bool see(void *user, const char *key, const char *options, double unused)
{
    struct seen *seen = user;
    assert_string_equal(key, KEY);
    snprintf(seen->options, sizeof seen->options, "%s", options);
    seen->unused = unused;
    seen->count++;
    return true;
}

static void listings_tell_what_for_and_since_when(void **state)
{
    (void)state;
    struct seen seen = {0};
    const struct timespec long_ago[2] = {{1000, 0}, {1000, 0}};
    glint_ahead *ahead = open_ahead();
    assert_int_equal(glint_ahead_compile(ahead, KEY, "-DA -DB", NULL), GLINT_OK);
    write_file(in_cache("glint-short"), "-DC\n");
    assert_int_equal(utimensat(AT_FDCWD, in_cache("glint-" KEY), long_ago, 0), 0);
    glint_listing_each(cache, see, &seen);
    assert_int_equal(seen.count, 1);
    assert_string_equal(seen.options, "-DA -DB");
    assert_true(seen.unused > 1e9);
    assert_int_equal(glint_ahead_compile(ahead, KEY, "-DA -DB", NULL), GLINT_OK); // used now
    glint_listing_each(cache, see, &seen);
    assert_true(seen.unused < 1e6);
    glint_listing_remove(cache, KEY);
    glint_listing_each(cache, see, &seen);
    assert_int_equal(seen.count, 2);
    assert_int_not_equal(access(in_cache("AA/BB/kernel.so"), F_OK), 0);
    glint_ahead_destroy(&ahead);
}

static void what_ended_processes_left_is_swept_away_after_a_day(void **state)
{
    (void)state;
    const struct timespec long_ago[2] = {{1000, 0}, {1000, 0}};
    const char *const names[] = {"making-old", "tempfile_old", "making-new", "other"};
    for (int i = 0; i < 4; i++) {
        assert_int_equal(mkdir(in_cache(names[i]), 0700), 0);
        if (i != 2)
            assert_int_equal(utimensat(AT_FDCWD, in_cache(names[i]), long_ago, 0), 0);
    }
    glint_listing_sweep(cache);
    for (int i = 0; i < 4; i++)
        assert_int_equal(access(in_cache(names[i]), F_OK) == 0, i >= 2);
}

static void faults_in_kernels_are_told(void **state)
{
    (void)state;
    struct glint_error err = {0};
    glint_ahead *ahead = open_ahead();
    assert_int_equal(glint_ahead_compile(ahead, KEY, "-DWRONG", &err), GLINT_E_DEVICE);
    assert_non_null(strstr(glint_error_text(&err), "a fault"));
    glint_error_finish(&err);
    glint_ahead_destroy(&ahead);
}

static int count_making(const char *path, const struct stat *s, int type, struct FTW *at)
{
    (void)s;
    (void)type;
    (void)at;
    return strstr(path, "making-") != NULL;
}

static void a_helper_that_cannot_work_leaves_it_to_the_launch(void **state)
{
    (void)state;
    glint_ahead *ahead = open_ahead();
    assert_int_equal(glint_ahead_compile(ahead, KEY, "-DBROKEN", NULL), GLINT_OK);
    assert_false(glint_listing_holds(cache, KEY));
    assert_int_equal(nftw(cache, count_making, 8, FTW_PHYS), 0);
    glint_ahead_destroy(&ahead);
}

static void without_a_helper_nothing_is_compiled_ahead(void **state)
{
    (void)state;
    glint_ahead *ahead;
    assert_int_equal(glint_ahead_create(&ahead, cache, "/nowhere/glint-kernels", NULL), GLINT_OK);
    assert_null(ahead);
}

// ---- threads

static void *compile_key(void *ahead)
{
    return (void *)(intptr_t)glint_ahead_compile(ahead, KEY, "-DA", NULL);
}

static void threads_that_want_one_variant_compile_it_once(void **state)
{
    (void)state;
    glint_ahead *ahead = open_ahead();
    pthread_t thread[4];
    for (int i = 0; i < 4; i++)
        assert_int_equal(pthread_create(&thread[i], NULL, compile_key, ahead), 0);
    for (int i = 0; i < 4; i++) {
        void *status;
        assert_int_equal(pthread_join(thread[i], &status), 0);
        assert_int_equal((intptr_t)status, GLINT_OK);
    }
    assert_int_equal(times_made(), 1);
    glint_ahead_destroy(&ahead);
}

static void *idle_slowly(void *ahead)
{
    return (void *)(intptr_t)glint_ahead_idle(ahead, OTHER, "-DSLOW");
}

static void idle_work_is_given_up_for_a_job(void **state)
{
    (void)state;
    glint_ahead *ahead = open_ahead();
    pthread_t thread;
    void *whole;
    assert_int_equal(pthread_create(&thread, NULL, idle_slowly, ahead), 0);
    while (access(in_cache("slow"), F_OK)) // until its helper runs
        usleep(1000);
    assert_int_equal(glint_ahead_compile(ahead, KEY, "-DA", NULL), GLINT_OK);
    assert_int_equal(pthread_join(thread, &whole), 0);
    assert_false((intptr_t)whole);
    assert_true(glint_listing_holds(cache, KEY));
    assert_true(glint_ahead_idle(ahead, OTHER, "-DB"));
    assert_true(glint_listing_holds(cache, OTHER));
    glint_ahead_destroy(&ahead);
}

static void idle_work_ends_with_the_daemon(void **state)
{
    (void)state;
    glint_ahead *ahead = open_ahead();
    pthread_t thread;
    void *whole;
    assert_int_equal(pthread_create(&thread, NULL, idle_slowly, ahead), 0);
    while (access(in_cache("slow"), F_OK))
        usleep(1000);
    glint_ahead_hurry(ahead);
    assert_int_equal(pthread_join(thread, &whole), 0);
    assert_false((intptr_t)whole);
    assert_false(glint_ahead_idle(ahead, OTHER, "-DB"));
    glint_ahead_destroy(&ahead);
}

// ---- the real one

static int kernels, programs;

static int count_kernel(const char *path, const struct stat *s, int type, struct FTW *at)
{
    (void)s;
    (void)at;
    const size_t length = strlen(path);
    kernels += type == FTW_F && length > 3 && !strcmp(path + length - 3, ".so");
    programs += type == FTW_F && length > 3 && !strcmp(path + length - 3, ".bc");
    return 0;
}

static int count_kernels(void)
{
    kernels = programs = 0;
    nftw(cache, count_kernel, 16, FTW_PHYS);
    return kernels;
}

#define RAYS 64u

// Light that unoccluded shadow rays of a wave bring, some of it denormal, which kernels take for 0.
static void add_light(glint_devices *devices, glint_program *program, float light[3 * RAYS])
{
    const uint32_t stride = RAYS;
    const size_t bytes = (size_t)GK_COLUMNS * RAYS * 4;
    glint_buffer *wave;
    assert_int_equal(glint_buffer_create(&wave, devices, bytes, NULL), GLINT_OK);
    float *column = glint_buffer_host(wave);
    for (uint32_t i = 0; i < RAYS; i++) {
        memcpy(column + GK_COL_SLANE * stride + i, &i, 4);
        column[GK_COL_ST * stride + i] = i % 5 ? 1.0f : -INFINITY;
        for (uint32_t k = 0; k < 3; k++) {
            column[(GK_COL_SR + k) * stride + i] =
                ldexpf(1.0f + 0.1f * (float)(i + k), -(int)(3 * i));
            column[(GK_COL_LR + k) * stride + i] = ldexpf(0.7f, -(int)(3 * i) - 3);
        }
    }
    const struct glint_arg args[] = {{.buffer = wave}, {.value = &stride, .size = 4}};
    assert_int_equal(glint_launch(glint_devices_spare(devices), program, "add_unoccluded", RAYS,
                                  GLINT_AHEAD_GROUP, args, 2, NULL),
                     GLINT_OK);
    memcpy(light, column + GK_COL_LR * stride, 3 * RAYS * sizeof *light);
    glint_buffer_destroy(&wave);
}

static glint_program *open_program(glint_devices **devices, const char *kernels_helper)
{
    struct glint_error err = {0};
    glint_program *program = NULL;
    setenv("GLINT_KERNELS", kernels_helper, 1);
    if (glint_devices_create(devices, 1, cache, &err) ||
        glint_program_get(&program, *devices, "-DGK_LIGHTS", &err))
        fail_msg("%s", glint_error_text(&err));
    return program;
}

static void what_is_compiled_ahead_is_what_a_launch_would_compile(void **state)
{
    (void)state;
    char built[4096], path[512];
    const char *build = getenv("GLINT_BUILD");
    snprintf(built, sizeof built, "%s/glint-kernels", build ? build : ".");
    if (access(built, X_OK))
        skip();
    float light[2][3 * RAYS];
    glint_devices *devices;
    glint_program *program = open_program(&devices, built);
    const int made = count_kernels();
    assert_true(made >= 5);
    assert_true(glint_listing_bitcode(getenv("POCL_CACHE_DIR"), glint_program_key(program), path,
                                      sizeof path));
    add_light(devices, program, light[0]);
    assert_int_equal(count_kernels(), made); // nothing is left to compile
    assert_int_equal(programs, 1);           // nor read again: one folder, known by two names
    glint_program_release(&program);
    glint_devices_destroy(&devices);
    program = open_program(&devices, "/nowhere");
    add_light(devices, program, light[1]);
    assert_memory_equal(light[0], light[1], sizeof light[0]);
    glint_program_release(&program);
    glint_devices_destroy(&devices);
}

static void another_compiler_has_another_cache(void **state)
{
    (void)state;
    static const char one[] = "__kernel void a(", other[] = "__kernel void b(";
    const struct glint_source table[] = {{"kernels/a.cl", one, sizeof one - 1}, {0}};
    const struct glint_source second[] = {{"kernels/b.cl", other, sizeof other - 1}, {0}};
    char a[GLINT_COMPILER_FOLDER], b[GLINT_COMPILER_FOLDER];
    glint_compiler_name(a, table, "OpenCL 3.0 PoCL 3.1 LLVM 15.0.6");
    glint_compiler_name(b, table, "OpenCL 3.0 PoCL 3.1 LLVM 15.0.6");
    assert_string_equal(a, b);
    glint_compiler_name(b, table, "OpenCL 3.0 PoCL 3.1 LLVM 15.0.7");
    assert_string_not_equal(a, b);
    glint_compiler_name(b, second, "OpenCL 3.0 PoCL 3.1 LLVM 15.0.6");
    assert_string_not_equal(a, b);
}

int main(void)
{
#define FRESH(test) cmocka_unit_test_setup(test, fresh_cache)
    const struct CMUnitTest tests[] = {
        FRESH(what_is_compiled_is_used_as_it_is),
        FRESH(what_is_torn_is_made_anew),
        FRESH(a_listing_cannot_name_what_is_outside),
        FRESH(listings_tell_what_for_and_since_when),
        FRESH(what_ended_processes_left_is_swept_away_after_a_day),
        FRESH(faults_in_kernels_are_told),
        FRESH(a_helper_that_cannot_work_leaves_it_to_the_launch),
        FRESH(without_a_helper_nothing_is_compiled_ahead),
        FRESH(threads_that_want_one_variant_compile_it_once),
        FRESH(idle_work_is_given_up_for_a_job),
        FRESH(idle_work_ends_with_the_daemon),
        FRESH(what_is_compiled_ahead_is_what_a_launch_would_compile),
        cmocka_unit_test(another_compiler_has_another_cache),
    };
    return cmocka_run_group_tests(tests, open_folder, close_folder);
}
