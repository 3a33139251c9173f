#include "device/ahead.h"

#include "base/log.h"
#include "device/listing.h"

#include <fcntl.h>
#include <libgen.h>
#include <limits.h>
#include <pthread.h>
#include <signal.h>
#include <spawn.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#define MOST_HELPERS 4
#define MAX_LOG 16384

// Of nice, that a helper lets others go first by: in idle time as workers do.
static char idle_steps[] = "5", no_steps[] = "0";

extern char **environ;

struct glint_ahead {
    char *cache, *helper;
    int helpers;             // side by side
    pthread_mutex_t one;     // held while a variant is compiled
    pthread_mutex_t mutex;   // guards what follows
    pid_t pid[MOST_HELPERS]; // 0: none
    char idle_key[65];       // of what is compiled in idle time, or ""
    bool given_up;           // that is
    bool busy;               // nothing more is compiled in idle time
};

// One variant while it is compiled.
struct making {
    const char *key, *options;
    char folder[PATH_MAX];
    char part[MOST_HELPERS][PATH_MAX + 8];
    bool idle;
    int failed, refuser; // helper that could not do its work; that found faults; -1: none
};

static char *beside_program(void)
{
    char path[PATH_MAX], *found = NULL;
    const ssize_t n = readlink("/proc/self/exe", path, sizeof path - 1);
    if (n <= 0)
        return NULL;
    path[n] = 0;
    if (asprintf(&found, "%s/glint-kernels", dirname(path)) < 0)
        return NULL;
    if (!access(found, X_OK))
        return found;
    free(found);
    return NULL;
}

static char *find_helper(const char *wanted)
{
    const char *named = wanted ? wanted : getenv("GLINT_KERNELS");
    char *beside = named ? NULL : beside_program();
    if (beside)
        return beside;
    const char *path = named ? named : GLINT_LIBEXEC "/glint-kernels";
    return access(path, X_OK) ? NULL : strdup(path);
}

static int helpers_of_machine(void)
{
    const long cores = sysconf(_SC_NPROCESSORS_ONLN);
    return cores < 1 ? 1 : cores > MOST_HELPERS ? MOST_HELPERS : (int)cores;
}

glint_status glint_ahead_create(glint_ahead **out, const char *cache, const char *helper,
                                struct glint_error *err)
{
    *out = NULL;
    char *program = cache ? find_helper(helper) : NULL;
    if (!program)
        return GLINT_OK;
    glint_ahead *c = calloc(1, sizeof *c);
    if (c)
        c->cache = strdup(cache);
    if (!c || !c->cache) {
        free(program);
        free(c);
        return glint_fail(err, GLINT_E_NOMEM, "", "no memory for a compiler");
    }
    c->helper = program;
    c->helpers = helpers_of_machine();
    pthread_mutex_init(&c->one, NULL);
    pthread_mutex_init(&c->mutex, NULL);
    *out = c;
    return GLINT_OK;
}

void glint_ahead_destroy(glint_ahead **ahead)
{
    glint_ahead *c = *ahead;
    *ahead = NULL;
    if (!c)
        return;
    pthread_mutex_destroy(&c->one);
    pthread_mutex_destroy(&c->mutex);
    free(c->helper);
    free(c->cache);
    free(c);
}

const char *glint_ahead_cache(const glint_ahead *c)
{
    return c->cache;
}

// ---- one helper

static char no_helper[] = "GLINT_KERNELS=";

// The daemon's own environment but for the cache, and no helper for the helper.
static char **environment_for(const char *part, char *cache_name)
{
    size_t count = 0, kept = 0;
    while (environ[count])
        count++;
    char **all = calloc(count + 3, sizeof *all);
    if (!all)
        return NULL;
    for (size_t i = 0; i < count; i++)
        if (strncmp(environ[i], "POCL_CACHE_DIR=", 15) && strncmp(environ[i], "GLINT_KERNELS=", 14))
            all[kept++] = environ[i];
    sprintf(cache_name, "POCL_CACHE_DIR=%s", part);
    all[kept++] = cache_name;
    all[kept] = no_helper;
    return all;
}

