#include "base/vault.h"

#include "base/log.h"
#include "base/sha256.h"
#include "base/storage.h"
#include "base/thread.h"

#include <dirent.h>
#include <errno.h>
#include <fcntl.h>
#include <pthread.h>
#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#define NAME_DIGITS 64
#define PATH_BYTES 4096
#define WRITE_BYTES ((size_t)16 << 20) // of one call of write()

struct glint_vault {
    char *folder;
    _Atomic uint64_t bytes;
    pthread_mutex_t putting;   // one writer at a time: two of one name would share a file beside
    pthread_rwlock_t sweeping; // read by who puts, written by who removes
};

static bool is_name(const char *name)
{
    return strlen(name) == NAME_DIGITS && strspn(name, "0123456789abcdef") == NAME_DIGITS;
}

static void path_of(const glint_vault *v, const char *name, const char *suffix,
                    char path[PATH_BYTES])
{
    snprintf(path, PATH_BYTES, "%s/%.2s/%s%s", v->folder, name, name, suffix);
}

static bool size_of(const glint_vault *v, const char *name, uint64_t *size)
{
    char path[PATH_BYTES];
    struct stat s;
    path_of(v, name, "", path);
    if (stat(path, &s) || !S_ISREG(s.st_mode))
        return false;
    *size = (uint64_t)s.st_size;
    return true;
}

// ---- what is there

// Calls `visit` with every entry of every folder.
static void walk(glint_vault *v, void (*visit)(glint_vault *v, const char *entry, void *user),
                 void *user)
{
    char path[PATH_BYTES];
    for (int i = 0; i < 256; i++) {
        snprintf(path, sizeof path, "%s/%02x", v->folder, i);
        DIR *dir = opendir(path);
        for (struct dirent *e; dir && (e = readdir(dir));)
            if (e->d_name[0] != '.')
                visit(v, e->d_name, user);
        if (dir)
            closedir(dir);
    }
}

static void count_or_clean(glint_vault *v, const char *entry, void *user)
{
    (void)user;
    uint64_t size;
    char path[PATH_BYTES];
    if (is_name(entry)) {
        if (size_of(v, entry, &size))
            atomic_fetch_add(&v->bytes, size);
    } else if (strlen(entry) > 4 && !strcmp(entry + strlen(entry) - 4, ".new")) {
        snprintf(path, sizeof path, "%s/%.2s/%s", v->folder, entry, entry);
        unlink(path);
    }
}

static bool make_folders(const glint_vault *v)
{
    char path[PATH_BYTES];
    bool made = !mkdir(v->folder, 0750) || errno == EEXIST;
    for (int i = 0; made && i < 256; i++) {
        snprintf(path, sizeof path, "%s/%02x", v->folder, i);
        made = !mkdir(path, 0750) || errno == EEXIST;
    }
    return made && glint_storage_sync_folder(v->folder);
}

glint_status glint_vault_create(glint_vault **out, const char *folder, struct glint_error *err)
{
    glint_vault *v = *out = calloc(1, sizeof *v);
    if (v)
        v->folder = strdup(folder);
    if (!v || !v->folder) {
        free(v);
        *out = NULL;
        return glint_fail(err, GLINT_E_NOMEM, "", "no memory for the vault");
    }
    pthread_mutex_init(&v->putting, NULL);
    pthread_rwlock_init(&v->sweeping, NULL);
    if (!make_folders(v)) {
        const glint_status st = glint_storage_fault(err, folder, "cannot be made", errno);
        glint_vault_destroy(out);
        return st;
    }
    walk(v, count_or_clean, NULL);
    return GLINT_OK;
}

void glint_vault_destroy(glint_vault **vault)
{
    glint_vault *v = *vault;
    *vault = NULL;
    if (!v)
        return;
    pthread_rwlock_destroy(&v->sweeping);
    pthread_mutex_destroy(&v->putting);
    free(v->folder);
    free(v);
}

// ---- putting: all are written, then all synced, which the disk does together

static bool write_all(int fd, const char *bytes, size_t size)
{
    for (size_t done = 0; done < size;) {
        const size_t left = size - done;
        const ssize_t n = write(fd, bytes + done, left < WRITE_BYTES ? left : WRITE_BYTES);
        if (n < 0 && errno == EINTR)
            continue;
        if (n <= 0)
            return false;
        done += (size_t)n;
    }
    return true;
}

