#include "base/thread.h"
#include "jobs/use.h"
#include "jobs_fixture.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include <cmocka.h>

// The scheduler with its crew, over stand-in renders.

static void a_higher_priority_gets_the_next_slice(void **state)
{
    (void)state;
    struct fixture f;
    fixture_start(&f, 1);
    fake_close_gate();
    fixture_submit(&f, "{'scene': 's', 'seed': 1, 'resolution': [20, 1]}");
    fake_begun(1, NULL); // one slice of job 1 runs, another waits behind it
    const char *high =
        fixture_submit(&f, "{'scene': 's', 'seed': 2, 'resolution': [20, 1], 'priority': 1}");
    fixture_wait(&f, high, GLINT_JOB_RENDERING); // it has been given a slice
    fake_let(1);
    uint32_t seed[2];
    fake_begun(2, seed);
    assert_int_equal(seed[0], 1);
    assert_int_equal(seed[1], 2);
    fixture_stop(&f);
}

static void a_raised_priority_counts_from_the_next_slice(void **state)
{
    (void)state;
    struct fixture f;
    fixture_start(&f, 1);
    fake_close_gate();
    const char *a = fixture_submit(&f, "{'scene': 's', 'seed': 1, 'resolution': [20, 1]}");
    const char *b = fixture_submit(&f, "{'scene': 's', 'seed': 2, 'resolution': [20, 1]}");
    fake_begun(1, NULL);
    fixture_wait(&f, b, GLINT_JOB_RENDERING); // job 1 runs, job 2 waits behind it
    assert_int_equal(fixture_patch(&f, a, "{'priority': 7}"), GLINT_OK);
    assert_true(fixture_number(&f, a, "priority") == 7);
    fake_let(2);
    uint32_t seed[3];
    fake_begun(3, seed);
    for (int i = 0; i < 3; i++)
        assert_int_equal(seed[i], 1);
    fixture_stop(&f);
}

static void equal_jobs_have_had_equal_time_when_one_is_done(void **state)
{
    (void)state;
    struct fixture f;
    fixture_start(&f, 2);
    fake_hold_create(true); // so that both begin at once
    fake_slice_seconds(1, 0.0005);
    fake_slice_seconds(2, 0.0005);
    const char *a = fixture_submit(&f, "{'scene': 's', 'seed': 1, 'resolution': [400, 1],"
                                       " 'stop': {'samples': 1}}");
    const char *b = fixture_submit(&f, "{'scene': 's', 'seed': 2, 'resolution': [400, 1],"
                                       " 'stop': {'samples': 1}}");
    fake_close_gate();
    fake_hold_create(false);
    fixture_wait(&f, a, GLINT_JOB_RENDERING);
    fixture_wait(&f, b, GLINT_JOB_RENDERING);
    fake_open_gate();
    fixture_wait(&f, a, GLINT_JOB_DONE);
    // They are apart by a slice or two, and the system may stop any of them for a while.
    assert_true(fixture_number(&f, b, "worker_seconds") >
                0.5 * fixture_number(&f, a, "worker_seconds"));
    fixture_wait(&f, b, GLINT_JOB_DONE);
    assert_int_equal(fake_begun_now(), 800);
    fixture_stop(&f);
}

static void a_failing_slice_fails_its_job_alone(void **state)
{
    (void)state;
    struct fixture f;
    fixture_start(&f, 2);
    fake_fail_slice(1);
    const char *a = fixture_submit(&f, "{'scene': 's', 'seed': 1, 'resolution': [50, 1]}");
    const char *b = fixture_submit(&f, "{'scene': 's', 'seed': 2, 'resolution': [50, 1],"
                                       " 'stop': {'samples': 3}}");
    fixture_wait(&f, a, GLINT_JOB_FAILED);
    fixture_wait(&f, b, GLINT_JOB_DONE);
    cJSON *job = glint_jobs_describe(f.jobs, a, NULL);
    const cJSON *problem = cJSON_GetObjectItem(job, "problem");
    assert_string_equal(cJSON_GetObjectItem(problem, "detail")->valuestring,
                        "a slice of job 1 failed");
    assert_true(cJSON_GetObjectItem(problem, "status")->valuedouble == 500);
    cJSON_Delete(job);
    fixture_stop(&f);
}

