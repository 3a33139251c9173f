#include "protocol/film_header.h"

#include "kernels/gk_matte.h"
#include "protocol/bias.h"
#include "protocol/cryptomatte.h"
#include "protocol/fields.h"

#include <assert.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define MAX_RAYS 9007199254740992.0 // what a double counts exactly
#define MAX_SECONDS 1e12
#define MAX_MATTES GK_MATTE_BASE_KEY
#define MAX_BOUNCES 1025.0 // at each of which Eq. 8 may cover all of a pixel

static const struct glint_field plane_fields[] = {
    GLINT_FIELD(BOOL, struct glint_film_info, aovs),
    GLINT_FIELD(BOOL, struct glint_film_info, flow),
    GLINT_FIELD(BOOL, struct glint_film_info, batches),
    GLINT_FIELD(BOOL, struct glint_film_info, coverage),
    {0},
};

static const struct glint_field moment_fields[] = {
    GLINT_FIELD(BOOL, struct glint_film_moment, complete),
    GLINT_FIELD(BOOL, struct glint_film_moment, stopped),
    GLINT_FIELD(UINT, struct glint_film_moment, sample, .high = GLINT_MAX_SAMPLES),
    GLINT_FIELD(UINT, struct glint_film_moment, samples, .high = 16),
    GLINT_FIELD(UINT, struct glint_film_moment, tiles_log2, .high = 2),
    GLINT_FIELD(UINT, struct glint_film_moment, target, .high = GLINT_MAX_SAMPLES),
    GLINT_FIELD(DOUBLE, struct glint_film_moment, worker_seconds, .high = MAX_SECONDS),
    GLINT_FIELD_KNOWN("error"),
    GLINT_FIELD_KNOWN("spread"),
    GLINT_FIELD_KNOWN("linear"),
    GLINT_FIELD_KNOWN("tone_mapped"),
    GLINT_FIELD_KNOWN("tail"),
    GLINT_FIELD_KNOWN("lift"),
    GLINT_FIELD_KNOWN("biases"),
    GLINT_FIELD_KNOWN("shares"),
    GLINT_FIELD_KNOWN("camera_rays"),
    GLINT_FIELD_KNOWN("bounce_rays"),
    GLINT_FIELD_KNOWN("shadow_rays"),
    GLINT_FIELD_KNOWN("counts"),
    GLINT_FIELD_KNOWN("ranks"),
    GLINT_FIELD_KNOWN("curve"),
    {0},
};

// ---- writing

static void write_count(struct glint_text *t, const char *key, uint64_t n)
{
    glint_text_key(t, key);
    glint_text_print(t, "%llu", (unsigned long long)n);
}

static void write_double(struct glint_text *t, const char *key, double x)
{
    if (!isfinite(x))
        return;
    glint_text_key(t, key);
    glint_text_double(t, x);
}

// As bits: a matrix of an extreme camera need not be finite.
static void write_matrix(struct glint_text *t, const char *key, const float m[16])
{
    uint32_t bits[16];
    memcpy(bits, m, sizeof bits);
    glint_text_key(t, key);
    glint_text_add(t, "[");
    for (int i = 0; i < 16; i++) {
        glint_text_item(t);
        glint_text_print(t, "%u", bits[i]);
    }
    glint_text_add(t, "]");
}

static void write_mattes(struct glint_text *t, const struct glint_film_info *info)
{
    glint_text_key(t, "mattes");
    glint_text_add(t, "[");
    for (uint32_t k = 2; k < info->mattes; k++) {
        glint_text_item(t);
        glint_text_add(t, "[");
        for (int l = 0; l < GLINT_MATTE_LAYERS; l++) {
            glint_text_item(t);
            glint_text_string(t, info->matte[k].id[l] ? info->matte[k].name[l] : "");
        }
        glint_text_add(t, "]");
    }
    glint_text_add(t, "]");
}

