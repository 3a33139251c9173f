#include "outlook.h"
#include "problem.h"
#include "progress.h"

#include <math.h>
#include <stdio.h>

static const cJSON *member(const cJSON *object, const char *name)
{
    return cJSON_GetObjectItemCaseSensitive(object, name);
}

static double number(const cJSON *object, const char *name)
{
    return cJSON_GetNumberValue(member(object, name)); // NAN for what is none
}

static double end(const cJSON *object, const char *name, int which)
{
    return cJSON_GetNumberValue(cJSON_GetArrayItem(member(object, name), which));
}

static void print_error(const cJSON *e)
{
    const double low = end(e, "interval", 0), high = end(e, "interval", 1);
    if (isnan(low) || isnan(high))
        return;
    printf("error between: %.4g and %.4g\n", low, high);
    printf("tone-mapped: %.4g\n", number(e, "tone_mapped"));
    if (cJSON_IsTrue(member(e, "rare_events")))
        puts("noise: dominated by rare events; the error may be larger");
}

static void print_biases(const cJSON *biases)
{
    const cJSON *b;
    cJSON_ArrayForEach(b, biases) {
        const char *name = cJSON_GetStringValue(member(b, "name"));
        const char *setting = cJSON_GetStringValue(member(b, "setting"));
        fputs(b == biases->child ? "not in the error: " : ", ", stdout);
        glint_print_plain(stdout, name ? name : "?");
        putchar(' ');
        glint_print_plain(stdout, setting ? setting : "?");
    }
    if (biases && biases->child)
        putchar('\n');
}

static void print_known(const cJSON *e)
{
    const double known = number(e, "known_bias"), error = number(e, "error");
    if (!isnan(known))
        printf("known bias: %.4g, with the error %.4g\n", known, hypot(known, error));
}

static void print_forecast(const cJSON *f)
{
    char text[24];
    const double samples = number(f, "samples"), seconds = number(f, "seconds");
    if (isnan(samples) && cJSON_IsFalse(member(f, "reachable")))
        printf("forecast: %.4g is unreachable with these settings\n", number(f, "error"));
    if (isnan(samples))
        return;
    printf("forecast: %.4g at %.0f samples", number(f, "error"), samples);
    if (cJSON_IsTrue(member(f, "lower_bound")))
        printf(" or more");
    else
        printf(" (%.0f to %.0f)", end(f, "interval", 0), end(f, "interval", 1));
    if (!isnan(seconds))
        printf(", in %s", glint_progress_duration(seconds, text));
    puts(cJSON_IsFalse(member(f, "reachable")) ? "; unreachable with these settings" : "");
}

void glint_outlook_print(const cJSON *estimate)
{
    print_error(estimate);
    print_biases(member(estimate, "biases"));
    print_known(estimate);
    print_forecast(member(estimate, "forecast"));
}

void glint_outlook_short(const cJSON *estimate, char *text, size_t size)
{
    const cJSON *f = member(estimate, "forecast");
    const double samples = number(f, "samples");
    const char *more = cJSON_IsTrue(member(f, "lower_bound")) ? "+" : "";
    *text = 0;
    if (cJSON_IsFalse(member(f, "reachable")))
        snprintf(text, size, "%.4g unreachable", number(f, "error"));
    else if (!isnan(samples))
        snprintf(text, size, "%.4g at %.0f%s", number(f, "error"), samples, more);
}
