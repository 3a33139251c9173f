// The rules of the effects table, for every row: forcing a row that nothing calls for changes no bit
// of the image; the automatic plan is the smallest that a hand could make.
#include "device/program.h"
#include "tests/render/effect_worlds.h"
#include "tests/stability/stable.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static struct offline o;

#define COUNT(a) (sizeof(a) / sizeof *(a))

static glint_resident *load(const struct effect_world *w)
{
    char *text = effect_scene(w);
    glint_resident *scene = offline_load_text(&o, text);
    free(text);
    return scene;
}

static char *job_text(const struct effect_order *of)
{
    static const uint32_t size[2] = {24, 20};
    return effect_job(of, size, 8);
}

static struct glint_frame *frame_of(const struct effect_world *w, const struct effect_order *of,
                                    uint64_t force)
{
    glint_resident *scene = load(w);
    char *job = job_text(of);
    struct glint_frame *frame = offline_frame(&o, scene, job, force);
    free(job);
    glint_resident_release(&scene);
    return frame;
}

// ---- plans

static struct glint_plan plan_of(const struct effect_world *w, const struct effect_order *of,
                                 uint64_t force)
{
    glint_resident *scene = load(w);
    char *text = job_text(of);
    struct glint_job *job = offline_job(text);
    const struct glint_effect_input in = {glint_resident_facts(scene), job,
                                          &glint_resident_scene(scene)->camera[0], false};
    struct glint_plan plan;
    glint_plan_make(&plan, &in, force);
    glint_job_destroy(&job);
    free(text);
    glint_resident_release(&scene);
    return plan;
}

static uint64_t all_rows(void)
{
    return ~0ull >> (64 - glint_effect_count);
}

// ---- forcing

static void every_row_is_forced_but_twins_of_a_dial(void **state)
{
    (void)state;
    uint64_t covered = effect_bits(effect_twins);
    for (size_t i = 0; i < effect_forcing_count; i++)
        covered |= effect_bits(effect_forcings[i].effect);
    assert_int_equal(covered, all_rows());
    assert_int_equal(effect_forcing_count + 2, glint_effect_count);
}

static void assert_forcing_changes_nothing(const struct effect_world *w, uint64_t force)
{
    const struct glint_plan plan = plan_of(w, &effect_beauty, force);
    assert_int_equal(plan.called & force, 0);
    assert_int_equal(plan.on, plan.called | force);
    struct glint_frame *plain = frame_of(w, &effect_beauty, 0),
                       *forced = frame_of(w, &effect_beauty, force);
    assert_true(stable_most(plain, "G") > 0.1);
    stable_assert_same(plain, forced);
    glint_frame_destroy(&plain);
    glint_frame_destroy(&forced);
}

static void forcing_an_uncalled_effect_changes_no_bit(void **state)
{
    (void)state;
    for (size_t i = 0; i < effect_forcing_count; i++) {
        print_message("# forcing %s\n", effect_forcings[i].effect);
        assert_forcing_changes_nothing(effect_forcings[i].world,
                                       effect_bits(effect_forcings[i].effect) |
                                           effect_bits(effect_forcings[i].with));
    }
}

static void forcing_all_that_is_uncalled_changes_no_bit(void **state)
{
    (void)state;
    const uint64_t called = plan_of(&effect_sky, &effect_beauty, 0).called;
    assert_forcing_changes_nothing(&effect_sky, all_rows() & ~called & ~effect_bits(effect_twins));
}

// ---- the smallest plan

#define LIGHTS "-DGK_LIGHT_TABLE -DGK_LIGHTS"
#define BASE_PASSES                                                                \
    (1u << GLINT_PASS_GENERATE | 1u << GLINT_PASS_TRACE | 1u << GLINT_PASS_SHADE | \
     1u << GLINT_PASS_COMPACT | 1u << GLINT_PASS_COLOUR)
#define LIGHT_PASSES (1u << GLINT_PASS_SHADOW | 1u << GLINT_PASS_UNOCCLUDED)

// Planes of 4 bytes: two halves of three colour sums of two words, hits and rejections make 14;
// AOVs add depth and six sums of two words, mattes 8 bytes for each slot, twice for what found none and
// ten times for places of the tile.
static const struct effect_order with_aovs = {"'beauty','depth'", "box", "", 3};
static const struct effect_order with_mattes = {"'beauty','crypto_object'", "box",
                                                "'mattes':{'slots':14},", 3};

