// The device computes the bits that the host computes from the same headers.
#include "tests/kernel/probe.cl"

#include "device/device.h"
#include "device/program.h"
#include "scene/energy.h"
#include "tests/kernel/check.h"

#include <stdio.h>
#include <stdlib.h>

static glint_devices *devices;
static glint_program *program;

static char *read_probe(size_t *length)
{
    char path[4096];
    const char *top = getenv("top_srcdir");
    snprintf(path, sizeof path, "%s/tests/kernel/probe.cl", top ? top : ".");
    FILE *f = fopen(path, "rb");
    assert_non_null(f);
    char *text = malloc(1 << 16);
    assert_non_null(text);
    *length = fread(text, 1, 1 << 16, f);
    fclose(f);
    return text;
}

// The embedded headers and, as the only entry points, the probe's.
static void build_probe(const char *text, size_t length)
{
    struct glint_source table[128] = {{0}};
    struct glint_error err = {0};
    char *source = NULL;
    size_t n = 0;
    for (size_t i = 0; glint_sources[i].name; i++) {
        const char *dot = strrchr(glint_sources[i].name, '.');
        if (!strcmp(dot, ".h") && n < 126)
            table[n++] = glint_sources[i];
    }
    table[n] = (struct glint_source){"probe.cl", text, length};
    assert_int_equal(glint_source_expand(&source, table, &err), GLINT_OK);
    assert_int_equal(glint_program_build(&program, devices, source, "", &err), GLINT_OK);
    free(source);
}

static int open_device(void **state)
{
    (void)state;
    struct glint_error err = {0};
    size_t length;
    if (glint_devices_create(&devices, 1, NULL, &err))
        return -1;
    glint_worker_enter(glint_devices_worker(devices, 0));
    char *text = read_probe(&length);
    build_probe(text, length);
    free(text);
    return 0;
}

static int close_device(void **state)
{
    (void)state;
    glint_program_release(&program);
    glint_devices_destroy(&devices);
    return 0;
}

static glint_buffer *make_buffer(size_t bytes)
{
    glint_buffer *buffer;
    struct glint_error err = {0};
    assert_int_equal(glint_buffer_create(&buffer, devices, bytes, &err), GLINT_OK);
    return buffer;
}

static void launch(const char *kernel, size_t items, const struct glint_arg *args, size_t count)
{
    struct glint_error err = {0};
    assert_int_equal(glint_launch(glint_devices_worker(devices, 0), program, kernel, items, 64,
                                  args, count, &err),
                     GLINT_OK);
}

static void assert_same(const char *kernel, const gk_u32 *actual, const gk_u32 *expected)
{
    for (size_t k = 0; k < (size_t)PROBE_ROWS * PROBE_COLUMNS; k++)
        if (actual[k] != expected[k])
            fail_msg("%s: row %zu, column %zu: device %.9g (%08x), host %.9g (%08x)", kernel,
                     k % PROBE_ROWS, k / PROBE_ROWS, (double)gk_as_f32(actual[k]), actual[k],
                     (double)gk_as_f32(expected[k]), expected[k]);
}

typedef void probe(gk_u32, gk_u32 *);

static void assert_same_bits(const char *kernel, probe *host)
{
    const size_t words = (size_t)PROBE_ROWS * PROBE_COLUMNS;
    glint_buffer *buffer = make_buffer(words * sizeof(gk_u32));
    gk_u32 *expected = calloc(words, sizeof *expected);
    assert_non_null(expected);
    launch(kernel, PROBE_ROWS, &(struct glint_arg){.buffer = buffer}, 1);
    for (gk_u32 i = 0; i < PROBE_ROWS; i++)
        host(i, expected);
    assert_same(kernel, glint_buffer_host(buffer), expected);
    free(expected);
    glint_buffer_destroy(&buffer);
}

static void elementary_functions_agree(void **state)
{
    (void)state;
    assert_same_bits("math", probe_math);
}

static void limits_agree(void **state)
{
    (void)state;
    assert_same_bits("limits", probe_limits);
}

static void samples_and_filters_agree(void **state)
{
    (void)state;
    assert_same_bits("sampler", probe_sampler);
}

static void scattering_agrees(void **state)
{
    (void)state;
    const size_t words = (size_t)PROBE_ROWS * PROBE_COLUMNS;
    const size_t part = GK_ENERGY_PART * sizeof(float);
    glint_buffer *buffer = make_buffer(words * sizeof(gk_u32)),
                 *energy = make_buffer((1 + GK_ENERGY_PARTS) * part);
    memcpy(glint_buffer_host(energy), glint_energy_white(), part);
    memcpy((char *)glint_buffer_host(energy) + part, glint_energy_glass(1.5f),
           GK_ENERGY_PARTS * part);
    gk_u32 *expected = calloc(words, sizeof *expected);
    assert_non_null(expected);
    const struct glint_arg args[] = {{.buffer = buffer}, {.buffer = energy}};
    launch("bsdf", PROBE_ROWS, args, 2);
    for (gk_u32 i = 0; i < PROBE_ROWS; i++)
        probe_bsdf(i, expected, glint_buffer_host(energy));
    assert_same("bsdf", glint_buffer_host(buffer), expected);
    free(expected);
    glint_buffer_destroy(&energy);
    glint_buffer_destroy(&buffer);
}

static void matte_tables_agree(void **state)
{
    (void)state;
    static gk_u64 table[PROBE_PIXELS * PROBE_SLOTS], lost[PROBE_PIXELS];
    glint_buffer *tables = make_buffer(sizeof table), *losses = make_buffer(sizeof lost);
    const struct glint_arg args[] = {{.buffer = tables}, {.buffer = losses}};
    launch("matte", PROBE_PIXELS, args, 2);
    for (gk_u32 i = 0; i < PROBE_PIXELS; i++)
        probe_matte(i, table, lost);
    assert_memory_equal(glint_buffer_host(tables), table, sizeof table);
    assert_memory_equal(glint_buffer_host(losses), lost, sizeof lost);
    assert_true(lost[0] > 0);
    glint_buffer_destroy(&losses);
    glint_buffer_destroy(&tables);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(elementary_functions_agree), cmocka_unit_test(limits_agree),
        cmocka_unit_test(samples_and_filters_agree),  cmocka_unit_test(scattering_agrees),
        cmocka_unit_test(matte_tables_agree),
    };
    return cmocka_run_group_tests(tests, open_device, close_device);
}
