// What every job counts against the rules that hold for all samples, and what its owner is told.
#include "jobs/invariants.h"
#include "kernels/gk_film.h"
#include "kernels/gk_matte.h"
#include "kernels/gk_wave.h"
#include "render/wave_parts.h"
#include "tests/render/things.h"
#include "tests/stability/stable.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

// ---- by reason

// Counts of samples with these colours, the others being white.
static void count_samples(const float (*rgb)[3], uint32_t n, uint64_t count[GLINT_COUNTS])
{
    struct glint_error err = {0};
    glint_wave *wave;
    if (glint_wave_create(&wave, things_crew.devices, &err))
        offline_die("wave", &err);
    float *columns = glint_buffer_host(wave->columns);
    for (uint32_t c = 0; c < 3; c++)
        for (uint32_t i = 0; i < GLINT_WAVE_LANES; i++)
            columns[(GK_COL_LR + c) * GLINT_WAVE_STRIDE + i] = i < n ? rgb[i][c] : 1.0f;
    struct glint_run run = {.wave = wave, .lanes = GLINT_WAVE_LANES};
    glint_run_count_samples(&run);
    memcpy(count, wave->stats.count, sizeof wave->stats.count);
    glint_wave_destroy(&wave);
}

static void samples_are_counted_by_what_is_wrong_with_them(void **state)
{
    (void)state;
    static const float rgb[][3] = {
        {NAN, 1, 1},
        {1, 1, -NAN},
        {INFINITY, NAN, 0}, // no number
        {INFINITY, 1, 1},
        {0, 0, 2e38f * 4}, // infinite
        {1, -1e-30f, 1},
        {-1, 0, INFINITY},
        {1, -INFINITY, 1}, // negative
        {GK_RADIANCE_NESTED, 0, 0},
        {1e31f, 0, 0}, // nested, bright
        {-0.0f, 0, 1e-45f},
        {3.0f, GK_SUM_LARGEST, 0}, // sound
    };
    static const uint64_t want[GLINT_COUNTS] = {3, 2, 3, 1, 1, 0, 0};
    uint64_t count[GLINT_COUNTS];
    count_samples(rgb, COUNT(rgb), count);
    for (int i = 0; i < GLINT_COUNTS; i++)
        if (count[i] != want[i])
            fail_msg("%s: %llu", glint_count_name[i], (unsigned long long)count[i]);
}

static void state_of(const char *scene, char *job, struct glint_render_state *out)
{
    struct glint_error err = {0};
    glint_resident *resident = offline_load_text(&things_crew, scene);
    struct glint_job *parsed = offline_job(job);
    glint_render *render;
    if (glint_render_create(&render, things_crew.devices, resident, NULL, parsed, &err))
        offline_die("render", &err);
    offline_render(&things_crew, render);
    glint_render_state(render, out);
    glint_render_destroy(&render);
    glint_job_destroy(&parsed);
    glint_resident_release(&resident);
    free(job);
}

// A camera before nine balls of glass, one in the other.
static char *nine_balls(void)
{
    char instance[1024] = "";
    for (int i = 0; i < 9; i++)
        snprintf(instance + strlen(instance), sizeof instance - strlen(instance),
                 "%s'%d':{'mesh':'b','material':'g','transform':{'scale':[%d,%d,%d]}}",
                 i ? "," : "", i, i + 1, i + 1, i + 1);
    return stable_text("{'environment':{'radiance':[1,1,1]},'meshes':{'b':{'primitive':'sphere'}},"
                       "'materials':{'g':{'transmission':1,'roughness':0,'priority':1}},"
                       "'instances':{%s},'cameras':{'c':{'yfov':0.8,"
                       "'transform':{'translation':[0,0,30]}}}}",
                       instance);
}

static void too_many_nested_solids_are_a_reason_of_their_own(void **state)
{
    (void)state;
    struct glint_render_state s;
    char *scene = nine_balls();
    state_of(scene, stable_job("'resolution':[8,8],'stop':{'samples':4}"), &s);
    assert_true(s.count[GLINT_COUNT_NESTED] > 0);
    assert_int_equal(s.count[GLINT_COUNT_NESTED], glint_counts_rejected(s.count));
    assert_false(glint_counts_sound(s.count, s.camera_rays));
    free(scene);
}

// ---- coverage

#define STRIPS 10

// Strips side by side in one column of pixels.
static void lay_strips(struct thing strip[STRIPS])
{
    static const char *const name[STRIPS] = {"a", "b", "c", "d", "e", "f", "g", "h", "i", "j"};
    for (int i = 0; i < STRIPS; i++)
        strip[i] =
            (struct thing){name[i], "m", NULL, 0.05 + 0.1 * i, 0, 0, 0.1, HEIGHT, NULL, false};
}