// The descriptor of what was written beside, -1 with errno.
static int write_beside(const glint_vault *v, const struct glint_content *blob)
{
    char path[PATH_BYTES];
    path_of(v, blob->name, ".new", path);
    const int fd = open(path, O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0640);
    if (fd < 0 || write_all(fd, blob->bytes, blob->size))
        return fd;
    const int why = errno;
    close(fd);
    unlink(path);
    errno = why;
    return -1;
}

#define BATCH 64u       // files that are open at once
#define SYNCERS 8u      // that wait for the disk at once
#define SYNCER_FILES 4u // that are worth one more of them

// What is to be synced and closed; whoever is done with one takes the next.
struct syncing {
    const int *fd;
    size_t count;
    atomic_size_t next;
    atomic_int why; // an errno, 0: all is well
};

static bool sync_and_close(int fd)
{
    const bool synced = !fsync(fd);
    const int why = errno;
    const bool closed = !close(fd);
    if (!synced)
        errno = why;
    return synced && closed;
}

static void *sync_some(void *arg)
{
    struct syncing *s = arg;
    for (size_t i; (i = atomic_fetch_add(&s->next, 1)) < s->count;)
        if (!sync_and_close(s->fd[i]))
            atomic_store(&s->why, errno);
    return NULL;
}

// The disk brings what is asked for at once out in one go: a scene of 28 meshes waited for it 55 times,
// one after the other. An errno, or 0.
static int sync_all(const int *fd, size_t count)
{
    struct syncing s = {.fd = fd, .count = count};
    pthread_t other[SYNCERS];
    size_t others = 0;
    while (others + 1 < SYNCERS && (others + 1) * SYNCER_FILES < count &&
           !glint_thread_start(&other[others], "sync", sync_some, &s, NULL))
        others++;
    sync_some(&s);
    while (others)
        pthread_join(other[--others], NULL);
    return atomic_load(&s.why);
}

static bool rename_one(glint_vault *v, const struct glint_content *blob)
{
    char from[PATH_BYTES], to[PATH_BYTES];
    path_of(v, blob->name, ".new", from);
    path_of(v, blob->name, "", to);
    if (rename(from, to))
        return false;
    atomic_fetch_add(&v->bytes, blob->size);
    return true;
}

static int sync_folders(const glint_vault *v, const struct glint_content *const *blob, size_t count)
{
    bool touched[256] = {0};
    int fd[BATCH], why = 0;
    size_t open_now = 0;
    char path[PATH_BYTES];
    for (size_t i = 0; i < count && !why; i++) {
        const char prefix[3] = {blob[i]->name[0], blob[i]->name[1], 0};
        bool *seen = &touched[strtoul(prefix, NULL, 16)];
        if (*seen)
            continue;
        *seen = true;
        snprintf(path, sizeof path, "%s/%s", v->folder, prefix);
        fd[open_now] = open(path, O_RDONLY | O_DIRECTORY | O_CLOEXEC);
        why = fd[open_now] < 0 ? errno : 0;
        open_now += !why;
    }
    const int unsynced = sync_all(fd, open_now);
    return why ? why : unsynced;
}

static void drop_beside(const glint_vault *v, const struct glint_content *const *blob, size_t count)
{
    char path[PATH_BYTES];
    for (size_t i = 0; i < count; i++) {
        path_of(v, blob[i]->name, ".new", path);
        unlink(path);
    }
}

// At most BATCH. An errno, or 0.
static int put_batch(glint_vault *v, const struct glint_content *const *blob, size_t count)
{
    int fd[BATCH], why = 0;
    size_t written = 0;
    while (written < count && !why) {
        fd[written] = write_beside(v, blob[written]);
        why = fd[written] < 0 ? errno : 0;
        written += !why;
    }
    const int unsynced = sync_all(fd, written);
    why = why ? why : unsynced;
    for (size_t i = 0; i < count && !why; i++)
        why = rename_one(v, blob[i]) ? 0 : errno;
    if (!why)
        why = sync_folders(v, blob, count);
    if (why)
        drop_beside(v, blob, count);
    return why;
}

static int by_name(const void *a, const void *b)
{
    const struct glint_content *const *x = a, *const *y = b;
    return strcmp((*x)->name, (*y)->name);
}

