#include "base/keeper.h"

#include "base/storage.h"

#include <errno.h>
#include <fcntl.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

struct glint_keeper {
    char *folder, *films;
    int lock;
    glint_journal *journal;
    glint_vault *vault;
    glint_metrics *metrics;
    glint_metric *bytes;
};

static const double commit_bounds[] = {0.001, 0.002, 0.005, 0.01, 0.02, 0.05, 0.1, 0.5, 2};

static glint_status in_use(const glint_keeper *k, struct glint_error *err)
{
    char owner[24] = "";
    const ssize_t n = pread(k->lock, owner, sizeof owner - 1, 0);
    owner[n > 0 ? n : 0] = '\0';
    return glint_fail(err, GLINT_E_CONFLICT, "", "%s is in use by another glintd%s%.*s", k->folder,
                      *owner ? ", process " : "", (int)strcspn(owner, "\n"), owner);
}

// The lock goes with the process, however that ends.
static glint_status take_lock(glint_keeper *k, struct glint_error *err)
{
    char path[4096], owner[24];
    snprintf(path, sizeof path, "%s/lock", k->folder);
    k->lock = open(path, O_RDWR | O_CREAT | O_CLOEXEC, 0640);
    if (k->lock < 0)
        return glint_storage_fault(err, k->folder, "its lock", errno);
    if (flock(k->lock, LOCK_EX | LOCK_NB))
        return errno == EWOULDBLOCK ? in_use(k, err)
                                    : glint_storage_fault(err, k->folder, "its lock", errno);
    const int length = snprintf(owner, sizeof owner, "%ld\n", (long)getpid());
    // Only a hint for people: whether it can be written is found out by the journal.
    if (!ftruncate(k->lock, 0) && pwrite(k->lock, owner, (size_t)length, 0) != length)
        return glint_storage_fault(err, k->folder, "its lock", errno);
    return GLINT_OK;
}

static void refresh(void *user)
{
    const glint_keeper *k = user;
    glint_metric_set(k->bytes,
                     (double)(glint_journal_bytes(k->journal) + glint_vault_bytes(k->vault)));
}

static void name_metrics(glint_keeper *k)
{
    const struct glint_label label = {"kind", "scenes"};
    k->bytes =
        glint_metrics_gauge(k->metrics, "state_bytes", "Bytes in the state folder.", &label, 1);
    glint_metrics_on_read(k->metrics, refresh, k);
}

static glint_status open_parts(glint_keeper *k, struct glint_error *err)
{
    char assets[4096];
    glint_metric *commits =
        k->metrics ? glint_metrics_histogram(k->metrics, "journal_commit_seconds",
                                             "Time of one commit of the journal.", commit_bounds,
                                             sizeof commit_bounds / sizeof *commit_bounds, NULL, 0)
                   : NULL;
    glint_status st = glint_journal_create(&k->journal, k->folder, commits, err);
    snprintf(assets, sizeof assets, "%s/assets", k->folder);
    if (!st)
        st = glint_vault_create(&k->vault, assets, err);
    if (!st && mkdir(k->films, 0750) && errno != EEXIST)
        st = glint_storage_fault(err, k->films, "cannot be made", errno);
    if (!st && k->metrics)
        name_metrics(k);
    return st;
}

glint_status glint_keeper_create(glint_keeper **out, const char *folder, glint_metrics *metrics,
                                 struct glint_error *err)
{
    glint_keeper *k = *out = calloc(1, sizeof *k);
    if (!k)
        return glint_fail(err, GLINT_E_NOMEM, "", "no memory for the keeper");
    k->lock = -1;
    k->metrics = metrics;
    k->folder = strdup(folder);
    if (asprintf(&k->films, "%s/films", folder) < 0)
        k->films = NULL;
    glint_status st = k->folder && k->films
                          ? take_lock(k, err)
                          : glint_fail(err, GLINT_E_NOMEM, "", "no memory for the keeper");
    if (!st)
        st = open_parts(k, err);
    if (st)
        glint_keeper_destroy(out);
    return st;
}

void glint_keeper_destroy(glint_keeper **keeper)
{
    glint_keeper *k = *keeper;
    *keeper = NULL;
    if (!k)
        return;
    glint_vault_destroy(&k->vault);
    glint_journal_destroy(&k->journal);
    if (k->lock >= 0)
        close(k->lock);
    free(k->films);
    free(k->folder);
    free(k);
}

glint_journal *glint_keeper_journal(glint_keeper *k)
{
    return k->journal;
}

glint_vault *glint_keeper_vault(glint_keeper *k)
{
    return k->vault;
}

glint_metrics *glint_keeper_metrics(glint_keeper *k)
{
    return k->metrics;
}

const char *glint_keeper_films(const glint_keeper *k)
{
    return k->films;
}
