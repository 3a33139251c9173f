// Jobs over stand-ins for renders, kept in a real folder: which film a job goes on from.
#include "base/keeper.h"
#include "jobs_fixture.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>
#include <unistd.h>

#include <cmocka.h>

#define WORKERS 2
#define PATIENCE 2000 // times 10 ms

static char folder[64];
static glint_devices *devices;
static glint_keeper *keeper;
static struct fixture f;

static const char scene[] =
    "{\"cameras\": {\"c\": {\"name\": \"Front\", \"yfov\": 0.5}}, \"materials\": {\"m\": {}}, "
    "\"meshes\": {\"q\": {\"primitive\": \"quad\"}}, "
    "\"instances\": {\"i\": {\"mesh\": \"q\", \"material\": \"m\"}}, "
    "\"environment\": {\"radiance\": [1, 1, 1]}}";

static void start(void)
{
    const struct glint_import_limits limits = {1 << 20, 1};
    devices = fake_devices(WORKERS);
    assert_int_equal(glint_keeper_create(&keeper, folder, NULL, NULL), GLINT_OK);
    assert_int_equal(glint_store_create(&f.store, devices, NULL, &limits, keeper, NULL), GLINT_OK);
    assert_int_equal(glint_jobs_create(&f.jobs, devices, f.store, NULL, keeper, NULL), GLINT_OK);
    assert_int_equal(glint_store_begin(f.store, NULL), GLINT_OK);
}

static void put_scene(void)
{
    glint_revision *revision;
    bool created;
    const struct glint_import_source source = {
        .type = GLINT_SCENE_NATIVE, .bytes = (const uint8_t *)scene, .size = strlen(scene)};
    assert_int_equal(glint_store_put(f.store, "s", &source, NULL, &revision, &created, NULL),
                     GLINT_OK);
    glint_revision_release(&revision);
}

static void stop(void)
{
    glint_jobs_destroy(&f.jobs);
    glint_store_destroy(&f.store);
    glint_keeper_destroy(&keeper);
    assert_int_equal(fake_broken(), 0);
    assert_int_equal(fake_renders(), 0);
    assert_int_equal(fake_scene_residents(), 0);
}

static void restart(void)
{
    stop();
    start();
}

static int begin(void **state)
{
    (void)state;
    strcpy(folder, "/tmp/glint-films-XXXXXX");
    if (!mkdtemp(folder))
        return -1;
    fake_reset();
    start();
    put_scene();
    return 0;
}

static int end(void **state)
{
    (void)state;
    char command[128];
    stop();
    snprintf(command, sizeof command, "rm -rf '%s'", folder);
    return system(command);
}

static const char *film(const char *id, int number, const char *suffix)
{
    static char path[160];
    snprintf(path, sizeof path, "%s/films/%s.%d%s", folder, id, number, suffix);
    return path;
}

static void nap(void)
{
    nanosleep(&(struct timespec){.tv_nsec = 10000000}, NULL);
}

static void wait_file(const char *path, bool there)
{
    for (int i = 0; i < PATIENCE && !access(path, F_OK) != there; i++)
        nap();
    assert_int_equal(!access(path, F_OK), there);
}

static void wait_done(const char *id)
{
    for (int i = 0; i < PATIENCE && fixture_state(&f, id) != GLINT_JOB_DONE; i++)
        nap();
    assert_int_equal(fixture_state(&f, id), GLINT_JOB_DONE);
}

// Some slices of the job have run, and no more do.
static const char *half_way(unsigned slices)
{
    fake_close_gate();
    const char *id = fixture_submit(&f, "{'scene': 's', 'seed': 5, 'resolution': [4, 1], "
                                        "'stop': {'samples': 10}}");
    fake_let(slices);
    for (int i = 0; i < PATIENCE && fixture_number(&f, id, "samples") < slices / 4; i++)
        nap();
    assert_true(fixture_number(&f, id, "samples") >= slices / 4);
    return id;
}

static void checkpoint(const char *id, int number)
{
    glint_jobs_checkpoint(f.jobs);
    wait_file(film(id, number, ""), true);
}

static void a_job_goes_on_from_its_last_film(void **state)
{
    (void)state;
    const char *id = half_way(12);
    fake_open_gate();
    wait_done(id);
    const size_t before = fake_begun_now();
    assert_int_equal(before, 40);
    restart();
    assert_int_equal(fixture_state(&f, id), GLINT_JOB_DONE);
    assert_true(fixture_number(&f, id, "samples") == 10);
}

