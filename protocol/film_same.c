// film_same.c - whether the samples of two films may be mixed.
#include "protocol/film_header.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

// What says nothing of a sample.
static const char *const free_members[] = {"scene", "name", "priority", "stop", NULL};
static const char *const part_members[] = {"region", "sample_range", NULL};

static bool listed(const char *const *list, const char *name)
{
    while (*list && strcmp(*list, name))
        list++;
    return *list;
}

static cJSON *tree_of(const struct glint_job *job)
{
    char *text = glint_job_write(job);
    cJSON *tree = text ? cJSON_Parse(text) : NULL;
    free(text);
    return tree;
}

static glint_status differ(const char *member, const cJSON *a, const cJSON *b, const char *who,
                           struct glint_error *err)
{
    char pointer[128];
    char *is = b ? cJSON_PrintUnformatted(b) : NULL, *was = a ? cJSON_PrintUnformatted(a) : NULL;
    snprintf(pointer, sizeof pointer, "/job/%s", member);
    const glint_status st = glint_fail(err, GLINT_E_RANGE, pointer, "%.200s of %s is not %.200s",
                                       is ? is : "nothing", who, was ? was : "nothing");
    cJSON_free(is);
    cJSON_free(was);
    return st;
}

// Faults for the members of `a` that `b` has otherwise or not at all; with `missing` only the
// latter.
static glint_status compare(const cJSON *a, const cJSON *b, bool parts, bool missing,
                            const char *who, struct glint_error *err)
{
    glint_status st = GLINT_OK;
    for (const cJSON *x = a->child; x; x = x->next) {
        const cJSON *y = cJSON_GetObjectItemCaseSensitive(b, x->string);
        if (listed(free_members, x->string) || (parts && listed(part_members, x->string)))
            continue;
        if (missing ? !y : !cJSON_Compare(x, y, true))
            st = differ(x->string, missing ? NULL : x, missing ? x : y, who, err);
    }
    return st;
}

static glint_status same_jobs(const struct glint_job *a, const struct glint_job *b, bool parts,
                              const char *who, struct glint_error *err)
{
    cJSON *x = tree_of(a), *y = tree_of(b);
    glint_status st = GLINT_OK;
    if (x && y) {
        st = compare(x, y, parts, false, who, err);
        const glint_status more = compare(y, x, parts, true, who, err);
        st = st ? st : more;
    } else {
        st = glint_fail(err, GLINT_E_NOMEM, "", "no memory to compare two jobs");
    }
    cJSON_Delete(x);
    cJSON_Delete(y);
    return st;
}

static bool same_mattes(const struct glint_film_info *a, const struct glint_film_info *b)
{
    bool same = a->mattes == b->mattes;
    for (uint32_t k = 2; same && k < a->mattes; k++)
        for (int l = 0; same && l < GLINT_MATTE_LAYERS; l++)
            same = a->matte[k].id[l] == b->matte[k].id[l] &&
                   (!a->matte[k].id[l] || !strcmp(a->matte[k].name[l], b->matte[k].name[l]));
    return same;
}

glint_status glint_film_same(const struct glint_film_info *a, const struct glint_film_info *b,
                             bool parts, const char *who, struct glint_error *err)
{
    glint_status st = same_jobs(a->job, b->job, parts, who, err);
    if (strcmp(a->revision, b->revision))
        st = glint_fail(err, GLINT_E_RANGE, "/revision", "\"%s\" of %s is not \"%s\"", b->revision,
                        who, a->revision);
    else if (!same_mattes(a, b))
        st = glint_fail(err, GLINT_E_RANGE, "/mattes", "%s has other names", who);
    if (parts && strcmp(a->software, b->software))
        st = glint_fail(err, GLINT_E_RANGE, "/software", "\"%s\" of %s is not \"%s\"", b->software,
                        who, a->software);
    if (a->batches != b->batches || a->aovs != b->aovs || a->flow != b->flow ||
        a->coverage != b->coverage)
        st = glint_fail(err, GLINT_E_RANGE, "/planes", "%s has others", who);
    if (memcmp(a->to_camera, b->to_camera, sizeof a->to_camera) ||
        memcmp(a->to_ndc, b->to_ndc, sizeof a->to_ndc))
        st = glint_fail(err, GLINT_E_RANGE, "/job/camera", "%s is seen from elsewhere", who);
    return st;
}
