// Intervals, ratios, fronts and the table that they are drawn from.
#include "clients/cli/accuracy_stat.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include <cmocka.h>

// Mean 3, deviation sqrt(2.5), t = 2.776 with 4 degrees of freedom (tables of Student's t).
static void a_mean_has_students_interval(void **state)
{
    (void)state;
    const double five[] = {1, 2, 3, 4, 5};
    const struct glint_accuracy_interval i = glint_accuracy_mean_of(five, 5);
    assert_true(i.middle == 3);
    assert_true(fabs(i.high - 3 - 2.776 * sqrt(2.5 / 5)) < 0.003);
    assert_true(fabs(i.high + i.low - 6) < 1e-12);
    const double sixteen[16] = {1, -1, 1, -1, 1, -1, 1, -1, 1, -1, 1, -1, 1, -1, 1, -1};
    const struct glint_accuracy_interval j = glint_accuracy_mean_of(sixteen, 16);
    assert_true(fabs(j.high - 2.131 * sqrt(16.0 / 15 / 16)) < 0.001);
    assert_true(isinf(glint_accuracy_mean_of(five, 1).high));
}

static void a_medians_interval_holds_it_and_is_the_same_every_time(void **state)
{
    (void)state;
    const double nine[] = {5, 1, 9, 3, 7, 2, 8, 4, 6};
    const struct glint_accuracy_interval a = glint_accuracy_median_of(nine, 9);
    const struct glint_accuracy_interval b = glint_accuracy_median_of(nine, 9);
    assert_true(a.middle == 5 && a.low >= 1 && a.low < 5 && a.high > 5 && a.high <= 9);
    assert_memory_equal(&a, &b, sizeof a);
}

static struct glint_accuracy_point point(double cost, double error)
{
    return (struct glint_accuracy_point){.cost = {cost, cost}, .error = {error, error, error}};
}

static void what_is_dearer_and_worse_is_not_on_the_front(void **state)
{
    (void)state;
    struct glint_accuracy_point p[] = {point(1, 1), point(2, 0.5), point(3, 0.6), point(4, 0.1)};
    p[2].cost[GLINT_COST_CPU] = 1.5; // but not by this cost
    glint_accuracy_mark_front(p, 4);
    assert_true(p[0].front[0] && p[1].front[0] && !p[2].front[0] && p[3].front[0]);
    assert_true(p[2].front[GLINT_COST_CPU]);
    p[3] = point(3, 0.5); // as good as a cheaper one
    glint_accuracy_mark_front(p, 4);
    assert_true(!p[3].front[0] && p[1].front[0]);
}

static void a_line_of_monte_carlo_goes_on_as_it_does(void **state)
{
    (void)state;
    const struct glint_accuracy_point p[] = {point(1, 1), point(4, 0.5), point(16, 0.25)};
    const double at[] = {0.25, 1, 2, 4, 16, 64};
    for (size_t i = 0; i < sizeof at / sizeof *at; i++)
        assert_true(fabs(glint_accuracy_error_at(p, 3, GLINT_COST_RAYS, at[i]) - 1 / sqrt(at[i])) <
                    1e-12);
    assert_true(isnan(glint_accuracy_error_at(p, 0, GLINT_COST_RAYS, 1)));
}

// ---- the table

static struct glint_accuracy_row *add(struct glint_accuracy_table *t, const char *value,
                                      const char *seed, unsigned spp, double cpu)
{
    struct glint_accuracy_row *row = glint_accuracy_table_add(t);
    strcpy(row->scene, "room");
    strcpy(row->knob, "max_bounces");
    strcpy(row->method, "max_bounces");
    strcpy(row->value, value);
    strcpy(row->seed, seed);
    strcpy(row->ref_id, "colour:2x64");
    row->spp = spp;
    row->cpu = cpu;
    row->rays[0] = row->rays[1] = row->rays[2] = 10 * spp;
    row->rmse61 = 1.0 / spp;
    return row;
}

static char *folder(void)
{
    static char name[] = "/tmp/glint-accuracy-XXXXXX";
    strcpy(name + strlen(name) - 6, "XXXXXX");
    assert_non_null(mkdtemp(name));
    return name;
}

