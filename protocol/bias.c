#include "protocol/bias.h"

#include <stdio.h>
#include <string.h>

#define BOUNCES "max_bounces"

static bool is_of_mattes(int dial)
{
    return strcmp(glint_dial_table[dial].parent, "mattes") == 0;
}

uint32_t glint_biases_asked(const struct glint_job *job)
{
    uint32_t asked = job->dial[GLINT_DIAL_GI] == 0 ? GLINT_BIAS_BOUNCES : 0;
    for (int d = 0; d < GLINT_DIAL_COUNT; d++)
        if (!(glint_dial_table[d].unbiased >> job->dial[d] & 1) &&
            (!is_of_mattes(d) || job->outputs & GLINT_OUT_CRYPTO))
            asked |= 1u << d;
    return asked;
}

uint32_t glint_biases_of_picture(uint32_t biases)
{
    for (int d = 0; d < GLINT_DIAL_COUNT; d++)
        biases &= is_of_mattes(d) ? ~(1u << d) : ~0u;
    return biases;
}

static const char *name_of(int bit, char text[64])
{
    if (bit == GLINT_DIAL_COUNT)
        return BOUNCES;
    snprintf(text, 64, "%s.%s", glint_dial_table[bit].parent, glint_dial_table[bit].name);
    return text;
}

static cJSON *describe_bounces(const struct glint_job *job)
{
    char setting[16];
    snprintf(setting, sizeof setting, "%u", job->max_bounces);
    cJSON *o = cJSON_CreateObject();
    cJSON_AddStringToObject(o, "name", BOUNCES);
    cJSON_AddStringToObject(o, "setting", setting);
    cJSON_AddStringToObject(o, "of", "picture");
    cJSON_AddStringToObject(o, "detail", "light that needs more bounces is lost");
    return o;
}

static cJSON *describe_dial(int dial, const struct glint_job *job)
{
    char name[64];
    const struct glint_dial_row *row = &glint_dial_table[dial];
    cJSON *o = cJSON_CreateObject();
    cJSON_AddStringToObject(o, "name", name_of(dial, name));
    cJSON_AddStringToObject(o, "setting", row->setting[job->dial[dial]]);
    cJSON_AddStringToObject(o, "of", is_of_mattes(dial) ? "mattes" : "picture");
    cJSON_AddStringToObject(o, "detail", row->source);
    return o;
}

cJSON *glint_biases_describe(uint32_t biases, const struct glint_job *job)
{
    cJSON *list = cJSON_CreateArray();
    for (int d = 0; d < GLINT_DIAL_COUNT; d++)
        if (biases >> d & 1)
            cJSON_AddItemToArray(list, describe_dial(d, job));
    if (biases & GLINT_BIAS_BOUNCES)
        cJSON_AddItemToArray(list, describe_bounces(job));
    return list;
}

cJSON *glint_biases_names(uint32_t biases)
{
    char name[64];
    cJSON *list = cJSON_CreateArray();
    for (int bit = 0; bit <= GLINT_DIAL_COUNT; bit++)
        if (biases >> bit & 1)
            cJSON_AddItemToArray(list, cJSON_CreateString(name_of(bit, name)));
    return list;
}

uint32_t glint_biases_named(const cJSON *names)
{
    uint32_t biases = 0;
    char name[64];
    const cJSON *item;
    cJSON_ArrayForEach(item, names) {
        for (int bit = 0; cJSON_IsString(item) && bit <= GLINT_DIAL_COUNT; bit++)
            if (strcmp(item->valuestring, name_of(bit, name)) == 0)
                biases |= 1u << bit;
    }
    return biases;
}