// Those that are not there yet, each once; returns how many.
static size_t missing(const glint_vault *v, const struct glint_content *blob, size_t count,
                      const struct glint_content **out)
{
    size_t kept = 0, wanted = 0;
    uint64_t size;
    for (size_t i = 0; i < count; i++)
        if (!size_of(v, blob[i].name, &size) || size != blob[i].size)
            out[wanted++] = &blob[i];
    if (wanted > 1)
        qsort(out, wanted, sizeof *out, by_name);
    for (size_t i = 0; i < wanted; i++)
        if (!kept || strcmp(out[kept - 1]->name, out[i]->name))
            out[kept++] = out[i];
    return kept;
}

glint_status glint_vault_put(glint_vault *v, const struct glint_content *blob, size_t count,
                             struct glint_error *err)
{
    if (!count)
        return GLINT_OK;
    const struct glint_content **wanted = malloc(count * sizeof *wanted);
    if (!wanted)
        return glint_fail(err, GLINT_E_NOMEM, "", "no memory to keep %zu assets", count);
    glint_status st = GLINT_OK;
    pthread_rwlock_rdlock(&v->sweeping);
    pthread_mutex_lock(&v->putting);
    const size_t n = missing(v, blob, count, wanted);
    for (size_t i = 0; i < n && !st; i += BATCH) {
        const int why = put_batch(v, wanted + i, n - i < BATCH ? n - i : BATCH);
        if (why)
            st = glint_storage_fault(err, v->folder, "an asset", why);
    }
    pthread_mutex_unlock(&v->putting);
    pthread_rwlock_unlock(&v->sweeping);
    free(wanted);
    return st;
}

// ---- reading

static glint_status put_aside(glint_vault *v, const char *name, struct glint_error *err)
{
    char from[PATH_BYTES], to[PATH_BYTES];
    uint64_t size = 0;
    path_of(v, name, "", from);
    path_of(v, name, ".torn", to);
    size_of(v, name, &size);
    if (!rename(from, to))
        atomic_fetch_sub(&v->bytes, size);
    glint_log(GLINT_LOG_ERROR, "store", NULL, NULL,
              "%s is damaged: its content is not what its name says; it is kept as %s", from, to);
    return glint_fail(err, GLINT_E_IO, "", "the file of asset %s is damaged", name);
}

glint_status glint_vault_map(glint_vault *v, const char *name, const uint8_t **bytes, size_t *size,
                             struct glint_error *err)
{
    char path[PATH_BYTES], content[65];
    struct stat s;
    path_of(v, name, "", path);
    const int fd = is_name(name) ? open(path, O_RDONLY | O_CLOEXEC) : -1;
    if (fd < 0 || fstat(fd, &s)) {
        if (fd >= 0)
            close(fd);
        return glint_fail(err, GLINT_E_NOT_FOUND, "", "there is no file of asset %.64s", name);
    }
    void *base = s.st_size ? mmap(NULL, (size_t)s.st_size, PROT_READ, MAP_PRIVATE, fd, 0) : NULL;
    close(fd);
    if (base == MAP_FAILED)
        return glint_fail(err, GLINT_E_NOMEM, "", "no memory to map asset %s", name);
    if (base)
        glint_sha256(base, (size_t)s.st_size, content);
    if (base && !strcmp(content, name)) {
        *bytes = base;
        *size = (size_t)s.st_size;
        return GLINT_OK;
    }
    if (base)
        munmap(base, (size_t)s.st_size);
    return put_aside(v, name, err);
}

// ---- removing

struct sweep {
    bool (*needed)(void *user, const char *name);
    void *user;
};

static void sweep_one(glint_vault *v, const char *name, void *user)
{
    const struct sweep *s = user;
    char path[PATH_BYTES];
    uint64_t size;
    if (!is_name(name) || !size_of(v, name, &size) || s->needed(s->user, name))
        return;
    path_of(v, name, "", path);
    if (!unlink(path))
        atomic_fetch_sub(&v->bytes, size);
}

bool glint_vault_sweep(glint_vault *v, const char *name,
                       bool (*needed)(void *user, const char *name), void *user)
{
    struct sweep s = {needed, user};
    if (pthread_rwlock_trywrlock(&v->sweeping))
        return false;
    if (name)
        sweep_one(v, name, &s);
    else
        walk(v, sweep_one, &s);
    pthread_rwlock_unlock(&v->sweeping);
    return true;
}

uint64_t glint_vault_bytes(const glint_vault *v)
{
    return atomic_load(&v->bytes);
}