static void remove_all(const char *name)
{
    char path[256];
    snprintf(path, sizeof path, "%s/accuracy.csv", name);
    unlink(path);
    snprintf(path, sizeof path, "%s/mattes.csv", name);
    unlink(path);
    rmdir(name);
}

static void a_table_reads_back_as_it_was_written(void **state)
{
    (void)state;
    char *name = folder();
    struct glint_accuracy_table a = {0}, b;
    struct glint_error err = {0};
    add(&a, "1", "1", 4, 0.125);
    struct glint_accuracy_row *matte = add(&a, "8", "2", 4, 0.5);
    matte->rmse61 = NAN;
    matte->tv = 0.25;
    matte->lost = 0.0625;
    matte->within = 1;
    assert_int_equal(glint_accuracy_table_write(&a, name, &err), GLINT_OK);
    assert_int_equal(glint_accuracy_table_read(&b, name, &err), GLINT_OK);
    assert_int_equal(b.rows, 2);
    assert_true(b.row[0].rmse61 == 0.25 && isnan(b.row[0].tv) && isnan(b.row[0].lost));
    assert_true(isnan(b.row[1].rmse61) && b.row[1].tv == 0.25 && b.row[1].lost == 0.0625);
    assert_string_equal(b.row[1].value, "8");
    const struct glint_accuracy_row *found =
        glint_accuracy_table_find(&b, "max_bounces", "1", "1", 4);
    assert_true(found == &b.row[0] && found->cpu == 0.125 && found->rays[2] == 40);
    assert_null(glint_accuracy_table_find(&b, "max_bounces", "1", "1", 8));
    glint_accuracy_table_finish(&a);
    glint_accuracy_table_finish(&b);
    remove_all(name);
}

static void another_table_is_refused_with_its_line(void **state)
{
    (void)state;
    char *name = folder(), path[256];
    snprintf(path, sizeof path, "%s/accuracy.csv", name);
    struct glint_accuracy_table t = {0};
    struct glint_error err = {0};
    add(&t, "1", "1", 4, 0.125);
    glint_accuracy_table_write(&t, name, &err);
    glint_accuracy_table_finish(&t);
    FILE *file = fopen(path, "a");
    fputs("room,a,b,c,1,four,1,1,1,1,1,2,1,1,1,,,,,,,,r,b\n", file);
    fclose(file);
    assert_int_equal(glint_accuracy_table_read(&t, name, &err), GLINT_E_SYNTAX);
    assert_non_null(strstr(err.fault[0].detail, "line 3"));
    glint_error_finish(&err);
    remove_all(name);
}

static void a_cost_is_compared_seed_by_seed(void **state)
{
    (void)state;
    struct glint_accuracy_table t = {0};
    const char *seeds[] = {"1", "2", "3"};
    for (int i = 0; i < 3; i++) { // a machine that gets slower and slower
        add(&t, "1", seeds[i], 4, 0.5 * (i + 1));
        add(&t, "128", seeds[i], 4, 1.0 * (i + 1));
    }
    struct glint_accuracy_interval ratio;
    const struct glint_accuracy_row one = t.row[0], twin = t.row[1];
    assert_true(glint_accuracy_ratio(&ratio, &t, &one, &twin, GLINT_COST_CPU));
    assert_true(ratio.low == 0.5 && ratio.middle == 0.5 && ratio.high == 0.5);
    struct glint_accuracy_point p;
    add(&t, "1", "all", 4, 99);
    assert_true(glint_accuracy_point_of(&p, &t, "max_bounces", "1", 4));
    assert_int_equal(p.seeds, 3); // means are no seed
    assert_true(p.cost[GLINT_COST_CPU] == 1 && p.cost[GLINT_COST_RAYS] == 120);
    assert_false(glint_accuracy_point_of(&p, &t, "max_bounces", "2", 4));
    glint_accuracy_table_finish(&t);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_mean_has_students_interval),
        cmocka_unit_test(a_medians_interval_holds_it_and_is_the_same_every_time),
        cmocka_unit_test(what_is_dearer_and_worse_is_not_on_the_front),
        cmocka_unit_test(a_line_of_monte_carlo_goes_on_as_it_does),
        cmocka_unit_test(a_table_reads_back_as_it_was_written),
        cmocka_unit_test(another_table_is_refused_with_its_line),
        cmocka_unit_test(a_cost_is_compared_seed_by_seed),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
