#include "base/thread.h"
#include "jobs/table.h"
#include "jobs_fixture.h"
#include "protocol/cryptomatte.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <string.h>
#include <time.h>

#include <cmocka.h>

#define SMALL "'resolution': [4, 1], 'stop': {'samples': 2}"

static const char *text(const cJSON *object, const char *member)
{
    return cJSON_GetStringValue(cJSON_GetObjectItemCaseSensitive(object, member));
}

static void delete (struct fixture *f, const char *id, bool expected)
{
    bool forgotten;
    assert_int_equal(glint_jobs_delete(f->jobs, id, &forgotten, NULL), GLINT_OK);
    assert_int_equal(forgotten, expected);
}

static void a_job_passes_from_queued_through_rendering_to_done(void **state)
{
    (void)state;
    struct fixture f;
    fixture_start(&f, 2);
    fake_hold_create(true);
    fake_close_gate();
    const char *id = fixture_submit(&f, "{'scene': 's', " SMALL "}");
    assert_int_equal(strlen(id), 32);
    assert_int_equal(strspn(id, "0123456789abcdef"), 32);
    assert_int_equal(fixture_state(&f, id), GLINT_JOB_QUEUED);
    assert_true(fixture_number(&f, id, "progress") == 0);
    assert_true(isnan(fixture_number(&f, id, "eta_seconds")));
    fake_hold_create(false);
    fixture_wait(&f, id, GLINT_JOB_RENDERING);
    fake_let(6); // three quarters of eight
    while (fixture_number(&f, id, "progress") < 0.75) {
    }
    const double seconds = fixture_number(&f, id, "seconds");
    const double eta = fixture_number(&f, id, "eta_seconds");
    assert_true(eta >= seconds / 3 && eta <= fixture_number(&f, id, "seconds") / 3);
    fake_open_gate();
    fixture_wait(&f, id, GLINT_JOB_DONE);
    assert_true(fixture_number(&f, id, "progress") == 1);
    assert_true(fixture_number(&f, id, "samples") == 2);
    assert_true(fixture_number(&f, id, "eta_seconds") == 0);
    // The stand-in's error is 1/sqrt(samples).
    assert_true(fabs(fixture_number(&f, id, "error") - sqrt(0.5)) < 1e-12);
    assert_true(fixture_number(&f, id, "seconds") > 0);
    fixture_stop(&f);
}

static void the_description_has_the_members_of_the_protocol(void **state)
{
    (void)state;
    struct fixture f;
    fixture_start(&f, 1);
    const char *id = fixture_submit(
        &f, "{'scene': 's', 'camera': 'Front', 'name': 'shot', 'priority': 3, " SMALL "}");
    fixture_wait(&f, id, GLINT_JOB_DONE);
    cJSON *job = glint_jobs_describe(f.jobs, id, NULL);
    static const char *const member[] = {
        "id",         "name",        "scene",          "revision",    "state",
        "priority",   "samples",     "target_samples", "progress",    "error",
        "seconds",    "eta_seconds", "worker_seconds", "cpu_seconds", "rays",
        "invariants", "plan",        "warnings",       "created",     "job"};
    for (size_t i = 0; i < sizeof member / sizeof *member; i++)
        assert_true(cJSON_HasObjectItem(job, member[i]));
    assert_false(cJSON_HasObjectItem(job, "problem"));
    assert_string_equal(text(job, "id"), id);
    assert_string_equal(text(job, "name"), "shot");
    assert_string_equal(text(job, "state"), "done");
    assert_int_equal(strlen(text(job, "revision")), 64);
    char plan[64];
    snprintf(plan, sizeof plan, "/v1/jobs/%s/plan", id);
    assert_string_equal(text(job, "plan"), plan);
    assert_string_equal(text(cJSON_GetObjectItem(job, "job"), "camera"), "Front");
    cJSON_Delete(job);
    fixture_stop(&f);
}

static void unknown_scenes_and_cameras_are_faults_of_the_job(void **state)
{
    (void)state;
    struct fixture f;
    fixture_start(&f, 1);
    char id[GLINT_JOB_ID_BYTES];
    bool repeated;
    struct glint_error err = {0};
    assert_int_equal(fixture_try(&f, "{'scene': 'other'}", NULL, id, &repeated, &err),
                     GLINT_E_RANGE);
    assert_string_equal(err.fault[0].pointer, "/scene");
    glint_error_finish(&err);
    assert_int_equal(fixture_try(&f, "{'scene': 's', 'camera': 'Back'}", NULL, id, &repeated, &err),
                     GLINT_E_RANGE);
    assert_string_equal(err.fault[0].pointer, "/camera");
    glint_error_finish(&err);
    // By id, by name, and as an object.
    fixture_submit(&f, "{'scene': 's', 'camera': 'c', " SMALL "}");
    fixture_submit(&f, "{'scene': 's', 'camera': 'Front', " SMALL "}");
    fixture_submit(&f, "{'scene': 's', 'camera': {'yfov': 1}, " SMALL "}");
    fixture_stop(&f);
}

