// Both rules of the effects table, for every row: forcing a row that nothing calls for changes no
// bit of the image; the automatic plan is the smallest that a hand could make.
#include "tests/render/offline.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

static struct offline o;

// A diffuse box with one lamp calls for hardly anything.
static const char plain_scene[] =
    "{\"materials\":{\"grey\":{\"base_color\":[0.5,0.4,0.3],\"ior\":1},"
    "\"lamp\":{\"base_color\":[0,0,0],\"ior\":1,\"emission\":[8,8,8]}},"
    "\"meshes\":{\"box\":{\"primitive\":\"box\"},\"ball\":{\"primitive\":\"sphere\",\"segments\":"
    "24},"
    "\"quad\":{\"primitive\":\"quad\"}},"
    "\"instances\":{\"room\":{\"mesh\":\"box\",\"material\":\"grey\",\"transform\":{\"scale\":[6,6,"
    "6]}},"
    "\"ball\":{\"mesh\":\"ball\",\"material\":\"grey\",\"transform\":{\"translation\":[0.3,-1,0.2]}"
    "},"
    "\"lamp\":{\"mesh\":\"quad\",\"material\":\"lamp\",\"transform\":{\"translation\":[0,2.9,0],"
    "\"rotation\":[0.70710678,0,0,0.70710678]}}},"
    "\"cameras\":{\"eye\":{\"yfov\":0.9,\"transform\":{\"translation\":[0,0,2.9]}}}}";

static const char plain_job[] = "{\"scene\":\"s\",\"resolution\":[48,40],\"outputs\":[\"beauty\"],"
                                "\"filter\":{\"kind\":\"box\",\"width\":1},\"max_bounces\":4,"
                                "\"stop\":{\"samples\":8}}";

static void assert_same_planes(const struct glint_frame *a, const struct glint_frame *b)
{
    assert_int_equal(a->channels, b->channels);
    for (uint32_t c = 0; c < a->channels; c++)
        assert_memory_equal(a->channel[c].plane, b->channel[c].plane,
                            (size_t)a->width * a->height * 4);
}

// The float64 film and the uniform light choice are settings of a dial, whose twin is another image.
static bool is_a_dial(const struct glint_effect *e)
{
    return e->dial == GLINT_DIAL_PRECISION || e->dial == GLINT_DIAL_LIGHTS;
}

static void forcing_an_uncalled_effect_changes_no_bit(void **state)
{
    (void)state;
    glint_resident *scene = offline_load_text(&o, plain_scene);
    struct glint_frame *plain = offline_frame(&o, scene, plain_job, 0);
    for (size_t i = 0; i < glint_effect_count; i++) {
        if (is_a_dial(&glint_effect_table[i]))
            continue;
        print_message("# forcing %s\n", glint_effect_table[i].name);
        struct glint_frame *forced = offline_frame(&o, scene, plain_job, 1ull << i);
        assert_same_planes(plain, forced);
        glint_frame_destroy(&forced);
    }
    glint_frame_destroy(&plain);
    glint_resident_release(&scene);
}

static void automatic_plan_is_the_smallest(void **state)
{
    (void)state;
    glint_resident *scene = offline_load_text(&o, plain_scene);
    struct glint_job *job = offline_job(plain_job);
    const struct glint_effect_input in = {glint_resident_facts(scene), job,
                                          &glint_resident_scene(scene)->camera[0]};
    struct glint_plan plan;
    glint_plan_make(&plan, &in, 0);
    assert_string_equal(plan.options, "-DGK_EMISSION -DGK_LIGHT_TABLE -DGK_LIGHTS");
    assert_int_equal(plan.film_bytes, 14 * 4);
    assert_false(glint_plan_has(&plan, GLINT_PASS_AOVS));
    assert_false(glint_plan_has(&plan, GLINT_PASS_COVERAGE));
    assert_true(glint_plan_has(&plan, GLINT_PASS_SHADOW));
    glint_job_destroy(&job);
    glint_resident_release(&scene);
}

// Each cause switches on its own row and no other.
struct cause {
    const char *effect;
    const char *find, *put; // in the scene
    const char *job_find, *job_put;
};

