// test_energy.c - the tables that are built in, and those that cores share the work of.
#include "scene/energy.h"
#include "scene/energy_rows.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#define FLINT 1.62f

// The row by itself, in the thread of the test.
static void assert_row(const float *parts, float ior, int y)
{
    static float whole[GK_ENERGY_PARTS * GK_ENERGY_PART];
    glint_energy_part_row(whole, ior, y);
    const size_t first = (size_t)y * GK_ENERGY_SIDE, bytes = GK_ENERGY_SIDE * sizeof *whole;
    const size_t mean = GK_ENERGY_SIDE * GK_ENERGY_SIDE + (size_t)y;
    assert_memory_equal(parts + first, whole + first, bytes);
    assert_memory_equal(parts + mean, whole + mean, sizeof *whole);
}

static void assert_glass_row(const float *parts, float ior, int y)
{
    static float whole[GK_ENERGY_PARTS * GK_ENERGY_PART];
    glint_energy_glass_row(whole, ior, y);
    for (size_t p = 1; p < GK_ENERGY_PARTS; p++) {
        const size_t first = p * GK_ENERGY_PART + (size_t)y * GK_ENERGY_SIDE;
        assert_memory_equal(parts + first, whole + first, GK_ENERGY_SIDE * sizeof *whole);
    }
}

static void what_is_built_in_is_what_the_integrals_give(void **state)
{
    static const float known[] = {1.0f, 1.33f, 1.45f, 1.5f};
    (void)state;
    for (int y = 0; y < GK_ENERGY_SIDE; y += 5) {
        assert_row(glint_energy_white(), 0.0f, y);
        for (size_t i = 0; i < sizeof known / sizeof *known; i++) {
            float ior;
            glint_energy_step(known[i], &ior);
            assert_row(glint_energy_interface(known[i]), ior, y);
            assert_glass_row(glint_energy_glass(known[i]), ior, y);
        }
    }
}

static void what_many_cores_make_is_what_one_makes(void **state)
{
    float ior;
    (void)state;
    glint_energy_step(FLINT, &ior);
    const float *flint = glint_energy_glass(FLINT);
    for (int y = 0; y < GK_ENERGY_SIDE; y += 5) {
        assert_row(flint, ior, y);
        assert_glass_row(flint, ior, y);
    }
}

static void an_interface_is_made_once_and_is_not_that_of_glass(void **state)
{
    (void)state;
    assert_ptr_equal(glint_energy_interface(1.5f), glint_energy_interface(1.5f));
    assert_ptr_not_equal(glint_energy_interface(1.5f), glint_energy_glass(1.5f));
    assert_ptr_not_equal(glint_energy_interface(FLINT), glint_energy_glass(FLINT));
    assert_ptr_equal(glint_energy_interface(1.7f), glint_energy_interface(1.7f));
    assert_ptr_not_equal(glint_energy_interface(1.7f), glint_energy_white());
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(what_is_built_in_is_what_the_integrals_give),
        cmocka_unit_test(what_many_cores_make_is_what_one_makes),
        cmocka_unit_test(an_interface_is_made_once_and_is_not_that_of_glass),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
