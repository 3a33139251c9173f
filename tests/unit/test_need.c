// What memory jobs need, and who waits for it: over stand-ins.
#include "jobs_fixture.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include <cmocka.h>

static void a_film_that_does_not_fit_waits_for_others_to_end(void **state)
{
    (void)state;
    struct fixture f;
    fixture_start(&f, 1);
    fake_close_gate();
    const char *a = fixture_submit(&f, "{'scene': 's', 'seed': 1, 'resolution': [5, 1],"
                                       " 'stop': {'samples': 1}}");
    fixture_wait(&f, a, GLINT_JOB_RENDERING);
    fake_fail_create(2, GLINT_E_CAPACITY, 1);
    const char *b = fixture_submit(&f, "{'scene': 's', 'seed': 2, 'resolution': [5, 1],"
                                       " 'stop': {'samples': 1}}");
    fake_wait_creates(2);
    const char *c = fixture_submit(&f, "{'scene': 's', 'seed': 3, 'resolution': [5, 1],"
                                       " 'priority': 1, 'stop': {'samples': 1}}");
    fixture_wait(&f, c, GLINT_JOB_RENDERING);
    assert_int_equal(fixture_state(&f, b), GLINT_JOB_QUEUED);
    fake_open_gate();
    fixture_wait(&f, b, GLINT_JOB_DONE);
    assert_int_equal(fake_creates(), 4);
    fixture_stop(&f);
}

static void assert_wait(struct fixture *f, const char *id, const char *expected)
{
    cJSON *job = glint_jobs_describe(f->jobs, id, NULL);
    const char *wait = cJSON_GetStringValue(cJSON_GetObjectItem(job, "waits_for"));
    assert_true(cJSON_HasObjectItem(job, "waits_for"));
    assert_true(expected ? wait && !strcmp(wait, expected) : !wait);
    cJSON_Delete(job);
}

static void a_job_waits_for_room_beside_those_that_render(void **state)
{
    (void)state;
    struct fixture f;
    fixture_start_within(&f, 1, 100);
    fake_close_gate();
    const char *a = fixture_submit(&f, "{'scene': 's', 'seed': 1, 'resolution': [60, 1]}");
    fixture_wait(&f, a, GLINT_JOB_RENDERING);
    const char *b = fixture_submit(&f, "{'scene': 's', 'seed': 2, 'resolution': [60, 1],"
                                       " 'stop': {'samples': 1}}");
    const char *c = fixture_submit(&f, "{'scene': 's', 'seed': 3, 'resolution': [30, 1],"
                                       " 'stop': {'samples': 1}}");
    const char *urgent = fixture_submit(&f, "{'scene': 's', 'seed': 4, 'resolution': [40, 1],"
                                            " 'priority': 1}");
    fixture_wait(&f, urgent, GLINT_JOB_RENDERING); // beside a: 60 + 40
    assert_int_equal(fixture_state(&f, b), GLINT_JOB_QUEUED);
    assert_int_equal(fixture_state(&f, c), GLINT_JOB_QUEUED); // it does not pass b
    assert_wait(&f, b, "memory");
    assert_wait(&f, c, "turn");
    assert_wait(&f, urgent, NULL);
    struct glint_jobs_stats stats;
    glint_jobs_stats(f.jobs, &stats);
    assert_int_equal(stats.film_bytes, 100);
    assert_int_equal(stats.by_wait[GLINT_WAIT_MEMORY], 1);
    assert_int_equal(stats.by_wait[GLINT_WAIT_TURN], 1);
    assert_int_equal(fake_creates(), 2);
    fake_open_gate();
    fixture_wait(&f, b, GLINT_JOB_DONE);
    fixture_wait(&f, c, GLINT_JOB_DONE);
    fixture_stop(&f);
}

static void the_oldest_ended_jobs_give_their_films_room(void **state)
{
    (void)state;
    struct fixture f;
    fixture_start_within(&f, 1, 100);
    const char *id[3];
    for (int i = 0; i < 3; i++) {
        id[i] = fixture_submit(&f, "{'scene': 's', 'resolution': [40, 1], 'stop': {'samples': 1}}");
        fixture_wait(&f, id[i], GLINT_JOB_DONE);
    }
    assert_null(glint_jobs_describe(f.jobs, id[0], NULL));
    assert_int_equal(fixture_state(&f, id[1]), GLINT_JOB_DONE);
    assert_int_equal(fake_renders(), 2);
    fixture_stop(&f);
}

