// Fronts: what is read, what is refused, and which point a budget gets.
#include "protocol/accuracy_front.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#define POINT(settings, seconds, variance, bias)                                             \
    "{\"settings\":" settings ",\"seconds\":" #seconds ",\"rays\":1,\"variance\":" #variance \
    ",\"bias\":" #bias "}"
#define EXACT "{\"accuracy\":{\"gi\":\"path\"},\"max_bounces\":128}"
#define ROUGH "{\"accuracy\":{\"gi\":\"none\"},\"max_bounces\":1}"

// The exact point has noise alone; the rough one costs a tenth, has less noise and a bias of 0.1.
static const char two[] =
    "{\"points\":[" POINT(EXACT, 1e-6, 1, 0) "," POINT(ROUGH, 1e-7, 0.5, 0.1) "]}";

static struct glint_front *parse(const char *text)
{
    struct glint_error err = {0};
    struct glint_front *front;
    if (glint_front_parse(&front, text, strlen(text), &err))
        fail_msg("%s: %s", err.fault[0].pointer, err.fault[0].detail);
    return front;
}

static void assert_refused(const char *text, const char *pointer)
{
    struct glint_error err = {0};
    struct glint_front *front;
    assert_int_equal(glint_front_parse(&front, text, strlen(text), &err), GLINT_E_RANGE);
    assert_null(front);
    assert_string_equal(err.fault[0].pointer, pointer);
    glint_error_finish(&err);
}

static void settings_are_those_of_a_job(void **state)
{
    (void)state;
    struct glint_front *f = parse(two);
    assert_int_equal(f->points, 2);
    assert_int_equal(f->point[0].dial[GLINT_DIAL_GI], 0);
    assert_int_equal(f->point[1].dial[GLINT_DIAL_GI], 1);
    assert_int_equal(f->point[0].max_bounces, 128);
    assert_true(f->point[1].seconds == 1e-7 && f->point[1].bias == 0.1);
    free(f);
}

static void what_is_wrong_is_named_by_its_pointer(void **state)
{
    (void)state;
    assert_refused("{}", "/points");
    assert_refused("{\"points\":[]}", "/points");
    assert_refused("{\"points\":[5]}", "/points/0");
    assert_refused("{\"points\":[],\"colour\":1}", "/colour");
    assert_refused("{\"points\":[" POINT("{\"accuracy\":{\"gi\":\"surfel\"}}", 1, 1, 1) "]}",
                   "/points/0/settings");
    assert_refused("{\"points\":[" POINT("{\"accuracy\":{\"time\":1}}", 1, 1, 1) "]}",
                   "/points/0/settings");
    assert_refused("{\"points\":[" POINT("{\"scene\":\"a\"}", 1, 1, 1) "]}",
                   "/points/0/settings/scene");
    assert_refused("{\"points\":[" POINT(EXACT, 0, 1, 0) "]}", "/points/0/seconds");
    assert_refused("{\"points\":[" POINT(EXACT, 1, -1, 0) "]}", "/points/0/variance");
    assert_refused("{\"revision\":3,\"points\":[" POINT(EXACT, 1, 1, 0) "]}", "/revision");
}

static void a_front_of_more_points_than_fit_is_refused(void **state)
{
    (void)state;
    const size_t each = sizeof(POINT(EXACT, 1, 1, 0));
    char *text = malloc(64 + (GLINT_MAX_FRONT_POINTS + 1) * (each + 1));
    strcpy(text, "{\"points\":[");
    char *end = text + strlen(text);
    for (int i = 0; i <= GLINT_MAX_FRONT_POINTS; i++)
        end = stpcpy(stpcpy(end, i ? "," : ""), POINT(EXACT, 1, 1, 0));
    strcpy(end, "]}");
    assert_refused(text, "/points");
    free(text);
}

static struct glint_front_choice choose(const struct glint_front *f, double seconds, double error)
{
    const struct glint_front_wish wish = {
        .seconds = seconds, .error = error, .pixels = 1000, .workers = 1, .max_samples = 1u << 24};
    struct glint_front_choice c = {0};
    assert_true(glint_front_choose(f, &wish, &c));
    return c;
}

// Of 1000 pixels a sample costs 1 ms exactly, 0.1 ms roughly: the lines cross where
// 1/n = 0.01 + 0.05/n, at 95 exact samples.
static void little_time_takes_the_rough_point_and_much_the_exact_one(void **state)
{
    (void)state;
    struct glint_front *f = parse(two);
    const struct glint_front_choice brief = choose(f, 0.05, 0), ample = choose(f, 0.2, 0);
    assert_int_equal(brief.point, 1);
    assert_true(fabs(brief.samples - 500) <= 1);
    assert_true(fabs(brief.error - sqrt(0.01 + 0.5 / brief.samples)) < 1e-12);
    assert_int_equal(ample.point, 0);
    assert_true(fabs(ample.samples - 200) <= 1);
    assert_true(ample.seconds == 0.2);
    free(f);
}