static bool prepare_spawn(posix_spawnattr_t *attributes, posix_spawn_file_actions_t *files,
                          const char *log)
{
    sigset_t none, all;
    sigemptyset(&none);
    sigfillset(&all);
    posix_spawnattr_init(attributes);
    posix_spawn_file_actions_init(files);
    return !posix_spawnattr_setsigmask(attributes, &none) &&
           !posix_spawnattr_setsigdefault(attributes, &all) &&
           !posix_spawnattr_setflags(attributes, POSIX_SPAWN_SETSIGMASK | POSIX_SPAWN_SETSIGDEF) &&
           !posix_spawn_file_actions_addopen(files, 0, "/dev/null", O_RDONLY, 0) &&
           !posix_spawn_file_actions_addopen(files, 1, "/dev/null", O_WRONLY, 0) &&
           !posix_spawn_file_actions_addopen(files, 2, log, O_WRONLY | O_CREAT | O_APPEND, 0600) &&
           !posix_spawn_file_actions_addclosefrom_np(files, 3);
}

// 0 where it cannot be started.
static pid_t spawn(const glint_ahead *c, struct making *m, int index)
{
    char cache[PATH_MAX + 32], log[PATH_MAX + 16];
    char *const arguments[] = {
        c->helper, (char *)m->key, (char *)m->options, m->folder, m->idle ? idle_steps : no_steps,
        NULL};
    posix_spawnattr_t attributes;
    posix_spawn_file_actions_t files;
    pid_t pid = 0;
    snprintf(m->part[index], sizeof m->part[index], "%s/%d", m->folder, index);
    snprintf(log, sizeof log, "%s.log", m->part[index]);
    char **environment =
        mkdir(m->part[index], 0700) ? NULL : environment_for(m->part[index], cache);
    if (!prepare_spawn(&attributes, &files, log) || !environment ||
        posix_spawn(&pid, c->helper, &files, &attributes, arguments, environment))
        pid = 0;
    posix_spawn_file_actions_destroy(&files);
    posix_spawnattr_destroy(&attributes);
    free(environment);
    return pid;
}

// Its number is the kernel's to give away only after `mutex` has taken it from the table.
static int wait_for(glint_ahead *c, int index)
{
    siginfo_t info;
    int status = -1;
    while (waitid(P_PID, (id_t)c->pid[index], &info, WEXITED | WNOWAIT))
        ;
    pthread_mutex_lock(&c->mutex);
    waitpid(c->pid[index], &status, 0);
    c->pid[index] = 0;
    pthread_mutex_unlock(&c->mutex);
    return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
}

// ---- all of them

static bool start(glint_ahead *c, struct making *m)
{
    int started = 0;
    snprintf(m->folder, sizeof m->folder, "%s/making-XXXXXX", c->cache);
    if (!mkdtemp(m->folder))
        return false; // as where nothing can be written at all
    pthread_mutex_lock(&c->mutex);
    for (int i = 0; i < c->helpers && !c->given_up; i++)
        started += (c->pid[i] = spawn(c, m, i)) > 0;
    pthread_mutex_unlock(&c->mutex);
    if (!started)
        glint_folder_remove(m->folder);
    return started > 0;
}

static void finish(glint_ahead *c, struct making *m)
{
    for (int i = 0; i < c->helpers; i++) {
        const int code = c->pid[i] ? wait_for(c, i) : -1;
        if (code == GLINT_AHEAD_REFUSED)
            m->refuser = i;
        else if (code)
            m->failed = i;
    }
}

