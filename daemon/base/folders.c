#include "base/folders.h"

#include <errno.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

// Makes every missing folder on the way; false with errno set.
static bool make_path(const char *path)
{
    char *part = strdup(path);
    if (!part)
        return false;
    bool made = true;
    for (char *slash = part + 1; made && (slash = strchr(slash, '/')); slash++) {
        *slash = '\0';
        made = !mkdir(part, 0750) || errno == EEXIST;
        *slash = '/';
    }
    made = made && (!mkdir(part, 0750) || errno == EEXIST) && !access(part, W_OK | X_OK);
    free(part);
    return made;
}

// systemd's folder (the first, if it is a list), or the XDG one; NULL without any. malloc'd.
static char *usual(const char *service, const char *xdg, const char *below_home)
{
    const char *folder = getenv(service), *base = getenv(xdg), *home = getenv("HOME");
    char *path = NULL;
    int printed = -1;
    if (folder && *folder)
        printed = asprintf(&path, "%.*s", (int)strcspn(folder, ":"), folder);
    else if (base && *base == '/')
        printed = asprintf(&path, "%s/glint", base);
    else if (home && *home == '/')
        printed = asprintf(&path, "%s/%s/glint", home, below_home);
    return printed < 0 ? NULL : path;
}

// Takes `path` always.
static glint_status use(char **out, char *path, struct glint_error *err)
{
    *out = NULL;
    if (!path)
        return glint_fail(err, GLINT_E_IO, "", "no folder for state: give --state or set HOME");
    if (make_path(path)) {
        *out = path;
        return GLINT_OK;
    }
    const glint_status st = glint_fail(err, GLINT_E_IO, "", "%s: %s", path, strerror(errno));
    free(path);
    return st;
}

glint_status glint_folder_state(char **out, const char *wanted, struct glint_error *err)
{
    return use(out,
               wanted ? strdup(wanted) : usual("STATE_DIRECTORY", "XDG_STATE_HOME", ".local/state"),
               err);
}

glint_status glint_folder_cache(char **out, const char *state, struct glint_error *err)
{
    char *path = usual("CACHE_DIRECTORY", "XDG_CACHE_HOME", ".cache");
    if (path && !use(out, path, NULL))
        return GLINT_OK;
    return use(out, asprintf(&path, "%s/cache", state) < 0 ? NULL : path, err);
}
