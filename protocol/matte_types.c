#include "protocol/matte_types.h"

#include <stdio.h>
#include <string.h>

static const char *const layer_name[GLINT_MATTE_LAYERS] = {"Object", "Material", "Asset"};
static const char *const layer_type[GLINT_MATTE_LAYERS] = {"CryptoObject", "CryptoMaterial",
                                                           "CryptoAsset"};
static const uint32_t layer_output[GLINT_MATTE_LAYERS] = {
    GLINT_OUT_CRYPTO_OBJECT, GLINT_OUT_CRYPTO_MATERIAL, GLINT_OUT_CRYPTO_ASSET};

const char *glint_matte_layer_type(enum glint_matte_layer layer)
{
    return layer_type[layer];
}

uint32_t glint_matte_classes(const struct glint_job *job)
{
    if (job->dial[GLINT_DIAL_THROUGH] == GLINT_THROUGH_NONE)
        return 0;
    return job->matte_depth_bins ? job->matte_depth_bins : job->matte_classes ? 2 : 1;
}

uint32_t glint_matte_slots(const struct glint_job *job, uint32_t mattes)
{
    return job->dial[GLINT_DIAL_EVICTION] == GLINT_EVICTION_EXACT
               ? mattes * (glint_matte_classes(job) + 1)
               : job->matte_slots;
}

uint32_t glint_matte_rows(const struct glint_job *job)
{
    const bool full = job->dial[GLINT_DIAL_COVERAGE] != 0;
    return full && job->dial[GLINT_DIAL_PATH_IDS] == GLINT_PATH_IDS_LIST ? job->max_bounces + 3 : 0;
}

glint_status glint_matte_check(const struct glint_job *job, uint32_t mattes, const char *pointer,
                               struct glint_error *err)
{
    const uint32_t slots = glint_matte_slots(job, mattes);
    return slots <= GLINT_MAX_EXACT_SLOTS
               ? GLINT_OK
               : glint_fail(err, GLINT_E_RANGE, pointer,
                            "exact keeps %u names in %u classes: %u slots a pixel are more than %u",
                            mattes, glint_matte_classes(job) + 1, slots, GLINT_MAX_EXACT_SLOTS);
}

static const char *const class_name[] = {"primary", "glossy", "reflection", "refraction", "depth0",
                                         "depth1",  "depth2", "depth3",     "depth4",     "depth5",
                                         "depth6",  "depth7", "depth8",     "depth9"};
enum { GLOSSY = 1, REFLECTION = 2, DEPTH = 4 };

const char *glint_matte_class_name(const struct glint_job *job, uint32_t c)
{
    if (c == 0 || c > glint_matte_classes(job))
        return c ? NULL : class_name[0];
    const uint32_t first = job->matte_depth_bins ? DEPTH : job->matte_classes ? REFLECTION : GLOSSY;
    return class_name[first + c - 1];
}

bool glint_matte_class_exists(const char *name, size_t length)
{
    for (size_t i = 0; i < sizeof class_name / sizeof *class_name; i++)
        if (strlen(class_name[i]) == length && !strncmp(class_name[i], name, length))
            return true;
    return false;
}

static void name_type(const struct glint_job *job, struct glint_matte_type *t)
{
    const char *layer = layer_name[t->layer];
    if (t->class_of_it == 0)
        snprintf(t->name, sizeof t->name, "Crypto%s", layer);
    else if (job->matte_depth_bins)
        snprintf(t->name, sizeof t->name, "CryptoD%u%s", t->class_of_it - 1, layer);
    else
        snprintf(t->name, sizeof t->name, "Crypto%s%s",
                 !job->matte_classes   ? "Gloss"
                 : t->class_of_it == 1 ? "Refl"
                                       : "Refr",
                 layer);
}

size_t glint_matte_types(const struct glint_job *job, uint32_t outputs,
                         struct glint_matte_type out[GLINT_MAX_MATTE_TYPES])
{
    size_t n = 0;
    for (uint32_t c = 0; c <= glint_matte_classes(job); c++)
        for (int l = 0; l < GLINT_MATTE_LAYERS; l++) {
            if (!(outputs & layer_output[l]))
                continue;
            out[n].layer = (enum glint_matte_layer)l;
            out[n].class_of_it = c;
            name_type(job, &out[n++]);
        }
    return n;
}