static void a_repeated_key_answers_the_first_job(void **state)
{
    (void)state;
    struct fixture f;
    fixture_start(&f, 1);
    char first[GLINT_JOB_ID_BYTES], again[GLINT_JOB_ID_BYTES];
    bool repeated;
    static const char job[] = "{'scene': 's', " SMALL "}";
    assert_int_equal(fixture_try(&f, job, "k1", first, &repeated, NULL), GLINT_OK);
    assert_false(repeated);
    // Other white space and spelled-out defaults are the same request.
    assert_int_equal(fixture_try(&f,
                                 "{ 'stop': {'samples': 2}, 'resolution': [4, 1], 'seed': 0,"
                                 " 'scene': 's'}",
                                 "k1", again, &repeated, NULL),
                     GLINT_OK);
    assert_true(repeated);
    assert_string_equal(first, again);
    assert_int_equal(fixture_try(&f, job, "k2", again, &repeated, NULL), GLINT_OK);
    assert_false(repeated);
    assert_string_not_equal(first, again);
    fixture_stop(&f);
}

static void a_key_is_not_good_for_another_job(void **state)
{
    (void)state;
    struct fixture f;
    fixture_start(&f, 1);
    char id[GLINT_JOB_ID_BYTES];
    bool repeated;
    struct glint_error err = {0};
    assert_int_equal(fixture_try(&f, "{'scene': 's', " SMALL "}", "k", id, &repeated, NULL),
                     GLINT_OK);
    assert_int_equal(
        fixture_try(&f, "{'scene': 's', 'seed': 1, " SMALL "}", "k", id, &repeated, &err),
        GLINT_E_RANGE);
    assert_non_null(strstr(glint_error_text(&err), "Idempotency-Key"));
    glint_error_finish(&err);
    struct glint_jobs_stats stats;
    glint_jobs_stats(f.jobs, &stats);
    assert_int_equal(stats.submitted, 1);
    fixture_stop(&f);
}

// A scheduler that is told to tell of a change waits while the gate is shut.
struct gate {
    pthread_mutex_t mutex;
    pthread_cond_t changed;
    bool shut, waited;
    struct fixture *f;
    int answers, pending, fresh, again; // submissions that came back, by how
};

static void wait_at_gate(void *user)
{
    struct gate *g = user;
    pthread_mutex_lock(&g->mutex);
    g->waited = true;
    pthread_cond_broadcast(&g->changed);
    while (g->shut)
        pthread_cond_wait(&g->changed, &g->mutex);
    pthread_mutex_unlock(&g->mutex);
}

static void *submit_at_gate(void *user)
{
    struct gate *g = user;
    char id[GLINT_JOB_ID_BYTES];
    bool repeated = false;
    const glint_status st =
        fixture_try(g->f, "{'scene': 's', " SMALL "}", "k", id, &repeated, NULL);
    pthread_mutex_lock(&g->mutex);
    g->answers++;
    g->pending += st == GLINT_E_PENDING;
    g->fresh += !st && !repeated;
    g->again += !st && repeated;
    pthread_cond_broadcast(&g->changed);
    pthread_mutex_unlock(&g->mutex);
    return NULL;
}

static void a_key_that_is_being_answered_is_refused_at_once(void **state)
{
    (void)state;
    struct fixture f;
    struct gate g = {.mutex = PTHREAD_MUTEX_INITIALIZER,
                     .changed = PTHREAD_COND_INITIALIZER,
                     .shut = true,
                     .f = &f};
    pthread_t twin[2];
    fixture_start(&f, 1);
    glint_jobs_on_change(f.jobs, wait_at_gate, &g);
    fixture_submit(&f, "{'scene': 's', 'seed': 1, " SMALL "}");
    pthread_mutex_lock(&g.mutex);
    while (!g.waited)
        pthread_cond_wait(&g.changed, &g.mutex);
    pthread_mutex_unlock(&g.mutex);
    for (int i = 0; i < 2; i++)
        pthread_create(&twin[i], NULL, submit_at_gate, &g);
    pthread_mutex_lock(&g.mutex);
    while (!g.answers)
        pthread_cond_wait(&g.changed, &g.mutex);
    assert_int_equal(g.pending, 1);
    g.shut = false;
    pthread_cond_broadcast(&g.changed);
    pthread_mutex_unlock(&g.mutex);
    for (int i = 0; i < 2; i++)
        pthread_join(twin[i], NULL);
    assert_int_equal(g.fresh, 1);
    submit_at_gate(&g);
    assert_int_equal(g.again, 1);
    glint_jobs_on_change(f.jobs, NULL, NULL);
    fixture_stop(&f);
}

