// Jobs that begin as sketches, over stand-ins: finished, counted for nothing, ended and failed.
#include "jobs_fixture.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <time.h>

#include <cmocka.h>

#define JOB "{'scene': 's', 'resolution': [4, 1], 'stop': {'samples': 3}, 'seed': 1}"

static void doze(void)
{
    nanosleep(&(struct timespec){.tv_nsec = 5000000}, NULL);
}

// A job whose sketch is there and which is about to be finished.
static const char *sketched(struct fixture *f, const char *job)
{
    fixture_start(f, 2);
    fake_sketch(1);
    fake_hold_move(true);
    const char *id = fixture_submit(f, job, NULL);
    fake_wait_moves(1);
    fake_begun(4, NULL);
    return id;
}

static void a_sketch_is_finished_and_counts_for_nothing(void **state)
{
    (void)state;
    struct fixture f;
    const char *id = sketched(&f, JOB);
    assert_int_equal(fixture_state(&f, id), GLINT_JOB_RENDERING);
    assert_true(fixture_number(&f, id, "samples") == 0);
    fake_hold_move(false);
    fixture_wait(&f, id, GLINT_JOB_DONE);
    assert_true(fixture_number(&f, id, "samples") == 3);
    assert_int_equal(fake_restarts(), 1);
    assert_int_equal(fake_moves(), 1);
    assert_int_equal(fake_begun_now(), 4 + 3 * 4);
    fixture_stop(&f);
}

static void slices_that_are_out_when_it_is_finished_come_back_first(void **state)
{
    (void)state;
    struct fixture f;
    fixture_start(&f, 2);
    fake_sketch(1);
    fake_close_gate();
    fake_deafen();
    const char *id = fixture_submit(&f, JOB);
    fake_begun(2, NULL); // both are out before one is let through
    fake_let(1);
    fake_wait_moves(1);
    assert_int_equal(fake_restarts(), 0);
    fake_open_gate();
    fixture_wait(&f, id, GLINT_JOB_DONE);
    assert_int_equal(fake_restarts(), 1);
    fixture_stop(&f);
}

// What takes all cores waits until something of the sketch can be seen.
static void nothing_is_finished_before_a_slice_is_back(void **state)
{
    (void)state;
    struct fixture f;
    fixture_start(&f, 2);
    fake_sketch(1);
    fake_close_gate();
    const char *id = fixture_submit(&f, JOB);
    fake_begun(2, NULL); // one for each worker
    for (int i = 0; i < 5; i++)
        doze();
    assert_int_equal(fake_moves(), 0);
    fake_open_gate();
    fixture_wait(&f, id, GLINT_JOB_DONE);
    assert_int_equal(fake_moves(), 1);
    fixture_stop(&f);
}

static void the_time_of_a_job_begins_with_its_first_sample(void **state)
{
    (void)state;
    struct fixture f;
    const char *id =
        sketched(&f, "{'scene': 's', 'resolution': [4, 1], 'stop': {'seconds': 0.005}, 'seed': 1}");
    for (int i = 0; i < 5; i++)
        doze();
    assert_int_equal(fixture_state(&f, id), GLINT_JOB_RENDERING);
    assert_int_equal(fake_restarts(), 0);
    fake_hold_move(false);
    fixture_wait(&f, id, GLINT_JOB_DONE);
    assert_int_equal(fake_restarts(), 1);
    fixture_stop(&f);
}

static void one_that_cannot_be_finished_fails(void **state)
{
    (void)state;
    struct fixture f;
    const char *id = sketched(&f, JOB);
    fake_fail_move(1);
    fake_hold_move(false);
    fixture_wait(&f, id, GLINT_JOB_FAILED);
    assert_int_equal(fake_restarts(), 0);
    fixture_stop(&f);
}

// While its sketch is being finished.
static const char *cancelled(struct fixture *f)
{
    bool forgotten;
    const char *id = sketched(f, JOB);
    assert_int_equal(glint_jobs_delete(f->jobs, id, &forgotten, NULL), GLINT_OK);
    fixture_wait(f, id, GLINT_JOB_CANCELLED);
    return id;
}

static void a_job_ends_while_it_is_finished(void **state)
{
    (void)state;
    struct fixture f;
    cancelled(&f);
    fake_hold_move(false);
    fixture_stop(&f);
}

static void one_that_was_cancelled_meanwhile_goes_on_and_is_finished(void **state)
{
    (void)state;
    struct fixture f;
    const char *id = cancelled(&f);
    assert_int_equal(fixture_patch(&f, id, "{'stop': {'samples': 5}}"), GLINT_OK);
    fake_hold_move(false);
    fixture_wait(&f, id, GLINT_JOB_DONE);
    assert_true(fixture_number(&f, id, "samples") == 5);
    fixture_stop(&f);
}

static void one_is_finished_while_it_is_paused(void **state)
{
    (void)state;
    struct fixture f;
    const char *id = sketched(&f, JOB);
    assert_int_equal(fixture_patch(&f, id, "{'paused': true}"), GLINT_OK);
    fake_hold_move(false);
    fake_wait_restarts(1);
    assert_int_equal(fake_begun_now(), 4);
    assert_int_equal(fixture_patch(&f, id, "{'paused': false}"), GLINT_OK);
    fixture_wait(&f, id, GLINT_JOB_DONE);
    fixture_stop(&f);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_sketch_is_finished_and_counts_for_nothing),
        cmocka_unit_test(slices_that_are_out_when_it_is_finished_come_back_first),
        cmocka_unit_test(nothing_is_finished_before_a_slice_is_back),
        cmocka_unit_test(the_time_of_a_job_begins_with_its_first_sample),
        cmocka_unit_test(one_that_cannot_be_finished_fails),
        cmocka_unit_test(a_job_ends_while_it_is_finished),
        cmocka_unit_test(one_that_was_cancelled_meanwhile_goes_on_and_is_finished),
        cmocka_unit_test(one_is_finished_while_it_is_paused),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