static void samples_are_taken_once_whatever_the_restarts(void **state)
{
    (void)state;
    const char *id = half_way(12);
    checkpoint(id, 1);
    fake_let(WORKERS * 2); // what is out comes back
    fake_open_gate();
    restart();
    wait_done(id);
    assert_true(fixture_number(&f, id, "samples") == 10);
    wait_file(film(id, 1, ""), false);
}

static void tear(const char *path)
{
    assert_int_equal(truncate(path, 20), 0);
}

static void a_torn_film_gives_way_to_the_one_before(void **state)
{
    (void)state;
    const char *id = half_way(8);
    checkpoint(id, 1);
    fake_let(8);
    for (int i = 0; i < PATIENCE && fixture_number(&f, id, "samples") < 4; i++)
        nap();
    checkpoint(id, 2);
    wait_file(film(id, 1, ""), true);
    fixture_patch(&f, id, "{'paused': true}");
    fake_let(100);
    stop(); // writes the third
    wait_file(film(id, 3, ""), true);
    wait_file(film(id, 1, ""), false);
    tear(film(id, 3, ""));
    fake_open_gate();
    const size_t begun = fake_begun_now();
    start();
    fixture_patch(&f, id, "{'paused': false}");
    wait_done(id);
    assert_true(fake_begun_now() - begun <= 4 * (10 - 4)); // the second film has four samples
    assert_int_equal(access(film(id, 3, ".torn"), F_OK), 0);
    cJSON *job = glint_jobs_describe(f.jobs, id, NULL);
    const cJSON *warnings = cJSON_GetObjectItem(job, "warnings");
    assert_int_equal(cJSON_GetArraySize(warnings), 1);
    assert_non_null(strstr(cJSON_GetArrayItem(warnings, 0)->valuestring, "film 3"));
    cJSON_Delete(job);
}

static void a_newer_film_is_kept_aside(void **state)
{
    (void)state;
    const char *id = half_way(8);
    fixture_patch(&f, id, "{'paused': true}");
    fake_let(100);
    stop();
    FILE *file = fopen(film(id, 1, ""), "w");
    fputs("film 2 of another time", file);
    fclose(file);
    fake_open_gate();
    start();
    fixture_patch(&f, id, "{'paused': false}");
    wait_done(id);
    assert_true(fixture_number(&f, id, "samples") == 10);
    assert_int_equal(access(film(id, 1, ".newer"), F_OK), 0);
}

static void a_missing_film_means_to_begin_anew(void **state)
{
    (void)state;
    const char *id = half_way(8);
    fixture_patch(&f, id, "{'paused': true}");
    fake_let(100);
    stop();
    assert_int_equal(unlink(film(id, 1, "")), 0);
    fake_open_gate();
    start();
    fixture_patch(&f, id, "{'paused': false}");
    wait_done(id);
    assert_true(fixture_number(&f, id, "samples") == 10);
}

static void an_ended_job_is_opened_from_its_film(void **state)
{
    (void)state;
    fake_open_gate();
    const char *id = fixture_submit(&f, "{'scene': 's', 'seed': 5, 'resolution': [4, 1], "
                                        "'stop': {'samples': 3}}");
    wait_done(id);
    wait_file(film(id, 1, ""), true);
    restart();
    struct glint_job_view view;
    assert_int_equal(glint_jobs_view(f.jobs, id, &view, NULL), GLINT_OK);
    assert_non_null(view.render);
    assert_true(view.opened);
    glint_jobs_release(f.jobs, &view);
    assert_int_equal(fake_renders(), 0);
    tear(film(id, 1, ""));
    assert_int_equal(glint_jobs_view(f.jobs, id, &view, NULL), GLINT_E_IO);
}

static void films_of_forgotten_jobs_go(void **state)
{
    (void)state;
    bool forgotten;
    fake_open_gate();
    const char *id = fixture_submit(&f, "{'scene': 's', 'seed': 5, 'resolution': [4, 1], "
                                        "'stop': {'samples': 3}}");
    wait_done(id);
    wait_file(film(id, 1, ""), true);
    assert_int_equal(glint_jobs_delete(f.jobs, id, &forgotten, NULL), GLINT_OK);
    assert_true(forgotten);
    wait_file(film(id, 1, ""), false);
    restart();
    assert_int_equal(glint_jobs_view(f.jobs, id, &(struct glint_job_view){0}, NULL),
                     GLINT_E_NOT_FOUND);
}

