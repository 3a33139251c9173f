// accuracy_front.c - fronts as JSON, and the choice among their points.
#include "protocol/accuracy_front.h"

#include "protocol/job.h"
#include "protocol/json.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#define MAX_SECONDS 1e3
#define MAX_FIGURE 1e12

// ---- reading

// The settings of a point are read as a job reads them.
static glint_status read_settings(const struct glint_json *at, struct glint_front_point *out)
{
    static const char *const known[] = {"accuracy", "max_bounces", NULL};
    if (!glint_json_require(at) || !glint_json_only(at, known))
        return GLINT_E_RANGE;
    struct glint_error faults = {0};
    struct glint_job *job = NULL;
    cJSON *tree = cJSON_Duplicate(at->value, true);
    cJSON_AddStringToObject(tree, "scene", "front");
    char *text = cJSON_PrintUnformatted(tree);
    glint_status st = text ? glint_job_parse(&job, text, strlen(text), &faults) : GLINT_E_NOMEM;
    if (!st && (job->budget.seconds > 0 || job->budget.error > 0))
        st = GLINT_E_RANGE;
    if (st)
        glint_json_fault(at, "%s: %s", faults.count ? faults.fault[0].pointer : "/accuracy",
                         faults.count ? faults.fault[0].detail : "a front does not choose");
    if (!st) {
        memcpy(out->dial, job->dial, sizeof out->dial);
        out->max_bounces = job->max_bounces;
    }
    glint_job_destroy(&job);
    glint_error_finish(&faults);
    free(text);
    cJSON_Delete(tree);
    return st;
}

static void read_number(const struct glint_json *point, const char *name, double low, double high,
                        double *out)
{
    const struct glint_json at = glint_json_member(point, name);
    glint_json_require(&at);
    glint_json_double(&at, low, high, out);
}

static void read_text(const struct glint_json *at, char *out, size_t size)
{
    const char *text = cJSON_GetStringValue(at->value);
    if (at->value && (!text || strlen(text) >= size))
        glint_json_fault(at, "a text of at most %zu bytes is expected", size - 1);
    else if (text)
        strcpy(out, text);
}

static void read_point(const struct glint_json *at, struct glint_front_point *out)
{
    static const char *const known[] = {"settings", "seconds", "rays", "variance",
                                        "bias",     "spread",  "row",  NULL};
    const struct glint_json settings = glint_json_member(at, "settings");
    const struct glint_json row = glint_json_member(at, "row");
    const struct glint_json spread = glint_json_member(at, "spread");
    glint_json_only(at, known);
    read_settings(&settings, out);
    read_number(at, "seconds", 1e-12, MAX_SECONDS, &out->seconds);
    read_number(at, "rays", 0, MAX_FIGURE, &out->rays);
    read_number(at, "variance", 0, MAX_FIGURE, &out->variance);
    read_number(at, "bias", 0, MAX_FIGURE, &out->bias);
    glint_json_double(&spread, 0, MAX_FIGURE, &out->spread);
    read_text(&row, out->row, sizeof out->row);
}

// What a reader is told of a front; the choice looks at its pixels alone.
static void read_provenance(const struct glint_json *root, struct glint_front *front)
{
    char text[128];
    uint32_t seeds, side[2] = {0, 0};
    const struct glint_json scene = glint_json_member(root, "scene");
    const struct glint_json build = glint_json_member(root, "build");
    const struct glint_json count = glint_json_member(root, "seeds");
    const struct glint_json resolution = glint_json_member(root, "resolution");
    read_text(&scene, text, sizeof text);
    read_text(&build, text, sizeof text);
    glint_json_uint(&count, 1, UINT32_MAX, &seeds);
    if (glint_json_uints(&resolution, 2, 1, UINT16_MAX, side))
        front->pixels = (double)side[0] * side[1];
}

static size_t read_length(const struct glint_json *points)
{
    size_t count = 0;
    if (!glint_json_require(points) || !glint_json_length(points, &count))
        return 0;
    if (count >= 1 && count <= GLINT_MAX_FRONT_POINTS)
        return count;
    glint_json_fault(points, "1 to %d points are expected, not %zu", GLINT_MAX_FRONT_POINTS, count);
    return 0;
}

static void read_points(const struct glint_json *points, struct glint_front *front)
{
    size_t i = 0;
    for (const cJSON *c = points->value->child; c; c = c->next, i++) {
        const struct glint_json item = glint_json_item(points, c, i);
        read_point(&item, &front->point[i]);
    }
    front->points = i;
}

