#include "jobs_fixture.h"

#include <math.h>
#include <pthread.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include <cmocka.h>

#define PATIENCE 20 // seconds
// Of the stand-in scene, and of the structure that a job makes of it: 160 for each triangle.
#define SCENE_BYTES (1500 + 24 * 160)

static const char scene[] =
    "{\"cameras\": {\"c\": {\"name\": \"Front\", \"yfov\": 0.5}}, \"materials\": {\"m\": {}},"
    " \"meshes\": {\"q\": {\"primitive\": \"quad\"}},"
    " \"instances\": {\"i\": {\"mesh\": \"q\", \"material\": \"m\"}},"
    " \"environment\": {\"radiance\": [1, 1, 1]}}";

static pthread_mutex_t mutex = PTHREAD_MUTEX_INITIALIZER;
static pthread_cond_t news = PTHREAD_COND_INITIALIZER;
static uint64_t changes;

static void note(void *user)
{
    (void)user;
    pthread_mutex_lock(&mutex);
    changes++;
    pthread_cond_broadcast(&news);
    pthread_mutex_unlock(&mutex);
}

void fixture_start(struct fixture *f, uint32_t workers)
{
    fixture_start_within(f, workers, UINT32_MAX);
}

void fixture_start_within(struct fixture *f, uint32_t workers, uint64_t film_bytes)
{
    const struct glint_import_limits limits = {1 << 20, 1};
    glint_revision *revision;
    bool created;
    glint_devices *devices = fake_devices(workers);
    fake_reset();
    f->client = NULL;
    assert_int_equal(glint_store_create(&f->store, devices, NULL, &limits, NULL, NULL), GLINT_OK);
    assert_int_equal(glint_store_put(f->store, "s",
                                     &(struct glint_import_source){.type = GLINT_SCENE_NATIVE,
                                                                   .bytes = (const uint8_t *)scene,
                                                                   .size = strlen(scene)},
                                     NULL, &revision, &created, NULL),
                     GLINT_OK);
    glint_revision_release(&revision);
    const struct glint_jobs_limits within = {.memory_bytes = film_bytes + SCENE_BYTES};
    assert_int_equal(glint_jobs_create(&f->jobs, devices, f->store, &within, NULL, NULL), GLINT_OK);
    glint_jobs_on_change(f->jobs, note, NULL);
}

void fixture_stop(struct fixture *f)
{
    fake_open_gate();
    fake_hold_create(false);
    glint_jobs_on_change(f->jobs, NULL, NULL);
    glint_jobs_destroy(&f->jobs);
    assert_null(f->jobs);
    glint_store_destroy(&f->store);
    assert_int_equal(fake_renders(), 0);
    assert_int_equal(fake_scene_residents(), 0);
    assert_int_equal(fake_scene_imports(), 0);
    assert_int_equal(fake_broken(), 0);
}

static void double_quotes(char *text)
{
    for (; *text; text++)
        if (*text == '\'')
            *text = '"';
}

glint_status fixture_try(struct fixture *f, const char *text, const char *key,
                         char id[GLINT_JOB_ID_BYTES], bool *repeated, struct glint_error *err)
{
    struct glint_job *job;
    char *json = strdup(text);
    double_quotes(json);
    assert_int_equal(glint_job_parse(&job, json, strlen(json), err), GLINT_OK);
    free(json);
    const glint_status st =
        glint_jobs_submit(f->jobs, job, &(struct glint_submission){.key = key, .client = f->client},
                          id, repeated, err);
    if (st)
        glint_job_destroy(&job);
    return st;
}

const char *fixture_submit(struct fixture *f, const char *format, ...)
{
    static char id[8][GLINT_JOB_ID_BYTES];
    static unsigned turn;
    char text[512];
    va_list args;
    va_start(args, format);
    vsnprintf(text, sizeof text, format, args);
    va_end(args);
    bool repeated;
    char *mine = id[turn++ % 8];
    assert_int_equal(fixture_try(f, text, NULL, mine, &repeated, NULL), GLINT_OK);
    assert_false(repeated);
    return mine;
}

glint_status fixture_patch(struct fixture *f, const char *id, const char *text)
{
    char *json = strdup(text);
    double_quotes(json);
    const glint_status st = glint_jobs_patch(f->jobs, id, json, strlen(json), NULL);
    free(json);
    return st;
}

double fixture_number(struct fixture *f, const char *id, const char *member)
{
    cJSON *job = glint_jobs_describe(f->jobs, id, NULL);
    assert_non_null(job);
    const cJSON *item = cJSON_GetObjectItemCaseSensitive(job, member);
    const double value = cJSON_IsNumber(item) ? item->valuedouble : NAN;
    cJSON_Delete(job);
    return value;
}

enum glint_job_state fixture_state(struct fixture *f, const char *id)
{
    cJSON *job = glint_jobs_describe(f->jobs, id, NULL);
    assert_non_null(job);
    const char *name = cJSON_GetStringValue(cJSON_GetObjectItem(job, "state"));
    int state = 0;
    while (strcmp(name, glint_job_state_name((enum glint_job_state)state)))
        state++;
    cJSON_Delete(job);
    return (enum glint_job_state)state;
}

void fixture_wait(struct fixture *f, const char *id, enum glint_job_state state)
{
    struct timespec until;
    clock_gettime(CLOCK_REALTIME, &until);
    until.tv_sec += PATIENCE;
    for (;;) {
        pthread_mutex_lock(&mutex);
        const uint64_t seen = changes;
        pthread_mutex_unlock(&mutex);
        if (fixture_state(f, id) == state)
            return;
        bool late = false;
        pthread_mutex_lock(&mutex);
        while (!late && changes == seen)
            late = pthread_cond_timedwait(&news, &mutex, &until) != 0;
        pthread_mutex_unlock(&mutex);
        if (late)
            fail_msg("job %s is %s and not %s", id, glint_job_state_name(fixture_state(f, id)),
                     glint_job_state_name(state));
    }
}
