#include "jobs/admit.h"

#include "base/clock.h"
#include "jobs/choose.h"
#include "jobs/warn.h"
#include "protocol/cryptomatte.h"

#include <errno.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/random.h>

#define MAX_KEY_BYTES 255
#define MAX_CLASHES 16 // warned about one by one

static glint_status check_key(const char *key, struct glint_error *err)
{
    const size_t length = key ? strlen(key) : 1;
    if (length >= 1 && length <= MAX_KEY_BYTES)
        return GLINT_OK;
    return glint_fail(err, GLINT_E_RANGE, "", "an Idempotency-Key has 1 to %d bytes",
                      MAX_KEY_BYTES);
}

static glint_status find_scene(glint_revision **out, glint_store *store, const char *name,
                               struct glint_error *err)
{
    if (!glint_store_get(store, name, out, NULL))
        return glint_revision_load(*out, err);
    return glint_fail(err, GLINT_E_RANGE, "/scene", "there is no scene \"%.140s\"", name);
}

static bool has_camera(const struct glint_scene *scene, const char *name)
{
    for (uint32_t i = 0; i < scene->cameras; i++)
        if (!strcmp(scene->camera[i].name, name) || !strcmp(scene->camera[i].id, name))
            return true;
    return false;
}

glint_status glint_admit_camera(const glint_revision *revision, const struct glint_job *job,
                                struct glint_error *err)
{
    const struct glint_scene *scene = glint_resident_scene(glint_revision_resident(revision));
    if (job->has_camera || !job->camera_name || has_camera(scene, job->camera_name))
        return GLINT_OK;
    return glint_fail(err, GLINT_E_RANGE, "/camera",
                      "the scene \"%.140s\" has no camera \"%.140s\"", job->scene,
                      job->camera_name);
}

static glint_status draw_id(char id[GLINT_JOB_ID_BYTES], struct glint_error *err)
{
    unsigned char random[(GLINT_JOB_ID_BYTES - 1) / 2];
    if (getrandom(random, sizeof random, 0) != (ssize_t)sizeof random)
        return glint_fail(err, GLINT_E_IO, "", "no random bytes: %s", strerror(errno));
    for (size_t i = 0; i < sizeof random; i++)
        snprintf(id + 2 * i, 3, "%02x", random[i]);
    return GLINT_OK;
}

static void warn_of_clashes(cJSON *warnings, const char *layer, const char *const *name,
                            size_t count)
{
    struct glint_cryptomatte_clash *clash = NULL;
    size_t clashes = 0;
    if (glint_cryptomatte_clashes(name, count, &clash, &clashes))
        return;
    for (size_t i = 0; i < clashes && i < MAX_CLASHES; i++)
        glint_warn(
            warnings,
            "the %s names \"%.100s\" and \"%.100s\" share one Cryptomatte ID: mattes have the "
            "second as \"%.100s~2\", or a higher number",
            layer, clash[i].a, clash[i].b, clash[i].b);
    if (clashes > MAX_CLASHES)
        glint_warn(warnings, "%zu more pairs of %s names share a Cryptomatte ID",
                   clashes - MAX_CLASHES, layer);
    free(clash);
}

static void warn_of_mattes(cJSON *warnings, const struct glint_scene *scene, uint32_t outputs)
{
    const size_t most = scene->objects > scene->materials ? scene->objects : scene->materials;
    const char **name = malloc((most + 1) * sizeof *name);
    if (!name)
        return;
    for (uint32_t i = 0; i < scene->objects; i++)
        name[i] = scene->object[i].name;
    if (outputs & GLINT_OUT_CRYPTO_OBJECT)
        warn_of_clashes(warnings, "object", name, scene->objects);
    size_t assets = 0;
    for (uint32_t i = 0; i < scene->objects; i++)
        if (*scene->object[i].asset)
            name[assets++] = scene->object[i].asset;
    if (outputs & GLINT_OUT_CRYPTO_ASSET)
        warn_of_clashes(warnings, "asset", name, assets);
    for (uint32_t i = 0; i < scene->materials; i++)
        name[i] = scene->material[i].name;
    if (outputs & GLINT_OUT_CRYPTO_MATERIAL)
        warn_of_clashes(warnings, "material", name, scene->materials);
    free(name);
}