static void workers_share_the_time_of_a_sample(void **state)
{
    (void)state;
    struct glint_front *f = parse(two);
    struct glint_front_wish wish = {
        .seconds = 0.2, .pixels = 1000, .workers = 4, .max_samples = 1u << 24};
    struct glint_front_choice c = {0};
    assert_true(glint_front_choose(f, &wish, &c));
    assert_true(c.point == 0 && fabs(c.samples - 800) <= 1);
    wish.seconds = 0;
    wish.error = 0.09;
    assert_true(glint_front_choose(f, &wish, &c));
    assert_true(fabs(c.seconds - c.samples * 1e-3 / 4) < 1e-9);
    free(f);
}

static void an_error_below_the_bias_takes_the_exact_point(void **state)
{
    (void)state;
    struct glint_front *f = parse(two);
    const struct glint_front_choice loose = choose(f, 0, 0.2), tight = choose(f, 0, 0.09);
    assert_int_equal(loose.point, 1);
    assert_true(loose.samples == ceil(0.5 / (0.04 - 0.01)));
    assert_int_equal(tight.point, 0);
    assert_true(tight.samples == ceil(1 / (0.09 * 0.09)));
    assert_true(tight.error <= 0.09 && fabs(tight.seconds - tight.samples * 1e-3) < 1e-9);
    free(f);
}

// Noise 1/n x (1 + 2 x 3 / sqrt(n)) <= 0.01 from the n on that is 100 (1 + 6 / sqrt(n)).
static void errors_that_spread_over_seeds_take_more_samples(void **state)
{
    (void)state;
    struct glint_front *f = parse("{\"points\":[{\"settings\":" EXACT
                                  ",\"seconds\":1e-6,\"rays\":1,\"variance\":1,\"bias\":0,"
                                  "\"spread\":3}]}");
    const double n = choose(f, 0, 0.1).samples;
    assert_true(n >= 100 * (1 + 6 / sqrt(n)) && n - 1 < 100 * (1 + 6 / sqrt(n - 1)));
    f->pixels = 4000; // four times those of the image: the spread is twice as large
    const double few = choose(f, 0, 0.1).samples;
    assert_true(few >= 100 * (1 + 12 / sqrt(few)) && few - 1 < 100 * (1 + 12 / sqrt(few - 1)));
    f->pixels = 250; // it is not taken for smaller
    assert_true(choose(f, 0, 0.1).samples == n);
    free(f);
}

static void pinned_settings_leave_the_points_that_have_them(void **state)
{
    (void)state;
    struct glint_front *f = parse(two);
    struct glint_front_choice c;
    struct glint_front_point at = f->point[0];
    struct glint_front_wish wish = {.seconds = 0.01,
                                    .pixels = 1000,
                                    .workers = 1,
                                    .pinned = 1u << GLINT_DIAL_GI,
                                    .at = &at,
                                    .max_samples = 100};
    assert_true(glint_front_choose(f, &wish, &c));
    assert_int_equal(c.point, 0);
    at.max_bounces = 3;
    wish.pinned |= GLINT_CHOICE_BOUNCES;
    assert_false(glint_front_choose(f, &wish, &c));
    free(f);
}

static void an_error_that_no_point_reaches_is_not_promised(void **state)
{
    (void)state;
    struct glint_front *f = parse("{\"points\":[" POINT(ROUGH, 1e-7, 0.5, 0.1) "]}");
    const struct glint_front_wish wish = {
        .error = 0.1, .pixels = 1, .workers = 1, .max_samples = 100};
    struct glint_front_choice c;
    assert_false(glint_front_choose(f, &wish, &c));
    free(f);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(settings_are_those_of_a_job),
        cmocka_unit_test(what_is_wrong_is_named_by_its_pointer),
        cmocka_unit_test(a_front_of_more_points_than_fit_is_refused),
        cmocka_unit_test(little_time_takes_the_rough_point_and_much_the_exact_one),
        cmocka_unit_test(workers_share_the_time_of_a_sample),
        cmocka_unit_test(an_error_below_the_bias_takes_the_exact_point),
        cmocka_unit_test(errors_that_spread_over_seeds_take_more_samples),
        cmocka_unit_test(pinned_settings_leave_the_points_that_have_them),
        cmocka_unit_test(an_error_that_no_point_reaches_is_not_promised),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
