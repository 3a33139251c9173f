#include "jobs/invariants.h"

#include "jobs/warn.h"

#include <inttypes.h>

// Coverage that weights above one were cut by: more than this share is worth a warning.
#define CLAMPED_SHARE 1e-4

void glint_invariants_add(cJSON *object, const struct glint_render_state *r)
{
    cJSON *o = cJSON_AddObjectToObject(object, "invariants");
    cJSON_AddBoolToObject(o, "sound", glint_counts_sound(r->count, r->camera_rays));
    cJSON *rejected = cJSON_AddObjectToObject(o, "rejected");
    for (int i = 0; i < GLINT_REJECTIONS; i++)
        cJSON_AddNumberToObject(rejected, glint_count_name[i], (double)r->count[i]);
    cJSON_AddNumberToObject(o, "bright", (double)r->count[GLINT_COUNT_BRIGHT]);
    for (int i = GLINT_COUNT_CLAMPED; i <= GLINT_COUNT_LOST; i++)
        cJSON_AddNumberToObject(o, glint_count_name[i],
                                glint_counts_share(r->count, i, r->camera_rays));
}

void glint_invariants_warn(cJSON *warnings, const struct glint_render_state *r)
{
    const uint64_t *n = r->count;
    const double clamped = glint_counts_share(n, GLINT_COUNT_CLAMPED, r->camera_rays);
    if (!glint_counts_sound(n, r->camera_rays))
        glint_warn(warnings,
                   "%" PRIu64 " of %" PRIu64 " samples were rejected and count as black: %" PRIu64
                   " are no number, %" PRIu64 " infinite, %" PRIu64 " negative, %" PRIu64
                   " in too many nested solids",
                   glint_counts_rejected(n), r->camera_rays, n[GLINT_COUNT_NAN],
                   n[GLINT_COUNT_INFINITE], n[GLINT_COUNT_NEGATIVE], n[GLINT_COUNT_NESTED]);
    if (clamped > CLAMPED_SHARE)
        glint_warn(warnings,
                   "%.2g of the coverage that bounces carry was cut from weights above one",
                   clamped);
}

void glint_invariants_ranks(cJSON *object, const struct glint_matte_excess *x)
{
    if (!x->needed)
        return;
    cJSON *o = cJSON_AddObjectToObject(object, "ranks");
    cJSON_AddNumberToObject(o, "pixels", (double)x->pixels);
    cJSON_AddNumberToObject(o, "left_out", x->left_out);
    cJSON_AddNumberToObject(o, "needed", x->needed);
}

void glint_invariants_warn_of_ranks(cJSON *warnings, const struct glint_matte_excess *x,
                                    const struct glint_job *job)
{
    char text[256];
    if (glint_matte_excess_tell(x, job, text))
        glint_warn(warnings, "%s", text);
}