static void a_failing_preparation_fails_its_job_alone(void **state)
{
    (void)state;
    struct fixture f;
    fixture_start(&f, 1);
    fake_fail_create(1, GLINT_E_DEVICE, 1);
    const char *a = fixture_submit(&f, "{'scene': 's', 'seed': 1, 'resolution': [2, 1]}");
    const char *b = fixture_submit(&f, "{'scene': 's', 'seed': 2, 'resolution': [2, 1]}");
    fixture_wait(&f, a, GLINT_JOB_FAILED);
    fixture_wait(&f, b, GLINT_JOB_DONE);
    struct glint_job_view view;
    assert_int_equal(glint_jobs_view(f.jobs, a, &view, NULL), GLINT_OK);
    assert_null(view.render);
    glint_jobs_release(f.jobs, &view);
    fixture_stop(&f);
}

static void a_client_with_one_job_is_served_as_much_as_one_with_twenty(void **state)
{
    (void)state;
    enum { MANY = 20, SLICES = 400 };
    struct fixture f;
    fixture_start(&f, 2);
    fake_hold_create(true); // so that all begin at once
    fake_close_gate();
    f.client = "many";
    for (int i = 1; i <= MANY; i++) {
        fake_slice_seconds((uint32_t)i, 0.0003);
        fixture_submit(&f, "{'scene': 's', 'seed': %d, 'resolution': [1000, 1]}", i);
    }
    f.client = "one";
    fake_slice_seconds(100, 0.0003);
    const char *one = fixture_submit(&f, "{'scene': 's', 'seed': 100, 'resolution': [1000, 1]}");
    fake_hold_create(false);
    fixture_wait(&f, one, GLINT_JOB_RENDERING); // though its film was the last that was asked for
    const size_t before = fake_begun_now();
    fake_open_gate();
    uint32_t seed[SLICES + 64];
    assert_true(before < 64);
    fake_begun(before + SLICES, seed);
    int served = 0;
    for (size_t i = before; i < before + SLICES; i++)
        served += seed[i] == 100;
    assert_true(served > SLICES / 3 && served < SLICES * 2 / 3); // the system may stop a worker
    fixture_stop(&f);
}

static void the_next_slice_of_every_worker_is_the_most_important(void **state)
{
    (void)state;
    enum { WORKERS = 4 };
    struct fixture f;
    fixture_start(&f, WORKERS);
    fake_close_gate();
    const char *low = fixture_submit(&f, "{'scene': 's', 'seed': 1, 'resolution': [50, 1],"
                                         " 'stop': {'samples': 2}}");
    fake_begun(WORKERS, NULL); // each runs one, and has another waiting
    const char *high = fixture_submit(&f, "{'scene': 's', 'seed': 2, 'resolution': [50, 1],"
                                          " 'priority': 1, 'stop': {'samples': 1}}");
    fixture_wait(&f, high, GLINT_JOB_RENDERING);
    fake_let(WORKERS);
    uint32_t seed[2 * WORKERS];
    fake_begun(2 * WORKERS, seed);
    for (int i = 0; i < 2 * WORKERS; i++)
        assert_int_equal(seed[i], i < WORKERS ? 1 : 2);
    fake_open_gate();
    fixture_wait(&f, high, GLINT_JOB_DONE);
    fixture_wait(&f, low, GLINT_JOB_DONE);
    assert_int_equal(fake_begun_now(), 100 + 50); // what was preempted lost no slice
    fixture_stop(&f);
}

static void workers_tell_whose_slice_they_run(void **state)
{
    (void)state;
    struct fixture f;
    fixture_start(&f, 2);
    fake_close_gate();
    struct glint_worker_use use[3];
    assert_int_equal(glint_jobs_workers(f.jobs, use, 3), 2);
    assert_string_equal(use[0].job, "");
    assert_true(use[0].share == 0 && use[0].busy_seconds == 0);
    const char *id = fixture_submit(&f, "{'scene': 's', 'resolution': [1, 1],"
                                        " 'stop': {'samples': 1}}");
    fake_begun(1, NULL);
    int busy = 0;
    while (!busy) { // the worker may be ahead of the scheduler's note
        glint_jobs_workers(f.jobs, use, 2);
        busy = !strcmp(use[0].job, id) + !strcmp(use[1].job, id);
    }
    assert_int_equal(busy, 1);
    assert_true(use[0].share > 0 || use[1].share > 0);
    fake_open_gate();
    fixture_wait(&f, id, GLINT_JOB_DONE);
    glint_jobs_workers(f.jobs, use, 2);
    assert_string_equal(use[0].job, "");
    assert_string_equal(use[1].job, "");
    assert_true(use[0].busy_seconds + use[1].busy_seconds > 0);
    fixture_stop(&f);
}

