// json_read.c - typed values out of a tree, each with its range.
#include "protocol/json_lists.h"
#include "protocol/nearest.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define MAX_LIST 1024

static const char *kind(const cJSON *value)
{
    switch (value->type & 0xff) {
    case cJSON_False:
    case cJSON_True:
        return "a boolean";
    case cJSON_NULL:
        return "null";
    case cJSON_Number:
        return "a number";
    case cJSON_String:
        return "a string";
    case cJSON_Array:
    case cJSON_Raw:
        return "an array";
    default:
        return "an object";
    }
}

static bool wrong_kind(const struct glint_json *at, const char *expected)
{
    return glint_json_fault(at, "%s is expected, not %s", expected, kind(at->value));
}

// What was probably meant, and "a, b, c", cut where it gets too long.
static const char *list(char out[MAX_LIST], const char *const *names, const char *typed)
{
    const char *nearest = glint_nearest(names, typed);
    size_t n = 0;
    if (nearest)
        n = (size_t)snprintf(out, MAX_LIST, "did you mean \"%s\"? There are: ", nearest);
    else
        n = (size_t)snprintf(out, MAX_LIST, "there are: ");
    for (size_t i = 0; names[i] && n < MAX_LIST; i++)
        n += (size_t)snprintf(out + n, MAX_LIST - n, "%s%s", i ? ", " : "", names[i]);
    return out;
}

static int find(const char *const *names, const char *name)
{
    for (int i = 0; names[i]; i++)
        if (strcmp(names[i], name) == 0)
            return i;
    return -1;
}

bool glint_json_require(const struct glint_json *at)
{
    if (at->value)
        return true;
    if (at->key && at->parent->value && !cJSON_IsObject(at->parent->value))
        return false;
    return glint_json_fault(at, "the member is required");
}

bool glint_json_only(const struct glint_json *at, const char *const *known)
{
    if (!at->value)
        return true;
    if (!cJSON_IsObject(at->value))
        return wrong_kind(at, "an object");
    bool fine = true;
    char text[MAX_LIST];
    for (const cJSON *m = at->value->child; m; m = m->next) {
        if (find(known, m->string) >= 0)
            continue;
        const struct glint_json item = glint_json_item(at, m, 0);
        fine = glint_json_fault(&item, "no member \"%.80s\" exists here; %s", m->string,
                                list(text, known, m->string));
    }
    return fine;
}

bool glint_json_bool(const struct glint_json *at, bool *out)
{
    if (!at->value)
        return true;
    if (!cJSON_IsBool(at->value))
        return wrong_kind(at, "a boolean");
    *out = cJSON_IsTrue(at->value);
    return true;
}

static bool number(const struct glint_json *at, double *out)
{
    if (!cJSON_IsNumber(at->value))
        return wrong_kind(at, "a number");
    *out = at->value->valuedouble;
    return isfinite(*out) || glint_json_fault(at, "the number is too large to be represented");
}

// As few digits as name the same float: 1e-06, not 9.99999997e-07.
static const char *bound(double x, char out[24])
{
    snprintf(out, 24, "%.6g", x);
    if ((float)strtod(out, NULL) != (float)x)
        snprintf(out, 24, "%.9g", x);
    return out;
}

static bool outside(const struct glint_json *at, double x, double low, double high)
{
    char from[24], to[24];
    return glint_json_fault(at, "%.9g is outside of %s to %s", x, bound(low, from),
                            bound(high, to));
}

bool glint_json_double(const struct glint_json *at, double low, double high, double *out)
{
    double x;
    if (!at->value)
        return true;
    if (!number(at, &x))
        return false;
    if (x < low || x > high)
        return outside(at, x, low, high);
    *out = x;
    return true;
}

// Compared as a float: what is stored is what was checked.
bool glint_json_float(const struct glint_json *at, float low, float high, float *out)
{
    double x;
    if (!at->value)
        return true;
    if (!number(at, &x))
        return false;
    const float f = (float)x;
    if (!(f >= low && f <= high))
        return outside(at, x, low, high);
    *out = f;
    return true;
}