static void write_curve(struct glint_text *t, const struct glint_film_moment *m)
{
    glint_text_key(t, "curve");
    glint_text_add(t, "[");
    for (uint32_t i = 0; i < m->points; i++) {
        glint_text_item(t);
        glint_text_add(t, "{");
        write_count(t, "samples", m->curve[i].samples);
        write_double(t, "seconds", m->curve[i].seconds);
        write_double(t, "error", m->curve[i].error);
        write_double(t, "spread", m->curve[i].spread);
        write_count(t, "rays", m->curve[i].rays);
        glint_text_add(t, "}");
    }
    glint_text_add(t, "]");
}

static void write_counts(struct glint_text *t, const struct glint_film_moment *m)
{
    glint_text_key(t, "counts");
    glint_text_add(t, "{");
    for (int i = 0; i < GLINT_COUNTS; i++)
        write_count(t, glint_count_name[i], m->count[i]);
    glint_text_add(t, "}");
}

static void write_excess(struct glint_text *t, const struct glint_matte_excess *x)
{
    if (!x->needed)
        return;
    glint_text_key(t, "ranks");
    glint_text_add(t, "{");
    write_count(t, "pixels", x->pixels);
    write_count(t, "needed", x->needed);
    write_double(t, "left_out", x->left_out);
    glint_text_add(t, "}");
}

static void write_estimate(struct glint_text *t, const struct glint_estimate *e)
{
    write_double(t, "error", e->error);
    write_double(t, "spread", e->spread);
    write_double(t, "linear", e->linear);
    write_double(t, "tone_mapped", e->tone_mapped);
    write_double(t, "tail", e->tail);
    write_double(t, "lift", e->lift);
}

static void write_tree(struct glint_text *t, const char *key, const cJSON *tree)
{
    char *text = tree ? cJSON_PrintUnformatted(tree) : NULL;
    if (tree && !text)
        t->failed = true;
    if (!text)
        return;
    glint_text_key(t, key);
    glint_text_add(t, text);
    cJSON_free(text);
}

static void write_moment(struct glint_text *t, const struct glint_film_moment *m)
{
    glint_text_key(t, "moment");
    glint_text_add(t, "{");
    glint_fields_write(t, moment_fields, m);
    write_estimate(t, &m->estimate);
    write_count(t, "camera_rays", m->camera_rays);
    write_count(t, "bounce_rays", m->bounce_rays);
    write_count(t, "shadow_rays", m->shadow_rays);
    write_counts(t, m);
    write_excess(t, &m->excess);
    write_curve(t, m);
    if (m->shares) {
        glint_text_key(t, "shares");
        glint_text_string(t, m->shares);
    }
    cJSON *biases = glint_biases_names(m->biases);
    write_tree(t, "biases", biases);
    cJSON_Delete(biases);
    glint_text_add(t, "}");
}

char *glint_film_header_write(const struct glint_film_header *h, size_t *length)
{
    struct glint_text t = {0};
    char *job = glint_job_write(h->info.job);
    glint_text_add(&t, "{");
    glint_text_key(&t, "software");
    glint_text_string(&t, h->info.software);
    glint_text_key(&t, "revision");
    glint_text_string(&t, h->info.revision);
    glint_text_key(&t, "job");
    glint_text_add(&t, job ? job : "");
    t.failed |= !job;
    free(job);
    glint_text_key(&t, "planes");
    glint_text_add(&t, "{");
    glint_fields_write(&t, plane_fields, &h->info);
    glint_text_add(&t, "}");
    write_matrix(&t, "world_to_camera", h->info.to_camera);
    write_matrix(&t, "world_to_ndc", h->info.to_ndc);
    write_moment(&t, &h->moment);
    write_tree(&t, "seconds", h->seconds);
    write_tree(&t, "plan", h->plan);
    write_mattes(&t, &h->info);
    glint_text_add(&t, "}");
    return glint_text_take(&t, length);
}

// ---- reading

// The member, which must be there.
static struct glint_json required(const struct glint_json *object, const char *key)
{
    const struct glint_json at = glint_json_member(object, key);
    glint_json_require(&at);
    return at;
}