static void a_share_fades_and_is_none_in_the_end(void **state)
{
    (void)state;
    struct glint_use use = {0};
    glint_use_set(&use, "job", 10);
    glint_use_set(&use, NULL, 15);
    assert_true(glint_use_look(&use, 15).share > 0.99);
    const double later = glint_use_look(&use, 17).share;
    assert_true(later > 0.13 && later < 0.14);
    assert_true(glint_use_look(&use, 60).share == 0);
}

static void compiling_holds_up_neither_slices_nor_answers(void **state)
{
    (void)state;
    struct fixture f;
    fixture_start(&f, 1);
    fake_close_gate();
    const char *a = fixture_submit(&f, "{'scene': 's', 'seed': 1, 'resolution': [9, 1],"
                                       " 'stop': {'samples': 9}}");
    fixture_wait(&f, a, GLINT_JOB_RENDERING);
    fake_hold_create(true);
    const char *b = fixture_submit(&f, "{'scene': 's', 'seed': 2}");
    fake_wait_create();
    fake_open_gate();
    fixture_wait(&f, a, GLINT_JOB_DONE);
    struct glint_job_view view;
    assert_int_equal(glint_jobs_view(f.jobs, b, &view, NULL), GLINT_E_BUSY);
    bool forgotten;
    assert_int_equal(glint_jobs_delete(f.jobs, b, &forgotten, NULL), GLINT_OK);
    assert_false(forgotten);
    assert_int_equal(fixture_state(&f, b), GLINT_JOB_CANCELLED);
    assert_int_equal(glint_jobs_delete(f.jobs, b, &forgotten, NULL), GLINT_OK);
    assert_true(forgotten);
    fixture_stop(&f);
}

static void a_cancelled_job_gives_up_what_runs_and_begins_no_more(void **state)
{
    (void)state;
    struct fixture f;
    fixture_start(&f, 1);
    fake_close_gate();
    const char *a = fixture_submit(&f, "{'scene': 's', 'seed': 1, 'resolution': [20, 1]}");
    fake_begun(1, NULL);
    bool forgotten;
    assert_int_equal(glint_jobs_delete(f.jobs, a, &forgotten, NULL), GLINT_OK);
    assert_false(forgotten);
    fixture_wait(&f, a, GLINT_JOB_CANCELLED); // the gate is still closed
    assert_int_equal(fake_begun_now(), 1);
    assert_int_equal(fake_renders(), 1); // what was rendered is kept
    fixture_stop(&f);
}

static void a_paused_job_gets_no_slice_and_its_clock_stands(void **state)
{
    (void)state;
    struct fixture f;
    fixture_start(&f, 1);
    fake_close_gate();
    const char *a = fixture_submit(&f, "{'scene': 's', 'seed': 1, 'resolution': [4, 1],"
                                       " 'stop': {'samples': 1}}");
    fake_begun(1, NULL);
    assert_int_equal(fixture_patch(&f, a, "{'paused': true}"), GLINT_OK);
    assert_int_equal(fixture_state(&f, a), GLINT_JOB_PAUSED);
    const double seconds = fixture_number(&f, a, "seconds");
    fake_open_gate();
    // Another job passes through: whatever was due to the first would have run before it ends.
    const char *b = fixture_submit(&f, "{'scene': 's', 'seed': 2, 'resolution': [4, 1],"
                                       " 'stop': {'samples': 2}}");
    fixture_wait(&f, b, GLINT_JOB_DONE);
    assert_int_equal(fake_begun_now(), 1 + 8);
    assert_true(fixture_number(&f, a, "seconds") == seconds);
    assert_int_equal(fixture_patch(&f, a, "{'paused': null}"), GLINT_OK);
    fixture_wait(&f, a, GLINT_JOB_DONE);
    assert_int_equal(fake_begun_now(), 4 + 8);
    fixture_stop(&f);
}

static void wait_until_idle(struct fixture *f)
{
    struct glint_worker_use use;
    do
        glint_jobs_workers(f->jobs, &use, 1);
    while (*use.job);
}