static void a_key_outlives_its_scene_but_not_its_job(void **state)
{
    (void)state;
    struct fixture f;
    fixture_start(&f, 1);
    char first[GLINT_JOB_ID_BYTES], again[GLINT_JOB_ID_BYTES];
    bool repeated;
    static const char job[] = "{'scene': 's', " SMALL "}";
    assert_int_equal(fixture_try(&f, job, "k", first, &repeated, NULL), GLINT_OK);
    fixture_wait(&f, first, GLINT_JOB_DONE);
    assert_int_equal(glint_store_delete(f.store, "s", NULL, false, NULL), GLINT_OK);
    assert_int_equal(fixture_try(&f, job, "k", again, &repeated, NULL), GLINT_OK);
    assert_true(repeated);
    delete (&f, first, true);
    assert_int_equal(fixture_try(&f, job, "k", again, &repeated, NULL), GLINT_E_RANGE);
    fixture_stop(&f);
}

static void keys_are_bounded(void **state)
{
    (void)state;
    struct fixture f;
    fixture_start(&f, 1);
    char id[GLINT_JOB_ID_BYTES], key[257];
    bool repeated;
    memset(key, 'k', sizeof key);
    key[256] = '\0';
    static const char job[] = "{'scene': 's', " SMALL "}";
    assert_int_equal(fixture_try(&f, job, key, id, &repeated, NULL), GLINT_E_RANGE);
    assert_int_equal(fixture_try(&f, job, "", id, &repeated, NULL), GLINT_E_RANGE);
    key[255] = '\0';
    assert_int_equal(fixture_try(&f, job, key, id, &repeated, NULL), GLINT_OK);
    fixture_stop(&f);
}

struct submitter {
    struct fixture *f;
    char id[GLINT_JOB_ID_BYTES];
    bool repeated;
};

static void *submit_with_key(void *arg)
{
    struct submitter *s = arg;
    while (fixture_try(s->f, "{'scene': 's', " SMALL "}", "k", s->id, &s->repeated, NULL) ==
           GLINT_E_PENDING) // as a client would, who is told to try again
        ;
    return NULL;
}

static void one_job_is_made_of_submissions_at_once_with_one_key(void **state)
{
    (void)state;
    enum { COUNT = 6 };
    struct fixture f;
    fixture_start(&f, 1);
    struct submitter submitter[COUNT];
    pthread_t thread[COUNT];
    for (int i = 0; i < COUNT; i++) {
        submitter[i] = (struct submitter){.f = &f};
        assert_int_equal(
            glint_thread_start(&thread[i], "submit", submit_with_key, &submitter[i], NULL),
            GLINT_OK);
    }
    int made = 0;
    for (int i = 0; i < COUNT; i++) {
        pthread_join(thread[i], NULL);
        made += !submitter[i].repeated;
        assert_string_equal(submitter[i].id, submitter[0].id);
    }
    assert_int_equal(made, 1);
    fixture_stop(&f);
}

static void deleting_cancels_then_forgets(void **state)
{
    (void)state;
    struct fixture f;
    fixture_start(&f, 1);
    fake_close_gate();
    const char *id = fixture_submit(&f, "{'scene': 's', 'resolution': [50, 1]}");
    fixture_wait(&f, id, GLINT_JOB_RENDERING);
    delete (&f, id, false);
    fake_open_gate();
    fixture_wait(&f, id, GLINT_JOB_CANCELLED);
    struct glint_job_view view;
    assert_int_equal(glint_jobs_view(f.jobs, id, &view, NULL), GLINT_OK);
    assert_non_null(view.render);
    assert_int_equal(view.state, GLINT_JOB_CANCELLED);
    delete (&f, id, true);
    assert_int_equal(fake_renders(), 1); // the view's
    glint_jobs_release(f.jobs, &view);
    assert_int_equal(fake_renders(), 0);
    bool forgotten;
    assert_int_equal(glint_jobs_delete(f.jobs, id, &forgotten, NULL), GLINT_E_NOT_FOUND);
    assert_null(glint_jobs_describe(f.jobs, id, NULL));
    assert_int_equal(glint_jobs_view(f.jobs, id, &view, NULL), GLINT_E_NOT_FOUND);
    assert_int_equal(fixture_patch(&f, id, "{'priority': 1}"), GLINT_E_NOT_FOUND);
    fixture_stop(&f);
}

