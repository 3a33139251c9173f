// The scene of the README, with everything in it: every pixel is sound, and of a million samples
// none is rejected.
#include "render/common.h"
#include "tests/stability/stable.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static struct offline o;
static glint_resident *demo;

// The text that glint-demo-scene writes.
static char *demo_text(void)
{
    char command[4096];
    const char *build = getenv("GLINT_BUILD");
    snprintf(command, sizeof command, "'%s/glint-demo-scene'", build ? build : ".");
    FILE *pipe = popen(command, "r");
    size_t capacity = (size_t)1 << 24, size = 0, n;
    char *text = malloc(capacity + 1);
    assert_true(pipe && text);
    while ((n = fread(text + size, 1, capacity - size, pipe)) > 0)
        size += n;
    text[size] = 0;
    assert_int_equal(pclose(pipe), 0);
    return text;
}

static void check(const char *members)
{
    struct glint_frame *f = stable_frame_of(
        &o, demo,
        stable_text("{'scene':'s','outputs':['beauty','variance','depth','normal','albedo',"
                    "'crypto_object','crypto_material'],%s}",
                    members));
    assert_true(stable_mean(f, "G").mean > 0.0);
    assert_true(stable_most(f, "A") <= 1.0);
    assert_true(stable_most(f, "albedo.G") <= 1.0 + 1e-6);
    glint_frame_destroy(&f);
}

// 144 x 81 pixels of 96 samples: 1.1 million.
static void a_million_samples_are_all_sound(void **state)
{
    (void)state;
    check("'resolution':[144,81],'stop':{'samples':96}");
}

// Deep paths without roulette, where weights have the most factors.
static void deep_paths_are_sound(void **state)
{
    (void)state;
    check("'resolution':[64,36],'max_bounces':256,'accuracy':{'roulette':'none'},'stop':{'samples':"
          "8}");
}

// A new installation is tried with it, so a daemon compiles what it needs first of all.
static void its_kernels_are_the_first_to_be_foreseen(void **state)
{
    (void)state;
    char options[GLINT_COMMON_OPTIONS];
    struct glint_plan plan;
    struct glint_job *job = offline_job("{\"scene\":\"s\"}");
    const struct glint_effect_input in = {glint_resident_facts(demo), job,
                                          &glint_resident_scene(demo)->camera[0], false};
    glint_plan_make(&plan, &in, 0);
    assert_true(glint_common_variant(0, options) > 1);
    assert_string_equal(plan.options, options);
    glint_job_destroy(&job);
}

static int start(void **state)
{
    (void)state;
    offline_start(&o, offline_workers());
    char *text = demo_text();
    demo = offline_load_text(&o, text);
    free(text);
    return 0;
}

static int finish(void **state)
{
    (void)state;
    glint_resident_release(&demo);
    offline_finish(&o);
    return 0;
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_million_samples_are_all_sound),
        cmocka_unit_test(deep_paths_are_sound),
        cmocka_unit_test(its_kernels_are_the_first_to_be_foreseen),
    };
    return cmocka_run_group_tests(tests, start, finish);
}
