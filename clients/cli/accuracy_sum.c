// accuracy_sum.c - settings summed up over their seeds.
#include "accuracy_report.h"

#include "accuracy_mean.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static unsigned most_samples(const struct glint_accuracy_run *run)
{
    return run->ladder[run->steps - 1];
}

static const struct glint_accuracy_setting *twin_of(const struct glint_accuracy_run *run,
                                                    const struct glint_accuracy_setting *s)
{
    return &run->plan->setting[run->plan->group[s->group].twin];
}

static struct glint_accuracy_row key_of(const struct glint_accuracy_setting *s, unsigned spp)
{
    struct glint_accuracy_row key = {.spp = spp};
    memcpy(key.knob, s->knob, sizeof key.knob);
    memcpy(key.value, s->value, sizeof key.value);
    return key;
}

static glint_status spread(struct glint_accuracy_sum *out, const struct glint_accuracy_run *run,
                           struct glint_error *err)
{
    const struct glint_accuracy_reference *reference = &run->reference[out->setting->group];
    struct glint_accuracy_mean mean;
    char name[160];
    glint_accuracy_mean_name(run, out->setting, name);
    const glint_status st =
        glint_accuracy_mean_load(&mean, run->folder, name, &reference->mean, err);
    if (st)
        return st;
    glint_accuracy_spread(&out->spread, &mean.mean, &mean.squares, glint_accuracy_mean_count(&mean),
                          reference);
    glint_accuracy_mean_finish(&mean);
    return GLINT_OK;
}

static void measure(struct glint_accuracy_sum *out, const struct glint_accuracy_run *run)
{
    const struct glint_accuracy_setting *s = out->setting;
    const struct glint_accuracy_row own = key_of(s, most_samples(run));
    const struct glint_accuracy_row twin = key_of(twin_of(run, s), most_samples(run));
    for (size_t i = 0; i < run->steps; i++)
        glint_accuracy_point_of(&out->point[i], &run->table, s->knob, s->value, run->ladder[i]);
    for (int c = 0; c < GLINT_COSTS; c++)
        if (!glint_accuracy_ratio(&out->ratio[c], &run->table, &own, &twin,
                                  (enum glint_accuracy_cost)c))
            out->ratio[c] = (struct glint_accuracy_interval){NAN, NAN, NAN};
}

// Where the twin with samples for the same cost is better, by more than the intervals of both error
// and cost. What asks for another picture does not lose.
static void find_failure(struct glint_accuracy_sum *out, const struct glint_accuracy_run *run,
                         const struct glint_accuracy_sum *twin, enum glint_accuracy_cost c)
{
    out->loses[c] = out->by[c] = NAN;
    const bool loses = out != twin && !out->setting->other_question;
    for (size_t i = 0; i < run->steps && loses; i++) {
        const struct glint_accuracy_point *p = &out->point[i];
        const double cost = twin->point[i].cost[c] * out->ratio[c].low;
        const double exact = glint_accuracy_error_at(twin->point, run->steps, c, cost);
        if (!(p->error.low > exact))
            continue;
        out->loses[c] = fmin(p->spp, isnan(out->loses[c]) ? p->spp : out->loses[c]);
        out->by[c] = p->error.middle / exact;
    }
}

glint_status glint_accuracy_sum_up(struct glint_accuracy_sum **out,
                                   const struct glint_accuracy_run *run, struct glint_error *err)
{
    const struct glint_accuracy_plan *plan = run->plan;
    struct glint_accuracy_sum *sum = calloc(plan->settings, sizeof *sum);
    *out = sum;
    if (!sum)
        return glint_fail(err, GLINT_E_NOMEM, "", "no memory for a report");
    glint_status st = GLINT_OK;
    for (size_t i = 0; i < plan->settings && !st; i++) {
        sum[i].setting = &plan->setting[i];
        measure(&sum[i], run);
        st = spread(&sum[i], run, err);
    }
    for (size_t i = 0; i < plan->settings && !st; i++)
        for (int c = 0; c < GLINT_COSTS; c++)
            find_failure(&sum[i], run, &sum[plan->group[plan->setting[i].group].twin],
                         (enum glint_accuracy_cost)c);
    return st;
}

// ---- rows of means

static bool is_mean(void *user, const struct glint_accuracy_row *row)
{
    (void)user;
    return strcmp(row->seed, "all") == 0;
}

// Mean of a figure over the seeds, NAN where any has none.
static double mean_of(const struct glint_accuracy_run *run, const struct glint_accuracy_row *key,
                      size_t offset)
{
    double sum = 0;
    size_t n = 0;
    for (size_t i = 0; i < run->table.rows; i++) {
        const struct glint_accuracy_row *r = &run->table.row[i];
        if (r->spp != key->spp || is_mean(NULL, r) || strcmp(r->value, key->value) ||
            strcmp(r->knob, key->knob))
            continue;
        sum += *(const double *)((const char *)r + offset);
        n++;
    }
    return n ? sum / (double)n : NAN;
}

static void fill_means(struct glint_accuracy_row *row, const struct glint_accuracy_run *run,
                       const struct glint_accuracy_row *key)
{
    static const size_t figures[] = {
        offsetof(struct glint_accuracy_row, rays[0]),
        offsetof(struct glint_accuracy_row, rays[1]),
        offsetof(struct glint_accuracy_row, rays[2]),
        offsetof(struct glint_accuracy_row, cpu),
        offsetof(struct glint_accuracy_row, wall),
        offsetof(struct glint_accuracy_row, rmse61),
        offsetof(struct glint_accuracy_row, relmse),
        offsetof(struct glint_accuracy_row, relmse_trim),
        offsetof(struct glint_accuracy_row, matte_mae),
        offsetof(struct glint_accuracy_row, tv),
        offsetof(struct glint_accuracy_row, est_error),
        offsetof(struct glint_accuracy_row, matte_max),
        offsetof(struct glint_accuracy_row, lost),
        offsetof(struct glint_accuracy_row, within),
    };
    for (size_t i = 0; i < sizeof figures / sizeof *figures; i++)
        *(double *)((char *)row + figures[i]) = mean_of(run, key, figures[i]);
}