static void read_text(const struct glint_json *root, const char *key, struct glint_film_header *h,
                      const char **out)
{
    const struct glint_json at = required(root, key);
    char *text = NULL;
    glint_json_string(&at, &h->arena, &text);
    *out = text ? text : "";
    if (strlen(*out) > 64)
        glint_json_fault(&at, "%zu bytes are more than 64", strlen(*out));
}

static void read_matrix(const struct glint_json *root, const char *key, float m[16])
{
    const struct glint_json at = required(root, key);
    uint32_t bits[16] = {0};
    glint_json_uints(&at, 16, 0, UINT32_MAX, bits);
    memcpy(m, bits, sizeof bits);
}

static void read_count(const struct glint_json *object, const char *key, uint64_t *out)
{
    const struct glint_json at = required(object, key);
    double n = 0.0;
    if (glint_json_double(&at, 0.0, MAX_RAYS, &n))
        *out = (uint64_t)n;
}

// NAN where it is absent.
static void read_known(const struct glint_json *object, const char *key, double *out)
{
    const struct glint_json at = glint_json_member(object, key);
    *out = NAN;
    glint_json_double(&at, 0.0, INFINITY, out);
}

static void read_point(const struct glint_json *at, struct glint_convergence_point *p)
{
    static const char *const known[] = {"samples", "seconds", "error", "spread", "rays", NULL};
    const struct glint_json samples = required(at, "samples"), seconds = required(at, "seconds");
    glint_json_only(at, known);
    glint_json_uint(&samples, 1, GLINT_MAX_SAMPLES, &p->samples);
    glint_json_double(&seconds, 0.0, MAX_SECONDS, &p->seconds);
    read_known(at, "error", &p->error);
    read_known(at, "spread", &p->spread);
    read_count(at, "rays", &p->rays);
}

static void read_estimate(const struct glint_json *moment, struct glint_estimate *e)
{
    read_known(moment, "error", &e->error);
    read_known(moment, "spread", &e->spread);
    read_known(moment, "linear", &e->linear);
    read_known(moment, "tone_mapped", &e->tone_mapped);
    read_known(moment, "tail", &e->tail);
    read_known(moment, "lift", &e->lift);
}

static void read_curve(const struct glint_json *moment, struct glint_film_moment *m)
{
    const struct glint_json at = required(moment, "curve");
    size_t count = 0, i = 0;
    if (!glint_json_length(&at, &count))
        return;
    if (count > GLINT_CURVE_POINTS) {
        glint_json_fault(&at, "%zu points are more than %d", count, GLINT_CURVE_POINTS);
        return;
    }
    for (const cJSON *c = count ? at.value->child : NULL; c; c = c->next, i++) {
        const struct glint_json point = glint_json_item(&at, c, i);
        read_point(&point, &m->curve[i]);
        if (i && m->curve[i].samples <= m->curve[i - 1].samples)
            glint_json_fault(&point, "%u samples do not come after %u", m->curve[i].samples,
                             m->curve[i - 1].samples);
    }
    m->points = (uint32_t)count;
}

// Films of older versions have none.
static void read_counts(const struct glint_json *moment, struct glint_film_moment *m)
{
    const struct glint_json at = glint_json_member(moment, "counts");
    const char *known[GLINT_COUNTS + 1] = {NULL};
    memcpy(known, glint_count_name, sizeof glint_count_name);
    if (!at.value)
        return;
    glint_json_only(&at, known);
    for (int i = 0; i < GLINT_COUNTS; i++)
        read_count(&at, glint_count_name[i], &m->count[i]);
}

// Likewise.
static void read_excess(const struct glint_json *moment, struct glint_matte_excess *x)
{
    static const char *const known[] = {"pixels", "needed", "left_out", NULL};
    const struct glint_json at = glint_json_member(moment, "ranks");
    if (!at.value)
        return;
    const struct glint_json needed = required(&at, "needed"), left = required(&at, "left_out");
    glint_json_only(&at, known);
    read_count(&at, "pixels", &x->pixels);
    glint_json_uint(&needed, 2, MAX_MATTES, &x->needed);
    glint_json_double(&left, 0.0, MAX_BOUNCES, &x->left_out);
}