static void a_pause_does_not_wait_for_a_long_slice(void **state)
{
    (void)state;
    enum { LONG = 6 };
    struct fixture f;
    fixture_start(&f, 1);
    fake_slice_seconds(1, 0.15);
    fake_close_gate();
    const char *a = fixture_submit(&f, "{'scene': 's', 'seed': 1, 'resolution': [9, 1],"
                                       " 'stop': {'samples': 1}}");
    fake_let(LONG);
    fake_begun(LONG + 1, NULL); // it is known by now how long they take
    assert_int_equal(fixture_patch(&f, a, "{'paused': true}"), GLINT_OK);
    wait_until_idle(&f); // the gate is closed
    assert_int_equal(fixture_state(&f, a), GLINT_JOB_PAUSED);
    fake_slice_seconds(1, 0);
    fake_open_gate();
    assert_int_equal(fixture_patch(&f, a, "{'paused': false}"), GLINT_OK);
    fixture_wait(&f, a, GLINT_JOB_DONE);
    assert_int_equal(fake_begun_now(), 9 + 1); // what was given up is run again
    fixture_stop(&f);
}

static void a_job_paused_in_the_queue_begins_when_it_is_let_go(void **state)
{
    (void)state;
    struct fixture f;
    fixture_start(&f, 1);
    fake_hold_create(true);
    const char *a = fixture_submit(&f, "{'scene': 's', 'seed': 1, 'resolution': [4, 1]}");
    fake_wait_create();
    assert_int_equal(fixture_patch(&f, a, "{'paused': true}"), GLINT_OK);
    fake_hold_create(false);
    const char *b = fixture_submit(&f, "{'scene': 's', 'seed': 2, 'resolution': [4, 1]}");
    fixture_wait(&f, b, GLINT_JOB_DONE);
    assert_int_equal(fixture_state(&f, a), GLINT_JOB_PAUSED);
    assert_true(fixture_number(&f, a, "seconds") == 0);
    assert_int_equal(fixture_patch(&f, a, "{'paused': false}"), GLINT_OK);
    fixture_wait(&f, a, GLINT_JOB_DONE);
    fixture_stop(&f);
}

static void a_job_stops_at_its_seconds_and_goes_on_when_given_more(void **state)
{
    (void)state;
    struct fixture f;
    fixture_start(&f, 2);
    fake_slice_seconds(1, 0.0005);
    const char *a = fixture_submit(&f, "{'scene': 's', 'seed': 1, 'resolution': [50, 1],"
                                       " 'stop': {'samples': 20, 'seconds': 0.05}}");
    fixture_wait(&f, a, GLINT_JOB_DONE);
    const double seconds = fixture_number(&f, a, "seconds");
    const double slices = (double)fake_begun_now();
    assert_true(seconds >= 0.05 && slices > 0 && slices < 1000);
    assert_true(fixture_number(&f, a, "progress") == 1);
    assert_int_equal(fixture_patch(&f, a, "{'stop': {'seconds': 0.01}}"), GLINT_E_CONFLICT);
    assert_int_equal(fixture_patch(&f, a, "{'stop': {'seconds': null}}"), GLINT_OK);
    fixture_wait(&f, a, GLINT_JOB_DONE);
    assert_int_equal(fake_begun_now(), 1000); // 50 blocks, 20 samples: none lost, none twice
    assert_int_equal(fixture_patch(&f, a, "{'stop': {'seconds': 900}}"), GLINT_E_CONFLICT);
    fixture_stop(&f);
}

static void seconds_are_counted_though_no_slice_comes_back(void **state)
{
    (void)state;
    struct fixture f;
    fixture_start(&f, 1);
    fake_close_gate();
    const char *a = fixture_submit(&f, "{'scene': 's', 'seed': 1, 'resolution': [50, 1],"
                                       " 'stop': {'seconds': 0.02}}");
    fixture_wait(&f, a, GLINT_JOB_RENDERING);
    // The more important one takes the only worker from its next slice on.
    const char *b =
        fixture_submit(&f, "{'scene': 's', 'seed': 2, 'resolution': [50, 1], 'priority': 9}");
    fixture_wait(&f, b, GLINT_JOB_RENDERING);
    fake_let(1);
    fixture_wait(&f, a, GLINT_JOB_DONE);
    uint32_t seed[2];
    fake_begun(2, seed);
    assert_int_equal(seed[1], 2);
    fixture_stop(&f);
}

static void a_render_that_stalls_fails_instead_of_waiting_for_ever(void **state)
{
    (void)state;
    struct fixture f;
    fixture_start(&f, 1);
    fake_stick(1);
    const char *a = fixture_submit(&f, "{'scene': 's', 'seed': 1}");
    fixture_wait(&f, a, GLINT_JOB_FAILED);
    fixture_stop(&f);
}