static void a_film_over_the_limit_is_refused_and_costs_nobody_anything(void **state)
{
    (void)state;
    struct fixture f;
    fixture_start_within(&f, 1, 100);
    const char *a = fixture_submit(&f, "{'scene': 's', 'resolution': [100, 1],"
                                       " 'stop': {'samples': 1}}");
    fixture_wait(&f, a, GLINT_JOB_DONE);
    char id[GLINT_JOB_ID_BYTES];
    bool repeated;
    struct glint_error err = {0};
    assert_int_equal(
        fixture_try(&f, "{'scene': 's', 'resolution': [101, 1]}", NULL, id, &repeated, &err),
        GLINT_E_CAPACITY);
    assert_string_equal(err.fault[0].pointer, "/resolution");
    glint_error_finish(&err);
    assert_int_equal(fixture_state(&f, a), GLINT_JOB_DONE);
    fixture_stop(&f);
}

static void more_memory_lets_in_who_waits_for_it(void **state)
{
    (void)state;
    struct fixture f;
    fixture_start_within(&f, 1, 100);
    fake_close_gate();
    const char *a = fixture_submit(&f, "{'scene': 's', 'seed': 1, 'resolution': [60, 1]}");
    fixture_wait(&f, a, GLINT_JOB_RENDERING);
    const char *b = fixture_submit(&f, "{'scene': 's', 'seed': 2, 'resolution': [60, 1]}");
    struct glint_jobs_stats stats;
    do
        glint_jobs_stats(f.jobs, &stats);
    while (!stats.by_wait[GLINT_WAIT_MEMORY]);
    stats.limits.memory_bytes += 100;
    glint_jobs_set_limits(f.jobs, &stats.limits);
    fake_let(1);
    fixture_wait(&f, b, GLINT_JOB_RENDERING);
    fixture_stop(&f);
}

static void who_waits_for_memory_gets_that_of_a_scene_that_goes(void **state)
{
    (void)state;
    static const char other[] =
        "{\"materials\": {\"m\": {}}, \"meshes\": {\"q\": {\"primitive\": \"quad\"}},"
        " \"instances\": {\"i\": {\"mesh\": \"q\", \"material\": \"m\"}}}";
    struct fixture f;
    glint_revision *revision;
    bool created;
    fixture_start_within(&f, 1, 100);
    const struct glint_import_source source = {
        .type = GLINT_SCENE_NATIVE, .bytes = (const uint8_t *)other, .size = strlen(other)};
    assert_int_equal(glint_store_put(f.store, "t", &source, NULL, &revision, &created, NULL),
                     GLINT_OK);
    glint_revision_release(&revision);
    const char *a = fixture_submit(&f, "{'scene': 's', 'resolution': [60, 1],"
                                       " 'stop': {'samples': 1}}");
    struct glint_jobs_stats stats;
    do
        glint_jobs_stats(f.jobs, &stats);
    while (!stats.by_wait[GLINT_WAIT_MEMORY]);
    assert_int_equal(glint_store_delete(f.store, "t", NULL, false, NULL), GLINT_OK);
    fixture_wait(&f, a, GLINT_JOB_DONE);
    fixture_stop(&f);
}

static void a_film_that_fits_nowhere_fails_with_capacity(void **state)
{
    (void)state;
    struct fixture f;
    fixture_start(&f, 1);
    fake_fail_create(1, GLINT_E_CAPACITY, 1000);
    const char *a = fixture_submit(&f, "{'scene': 's', 'seed': 1}");
    fixture_wait(&f, a, GLINT_JOB_FAILED);
    cJSON *job = glint_jobs_describe(f.jobs, a, NULL);
    assert_true(cJSON_GetObjectItem(cJSON_GetObjectItem(job, "problem"), "status")->valuedouble ==
                507);
    cJSON_Delete(job);
    assert_int_equal(fake_creates(), 1);
    fixture_stop(&f);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_film_that_does_not_fit_waits_for_others_to_end),
        cmocka_unit_test(a_job_waits_for_room_beside_those_that_render),
        cmocka_unit_test(the_oldest_ended_jobs_give_their_films_room),
        cmocka_unit_test(a_film_over_the_limit_is_refused_and_costs_nobody_anything),
        cmocka_unit_test(more_memory_lets_in_who_waits_for_it),
        cmocka_unit_test(who_waits_for_memory_gets_that_of_a_scene_that_goes),
        cmocka_unit_test(a_film_that_fits_nowhere_fails_with_capacity),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
