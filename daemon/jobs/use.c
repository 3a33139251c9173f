#include "jobs/use.h"

#include <math.h>
#include <string.h>

#define LATE_SECONDS 1.0 // what was so long ago counts a third of what is now
#define LEAST_SHARE 1e-6 // less is shown as none: shares fade for ever, to 1e-158 and beyond

// The share at `now`: what it does it has done since it was seen last.
static double share_at(const struct glint_use *use, double now)
{
    const double past = exp(-fmax(now - use->seen, 0) / LATE_SECONDS);
    return use->share * past + (*use->job ? 1 - past : 0);
}

void glint_use_set(struct glint_use *use, const char *job, double now)
{
    use->share = share_at(use, now);
    use->seen = now;
    strcpy(use->job, job ? job : "");
}

void glint_use_add(struct glint_use *use, double seconds)
{
    use->seconds += seconds;
}

struct glint_worker_use glint_use_look(const struct glint_use *use, double now)
{
    const double share = share_at(use, now);
    struct glint_worker_use out = {.busy_seconds = use->seconds,
                                   .share = share < LEAST_SHARE ? 0 : share};
    strcpy(out.job, use->job);
    return out;
}