static void stopping_cancels_what_lives_and_gives_up_what_is_out(void **state)
{
    (void)state;
    struct fixture f;
    fixture_start(&f, 2);
    fake_close_gate();
    for (int i = 0; i < 3; i++)
        fixture_submit(&f, "{'scene': 's', 'seed': %d, 'resolution': [50, 1]}", i);
    fake_begun(2, NULL);
    glint_jobs_on_change(f.jobs, NULL, NULL);
    glint_jobs_destroy(&f.jobs); // the gate is closed: what is out is given up
    assert_int_equal(fake_begun_now(), 2);
    assert_int_equal(fake_renders(), 0);
    glint_store_destroy(&f.store);
    assert_int_equal(fake_broken(), 0);
}

// Every slice is run exactly once (the stand-in checks) whatever clients do meanwhile.

struct client {
    struct fixture *f;
    uint32_t index;
    char id[GLINT_JOB_ID_BYTES];
};

static void *bother(void *arg)
{
    struct client *c = arg;
    for (int i = 0; i < 60; i++) {
        fixture_patch(c->f, c->id, i % 2 ? "{'paused': false}" : "{'paused': true}");
        fixture_patch(c->f, c->id, i % 3 ? "{'priority': 1}" : "{'priority': 0}");
        cJSON_Delete(glint_jobs_list(c->f->jobs, NULL, NULL));
        struct glint_job_view view;
        if (!glint_jobs_view(c->f->jobs, c->id, &view, NULL))
            glint_jobs_release(c->f->jobs, &view);
        struct glint_jobs_stats stats;
        glint_jobs_stats(c->f->jobs, &stats);
    }
    fixture_patch(c->f, c->id, "{'paused': false}");
    bool forgotten;
    if (c->index % 2)
        glint_jobs_delete(c->f->jobs, c->id, &forgotten, NULL);
    return NULL;
}

static void no_slice_is_lost_or_run_twice_while_clients_interfere(void **state)
{
    (void)state;
    enum { CLIENTS = 4 };
    struct fixture f;
    fixture_start(&f, 3);
    struct client client[CLIENTS];
    pthread_t thread[CLIENTS];
    for (uint32_t i = 0; i < CLIENTS; i++) {
        client[i] = (struct client){.f = &f, .index = i};
        strcpy(client[i].id, fixture_submit(&f,
                                            "{'scene': 's', 'seed': %u,"
                                            " 'resolution': [100, 1], 'stop': {'samples': 5}}",
                                            i));
    }
    for (uint32_t i = 0; i < CLIENTS; i++)
        assert_int_equal(glint_thread_start(&thread[i], "client", bother, &client[i], NULL), 0);
    for (uint32_t i = 0; i < CLIENTS; i++)
        pthread_join(thread[i], NULL);
    fixture_wait(&f, client[0].id, GLINT_JOB_DONE);
    fixture_wait(&f, client[2].id, GLINT_JOB_DONE);
    assert_true(fixture_number(&f, client[0].id, "samples") == 5);
    fixture_stop(&f);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_higher_priority_gets_the_next_slice),
        cmocka_unit_test(a_raised_priority_counts_from_the_next_slice),
        cmocka_unit_test(equal_jobs_have_had_equal_time_when_one_is_done),
        cmocka_unit_test(a_failing_slice_fails_its_job_alone),
        cmocka_unit_test(a_failing_preparation_fails_its_job_alone),
        cmocka_unit_test(a_client_with_one_job_is_served_as_much_as_one_with_twenty),
        cmocka_unit_test(the_next_slice_of_every_worker_is_the_most_important),
        cmocka_unit_test(workers_tell_whose_slice_they_run),
        cmocka_unit_test(a_share_fades_and_is_none_in_the_end),
        cmocka_unit_test(compiling_holds_up_neither_slices_nor_answers),
        cmocka_unit_test(a_cancelled_job_gives_up_what_runs_and_begins_no_more),
        cmocka_unit_test(a_paused_job_gets_no_slice_and_its_clock_stands),
        cmocka_unit_test(a_pause_does_not_wait_for_a_long_slice),
        cmocka_unit_test(a_job_paused_in_the_queue_begins_when_it_is_let_go),
        cmocka_unit_test(a_job_stops_at_its_seconds_and_goes_on_when_given_more),
        cmocka_unit_test(seconds_are_counted_though_no_slice_comes_back),
        cmocka_unit_test(a_render_that_stalls_fails_instead_of_waiting_for_ever),
        cmocka_unit_test(stopping_cancels_what_lives_and_gives_up_what_is_out),
        cmocka_unit_test(no_slice_is_lost_or_run_twice_while_clients_interfere),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