static glint_status read_front(struct glint_front **out, const cJSON *tree, struct glint_error *err)
{
    static const char *const known[] = {"revision", "build",  "resolution", "scene",
                                        "seeds",    "points", NULL};
    const struct glint_json root = glint_json_root(tree, err);
    const struct glint_json points = glint_json_member(&root, "points");
    const struct glint_json revision = glint_json_member(&root, "revision");
    glint_json_only(&root, known);
    const size_t count = read_length(&points);
    struct glint_front *front = calloc(1, sizeof *front + count * sizeof *front->point);
    if (!front)
        return glint_fail(err, GLINT_E_NOMEM, "", "no memory for a front");
    read_text(&revision, front->revision, sizeof front->revision);
    read_provenance(&root, front);
    if (count)
        read_points(&points, front);
    *out = front;
    return GLINT_OK;
}

glint_status glint_front_parse(struct glint_front **out, const char *text, size_t length,
                               struct glint_error *err)
{
    struct glint_error faults = {0};
    cJSON *tree;
    *out = NULL;
    glint_status st = glint_json_parse(&tree, text, length, &glint_json_request, err);
    if (st)
        return st;
    read_front(out, tree, &faults);
    cJSON_Delete(tree);
    st = faults.status;
    for (size_t i = 0; i < faults.count; i++)
        glint_fail(err, st, faults.fault[i].pointer, "%s", faults.fault[i].detail);
    glint_error_finish(&faults);
    if (st) {
        free(*out);
        *out = NULL;
    }
    return st;
}

// ---- choosing

static bool keeps(const struct glint_front_point *p, const struct glint_front_wish *wish)
{
    for (int d = 0; d < GLINT_DIAL_COUNT; d++)
        if (wish->pinned >> d & 1 && p->dial[d] != wish->at->dial[d])
            return false;
    return !(wish->pinned & GLINT_CHOICE_BOUNCES) || p->max_bounces == wish->at->max_bounces;
}

const struct glint_front_point *glint_front_find(const struct glint_front *front,
                                                 const struct glint_front_point *settings)
{
    struct glint_front_wish all = {.pinned = GLINT_CHOICE_BOUNCES, .at = settings};
    for (int d = 0; d < GLINT_DIAL_COUNT; d++)
        all.pinned |= !strcmp(glint_dial_table[d].parent, "accuracy") ? 1u << d : 0;
    for (size_t i = 0; i < front->points; i++)
        if (keeps(&front->point[i], &all))
            return &front->point[i];
    return NULL;
}

// Samples after which the noise of nearly every image is below `room`, a squared error: the root in
// 1/sqrt(n) of variance x^2 (1 + 2 spread x) = room, by Newton from above, where it is convex.
static double samples_for(const struct glint_front_point *p, double spread, double room)
{
    double x = sqrt(room / p->variance);
    for (int i = 0; i < 32; i++) {
        const double value = p->variance * x * x * (1 + 2 * spread * x) - room;
        x -= value / (p->variance * x * (2 + 6 * spread * x));
    }
    return ceil(1 / (x * x));
}

// What the point makes of the wish; false: nothing.
static bool price(const struct glint_front *front, const struct glint_front_wish *wish,
                  struct glint_front_choice *out)
{
    const struct glint_front_point *p = &front->point[out->point];
    const double spread = p->spread * sqrt(fmax(front->pixels / wish->pixels, 1));
    const double each =
        p->seconds * wish->pixels / wish->workers; // seconds for a sample everywhere
    const double room = wish->error * wish->error - p->bias * p->bias;
    if (wish->error > 0 && room <= 0)
        return false;
    out->samples = wish->seconds > 0 ? floor(wish->seconds / each)
                   : p->variance > 0 ? samples_for(p, spread, room)
                                     : 1;
    out->samples = fmin(fmax(out->samples, 1), wish->max_samples);
    out->error = sqrt(p->bias * p->bias + p->variance / out->samples);
    out->seconds = wish->seconds > 0 ? wish->seconds : out->samples * each;
    return true;
}

bool glint_front_choose(const struct glint_front *front, const struct glint_front_wish *wish,
                        struct glint_front_choice *out)
{
    bool found = false;
    for (size_t i = 0; i < front->points; i++) {
        struct glint_front_choice c = {.point = i};
        if (!keeps(&front->point[i], wish) || !price(front, wish, &c))
            continue;
        if (!found || (wish->seconds > 0 ? c.error < out->error : c.seconds < out->seconds))
            *out = c;
        found = true;
    }
    return found;
}
