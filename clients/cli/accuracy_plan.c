#include "accuracy_plan.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static const cJSON *member(const cJSON *object, const char *name)
{
    return cJSON_GetObjectItemCaseSensitive(object, name);
}

static const char *text_of(const cJSON *object, const char *name)
{
    const char *text = cJSON_GetStringValue(member(object, name));
    return text ? text : "";
}

static bool is_matte(const cJSON *knob)
{
    return strcmp(text_of(knob, "metric"), "matte") == 0;
}

// ---- jobs

// RFC 7396, without removals.
static void merge(cJSON *into, const cJSON *from)
{
    for (const cJSON *c = from ? from->child : NULL; c; c = c->next) {
        cJSON *known = cJSON_GetObjectItemCaseSensitive(into, c->string);
        if (cJSON_IsObject(c) && cJSON_IsObject(known)) {
            merge(known, c);
            continue;
        }
        cJSON_DeleteItemFromObjectCaseSensitive(into, c->string);
        cJSON_AddItemToObject(into, c->string, cJSON_Duplicate(c, true));
    }
}

static void set_member(cJSON *object, const char *name, const cJSON *value)
{
    cJSON_DeleteItemFromObjectCaseSensitive(object, name);
    cJSON_AddItemToObject(object, name, cJSON_Duplicate(value, true));
}

// Slots hold twice as many candidates as levels are written: all that can be are.
static void set_slots(cJSON *mattes, const cJSON *slots)
{
    cJSON *levels = cJSON_CreateNumber((double)(int)(slots->valuedouble / 2));
    set_member(mattes, "levels", levels);
    cJSON_Delete(levels);
}

static void set_knob(cJSON *job, const cJSON *knob, const cJSON *value)
{
    const char *parent = text_of(knob, "parent"), *name = text_of(knob, "name");
    cJSON *object = *parent ? cJSON_GetObjectItemCaseSensitive(job, parent) : job;
    if (!object)
        object = cJSON_AddObjectToObject(job, parent);
    set_member(object, name, value);
    if (strcmp(name, "slots") == 0)
        set_slots(object, value);
}

static void set_outputs(cJSON *job, bool matte)
{
    cJSON *outputs = cJSON_AddArrayToObject(job, "outputs");
    cJSON_AddItemToArray(outputs, cJSON_CreateString(matte ? "crypto_object" : "beauty"));
}

cJSON *glint_accuracy_twin(const cJSON *capabilities, const cJSON *base, bool matte)
{
    cJSON *job = cJSON_Duplicate(base, true);
    const cJSON *knob;
    set_outputs(job, matte);
    cJSON_ArrayForEach(knob, member(capabilities, "knobs"))
        if (!member(knob, "base") && (matte || !is_matte(knob)))
            set_knob(job, knob, member(knob, "twin"));
    return job;
}

// ---- the list

static struct glint_accuracy_setting *add(struct glint_accuracy_plan *plan)
{
    if (plan->settings == plan->capacity) {
        const size_t more = plan->capacity ? 2 * plan->capacity : 32;
        struct glint_accuracy_setting *grown = realloc(plan->setting, more * sizeof *grown);
        if (!grown)
            return NULL;
        plan->setting = grown;
        plan->capacity = more;
    }
    struct glint_accuracy_setting *s = &plan->setting[plan->settings++];
    *s = (struct glint_accuracy_setting){.twin = false};
    return s;
}

static void print_value(const cJSON *value, char *out)
{
    if (cJSON_IsString(value))
        snprintf(out, GLINT_ACCURACY_VALUE, "%s", value->valuestring);
    else if (cJSON_IsBool(value))
        snprintf(out, GLINT_ACCURACY_VALUE, "%s", cJSON_IsTrue(value) ? "true" : "false");
    else
        snprintf(out, GLINT_ACCURACY_VALUE, "%g", value->valuedouble);
}

static void print_knob(const cJSON *knob, char *out)
{
    const char *parent = text_of(knob, "parent");
    snprintf(out, GLINT_ACCURACY_NAME, "%s%s%s", parent, *parent ? "." : "", text_of(knob, "name"));
}

static bool add_group(struct glint_accuracy_plan *plan, const char *name, bool matte, cJSON *job)
{
    struct glint_accuracy_group *grown =
        realloc(plan->group, (plan->groups + 1) * sizeof *plan->group);
    if (grown)
        plan->group = grown;
    struct glint_accuracy_setting *twin = grown ? add(plan) : NULL;
    if (!twin) {
        cJSON_Delete(job);
        return false;
    }
    struct glint_accuracy_group *group = &grown[plan->groups];
    *group = (struct glint_accuracy_group){.matte = matte, .twin = plan->settings - 1};
    snprintf(group->name, sizeof group->name, "%s", name);
    *twin = (struct glint_accuracy_setting){
        .group = plan->groups++, .twin = true, .unbiased = true, .chosen = !matte, .job = job};
    snprintf(twin->method, sizeof twin->method, "exact");
    snprintf(twin->knob, sizeof twin->knob, "twin");
    snprintf(twin->value, sizeof twin->value, "%.31s", name);
    return true;
}