static void a_scene_is_in_use_until_its_jobs_have_ended(void **state)
{
    (void)state;
    struct fixture f;
    fixture_start(&f, 1);
    fake_close_gate();
    const char *id = fixture_submit(&f, "{'scene': 's', " SMALL "}");
    assert_int_equal(glint_store_delete(f.store, "s", NULL, false, NULL), GLINT_E_CONFLICT);
    fake_open_gate();
    fixture_wait(&f, id, GLINT_JOB_DONE);
    assert_int_equal(glint_store_delete(f.store, "s", NULL, false, NULL), GLINT_OK);
    assert_int_equal(fake_scene_residents(), 1); // the ended job still has its revision
    delete (&f, id, true);
    while (fake_scene_residents()) // the crew lets go of its reference in its own time
        nanosleep(&(struct timespec){.tv_nsec = 1000000}, NULL);
    fixture_stop(&f);
}

static void jobs_are_listed_in_order_of_submission(void **state)
{
    (void)state;
    struct fixture f;
    fixture_start(&f, 2);
    const char *id[3];
    for (int i = 0; i < 3; i++)
        id[i] = fixture_submit(&f, "{'scene': 's', 'priority': %d, " SMALL "}", i);
    fixture_wait(&f, id[1], GLINT_JOB_DONE);
    delete (&f, id[1], true);
    cJSON *list = glint_jobs_list(f.jobs, NULL, NULL);
    const cJSON *jobs = cJSON_GetObjectItem(list, "jobs");
    assert_int_equal(cJSON_GetArraySize(jobs), 2);
    assert_string_equal(text(cJSON_GetArrayItem(jobs, 0), "id"), id[0]);
    assert_string_equal(text(cJSON_GetArrayItem(jobs, 1), "id"), id[2]);
    cJSON_Delete(list);
    fixture_stop(&f);
}

static void every_fault_of_a_patch_is_named(void **state)
{
    (void)state;
    struct fixture f;
    fixture_start(&f, 1);
    fake_close_gate();
    const char *id = fixture_submit(&f, "{'scene': 's', " SMALL "}");
    static const char bad[] = "{\"priority\": 101, \"paused\": 1, \"colour\": 2,"
                              " \"stop\": {\"seconds\": -1, \"samples\": 0, \"when\": 1}}";
    static const char *const pointer[] = {"/priority",     "/paused",       "/colour",
                                          "/stop/seconds", "/stop/samples", "/stop/when"};
    struct glint_error err = {0};
    assert_int_equal(glint_jobs_patch(f.jobs, id, bad, strlen(bad), &err), GLINT_E_RANGE);
    assert_int_equal(err.count, 6);
    for (size_t p = 0; p < 6; p++) {
        size_t i = 0;
        while (i < err.count && strcmp(err.fault[i].pointer, pointer[p]))
            i++;
        assert_true(i < err.count);
    }
    glint_error_finish(&err);
    assert_int_equal(fixture_patch(&f, id, "{'priority'"), GLINT_E_SYNTAX);
    assert_int_equal(fixture_patch(&f, id, "[1]"), GLINT_E_RANGE);
    assert_true(fixture_number(&f, id, "priority") == 0);
    assert_int_equal(fixture_patch(&f, id, "{}"), GLINT_OK);
    fixture_stop(&f);
}