static void a_job_that_cannot_be_read_has_failed_and_keeps_its_film(void **state)
{
    (void)state;
    fake_open_gate();
    const char *id = fixture_submit(&f, "{'scene': 's', 'seed': 5, 'resolution': [4, 1], "
                                        "'stop': {'samples': 3}}");
    wait_done(id);
    wait_file(film(id, 1, ""), true);
    const struct glint_statement edit = {.sql = "UPDATE job SET text='{\"later\": 1}'"};
    assert_int_equal(glint_journal_commit(glint_keeper_journal(keeper), &edit, 1, NULL), GLINT_OK);
    restart();
    assert_int_equal(fixture_state(&f, id), GLINT_JOB_FAILED);
    assert_int_equal(access(film(id, 1, ""), F_OK), 0);
}

static void a_paused_job_tells_its_new_stop_after_a_restart(void **state)
{
    (void)state;
    const char *id = half_way(8);
    fixture_patch(&f, id, "{'paused': true}");
    fake_let(100);
    restart();
    fixture_patch(&f, id, "{'stop': {'samples': 20}}");
    assert_true(fixture_number(&f, id, "target_samples") == 20);
    fake_open_gate();
    fixture_patch(&f, id, "{'paused': false}");
    wait_done(id);
    assert_true(fixture_number(&f, id, "samples") == 20);
}

static void a_film_leaves_memory_for_another(void **state)
{
    (void)state;
    fake_open_gate();
    glint_jobs_set_limits(f.jobs, &(struct glint_jobs_limits){.memory_bytes = 1 << 14});
    char first[GLINT_JOB_ID_BYTES];
    for (int i = 0; i < 6; i++) { // of 4096 bytes each: more than there is room for
        const char *id = fixture_submit(&f,
                                        "{'scene': 's', 'seed': %d, 'resolution': [64, 64], "
                                        "'stop': {'samples': 1}}",
                                        i + 1);
        wait_done(id);
        wait_file(film(id, 1, ""), true);
        if (!i)
            strcpy(first, id);
    }
    struct glint_job_view view;
    assert_int_equal(glint_jobs_view(f.jobs, first, &view, NULL), GLINT_OK); // it is still known
    assert_true(view.opened);
    glint_jobs_release(f.jobs, &view);
}

static void films_past_their_share_of_the_disk_go_oldest_first(void **state)
{
    (void)state;
    char id[3][GLINT_JOB_ID_BYTES];
    fake_open_gate();
    glint_jobs_set_film_disk(f.jobs, 100); // a film has 45 bytes
    for (int i = 0; i < 3; i++) {
        strcpy(id[i], fixture_submit(&f, "{'scene': 's', 'seed': 5, 'resolution': [4, 1], "
                                         "'stop': {'samples': 3}}"));
        wait_done(id[i]);
        wait_file(film(id[i], 1, ""), true);
    }
    wait_file(film(id[0], 1, ""), false);
    assert_int_equal(access(film(id[1], 1, ""), F_OK), 0);
    assert_null(glint_jobs_describe(f.jobs, id[0], NULL));
}

#define KEPT(test) cmocka_unit_test_setup_teardown(test, begin, end)

int main(void)
{
    const struct CMUnitTest tests[] = {
        KEPT(a_job_goes_on_from_its_last_film),
        KEPT(samples_are_taken_once_whatever_the_restarts),
        KEPT(a_torn_film_gives_way_to_the_one_before),
        KEPT(a_newer_film_is_kept_aside),
        KEPT(a_missing_film_means_to_begin_anew),
        KEPT(an_ended_job_is_opened_from_its_film),
        KEPT(films_of_forgotten_jobs_go),
        KEPT(a_job_that_cannot_be_read_has_failed_and_keeps_its_film),
        KEPT(a_paused_job_tells_its_new_stop_after_a_restart),
        KEPT(a_film_leaves_memory_for_another),
        KEPT(films_past_their_share_of_the_disk_go_oldest_first),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
