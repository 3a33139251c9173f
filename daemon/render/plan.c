#include "render/plan.h"

#include "kernels/gk_film.h"
#include "protocol/bias.h"

#include <stdio.h>
#include <string.h>

#define PASSES_ALWAYS                                                              \
    (1u << GLINT_PASS_GENERATE | 1u << GLINT_PASS_TRACE | 1u << GLINT_PASS_SHADE | \
     1u << GLINT_PASS_COMPACT | 1u << GLINT_PASS_COLOUR)

static void add_option(struct glint_plan *plan, const char *define)
{
    const size_t used = strlen(plan->options);
    snprintf(plan->options + used, sizeof plan->options - used, "%s-D%s", used ? " " : "", define);
}

// Whether rows that the dial rules are on, at its setting or at its exact one; without such rows,
// always.
static bool matters(enum glint_dial dial, const struct glint_effect_input *in)
{
    struct glint_job exact = *in->job;
    struct glint_effect_input other = *in;
    bool ruled = false;
    exact.dial[dial] = 0;
    other.job = &exact;
    const uint64_t called = glint_effects_called(in) | glint_effects_called(&other);
    for (size_t i = 0; i < glint_effect_count; i++) {
        if (glint_effect_table[i].dial == dial && called >> i & 1)
            return true;
        ruled |= glint_effect_table[i].dial == dial;
    }
    return !ruled;
}

static uint32_t biases(const struct glint_effect_input *in)
{
    uint32_t all = glint_biases_asked(in->job);
    for (int d = 0; d < GLINT_DIAL_COUNT; d++)
        if (all >> d & 1 && !matters((enum glint_dial)d, in))
            all &= ~(1u << d);
    return all;
}

void glint_plan_make(struct glint_plan *out, const struct glint_effect_input *in, uint64_t force)
{
    memset(out, 0, sizeof *out);
    out->called = glint_effects_called(in);
    out->on = out->called | force;
    out->biases = biases(in);
    out->passes = PASSES_ALWAYS;
    out->film_bytes = GK_PLANES_BASE * 4;
    for (size_t i = 0; i < glint_effect_count; i++) {
        const struct glint_effect *e = &glint_effect_table[i];
        if (!(out->on >> i & 1))
            continue;
        out->passes |= e->passes;
        out->carries |= e->carries;
        if (e->define)
            add_option(out, e->define);
        if (e->film_bytes)
            out->film_bytes += e->film_bytes(in->job, in->facts);
    }
}

bool glint_plan_has(const struct glint_plan *plan, enum glint_pass pass)
{
    return plan->passes >> pass & 1;
}

static double total(const double *seconds)
{
    double sum = 0.0;
    for (int p = 0; p < GLINT_PASSES; p++)
        sum += seconds[p];
    return sum;
}

static double effect_bytes(const struct glint_effect *e, const struct glint_plan_use *use)
{
    double bytes = 0.0;
    if (e->film_bytes)
        bytes = (double)(e->film_bytes(use->job, glint_resident_facts(use->scene)) * use->pixels);
    for (int t = 0; t < GLINT_TABLES; t++)
        if (e->tables >> t & 1)
            bytes += (double)glint_buffer_bytes(glint_resident_table(use->scene, t));
    return bytes;
}

// Seconds of the passes that the effect alone adds, over those of all.
static double effect_share(const struct glint_effect *e, const double *seconds)
{
    double own = 0.0;
    for (int p = 0; p < GLINT_PASSES; p++)
        own += e->passes >> p & 1 ? seconds[p] : 0.0;
    return own / total(seconds);
}

static cJSON *describe_effect(const struct glint_plan *plan, size_t i,
                              const struct glint_plan_use *use)
{
    const struct glint_effect *e = &glint_effect_table[i];
    const bool on = plan->on >> i & 1, called = plan->called >> i & 1;
    char reason[256];
    snprintf(reason, sizeof reason, "%s %s",
             called ? "called for by"
             : on   ? "forced; would be called for by"
                    : "off; would be called for by",
             e->cause);
    cJSON *o = cJSON_CreateObject();
    cJSON_AddStringToObject(o, "effect", e->name);
    cJSON_AddBoolToObject(o, "on", on);
    cJSON_AddStringToObject(o, "reason", reason);
    cJSON_AddStringToObject(o, "source", e->source);
    if (e->define)
        cJSON_AddStringToObject(o, "define", e->define);
    if (e->dial != GLINT_DIAL_COUNT)
        cJSON_AddStringToObject(o, "dial", glint_dial_table[e->dial].name);
    cJSON_AddNumberToObject(o, "bytes", on ? effect_bytes(e, use) : 0.0);
    if (e->passes && total(use->seconds) > 0.0)
        cJSON_AddNumberToObject(o, "share", effect_share(e, use->seconds));
    return o;
}

static cJSON *describe_passes(const struct glint_plan *plan, const double *seconds)
{
    cJSON *passes = cJSON_CreateArray();
    const double all = total(seconds);
    for (int p = 0; p < GLINT_PASSES; p++) {
        if (!glint_plan_has(plan, p))
            continue;
        cJSON *o = cJSON_CreateObject();
        cJSON_AddStringToObject(o, "pass", glint_pass_name[p]);
        cJSON_AddNumberToObject(o, "seconds", seconds[p]);
        cJSON_AddNumberToObject(o, "share", all > 0.0 ? seconds[p] / all : 0.0);
        cJSON_AddItemToArray(passes, o);
    }
    return passes;
}

cJSON *glint_plan_describe(const struct glint_plan *plan, const struct glint_plan_use *use)
{
    cJSON *root = cJSON_CreateObject();
    cJSON *effects = cJSON_AddArrayToObject(root, "effects");
    for (size_t i = 0; i < glint_effect_count; i++)
        cJSON_AddItemToArray(effects, describe_effect(plan, i, use));
    cJSON_AddItemToObject(root, "passes", describe_passes(plan, use->seconds));
    cJSON *dials = cJSON_AddObjectToObject(root, "accuracy");
    for (int d = 0; d < GLINT_DIAL_COUNT; d++)
        cJSON_AddStringToObject(dials, glint_dial_table[d].name,
                                glint_dial_table[d].setting[use->job->dial[d]]);
    cJSON_AddStringToObject(root, "program", plan->options);
    cJSON_AddNumberToObject(root, "film_bytes_per_pixel", (double)plan->film_bytes);
    cJSON_AddNumberToObject(root, "film_bytes", (double)(plan->film_bytes * use->pixels));
    return root;
}
