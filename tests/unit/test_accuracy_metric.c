// The metrics of `glint accuracy` against what can be computed by hand, and against noise of known
// variance: bias and variance are told apart, the reference's own variance is taken off.
#include "clients/cli/accuracy_mean.h"
#include "clients/cli/accuracy_metric.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#define SIDE 64
#define PIXELS (SIDE * SIDE)

static struct glint_frame *frame(const char *const *name, size_t names, float value)
{
    struct glint_frame *f;
    assert_int_equal(glint_frame_create(&f, SIDE, SIDE, 0, 0, SIDE, SIDE, NULL), GLINT_OK);
    for (size_t c = 0; c < names; c++) {
        float *plane = glint_frame_channel(f, name[c], GLINT_PIXEL_FLOAT);
        for (int p = 0; p < PIXELS; p++)
            plane[p] = value;
    }
    return f;
}

static struct glint_accuracy_image grey(float value)
{
    static const char *const rgb[] = {"R", "G", "B"};
    struct glint_frame *f = frame(rgb, 3, value);
    struct glint_accuracy_image image;
    assert_int_equal(glint_accuracy_image_take(&image, f, false, NULL), GLINT_OK);
    glint_frame_destroy(&f);
    return image;
}

// Uniform in [-s sqrt 3, s sqrt 3]: deviation s.
static float noise(float s)
{
    static uint64_t x = 88172645463325252u;
    x ^= x << 13, x ^= x >> 7, x ^= x << 17; // Marsaglia 2003
    return s * 1.7320508f * (2.0f * (float)((double)(x >> 11) / 9007199254740992.0) - 1.0f);
}

static void add_noise(struct glint_accuracy_image *image, float s)
{
    for (size_t c = 0; c < image->channels; c++)
        for (int p = 0; p < PIXELS; p++)
            image->channel[c].plane[p] += noise(s);
}

static struct glint_accuracy_reference reference(float value, float s)
{
    struct glint_accuracy_image half[2] = {grey(value), grey(value)};
    struct glint_accuracy_reference r;
    add_noise(&half[0], s);
    add_noise(&half[1], s);
    assert_int_equal(glint_accuracy_reference_take(&r, half, false, NULL), GLINT_OK);
    return r;
}

// T(1) = 1/2, T(3) = 3/4 in each of three channels; (3-1)^2/(1+0.01) per channel.
static void colour_is_compared_as_the_formulas_say(void **state)
{
    (void)state;
    struct glint_accuracy_reference r = reference(1, 0);
    struct glint_accuracy_image image = grey(3);
    struct glint_accuracy_error e;
    glint_accuracy_compare(&e, &image, &r);
    assert_true(fabs(e.rmse61 - sqrt(3) / 4) < 1e-6);
    assert_true(fabs(e.relmse - 4 / 1.01) < 1e-6 && fabs(e.relmse_trim - 4 / 1.01) < 1e-6);
    assert_true(!e.limited && isnan(e.tv));
    image.channel[0].plane[0] += 1e6f; // a firefly: one of the four pixels that are left out
    glint_accuracy_compare(&e, &image, &r);
    assert_true(e.relmse > 1e6 && fabs(e.relmse_trim - 4 / 1.01) < 1e-6);
    glint_accuracy_image_finish(&image);
    glint_accuracy_reference_finish(&r);
}

// The squared error of a perfect image is the reference's variance, which is taken off: what is left
// has a deviation of 4e-5 x sqrt(2/12288) around 0.
static void the_variance_of_the_reference_is_taken_off(void **state)
{
    (void)state;
    struct glint_accuracy_reference r = reference(1, 0.01f);
    struct glint_accuracy_image image = grey(1);
    struct glint_accuracy_error e;
    glint_accuracy_compare(&e, &image, &r);
    assert_true(e.limited);
    assert_true(fabs(e.relmse) < 5 * 0.5 * 1e-4 / 1.01 * sqrt(2 * 2.0 / (3 * PIXELS)));
    glint_accuracy_image_finish(&image);
    glint_accuracy_reference_finish(&r);
}

// 16 images of mean 1.1 and deviation 0.2 against 1: variance 0.04/1.01, bias^2 0.01/1.01 with a
// deviation of about 2 x 0.1 x sqrt(0.04/16) / sqrt(12288) / 1.01 = 9e-5.
static void bias_and_variance_are_told_apart(void **state)
{
    (void)state;
    struct glint_accuracy_reference r = reference(1, 0.01f);
    struct glint_accuracy_mean m = {0};
    glint_accuracy_image_like(&m.mean, &r.mean, NULL);
    glint_accuracy_image_like(&m.squares, &r.mean, NULL);
    for (unsigned seed = 1; seed <= 16; seed++) {
        struct glint_accuracy_image image = grey(1.1f);
        add_noise(&image, 0.2f);
        glint_accuracy_mean_add(&m, seed, &image);
        glint_accuracy_image_finish(&image);
    }
    assert_int_equal(glint_accuracy_mean_count(&m), 16);
    struct glint_accuracy_spread s;
    glint_accuracy_spread(&s, &m.mean, &m.squares, 16, &r);
    assert_true(fabs(s.bias2 - 0.01 / 1.01) < 5 * 9e-5);
    assert_true(s.bias2_se > 5e-5 && s.bias2_se < 3e-4);
    assert_true(fabs(s.variance * 1.01 / 0.04 - 1) < 5 * sqrt(2.0 / (16 * 3 * PIXELS)));
    glint_accuracy_mean_finish(&m);
    glint_accuracy_reference_finish(&r);
}

