#include "base/metrics.h"
#include "base/thread.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

static glint_metrics *make(void)
{
    glint_metrics *metrics;
    assert_int_equal(glint_metrics_create(&metrics, NULL), GLINT_OK);
    return metrics;
}

static void assert_text(glint_metrics *metrics, const char *expected)
{
    size_t length;
    char *text = glint_metrics_text(metrics, &length);
    assert_non_null(text);
    assert_int_equal(length, strlen(text));
    assert_string_equal(text, expected);
    free(text);
}

static void a_family_is_described_once_before_its_series(void **state)
{
    (void)state;
    glint_metrics *metrics = make();
    const struct glint_label done = {"state", "done"}, failed = {"state", "failed"};
    glint_metric_set(glint_metrics_gauge(metrics, "jobs", "Jobs by state.", &done, 1), 3);
    glint_metric_add(glint_metrics_counter(metrics, "slices_total", "Slices run.", NULL, 0), 2);
    glint_metric_set(glint_metrics_gauge(metrics, "jobs", "Jobs by state.", &failed, 1), 0.5);
    assert_text(metrics, "# HELP glint_jobs Jobs by state.\n"
                         "# TYPE glint_jobs gauge\n"
                         "glint_jobs{state=\"done\"} 3\n"
                         "glint_jobs{state=\"failed\"} 0.5\n"
                         "# HELP glint_slices_total Slices run.\n"
                         "# TYPE glint_slices_total counter\n"
                         "glint_slices_total 2\n");
    glint_metrics_destroy(&metrics);
    assert_null(metrics);
}

static void the_same_name_and_labels_are_the_same_series(void **state)
{
    (void)state;
    glint_metrics *metrics = make();
    glint_metric *one = glint_metrics_counter(metrics, "a_total", "A.", NULL, 0);
    assert_ptr_equal(one, glint_metrics_counter(metrics, "a_total", "A.", NULL, 0));
    const struct glint_label label = {"x", "1"};
    assert_ptr_not_equal(one, glint_metrics_counter(metrics, "a_total", "A.", &label, 1));
    glint_metrics_destroy(&metrics);
}

static void label_values_are_escaped(void **state)
{
    (void)state;
    glint_metrics *metrics = make();
    const struct glint_label label[] = {{"a", "q\"b\\n\n"}, {"b", ""}};
    glint_metrics_counter(metrics, "x_total", "Back\\slash.", label, 2);
    assert_text(metrics, "# HELP glint_x_total Back\\\\slash.\n"
                         "# TYPE glint_x_total counter\n"
                         "glint_x_total{a=\"q\\\"b\\\\n\\n\",b=\"\"} 0\n");
    glint_metrics_destroy(&metrics);
}

static void histogram_buckets_are_cumulative_and_include_their_bound(void **state)
{
    (void)state;
    static const double bound[] = {0.1, 1};
    glint_metrics *metrics = make();
    glint_metric *h = glint_metrics_histogram(metrics, "t_seconds", "T.", bound, 2, NULL, 0);
    glint_metric_observe(h, 0.1);
    glint_metric_observe(h, 0.5);
    glint_metric_observe(h, 2.25);
    glint_metric_observe(h, 0.0625);
    assert_text(metrics, "# HELP glint_t_seconds T.\n"
                         "# TYPE glint_t_seconds histogram\n"
                         "glint_t_seconds_bucket{le=\"0.1\"} 2\n"
                         "glint_t_seconds_bucket{le=\"1\"} 3\n"
                         "glint_t_seconds_bucket{le=\"+Inf\"} 4\n"
                         "glint_t_seconds_sum 2.9125\n"
                         "glint_t_seconds_count 4\n");
    glint_metrics_destroy(&metrics);
}

static void mirror(void *user)
{
    glint_metric_set(user, 42);
}

static void mirrored_values_are_brought_up_to_date_before_reading(void **state)
{
    (void)state;
    glint_metrics *metrics = make();
    glint_metric *gauge = glint_metrics_gauge(metrics, "m", "M.", NULL, 0);
    glint_metrics_on_read(metrics, mirror, gauge);
    assert_text(metrics, "# HELP glint_m M.\n# TYPE glint_m gauge\nglint_m 42\n");
    glint_metrics_destroy(&metrics);
}

static void series_beyond_the_limit_are_refused_and_harmless(void **state)
{
    (void)state;
    glint_metrics *metrics = make();
    char value[16];
    const struct glint_label label = {"n", value};
    for (int i = 0; i < GLINT_MAX_SERIES; i++) {
        snprintf(value, sizeof value, "%d", i);
        assert_non_null(glint_metrics_counter(metrics, "n_total", "N.", &label, 1));
    }
    strcpy(value, "more");
    glint_metric *none = glint_metrics_counter(metrics, "n_total", "N.", &label, 1);
    assert_null(none);
    glint_metric_add(none, 1);
    glint_metric_set(none, 1);
    glint_metric_observe(none, 1);
    glint_metrics_destroy(&metrics);
}

static void *add_thousand(void *metric)
{
    for (int i = 0; i < 1000; i++)
        glint_metric_add(metric, 1);
    return NULL;
}

static void no_addition_is_lost_between_threads(void **state)
{
    (void)state;
    glint_metrics *metrics = make();
    glint_metric *counter = glint_metrics_counter(metrics, "c_total", "C.", NULL, 0);
    pthread_t thread[4];
    for (int i = 0; i < 4; i++)
        assert_int_equal(glint_thread_start(&thread[i], "adder", add_thousand, counter, NULL), 0);
    for (int i = 0; i < 4; i++)
        pthread_join(thread[i], NULL);
    assert_text(metrics, "# HELP glint_c_total C.\n# TYPE glint_c_total counter\n"
                         "glint_c_total 4000\n");
    glint_metrics_destroy(&metrics);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_family_is_described_once_before_its_series),
        cmocka_unit_test(the_same_name_and_labels_are_the_same_series),
        cmocka_unit_test(label_values_are_escaped),
        cmocka_unit_test(histogram_buckets_are_cumulative_and_include_their_bound),
        cmocka_unit_test(mirrored_values_are_brought_up_to_date_before_reading),
        cmocka_unit_test(series_beyond_the_limit_are_refused_and_harmless),
        cmocka_unit_test(no_addition_is_lost_between_threads),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