// The group of that name, made where there is none; (size_t)-1 without memory.
static size_t group_of(struct glint_accuracy_plan *plan, const struct glint_accuracy_wish *wish,
                       const cJSON *knob)
{
    char name[GLINT_ACCURACY_NAME];
    const bool matte = is_matte(knob);
    if (member(knob, "base"))
        print_knob(knob, name);
    else
        snprintf(name, sizeof name, "%s", matte ? "matte" : "colour");
    for (size_t i = 0; i < plan->groups; i++)
        if (strcmp(plan->group[i].name, name) == 0)
            return i;
    cJSON *job = glint_accuracy_twin(wish->capabilities, wish->base, matte);
    merge(job, member(knob, "base"));
    if (member(knob, "base"))
        set_knob(job, knob, member(knob, "exact"));
    return add_group(plan, name, matte, job) ? plan->groups - 1 : (size_t)-1;
}

static bool contains(const cJSON *list, const cJSON *value)
{
    const cJSON *item;
    cJSON_ArrayForEach(item, list)
        if (cJSON_Compare(item, value, true))
            return true;
    return false;
}

static bool add_setting(struct glint_accuracy_plan *plan, const cJSON *knob, const cJSON *value,
                        size_t group)
{
    struct glint_accuracy_setting *s = add(plan);
    if (!s)
        return false;
    *s = (struct glint_accuracy_setting){.group = group};
    s->job = cJSON_Duplicate(plan->setting[plan->group[group].twin].job, true);
    print_knob(knob, s->knob);
    memcpy(s->method, s->knob, sizeof s->method);
    print_value(value, s->value);
    s->unbiased = contains(member(knob, "unbiased"), value) ||
                  cJSON_Compare(member(knob, "exact"), value, true);
    s->other_question = cJSON_IsTrue(member(knob, "other_question"));
    s->chosen = !plan->group[group].matte && !s->other_question;
    merge(s->job, member(knob, "with"));
    set_knob(s->job, knob, value);
    return s->job != NULL;
}

// Every setting but the twin's.
static bool add_knob(struct glint_accuracy_plan *plan, const struct glint_accuracy_wish *wish,
                     const cJSON *knob)
{
    const cJSON *twin = member(knob, "twin"), *exact = member(knob, "exact"), *value;
    const size_t group = group_of(plan, wish, knob);
    bool fine = group != (size_t)-1;
    if (fine && !cJSON_Compare(exact, twin, true))
        fine = add_setting(plan, knob, exact, group);
    cJSON_ArrayForEach(value, member(knob, "approximations"))
        if (fine && !cJSON_Compare(value, twin, true))
            fine = add_setting(plan, knob, value, group);
    return fine;
}

// ---- settings of several knobs at once

// Dials of the picture as the preset has them, and a limit of bounces.
static bool add_joint(struct glint_accuracy_plan *plan, size_t group, const cJSON *preset,
                      unsigned bounces)
{
    struct glint_accuracy_setting *s = add(plan);
    if (!s)
        return false;
    *s = (struct glint_accuracy_setting){.group = group, .joint = true, .chosen = true};
    s->job = cJSON_Duplicate(plan->setting[plan->group[group].twin].job, true);
    snprintf(s->method, sizeof s->method, "joint");
    snprintf(s->knob, sizeof s->knob, "preset+max_bounces");
    snprintf(s->value, sizeof s->value, "%.20s+%u", text_of(preset, "name"), bounces);
    cJSON *dials = cJSON_CreateObject(), *limit = cJSON_CreateNumber(bounces);
    cJSON_AddStringToObject(dials, "preset", text_of(preset, "name"));
    set_member(s->job, "accuracy", dials);
    set_member(s->job, "max_bounces", limit);
    cJSON_Delete(dials);
    cJSON_Delete(limit);
    return s->job != NULL;
}

static bool add_joints(struct glint_accuracy_plan *plan, const struct glint_accuracy_wish *wish)
{
    static const unsigned bounces[] = {2, 3, 5, 8, 16, 128};
    const cJSON *knob, *preset = member(wish->capabilities, "presets");
    size_t group = (size_t)-1;
    cJSON_ArrayForEach(knob, member(wish->capabilities, "knobs"))
        if (group == (size_t)-1 && !is_matte(knob))
            group = group_of(plan, wish, knob);
    bool fine = group != (size_t)-1;
    for (size_t i = 0; i < sizeof bounces / sizeof *bounces && fine && preset; i++)
        fine = add_joint(plan, group, preset->child, bounces[i]);
    return fine;
}

// ---- what the scene calls for

