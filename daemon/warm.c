#include "warm.h"

#include "base/thread.h"
#include "render/common.h"

#include <stdlib.h>
#include <string.h>

struct glint_warm {
    glint_devices *devices;
    pthread_t thread;
};

// Whoever starts daemons one after the other, as tests do, wants none of it.
static bool is_wanted(void)
{
    const char *wish = getenv("GLINT_FORESEE");
    return !wish || strcmp(wish, "no");
}

static void *run(void *arg)
{
    const glint_warm *w = arg;
    char options[GLINT_COMMON_OPTIONS];
    glint_program_recall(w->devices);
    bool idle = is_wanted() && glint_program_foresee_known(w->devices);
    for (size_t i = 0; idle && i < glint_common_variant(i, options); i++)
        idle = glint_program_foresee(w->devices, options);
    return NULL;
}

glint_status glint_warm_start(glint_warm **out, glint_devices *devices, struct glint_error *err)
{
    *out = malloc(sizeof **out);
    if (!*out)
        return glint_fail(err, GLINT_E_NOMEM, "", "no memory to foresee anything");
    (*out)->devices = devices;
    const glint_status st = glint_thread_start(&(*out)->thread, "warm", run, *out, err);
    if (st) {
        free(*out);
        *out = NULL;
    }
    return st;
}

void glint_warm_destroy(glint_warm **warm)
{
    glint_warm *w = *warm;
    *warm = NULL;
    if (!w)
        return;
    glint_devices_hurry(w->devices);
    pthread_join(w->thread, NULL);
    free(w);
}