static const struct smallest {
    const struct effect_world *world;
    const struct effect_order *order;
    const char *options;
    uint32_t passes;
    size_t film_bytes;
} smallest[] = {
    {&effect_sky, &effect_beauty, "-DGK_ENVIRONMENT_CONSTANT", BASE_PASSES, 80},
    {&effect_lamp, &effect_beauty, "-DGK_EMISSION " LIGHTS, BASE_PASSES | LIGHT_PASSES, 80},
    {&effect_textured, &effect_beauty, "-DGK_TEXTURES -DGK_ENVIRONMENT_CONSTANT", BASE_PASSES, 80},
    {&effect_image_sky, &effect_beauty, "-DGK_LIGHTS -DGK_ENVIRONMENT_IMAGE",
     BASE_PASSES | LIGHT_PASSES, 80},
    {&effect_glass, &effect_beauty, "-DGK_MICROFACET -DGK_TRANSMISSION -DGK_ENVIRONMENT_CONSTANT",
     BASE_PASSES, 80},
    {&effect_sky, &with_aovs, "-DGK_ENVIRONMENT_CONSTANT -DGK_AOVS",
     BASE_PASSES | 1u << GLINT_PASS_AOVS, 80 + 13 * 4},
    {&effect_sky, &with_mattes, "-DGK_ENVIRONMENT_CONSTANT",
     BASE_PASSES | 1u << GLINT_PASS_COVERAGE, 80 + 26 * 8},
};

static void automatic_plan_is_the_smallest(void **state)
{
    (void)state;
    for (size_t i = 0; i < COUNT(smallest); i++) {
        const struct smallest *s = &smallest[i];
        const struct glint_plan plan = plan_of(s->world, s->order, 0);
        assert_string_equal(plan.options, s->options);
        assert_int_equal(plan.passes, s->passes);
        assert_int_equal(plan.film_bytes, s->film_bytes);
    }
}

// What a render really runs is the program that the options written by hand select.
static void assert_runs(const struct effect_world *w, const char *options)
{
    struct glint_error err = {0};
    glint_resident *scene = load(w);
    char *text = job_text(&effect_beauty);
    struct glint_job *job = offline_job(text);
    glint_render *render = NULL;
    glint_program *by_hand = NULL;
    if (glint_render_create(&render, o.devices, scene, NULL, job, &err) ||
        glint_program_get(&by_hand, o.devices, options, &err))
        offline_die("program", &err);
    assert_string_equal(glint_program_key(render->view->program), glint_program_key(by_hand));
    glint_program_release(&by_hand);
    glint_render_destroy(&render);
    glint_job_destroy(&job);
    free(text);
    glint_resident_release(&scene);
}

static void renders_run_the_program_that_a_hand_would_choose(void **state)
{
    (void)state;
    for (size_t i = 0; i < 3; i++)
        assert_runs(smallest[i].world, smallest[i].options);
}

// ---- causes

#define CONSTANT "constant environment"
#define TABLE "light table|next-event estimation"

static void each_cause_calls_for_its_own_row(void **state)
{
    (void)state;
    uint64_t covered = effect_bits(effect_by_facts);
    for (size_t i = 0; i < effect_cause_count; i++) {
        print_message("# %s\n", effect_causes[i].effect);
        const uint64_t called = plan_of(&effect_causes[i].world, &effect_causes[i].order, 0).called;
        assert_int_equal(called, effect_bits(effect_causes[i].calls));
        assert_true(called & effect_bits(effect_causes[i].effect));
        covered |= effect_bits(effect_causes[i].effect);
    }
    assert_int_equal(covered, all_rows());
}