static void read_moment(const struct glint_json *root, struct glint_film_header *h)
{
    struct glint_film_moment *m = &h->moment;
    const struct glint_json at = required(root, "moment");
    if (!at.value)
        return;
    glint_fields_read(&at, moment_fields, &h->arena, m);
    read_estimate(&at, &m->estimate);
    const struct glint_json shares = glint_json_member(&at, "shares");
    char *letters = NULL;
    glint_json_string(&shares, &h->arena, &letters);
    m->shares = letters;
    m->biases = glint_biases_named(glint_json_member(&at, "biases").value);
    read_count(&at, "camera_rays", &m->camera_rays);
    read_count(&at, "bounce_rays", &m->bounce_rays);
    read_count(&at, "shadow_rays", &m->shadow_rays);
    read_counts(&at, m);
    read_excess(&at, &m->excess);
    read_curve(&at, m);
    const uint32_t first = h->job ? h->job->sample_range[0] : 0;
    if (m->sample < first || m->sample + m->samples > GLINT_MAX_SAMPLES || m->target < m->sample)
        glint_json_fault(&at, "samples %u to %u are not the next of a job from %u to %u", m->sample,
                         m->sample + m->samples, first, m->target);
    const bool pilot = h->job && h->job->adaptive && !m->shares;
    const bool whole = !(m->sample % GLINT_PILOT_SAMPLES || m->samples % GLINT_PILOT_SAMPLES);
    if (pilot ? m->sample + m->samples > GLINT_PILOT_SAMPLES
              : m->shares && (m->sample < GLINT_PILOT_SAMPLES || !whole))
        glint_json_fault(&at, "samples %u to %u are not of a pass of an adaptive job", m->sample,
                         m->sample + m->samples);
    if (m->complete && m->samples)
        glint_json_fault(&at, "a complete film has no pass under way");
}

// Faults of the job are faults of the header at the job.
static void read_job(const struct glint_json *root, struct glint_film_header *h)
{
    const struct glint_json at = required(root, "job");
    char *text = at.value ? cJSON_PrintUnformatted(at.value) : NULL;
    struct glint_error faults = {0};
    const glint_status st = text ? glint_job_parse(&h->job, text, strlen(text), &faults) : GLINT_OK;
    for (size_t i = 0; i < faults.count; i++) {
        char pointer[512];
        snprintf(pointer, sizeof pointer, "/job%s", faults.fault[i].pointer);
        glint_fail(root->err, st, pointer, "%s", faults.fault[i].detail);
    }
    glint_error_finish(&faults);
    cJSON_free(text);
    h->info.job = h->job;
}

// Frames take what their outputs call for; more may be there.
static void read_planes(const struct glint_json *root, struct glint_film_header *h)
{
    const struct glint_json at = required(root, "planes");
    struct glint_film_info *info = &h->info;
    glint_fields_read(&at, plane_fields, &h->arena, info);
    const uint32_t outputs = h->job ? h->job->outputs : 0;
    const uint32_t aovs = GLINT_OUT_DEPTH | GLINT_OUT_NORMAL | GLINT_OUT_ALBEDO | GLINT_OUT_MOTION;
    if ((outputs & aovs && !info->aovs) || (outputs & GLINT_OUT_MOTION && !info->flow) ||
        (info->flow && !info->aovs) ||
        (h->job && h->job->estimate == GLINT_ESTIMATE_BATCHES && !info->batches) ||
        (outputs & GLINT_OUT_CRYPTO && !info->coverage))
        glint_json_fault(&at, "the job's outputs need more");
}

static void read_names(const struct glint_json *at, struct glint_film_header *h,
                       struct glint_matte_key *key)
{
    size_t count = 0;
    if (!glint_json_length(at, &count) || count != GLINT_MATTE_LAYERS) {
        glint_json_fault(at, "the names of an object, a material and an asset are expected");
        return;
    }
    const cJSON *c = at->value->child;
    for (size_t l = 0; l < GLINT_MATTE_LAYERS; l++, c = c->next) {
        const struct glint_json item = glint_json_item(at, c, l);
        char *name = NULL;
        glint_json_string(&item, &h->arena, &name);
        key->name[l] = name;
        key->id[l] = name && *name ? glint_cryptomatte_id(name) : 0;
    }
}