// In four slots: what has none, by counter and by the film's own tables.
static void coverage_that_finds_no_slot_is_counted_to_the_unit(void **state)
{
    (void)state;
    static const char *const mattes[] = {
        BOX "\"mattes\":{\"levels\":2,\"slots\":4,\"eviction\":\"drop\"},",
        BOX "\"mattes\":{\"levels\":2,\"slots\":4,\"eviction\":\"drop\",\"through\":\"glossy\"},"};
    struct thing strip[STRIPS];
    lay_strips(strip);
    for (size_t i = 0; i < COUNT(mattes); i++) {
        struct shot s;
        struct glint_render_state at;
        shoot_things(&s, strip, STRIPS, "", mattes[i], 24);
        glint_render_state(s.render, &at);
        const double lost = (double)at.count[GLINT_COUNT_LOST] / GK_MATTE_ONE / 24;
        assert_true(lost > 0.3 * HEIGHT);
        if (i == 0) // the others' tables lose what bounces bring, too
            assert_float_equal(lost, lost_in(&s), 1e-9);
        finish_shot(&s);
    }
}

static void coverage_that_fits_leaves_nothing_to_count(void **state)
{
    (void)state;
    struct shot s;
    struct glint_render_state at;
    shoot_things(&s, crowd, CROWD, LENS, ALL_RANKS, 16);
    glint_render_state(s.render, &at);
    for (int i = 0; i < GLINT_COUNTS; i++)
        assert_int_equal(at.count[i], 0);
    finish_shot(&s);
}

// ---- what is told

static cJSON *told(const struct glint_render_state *s, cJSON **warnings)
{
    cJSON *object = cJSON_CreateObject();
    glint_invariants_add(object, s);
    *warnings = cJSON_AddArrayToObject(object, "warnings");
    glint_invariants_warn(*warnings, s);
    return object;
}

static bool is_sound(const cJSON *object)
{
    const cJSON *o = cJSON_GetObjectItem(object, "invariants");
    return cJSON_IsTrue(cJSON_GetObjectItem(o, "sound"));
}

static void more_than_one_rejected_in_a_million_is_not_sound_and_said(void **state)
{
    (void)state;
    for (uint64_t rejected = 2; rejected <= 3; rejected++) {
        cJSON *warnings;
        const struct glint_render_state s = {
            .camera_rays = 2000000,
            .count = {[GLINT_COUNT_NAN] = 1, [GLINT_COUNT_NEGATIVE] = rejected - 1}};
        cJSON *object = told(&s, &warnings);
        assert_int_equal(is_sound(object), rejected == 2);
        assert_int_equal(cJSON_GetArraySize(warnings), rejected == 3);
        if (rejected == 3)
            assert_non_null(strstr(cJSON_GetArrayItem(warnings, 0)->valuestring,
                                   "3 of 2000000 samples were rejected"));
        cJSON_Delete(object);
    }
}

static void clamped_coverage_is_said_above_one_in_ten_thousand(void **state)
{
    (void)state;
    for (uint64_t units = 6; units <= 7; units++) { // of 65536
        cJSON *warnings;
        const struct glint_render_state s = {.camera_rays = 1,
                                             .count = {[GLINT_COUNT_CLAMPED] = units}};
        cJSON *object = told(&s, &warnings);
        assert_true(is_sound(object));
        assert_int_equal(cJSON_GetArraySize(warnings), units == 7);
        const cJSON *share =
            cJSON_GetObjectItem(cJSON_GetObjectItem(object, "invariants"), "coverage_clamped");
        assert_true(share->valuedouble == (double)units / GK_MATTE_ONE);
        cJSON_Delete(object);
    }
}

static void a_job_without_samples_is_sound(void **state)
{
    (void)state;
    cJSON *warnings;
    const struct glint_render_state s = {0};
    cJSON *object = told(&s, &warnings);
    assert_true(is_sound(object));
    assert_int_equal(cJSON_GetArraySize(warnings), 0);
    cJSON_Delete(object);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(samples_are_counted_by_what_is_wrong_with_them),
        cmocka_unit_test(too_many_nested_solids_are_a_reason_of_their_own),
        cmocka_unit_test(coverage_that_finds_no_slot_is_counted_to_the_unit),
        cmocka_unit_test(coverage_that_fits_leaves_nothing_to_count),
        cmocka_unit_test(more_than_one_rejected_in_a_million_is_not_sound_and_said),
        cmocka_unit_test(clamped_coverage_is_said_above_one_in_ten_thousand),
        cmocka_unit_test(a_job_without_samples_is_sound),
    };
    return cmocka_run_group_tests(tests, things_start, things_finish);
}