static bool effect_on(const cJSON *plan, const char *name)
{
    const cJSON *effect;
    cJSON_ArrayForEach(effect, member(plan, "effects"))
        if (strcmp(text_of(effect, "effect"), name) == 0)
            return cJSON_IsTrue(member(effect, "on"));
    return false;
}

static bool is_called(const cJSON *plan, const cJSON *knob)
{
    const cJSON *causes = member(knob, "called_for_by"), *cause;
    cJSON_ArrayForEach(cause, causes)
        if (cJSON_IsString(cause) && effect_on(plan, cause->valuestring))
            return true;
    return cJSON_GetArraySize(causes) == 0;
}

static void skip(struct glint_accuracy_plan *plan, const cJSON *knob)
{
    char name[GLINT_ACCURACY_NAME], why[256];
    const cJSON *cause = member(knob, "called_for_by");
    const bool alone = cJSON_GetArraySize(member(knob, "approximations")) == 0;
    print_knob(knob, name);
    snprintf(why, sizeof why,
             alone ? "no approximation of it is built" : "the scene has nothing for \"%.100s\"",
             cause && cause->child ? cause->child->valuestring : "");
    cJSON *o = cJSON_CreateObject();
    cJSON_AddStringToObject(o, "knob", name);
    cJSON_AddStringToObject(o, "why", why);
    cJSON_AddItemToArray(plan->skipped, o);
}

// Whether the comma-separated list has the name, whole or without its parent; NULL has all.
static bool is_wanted(const char *list, const char *knob)
{
    const char *dot = strrchr(knob, '.');
    for (const char *p = list; p; p = strchr(p, ',') ? strchr(p, ',') + 1 : NULL) {
        const size_t n = strcspn(p, ",");
        const char *names[] = {knob, dot ? dot + 1 : knob};
        for (int i = 0; i < 2; i++)
            if (strlen(names[i]) == n && strncmp(names[i], p, n) == 0)
                return true;
    }
    return !list;
}

static bool has_knob(const cJSON *capabilities, const char *name, size_t length)
{
    char one[GLINT_ACCURACY_NAME], full[GLINT_ACCURACY_NAME];
    const cJSON *knob;
    snprintf(one, sizeof one, "%.*s", (int)length, name);
    cJSON_ArrayForEach(knob, member(capabilities, "knobs")) {
        print_knob(knob, full);
        if (is_wanted(one, full))
            return true;
    }
    return strcmp(one, "joint") == 0;
}

// "accuracy.gi, max_bounces, joint", in text of `size` bytes.
static void list_knobs(const cJSON *capabilities, char *text, size_t size)
{
    char full[GLINT_ACCURACY_NAME];
    const cJSON *knob;
    size_t n = 0;
    cJSON_ArrayForEach(knob, member(capabilities, "knobs")) {
        print_knob(knob, full);
        n += (size_t)snprintf(text + n, size - n, "%s, ", full);
        n = n < size ? n : size - 1;
    }
    snprintf(text + n, size - n, "joint");
}

static glint_status check_wanted(const struct glint_accuracy_wish *wish, struct glint_error *err)
{
    glint_status st = GLINT_OK;
    char known[512];
    list_knobs(wish->capabilities, known, sizeof known);
    for (const char *p = wish->wanted; p; p = strchr(p, ',') ? strchr(p, ',') + 1 : NULL) {
        const size_t n = strcspn(p, ",");
        if (!has_knob(wish->capabilities, p, n))
            st = glint_fail(err, GLINT_E_RANGE, "",
                            "--dials: there is no dial \"%.*s\"; there are %s",
                            (int)(n < 40 ? n : 40), p, known);
    }
    return st;
}

glint_status glint_accuracy_plan_make(struct glint_accuracy_plan *out,
                                      const struct glint_accuracy_wish *wish,
                                      struct glint_error *err)
{
    char name[GLINT_ACCURACY_NAME];
    const cJSON *knob;
    *out = (struct glint_accuracy_plan){.skipped = cJSON_CreateArray()};
    const glint_status st = check_wanted(wish, err);
    bool fine = true;
    cJSON_ArrayForEach(knob, member(wish->capabilities, "knobs")) {
        print_knob(knob, name);
        const bool choice = cJSON_GetArraySize(member(knob, "approximations")) > 0;
        if (!is_wanted(wish->wanted, name))
            continue;
        if (choice && is_called(wish->plan, knob))
            fine = fine && add_knob(out, wish, knob);
        else
            skip(out, knob);
    }
    if (fine && is_wanted(wish->wanted, "joint"))
        fine = add_joints(out, wish);
    if (!fine && !st)
        return glint_fail(err, GLINT_E_NOMEM, "", "no memory for the programme");
    return st;
}

void glint_accuracy_plan_finish(struct glint_accuracy_plan *plan)
{
    for (size_t i = 0; i < plan->settings; i++)
        cJSON_Delete(plan->setting[i].job);
    free(plan->setting);
    free(plan->group);
    cJSON_Delete(plan->skipped);
    *plan = (struct glint_accuracy_plan){0};
}