static void read_mattes(const struct glint_json *root, struct glint_film_header *h)
{
    const struct glint_json at = required(root, "mattes");
    size_t count = 0, i = 0;
    if (!glint_json_length(&at, &count))
        return;
    if (count > MAX_MATTES - 1) {
        glint_json_fault(&at, "%zu are more than %u", count, MAX_MATTES - 1);
        return;
    }
    struct glint_matte_key *key = glint_arena_array(&h->arena, count + 2, sizeof *key);
    if (!key) {
        glint_fail(root->err, GLINT_E_NOMEM, "/mattes", "no memory for %zu names", count);
        return;
    }
    for (const cJSON *c = count ? at.value->child : NULL; c; c = c->next, i++) {
        const struct glint_json item = glint_json_item(&at, c, i);
        read_names(&item, h, &key[i + 2]);
    }
    h->info.matte = key;
    h->info.mattes = (uint32_t)count + 2;
    if (h->job)
        glint_matte_check(h->job, h->info.mattes, "/mattes", root->err);
}

// Takes a member out of the tree.
static cJSON *take(const struct glint_json *root, const char *key)
{
    const struct glint_json at = glint_json_member(root, key);
    if (!at.value)
        return NULL;
    if (!cJSON_IsObject(at.value)) {
        glint_json_fault(&at, "an object is expected");
        return NULL;
    }
    return cJSON_DetachItemFromObjectCaseSensitive((cJSON *)root->value, key);
}

static void read_members(const struct glint_json *root, struct glint_film_header *h)
{
    static const char *const known[] = {
        "software", "revision", "job",    "planes", "world_to_camera", "world_to_ndc", "moment",
        "seconds",  "plan",     "mattes", NULL};
    glint_json_only(root, known);
    read_text(root, "software", h, &h->info.software);
    read_text(root, "revision", h, &h->info.revision);
    read_job(root, h);
    read_planes(root, h);
    read_matrix(root, "world_to_camera", h->info.to_camera);
    read_matrix(root, "world_to_ndc", h->info.to_ndc);
    read_moment(root, h);
    read_mattes(root, h);
    h->seconds = take(root, "seconds");
    h->plan = take(root, "plan");
}

static glint_status read_tree(cJSON *tree, struct glint_film_header *h, struct glint_error *err)
{
    struct glint_error faults = {0};
    const struct glint_json root = glint_json_root(tree, &faults);
    read_members(&root, h);
    const glint_status status = faults.status;
    for (size_t i = 0; i < faults.count; i++)
        glint_fail(err, status, faults.fault[i].pointer, "%s", faults.fault[i].detail);
    glint_error_finish(&faults);
    return status;
}

glint_status glint_film_header_parse(struct glint_film_header **out, const char *text,
                                     size_t length, struct glint_error *err)
{
    static const struct glint_json_limits limits = {
        .bytes = GLINT_MAX_FILM_HEADER, .depth = 24, .values = (size_t)1 << 26};
    *out = NULL;
    cJSON *tree;
    glint_status status = glint_json_parse(&tree, text, length, &limits, err);
    if (status)
        return status;
    struct glint_film_header *h = calloc(1, sizeof *h);
    status = h ? read_tree(tree, h, err)
               : glint_fail(err, GLINT_E_NOMEM, "", "no memory for a film's header");
    cJSON_Delete(tree);
    if (status)
        glint_film_header_destroy(&h);
    *out = h;
    return status;
}

void glint_film_header_destroy(struct glint_film_header **header)
{
    struct glint_film_header *h = *header;
    *header = NULL;
    if (!h)
        return;
    glint_job_destroy(&h->job);
    cJSON_Delete(h->seconds);
    cJSON_Delete(h->plan);
    glint_arena_finish(&h->arena);
    free(h);
}