static double signed_root(double square)
{
    return square < 0 ? -sqrt(-square) : sqrt(square);
}

glint_status glint_accuracy_add_means(struct glint_accuracy_run *run,
                                      const struct glint_accuracy_sum *sum, struct glint_error *err)
{
    glint_accuracy_table_drop(&run->table, is_mean, NULL);
    for (size_t i = 0; i < run->plan->settings; i++) {
        const struct glint_accuracy_setting *s = sum[i].setting;
        const struct glint_accuracy_row key = key_of(s, most_samples(run));
        struct glint_accuracy_row *row = glint_accuracy_table_add(&run->table);
        if (!row)
            return glint_fail(err, GLINT_E_NOMEM, "", "no memory for a row");
        fill_means(row, run, &key);
        memcpy(row->knob, key.knob, sizeof row->knob);
        memcpy(row->value, key.value, sizeof row->value);
        memcpy(row->method, s->method, sizeof row->method);
        snprintf(row->scene, sizeof row->scene, "%s", run->scene);
        snprintf(row->build, sizeof row->build, "%s", run->build);
        snprintf(row->ref_id, sizeof row->ref_id, "%s:2x%u%s", run->plan->group[s->group].name,
                 run->reference_samples, sum[i].point[run->steps - 1].limited ? ":limited" : "");
        strcpy(row->seed, "all");
        row->spp = key.spp;
        row->threads = run->threads;
        row->bias = signed_root(sum[i].spread.bias2);
        row->sd = sqrt(sum[i].spread.variance);
    }
    return GLINT_OK;
}

// ---- the front

static cJSON *settings_of(const struct glint_accuracy_setting *s)
{
    cJSON *settings = cJSON_CreateObject();
    static const char *const parts[] = {"accuracy", "max_bounces"};
    for (size_t i = 0; i < 2; i++) {
        const cJSON *part = cJSON_GetObjectItemCaseSensitive(s->job, parts[i]);
        if (part)
            cJSON_AddItemToObject(settings, parts[i], cJSON_Duplicate(part, true));
    }
    return settings;
}

// Upper end of a one-sided 95% interval; none where the table of dials says that there is no bias.
static double bias_bound(const struct glint_accuracy_sum *sum)
{
    if (sum->setting->unbiased)
        return 0;
    return sqrt(fmax(sum->spread.bias2 + 1.645 * sum->spread.bias2_se, 0));
}

// Standard deviation of the squared error over the seeds, over its mean: what one image may differ.
static double spread_of(const struct glint_accuracy_run *run,
                        const struct glint_accuracy_setting *s)
{
    double sum = 0, squares = 0;
    unsigned n = 0;
    for (size_t i = 0; i < run->table.rows; i++) {
        const struct glint_accuracy_row *r = &run->table.row[i];
        if (r->spp != most_samples(run) || is_mean(NULL, r) || strcmp(r->value, s->value) ||
            strcmp(r->knob, s->knob))
            continue;
        sum += r->relmse;
        squares += r->relmse * r->relmse;
        n++;
    }
    const double mean = sum / fmax(n, 1);
    return n > 1 && mean > 0 ? sqrt(fmax(squares / n - mean * mean, 0) * n / (n - 1)) / mean : 0;
}

static cJSON *front_point(const struct glint_accuracy_run *run,
                          const struct glint_accuracy_sum *sum)
{
    const struct glint_accuracy_point *p = &sum->point[run->steps - 1];
    const double samples = (double)run->width * run->height * p->spp;
    char row[128];
    snprintf(row, sizeof row, "%.60s=%.30s,seed=all,spp=%u", sum->setting->knob,
             sum->setting->value, p->spp);
    cJSON *o = cJSON_CreateObject();
    cJSON_AddItemToObject(o, "settings", settings_of(sum->setting));
    cJSON_AddNumberToObject(o, "seconds", fmax(p->cost[GLINT_COST_CPU] / samples, 1e-12));
    cJSON_AddNumberToObject(o, "rays", p->cost[GLINT_COST_RAYS] / samples);
    cJSON_AddNumberToObject(o, "variance", sum->spread.variance * p->spp);
    cJSON_AddNumberToObject(o, "bias", bias_bound(sum));
    cJSON_AddNumberToObject(o, "spread", spread_of(run, sum->setting) * sqrt(p->spp));
    cJSON_AddStringToObject(o, "row", row);
    return o;
}

cJSON *glint_accuracy_front(const struct glint_accuracy_run *run,
                            const struct glint_accuracy_sum *sum, const char *revision)
{
    cJSON *front = cJSON_CreateObject(), *size = cJSON_CreateArray();
    cJSON_AddStringToObject(front, "scene", run->scene);
    cJSON_AddStringToObject(front, "revision", revision);
    cJSON_AddStringToObject(front, "build", run->build);
    cJSON_AddItemToArray(size, cJSON_CreateNumber(run->width));
    cJSON_AddItemToArray(size, cJSON_CreateNumber(run->height));
    cJSON_AddItemToObject(front, "resolution", size);
    cJSON_AddNumberToObject(front, "seeds", run->seeds);
    cJSON *points = cJSON_AddArrayToObject(front, "points");
    for (size_t i = 0; i < run->plan->settings; i++)
        if (sum[i].setting->chosen)
            cJSON_AddItemToArray(points, front_point(run, &sum[i]));
    return front;
}