static void what_a_patch_changes_shows_in_the_job(void **state)
{
    (void)state;
    struct fixture f;
    fixture_start(&f, 1);
    fake_close_gate();
    const char *id = fixture_submit(&f, "{'scene': 's', 'priority': 1, " SMALL "}");
    struct glint_job_view view;
    fixture_wait(&f, id, GLINT_JOB_RENDERING);
    assert_int_equal(glint_jobs_view(f.jobs, id, &view, NULL), GLINT_OK);
    const uint64_t sequence = view.sequence;
    glint_jobs_release(f.jobs, &view);
    assert_int_equal(fixture_patch(&f, id, "{'priority': -5, 'stop': {'seconds': 60}}"), GLINT_OK);
    cJSON *job = glint_jobs_describe(f.jobs, id, NULL);
    const cJSON *inner = cJSON_GetObjectItem(job, "job");
    const cJSON *stop = cJSON_GetObjectItem(inner, "stop");
    assert_true(cJSON_GetObjectItem(inner, "priority")->valuedouble == -5);
    assert_true(cJSON_GetObjectItem(stop, "seconds")->valuedouble == 60);
    assert_true(cJSON_GetObjectItem(stop, "samples")->valuedouble == 2);
    cJSON_Delete(job);
    assert_int_equal(glint_jobs_view(f.jobs, id, &view, NULL), GLINT_OK);
    assert_true(view.sequence > sequence);
    glint_jobs_release(f.jobs, &view);
    assert_int_equal(fixture_patch(&f, id, "{'priority': null}"), GLINT_OK);
    assert_true(fixture_number(&f, id, "priority") == 0);
    fixture_stop(&f);
}

static void an_ended_job_takes_no_patch(void **state)
{
    (void)state;
    struct fixture f;
    fixture_start(&f, 1);
    const char *id = fixture_submit(&f, "{'scene': 's', " SMALL "}");
    fixture_wait(&f, id, GLINT_JOB_DONE);
    assert_int_equal(fixture_patch(&f, id, "{'paused': true}"), GLINT_E_CONFLICT);
    assert_int_equal(fixture_patch(&f, id, "{'priority': 1}"), GLINT_E_CONFLICT);
    fixture_stop(&f);
}

// Found by search: both names have the stored ID 1ab07975.
#define TWIN_A "part71663"
#define TWIN_B "part108007"

static void names_that_share_an_id_are_warned_of_where_mattes_are_asked(void **state)
{
    (void)state;
    static const char scene[] =
        "{\"materials\": {\"m\": {}}, \"meshes\": {\"q\": {\"primitive\": \"quad\"}},"
        " \"objects\": {\"a\": {\"name\": \"" TWIN_A "\"}, \"b\": {\"name\": \"" TWIN_B "\"}},"
        " \"instances\": {\"i\": {\"mesh\": \"q\", \"material\": \"m\", \"object\": \"a\"},"
        " \"j\": {\"mesh\": \"q\", \"material\": \"m\", \"object\": \"b\"}}}";
    assert_int_equal(glint_cryptomatte_id(TWIN_A), 0x1ab07975);
    assert_int_equal(glint_cryptomatte_id(TWIN_B), 0x1ab07975);
    struct fixture f;
    fixture_start(&f, 1);
    glint_revision *revision;
    bool created;
    assert_int_equal(glint_store_put(f.store, "twins",
                                     &(struct glint_import_source){.type = GLINT_SCENE_NATIVE,
                                                                   .bytes = (const uint8_t *)scene,
                                                                   .size = strlen(scene)},
                                     NULL, &revision, &created, NULL),
                     GLINT_OK);
    glint_revision_release(&revision);
    const char *mattes = fixture_submit(&f, "{'scene': 'twins', " SMALL "}");
    const char *plain = fixture_submit(&f, "{'scene': 'twins', 'outputs': ['beauty'], " SMALL "}");
    cJSON *job = glint_jobs_describe(f.jobs, mattes, NULL);
    const cJSON *warnings = cJSON_GetObjectItem(job, "warnings");
    assert_int_equal(cJSON_GetArraySize(warnings), 1);
    assert_non_null(strstr(cJSON_GetArrayItem(warnings, 0)->valuestring, TWIN_A));
    assert_non_null(strstr(cJSON_GetArrayItem(warnings, 0)->valuestring, TWIN_B));
    cJSON_Delete(job);
    job = glint_jobs_describe(f.jobs, plain, NULL);
    assert_int_equal(cJSON_GetArraySize(cJSON_GetObjectItem(job, "warnings")), 0);
    cJSON_Delete(job);
    fixture_stop(&f);
}