static const char *const ranks[] = {"CryptoObject00.R", "CryptoObject00.G", "CryptoObject00.B",
                                    "CryptoObject00.A"};

// Everywhere ID 7 with coverage a, ID 9 with b.
static struct glint_accuracy_image mattes(float a, float b)
{
    struct glint_frame *f = frame(ranks, 4, 0);
    const uint32_t id[] = {7, 9};
    const float coverage[] = {a, b};
    for (int p = 0; p < PIXELS; p++)
        for (int i = 0; i < 2; i++) {
            memcpy(&glint_frame_find(f, ranks[2 * i])[p], &id[i], 4);
            glint_frame_find(f, ranks[2 * i + 1])[p] = coverage[i];
        }
    struct glint_accuracy_image image;
    assert_int_equal(glint_accuracy_image_take(&image, f, true, NULL), GLINT_OK);
    glint_frame_destroy(&f);
    return image;
}

static void coverage_is_compared_name_by_name(void **state)
{
    (void)state;
    struct glint_accuracy_image half[2] = {mattes(0.75f, 0.25f), mattes(0.75f, 0.25f)};
    struct glint_accuracy_image image = mattes(0.5f, 0.25f), same = mattes(0.25f, 0.75f);
    struct glint_accuracy_reference r;
    struct glint_accuracy_error e;
    glint_accuracy_reference_take(&r, half, true, NULL);
    assert_int_equal(r.mean.channels, 3); // two names, and the others
    glint_accuracy_image_align(&image, &r.mean, NULL);
    glint_accuracy_compare(&e, &image, &r);
    assert_true(e.tv == 0.125 && e.lost == 0.25 && e.matte_max == 0.25 && e.within == 0);
    assert_true(isnan(e.rmse61) && fabs(e.matte_mae - 0.25 / 3) < 1e-9);
    glint_accuracy_image_align(&same, &r.mean, NULL); // the order of its ranks is another
    glint_accuracy_compare(&e, &same, &r);
    assert_true(e.tv == 0.5 && e.lost == 0);
    glint_accuracy_compare(&e, &r.mean, &r);
    assert_true(e.tv == 0 && e.within == 1);
    glint_accuracy_image_finish(&image);
    glint_accuracy_image_finish(&same);
    glint_accuracy_reference_finish(&r);
}

static void a_name_that_the_reference_has_not_goes_to_the_others(void **state)
{
    (void)state;
    struct glint_accuracy_image like = mattes(1, 0), other = mattes(0.5f, 0.5f);
    assert_int_equal(like.channels, 2);
    assert_int_equal(glint_accuracy_image_align(&other, &like, NULL), GLINT_OK);
    assert_true(other.channel[0].plane[5] == 0.5f && other.channel[1].plane[5] == 0.5f);
    other.width--;
    assert_int_equal(glint_accuracy_image_align(&other, &like, NULL), GLINT_E_RANGE);
    glint_accuracy_image_finish(&like);
    glint_accuracy_image_finish(&other);
}

static void what_is_seen_directly_stands_for_what_is_seen_through_reflections(void **state)
{
    (void)state;
    struct glint_accuracy_image like = mattes(0.75f, 0.25f), direct = mattes(0.5f, 0.25f);
    strcpy(like.channel[1].type, "CryptoGlossObject");
    like.channel[1].id = like.channel[0].id;
    assert_int_equal(glint_accuracy_image_align(&direct, &like, NULL), GLINT_OK);
    assert_true(direct.channel[0].plane[5] == 0.5f && direct.channel[1].plane[5] == 0.5f);
    assert_true(direct.channel[2].plane[5] == 0.5f); // of the other name, both
    glint_accuracy_image_finish(&like);
    glint_accuracy_image_finish(&direct);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(colour_is_compared_as_the_formulas_say),
        cmocka_unit_test(the_variance_of_the_reference_is_taken_off),
        cmocka_unit_test(bias_and_variance_are_told_apart),
        cmocka_unit_test(coverage_is_compared_name_by_name),
        cmocka_unit_test(what_is_seen_directly_stands_for_what_is_seen_through_reflections),
        cmocka_unit_test(a_name_that_the_reference_has_not_goes_to_the_others),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