static bool integer(const struct glint_json *at, double low, double high, double *out)
{
    double x;
    if (!number(at, &x))
        return false;
    if (x != floor(x))
        return glint_json_fault(at, "an integer is expected, not %.9g", x);
    if (x < low || x > high)
        return glint_json_fault(at, "%.17g is outside of %.0f to %.0f", x, low, high);
    *out = x;
    return true;
}

bool glint_json_uint(const struct glint_json *at, uint32_t low, uint32_t high, uint32_t *out)
{
    double x;
    if (!at->value)
        return true;
    if (!integer(at, low, high, &x))
        return false;
    *out = (uint32_t)x;
    return true;
}

bool glint_json_int(const struct glint_json *at, int32_t low, int32_t high, int32_t *out)
{
    double x;
    if (!at->value)
        return true;
    if (!integer(at, low, high, &x))
        return false;
    *out = (int32_t)x;
    return true;
}

bool glint_json_string(const struct glint_json *at, struct glint_arena *arena, char **out)
{
    if (!at->value)
        return true;
    if (!cJSON_IsString(at->value))
        return wrong_kind(at, "a string");
    if (strlen(at->value->valuestring) > GLINT_MAX_NAME)
        return glint_json_fault(at, "the string has more than %u bytes", GLINT_MAX_NAME);
    char *copy = glint_arena_string(arena, at->value->valuestring);
    if (!copy) {
        glint_fail(at->err, GLINT_E_NOMEM, "", "no memory for a string");
        return false;
    }
    *out = copy;
    return true;
}

bool glint_json_choice(const struct glint_json *at, const char *const *names, int *out)
{
    if (!at->value)
        return true;
    if (!cJSON_IsString(at->value))
        return wrong_kind(at, "a string");
    const int i = find(names, at->value->valuestring);
    char text[MAX_LIST];
    if (i < 0)
        return glint_json_fault(at, "\"%.80s\" does not exist here; %s", at->value->valuestring,
                                list(text, names, at->value->valuestring));
    *out = i;
    return true;
}

bool glint_json_length(const struct glint_json *at, size_t *out)
{
    *out = 0;
    if (!at->value)
        return true;
    if (cJSON_IsRaw(at->value)) {
        *out = (size_t)at->value->valuedouble;
        return true;
    }
    if (!cJSON_IsArray(at->value))
        return wrong_kind(at, "an array");
    for (const cJSON *child = at->value->child; child; child = child->next)
        ++*out;
    return true;
}

// A long list is not searched further once no more faults are kept.
static bool enough(const struct glint_json *at)
{
    if (!at->err || at->err->count < GLINT_MAX_FAULTS)
        return false;
    glint_json_fault(at, "and more");
    return true;
}

static bool counted(const struct glint_json *at, size_t count)
{
    size_t length;
    if (!glint_json_length(at, &length))
        return false;
    return length == count ||
           glint_json_fault(at, "%zu numbers are expected, not %zu", count, length);
}

bool glint_json_floats(const struct glint_json *at, size_t count, float low, float high, float *out)
{
    return !at->value || (counted(at, count) && glint_json_all_floats(at, low, high, out));
}

bool glint_json_all_floats(const struct glint_json *at, float low, float high, float *out)
{
    bool fine = true;
    size_t i = 0;
    struct glint_json_walk walk = glint_json_walk(at->value);
    for (const cJSON *c; !enough(at) && (c = glint_json_next(&walk)); i++) {
        const struct glint_json item = glint_json_item(at, c, i);
        fine &= glint_json_float(&item, low, high, &out[i]);
    }
    return fine;
}

bool glint_json_uints(const struct glint_json *at, size_t count, uint32_t low, uint32_t high,
                      uint32_t *out)
{
    return !at->value || (counted(at, count) && glint_json_all_uints(at, low, high, out));
}

bool glint_json_all_uints(const struct glint_json *at, uint32_t low, uint32_t high, uint32_t *out)
{
    bool fine = true;
    size_t i = 0;
    struct glint_json_walk walk = glint_json_walk(at->value);
    for (const cJSON *c; !enough(at) && (c = glint_json_next(&walk)); i++) {
        const struct glint_json item = glint_json_item(at, c, i);
        fine &= glint_json_uint(&item, low, high, &out[i]);
    }
    return fine;
}