static char *replaced(const char *text, const char *find, const char *put)
{
    const char *at = find ? strstr(text, find) : NULL;
    if (!at)
        return strdup(text);
    char *out = malloc(strlen(text) + strlen(put) + 1);
    sprintf(out, "%.*s%s%s", (int)(at - text), text, put, at + strlen(find));
    return out;
}

static uint64_t called_by(const char *scene_text, const char *job_text)
{
    glint_resident *scene = offline_load_text(&o, scene_text);
    struct glint_job *job = offline_job(job_text);
    const struct glint_effect_input in = {glint_resident_facts(scene), job,
                                          &glint_resident_scene(scene)->camera[0]};
    const uint64_t called = glint_effects_called(&in);
    glint_job_destroy(&job);
    glint_resident_release(&scene);
    return called;
}

static void each_cause_calls_for_its_own_row(void **state)
{
    (void)state;
    static const struct cause cause[] = {
        {"microfacet", "0.3],\"ior\":1}", "0.3],\"ior\":1.5}", NULL, NULL},
        {"depth of field", "\"yfov\":0.9", "\"yfov\":0.9,\"lens_radius\":0.1,\"focus_distance\":3",
         NULL, NULL},
        {"constant environment", "{\"materials\"",
         "{\"environment\":{\"radiance\":[1,1,1]},\"materials\"", NULL, NULL},
        {"alpha cut-outs", "0.3],\"ior\":1}", "0.3],\"ior\":1,\"alpha_mode\":\"mask\"}", NULL,
         NULL},
        {"ID coverage", NULL, NULL, "[\"beauty\"]", "[\"beauty\",\"crypto_object\"]"},
        {"first-hit AOVs", NULL, NULL, "[\"beauty\"]", "[\"beauty\",\"depth\"]"},
        {"Blackman-Harris filter", NULL, NULL, "\"box\"", "\"blackman_harris\""},
        {"float64 film", NULL, NULL, "\"max_bounces\"",
         "\"accuracy\":{\"precision\":\"float64\"},\"max_bounces\""},
        {"uniform light choice", NULL, NULL, "\"max_bounces\"",
         "\"accuracy\":{\"lights\":\"uniform\"},\"max_bounces\""},
    };
    const uint64_t plain = called_by(plain_scene, plain_job);
    for (size_t i = 0; i < sizeof cause / sizeof *cause; i++) {
        char *scene = replaced(plain_scene, cause[i].find, cause[i].put);
        char *job = replaced(plain_job, cause[i].job_find, cause[i].job_put);
        print_message("# %s\n", cause[i].effect);
        assert_int_not_equal(glint_effect_bit(cause[i].effect), 0);
        assert_int_equal(called_by(scene, job), plain | glint_effect_bit(cause[i].effect));
        free(scene);
        free(job);
    }
}

static void the_image_does_not_depend_on_mattes_or_aovs(void **state)
{
    (void)state;
    glint_resident *scene = offline_load_text(&o, plain_scene);
    struct glint_frame *plain = offline_frame(&o, scene, plain_job, 0);
    char *job = replaced(plain_job, "[\"beauty\"]",
                         "[\"beauty\",\"crypto_object\",\"crypto_material\",\"depth\",\"normal\"]");
    struct glint_frame *full = offline_frame(&o, scene, job, 0);
    for (int c = 0; c < 4; c++) {
        const char name[2] = {"RGBA"[c], 0};
        assert_memory_equal(glint_frame_find(plain, name), glint_frame_find(full, name),
                            (size_t)plain->width * plain->height * 4);
    }
    free(job);
    glint_frame_destroy(&plain);
    glint_frame_destroy(&full);
    glint_resident_release(&scene);
}

static int start(void **state)
{
    (void)state;
    offline_start(&o, 2);
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
        cmocka_unit_test(automatic_plan_is_the_smallest),
        cmocka_unit_test(each_cause_calls_for_its_own_row),
        cmocka_unit_test(forcing_an_uncalled_effect_changes_no_bit),
        cmocka_unit_test(the_image_does_not_depend_on_mattes_or_aovs),
    };
    return cmocka_run_group_tests(tests, start, finish);
}
