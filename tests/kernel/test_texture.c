// Where a coordinate falls between texels, in every way to wrap.
#include "kernels/gk_texture.h"
#include "tests/kernel/check.h"

#include <math.h>

enum { MOST = 9 };

static int remainder_of(int i, int n)
{
    return (i % n + n) % n;
}

// The texel i of an endless row made of n.
static int wrapped(int i, int n, gk_u32 wrap)
{
    if (wrap == GK_WRAP_REPEAT)
        return remainder_of(i, n);
    if (wrap == GK_WRAP_MIRROR) {
        const int at = remainder_of(i, 2 * n);
        return at < n ? at : 2 * n - 1 - at;
    }
    return i < 0 ? 0 : i > n - 1 ? n - 1 : i;
}

static const double texel[MOST] = {3, -1, 4, 1, -5, 9, 2, 6, -8};

// A row of texels at the coordinate t, interpolated.
static double expected(double t, int n, gk_u32 wrap)
{
    const double x = t * n - 0.5, below = floor(x), w = x - below;
    return (1 - w) * texel[wrapped((int)below, n, wrap)] +
           w * texel[wrapped((int)below + 1, n, wrap)];
}

static double found(double t, int n, gk_u32 wrap, gk_i32 nearest)
{
    const struct gk_taps taps = gk_wrap_taps((float)t, (gk_u32)n, wrap, nearest);
    assert_in_range(taps.lower, 0, n - 1);
    assert_in_range(taps.upper, 0, n - 1);
    return (1 - (double)taps.weight) * texel[taps.lower] + (double)taps.weight * texel[taps.upper];
}

static const gk_u32 wraps[] = {GK_WRAP_REPEAT, GK_WRAP_MIRROR, GK_WRAP_CLAMP};

// Coordinates of 1/64: every step is exact.
static void a_row_is_interpolated_across_its_ends(void **state)
{
    (void)state;
    for (int k = 0; k < 3; k++)
        for (int n = 1; n <= MOST; n++)
            for (int t = -256; t <= 256; t++)
                assert_within(found(t / 64.0, n, wraps[k], 0) - expected(t / 64.0, n, wraps[k]),
                              1e-5);
}

// In the middle between two texels' edges, in each of some periods.
static void the_nearest_texel_is_the_one_that_it_lies_in(void **state)
{
    (void)state;
    for (int k = 0; k < 3; k++)
        for (int n = 1; n <= MOST; n++)
            for (int i = -3 * n; i < 3 * n; i++)
                assert_within(found((i + 0.5) / n, n, wraps[k], 1) - texel[wrapped(i, n, wraps[k])],
                              0.0);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_row_is_interpolated_across_its_ends),
        cmocka_unit_test(the_nearest_texel_is_the_one_that_it_lies_in),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