static void the_oldest_ended_jobs_are_forgotten_past_a_thousand(void **state)
{
    (void)state;
    struct fixture f;
    fixture_start(&f, 2);
    char first[GLINT_JOB_ID_BYTES], second[GLINT_JOB_ID_BYTES];
    static const char job[] = "{'scene': 's', 'resolution': [1, 1], 'stop': {'samples': 1}}";
    strcpy(first, fixture_submit(&f, job));
    fixture_wait(&f, first, GLINT_JOB_DONE);
    strcpy(second, fixture_submit(&f, job));
    const char *last = second;
    for (unsigned i = 2; i <= GLINT_MAX_ENDED_JOBS; i++) {
        last = fixture_submit(&f, job);
        if (i % 100 == 0)
            fixture_wait(&f, last, GLINT_JOB_DONE);
    }
    fixture_wait(&f, last, GLINT_JOB_DONE);
    struct glint_jobs_stats stats;
    do
        glint_jobs_stats(f.jobs, &stats);
    while (stats.by_state[GLINT_JOB_DONE] != GLINT_MAX_ENDED_JOBS + 1);
    fake_close_gate();
    fixture_submit(&f, job); // makes room
    assert_null(glint_jobs_describe(f.jobs, first, NULL));
    assert_int_equal(fixture_state(&f, second), GLINT_JOB_DONE);
    glint_jobs_stats(f.jobs, &stats);
    assert_int_equal(stats.by_state[GLINT_JOB_DONE], GLINT_MAX_ENDED_JOBS);
    assert_int_equal(stats.submitted, GLINT_MAX_ENDED_JOBS + 2);
    fixture_stop(&f);
}

static void more_live_jobs_than_the_table_takes_are_told_to_come_back(void **state)
{
    (void)state;
    struct fixture f;
    fixture_start(&f, 1);
    fake_close_gate();
    char id[GLINT_JOB_ID_BYTES];
    bool repeated;
    static const char job[] = "{'scene': 's', 'resolution': [9, 1]}";
    for (unsigned i = 0; i < GLINT_MAX_LIVE_JOBS; i++)
        assert_int_equal(fixture_try(&f, job, NULL, id, &repeated, NULL), GLINT_OK);
    assert_int_equal(fixture_try(&f, job, NULL, id, &repeated, NULL), GLINT_E_BUSY);
    fixture_stop(&f);
}

static void statistics_count_states_slices_and_time(void **state)
{
    (void)state;
    struct fixture f;
    fixture_start(&f, 1);
    fake_slice_seconds(0, 0.001);
    const char *a = fixture_submit(&f, "{'scene': 's', " SMALL "}");
    fixture_wait(&f, a, GLINT_JOB_DONE);
    fake_fail_create(1, GLINT_E_DEVICE, 1);
    const char *b = fixture_submit(&f, "{'scene': 's', 'seed': 1, " SMALL "}");
    fixture_wait(&f, b, GLINT_JOB_FAILED);
    struct glint_jobs_stats stats;
    glint_jobs_stats(f.jobs, &stats);
    assert_int_equal(stats.submitted, 2);
    assert_int_equal(stats.by_state[GLINT_JOB_DONE], 1);
    assert_int_equal(stats.by_state[GLINT_JOB_FAILED], 1);
    assert_int_equal(stats.slices, 8);
    assert_true(stats.worker_busy_seconds >= 0.008);
    assert_true(stats.worker_busy_seconds == fixture_number(&f, a, "worker_seconds"));
    fixture_stop(&f);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_job_passes_from_queued_through_rendering_to_done),
        cmocka_unit_test(the_description_has_the_members_of_the_protocol),
        cmocka_unit_test(unknown_scenes_and_cameras_are_faults_of_the_job),
        cmocka_unit_test(a_repeated_key_answers_the_first_job),
        cmocka_unit_test(a_key_is_not_good_for_another_job),
        cmocka_unit_test(a_key_that_is_being_answered_is_refused_at_once),
        cmocka_unit_test(a_key_outlives_its_scene_but_not_its_job),
        cmocka_unit_test(keys_are_bounded),
        cmocka_unit_test(one_job_is_made_of_submissions_at_once_with_one_key),
        cmocka_unit_test(deleting_cancels_then_forgets),
        cmocka_unit_test(a_scene_is_in_use_until_its_jobs_have_ended),
        cmocka_unit_test(jobs_are_listed_in_order_of_submission),
        cmocka_unit_test(every_fault_of_a_patch_is_named),
        cmocka_unit_test(what_a_patch_changes_shows_in_the_job),
        cmocka_unit_test(an_ended_job_takes_no_patch),
        cmocka_unit_test(names_that_share_an_id_are_warned_of_where_mattes_are_asked),
        cmocka_unit_test(the_oldest_ended_jobs_are_forgotten_past_a_thousand),
        cmocka_unit_test(more_live_jobs_than_the_table_takes_are_told_to_come_back),
        cmocka_unit_test(statistics_count_states_slices_and_time),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