static void each_fact_calls_for_its_own_row(void **state)
{
    (void)state;
    static const struct {
        struct glint_scene_facts facts;
        const char *calls;
    } fact[] = {
        {{.texture_pools = 0}, ""},
        {{.texture_pools = 1}, ""},
        {{.texture_pools = 2}, "texture pools"},
        {{.texture_pools = 4}, "texture pools"},
        {{.microfacet = true}, "microfacet"},
        {{.uv1 = true}, "second texture coordinates"},
        {{.vertex_colours = true}, "vertex colours"},
        {{.motion = true}, "motion"},
        {{.transmission = true}, "transmission"},
        {{.textures = true}, "textures"},
        {{.roughness_textures = true}, "roughness textures"},
        {{.emission_textures = true}, "emission textures"},
        {{.normal_maps = true}, "normal maps"},
        {{.instances = true}, "instances"},
        {{.cutout = true}, "alpha cut-outs"},
        {{.emission = true}, "emission"},
        {{.light_table = true}, TABLE},
        {{.environment_constant = true}, CONSTANT},
        {{.environment_image = true}, "environment image|next-event estimation"},
    };
    char *text = job_text(&effect_beauty);
    struct glint_job *job = offline_job(text);
    const struct glint_camera camera = {.yfov = 1.0f};
    for (size_t i = 0; i < COUNT(fact); i++) {
        const struct glint_effect_input in = {&fact[i].facts, job, &camera, false};
        assert_int_equal(glint_effects_called(&in), effect_bits(fact[i].calls));
    }
    const struct glint_scene_facts none = {0};
    const struct glint_effect_input moves = {&none, job, &camera, true};
    assert_int_equal(glint_effects_called(&moves), effect_bits("camera motion"));
    glint_job_destroy(&job);
    free(text);
}

// ---- defines

// The value of kernel_options in kernels/local.mk on one line, a blank before and after each word.
static char *checked_options(const char *top)
{
    char path[4096];
    size_t size;
    snprintf(path, sizeof path, "%s/kernels/local.mk", top);
    char *text = (char *)offline_read_file(path, &size);
    static const char name[] = "\nkernel_options =";
    char *value = strstr(text, name);
    assert_non_null(value);
    value += strlen(name);
    char *c = value;
    for (; *c && *c != '\n'; c++)
        if (*c == '\\' && c[1] == '\n')
            *c = c[1] = c[2] = ' '; // the third is a tab
    *c = 0;
    value = stable_text("%s ", value);
    free(text);
    return value;
}

// A row that is not in the makefile's copy would be built without ever having been checked.
static void kernels_are_checked_with_every_define(void **state)
{
    (void)state;
    const char *top = getenv("top_srcdir");
    if (!top)
        skip();
    char *options = checked_options(top);
    size_t defines = 0, written = 0;
    for (size_t i = 0; i < glint_effect_count; i++) {
        char wanted[128];
        if (!glint_effect_table[i].define)
            continue;
        snprintf(wanted, sizeof wanted, " -D%s ", glint_effect_table[i].define);
        if (!strstr(options, wanted))
            fail_msg("kernels/local.mk does not check%s", wanted);
        defines++;
    }
    for (const char *c = options; (c = strstr(c, "-D")); c += 2)
        written++;
    assert_int_equal(written, defines);
    free(options);
}

// ---- outputs

static void the_image_does_not_depend_on_mattes_or_aovs(void **state)
{
    (void)state;
    static const struct effect_order all = {
        "'beauty','crypto_object','crypto_material','depth','normal'", "box", "", 3};
    struct glint_frame *plain = frame_of(&effect_sky, &effect_beauty, 0),
                       *full = frame_of(&effect_sky, &all, 0);
    for (int c = 0; c < 4; c++) {
        const char name[2] = {"RGBA"[c], 0};
        assert_int_equal(stable_equal(plain, full, name), stable_pixels(plain));
    }
    glint_frame_destroy(&plain);
    glint_frame_destroy(&full);
}

static int start(void **state)
{
    (void)state;
    offline_start(&o, offline_workers());
    return 0;
}

static int finish(void **state)
{
    (void)state;
    offline_finish(&o);
    return 0;
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(kernels_are_checked_with_every_define),
        cmocka_unit_test(automatic_plan_is_the_smallest),
        cmocka_unit_test(renders_run_the_program_that_a_hand_would_choose),
        cmocka_unit_test(each_fact_calls_for_its_own_row),
        cmocka_unit_test(each_cause_calls_for_its_own_row),
        cmocka_unit_test(every_row_is_forced_but_twins_of_a_dial),
        cmocka_unit_test(forcing_an_uncalled_effect_changes_no_bit),
        cmocka_unit_test(forcing_all_that_is_uncalled_changes_no_bit),
        cmocka_unit_test(the_image_does_not_depend_on_mattes_or_aovs),
    };
    return cmocka_run_group_tests(tests, start, finish);
}