// What the helper had to say, cut to the buffer.
static const char *complaint(const struct making *m, int index, char text[MAX_LOG])
{
    char path[PATH_MAX + 16];
    snprintf(path, sizeof path, "%s.log", m->part[index]);
    FILE *log = fopen(path, "re");
    text[log ? fread(text, 1, MAX_LOG - 1, log) : 0] = 0;
    if (log)
        fclose(log);
    return text;
}

// All that found faults found the same.
static glint_status conclude(glint_ahead *c, const struct making *m, struct glint_error *err)
{
    char text[MAX_LOG] = "";
    const char *part[MOST_HELPERS];
    for (int i = 0; i < c->helpers; i++)
        part[i] = m->part[i];
    if (m->refuser >= 0)
        return glint_fail(err, GLINT_E_DEVICE, "", "%s", complaint(m, m->refuser, text));
    if (m->failed >= 0)
        glint_log(GLINT_LOG_DEBUG, "cl", NULL, NULL, "variant %.12s is not compiled ahead: %s",
                  m->key, complaint(m, m->failed, text));
    else if (!glint_listing_take(c->cache, m->key, m->options, part, c->helpers))
        glint_log(GLINT_LOG_WARNING, "cl", NULL, NULL, "the kernel cache %s takes nothing",
                  c->cache);
    return GLINT_OK;
}

static glint_status make(glint_ahead *c, struct making *m, struct glint_error *err)
{
    if (!start(c, m)) {
        glint_log(GLINT_LOG_DEBUG, "cl", NULL, NULL, "%s is not started", c->helper);
        return GLINT_OK;
    }
    finish(c, m);
    const glint_status st = conclude(c, m, err);
    glint_folder_remove(m->folder);
    return st;
}

static void give_up(glint_ahead *c, const char *wanted)
{
    pthread_mutex_lock(&c->mutex);
    if (c->idle_key[0] && strcmp(c->idle_key, wanted)) {
        c->given_up = true;
        for (int i = 0; i < c->helpers; i++)
            if (c->pid[i] > 0)
                kill(c->pid[i], SIGKILL);
    }
    pthread_mutex_unlock(&c->mutex);
}

glint_status glint_ahead_compile(glint_ahead *c, const char *key, const char *options,
                                 struct glint_error *err)
{
    struct making m = {.key = key, .options = options, .failed = -1, .refuser = -1};
    glint_status st = GLINT_OK;
    give_up(c, key);
    pthread_mutex_lock(&c->one);
    if (!glint_listing_holds(c->cache, key))
        st = make(c, &m, err);
    pthread_mutex_unlock(&c->one);
    return st;
}

// False: not any more.
static bool begin_idle(glint_ahead *c, const char *key)
{
    pthread_mutex_lock(&c->mutex);
    const bool may = !c->busy;
    snprintf(c->idle_key, sizeof c->idle_key, "%s", may ? key : "");
    c->given_up = false;
    pthread_mutex_unlock(&c->mutex);
    return may;
}

static bool end_idle(glint_ahead *c)
{
    pthread_mutex_lock(&c->mutex);
    const bool whole = !c->given_up;
    c->idle_key[0] = 0;
    c->given_up = false;
    pthread_mutex_unlock(&c->mutex);
    return whole;
}

bool glint_ahead_idle(glint_ahead *c, const char *key, const char *options)
{
    struct making m = {.key = key, .options = options, .idle = true, .failed = -1, .refuser = -1};
    struct glint_error err = {0};
    pthread_mutex_lock(&c->one);
    bool whole = begin_idle(c, key);
    if (whole) {
        if (!glint_listing_holds(c->cache, key) && make(c, &m, &err))
            glint_error_finish(&err);
        whole = end_idle(c);
    }
    pthread_mutex_unlock(&c->one);
    return whole;
}

void glint_ahead_hurry(glint_ahead *c)
{
    pthread_mutex_lock(&c->mutex);
    c->busy = true;
    pthread_mutex_unlock(&c->mutex);
    give_up(c, "");
}