// All of the entry but what it takes from others; `chosen` and `asked` it takes in any case.
static struct glint_entry *new_entry(const struct glint_job *job,
                                     const struct glint_submission *from, cJSON *chosen,
                                     char *asked)
{
    struct glint_entry *e = calloc(1, sizeof *e);
    if (!e) {
        cJSON_Delete(chosen);
        free(asked);
        return NULL;
    }
    e->chosen = chosen;
    e->asked = asked;
    atomic_init(&e->references, 1);
    atomic_init(&e->abandoned, false);
    e->text = glint_job_write(job);
    e->key = from->key ? strdup(from->key) : NULL;
    e->client = strdup(from->client ? from->client : "");
    e->request = from->request ? strdup(from->request) : NULL;
    e->warnings = cJSON_CreateArray();
    if (!e->text || !e->warnings || !e->client || (from->key && !e->key) ||
        (from->request && !e->request))
        glint_entry_release(&e);
    return e;
}

static double expected_error(const cJSON *chosen)
{
    const cJSON *error = cJSON_GetObjectItemCaseSensitive(chosen, "expected_error");
    return cJSON_IsNumber(error) ? error->valuedouble : 0.0;
}

// A job ends at the most samples that it may take, whatever its error is then.
static void warn_of_reach(cJSON *warnings, const struct glint_job *job, const cJSON *chosen)
{
    const double expected = expected_error(chosen);
    if (job->budget.error > 0 && expected > job->budget.error)
        glint_warn(warnings,
                   "the error asked for, %.3g, is not expected within the samples that the job may "
                   "take: %.3g is",
                   job->budget.error, expected);
}

static void warn_of_front(cJSON *warnings, const cJSON *chosen)
{
    const char *from = cJSON_GetStringValue(cJSON_GetObjectItemCaseSensitive(chosen, "from"));
    if (from && !strcmp(from, "scene") &&
        !cJSON_IsTrue(cJSON_GetObjectItemCaseSensitive(chosen, "current")))
        glint_warn(warnings, "the settings were picked from a front of another revision of the "
                             "scene: what is expected of them may be wrong until it is measured "
                             "again");
}

static void fill(struct glint_entry *e, struct glint_job *job, glint_revision *revision)
{
    struct glint_resident_stats rest;
    glint_resident_stats(glint_revision_resident(revision), &rest);
    e->rest_bytes = rest.geometry_bytes + rest.bvh_bytes + rest.record_bytes + rest.texture_bytes +
                    rest.light_bytes;
    e->job = job;
    e->revision = revision;
    e->state = GLINT_JOB_QUEUED;
    e->end = GLINT_JOB_QUEUED;
    e->priority = job->priority;
    e->stop = job->stop;
    e->since = NAN;
    e->sequence = 1;
    e->submitted = glint_now();
    glint_utc(e->created);
    warn_of_mattes(e->warnings, glint_resident_scene(glint_revision_resident(revision)),
                   job->outputs);
    warn_of_front(e->warnings, e->chosen);
    warn_of_reach(e->warnings, job, e->chosen);
}

// Picks the settings of a job with a budget. *asked: the job as it was before.
static glint_status choose(cJSON **chosen, char **asked, const struct glint_admission *to,
                           const glint_revision *revision, struct glint_job *job,
                           struct glint_error *err)
{
    *asked = job->budget.seconds > 0 || job->budget.error > 0 ? glint_job_write(job) : NULL;
    const glint_status st = glint_choose(chosen, to->prices, revision, to->workers, job, err);
    if (st) {
        free(*asked);
        *asked = NULL;
    }
    return st;
}

glint_status glint_admit(struct glint_entry **out, const struct glint_admission *to,
                         struct glint_job *job, const struct glint_submission *from,
                         struct glint_error *err)
{
    *out = NULL;
    glint_revision *revision = NULL;
    glint_status st = check_key(from->key, err);
    const glint_status found = find_scene(&revision, to->store, job->scene, err);
    st = st ? st : found;
    struct glint_pose_request request;
    if (!st) {
        const struct glint_scene *scene = glint_resident_scene(glint_revision_resident(revision));
        st = glint_admit_camera(revision, job, err);
        const glint_status posed = glint_posed_request(&request, scene, job, err);
        st = st ? st : posed;
    }
    cJSON *chosen = NULL;
    char *asked = NULL;
    if (!st)
        st = choose(&chosen, &asked, to, revision, job, err);
    struct glint_entry *e = st ? NULL : new_entry(job, from, chosen, asked);
    if (!st && !e)
        st = glint_fail(err, GLINT_E_NOMEM, "", "no memory for a job");
    if (!st)
        st = draw_id(e->id, err);
    if (st) {
        glint_entry_release(&e);
        glint_revision_release(&revision);
        return st;
    }
    fill(e, job, revision);
    glint_need_estimate(&e->need, glint_revision_resident(revision), &request, job, to->workers);
    *out = e;
    return GLINT_OK;
}
