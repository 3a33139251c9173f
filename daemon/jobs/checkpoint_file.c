#include "jobs/checkpoint_file.h"

#include "base/storage.h"

#include <dirent.h>
#include <errno.h>
#include <fcntl.h>
#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <time.h>
#include <unistd.h>

#define PATH_BYTES 4096
#define JOB_DIGITS 32

static void path_of(const struct glint_checkpoint_file *f, const char *suffix,
                    char path[PATH_BYTES])
{
    snprintf(path, PATH_BYTES, "%s/%s.%" PRIu64 "%s", f->folder, f->job, f->number, suffix);
}

static glint_status fault(const struct glint_checkpoint_file *f, const char *what,
                          struct glint_error *err)
{
    return glint_storage_fault(err, f->folder, what, errno);
}

// What the render said when it could not write does not tell a full disk from others; errno does.
static glint_status write_film(int fd, const struct glint_checkpoint_file *f, glint_render *render,
                               struct glint_error *err)
{
    struct glint_error why = {0};
    errno = 0;
    const glint_status st = glint_render_film(render, fd, &why);
    const int code = errno;
    if (st == GLINT_E_IO)
        glint_storage_fault(err, f->folder, code ? "a film" : glint_error_text(&why),
                            code ? code : EIO);
    else if (st)
        glint_fail(err, st, "", "%s", glint_error_text(&why));
    glint_error_finish(&why);
    return st;
}

glint_status glint_checkpoint_file_write(const struct glint_checkpoint_file *f,
                                         glint_render *render, uint64_t *bytes,
                                         struct glint_error *err)
{
    char beside[PATH_BYTES], path[PATH_BYTES];
    struct stat s = {0};
    path_of(f, ".new", beside);
    path_of(f, "", path);
    const int fd = open(beside, O_RDWR | O_CREAT | O_TRUNC | O_CLOEXEC, 0640);
    if (fd < 0)
        return fault(f, "a film", err);
    glint_status st = write_film(fd, f, render, err);
    if (!st && (fsync(fd) || fstat(fd, &s)))
        st = fault(f, "a film", err);
    if (close(fd) && !st)
        st = fault(f, "a film", err);
    if (!st && (rename(beside, path) || !glint_storage_sync_folder(f->folder)))
        st = fault(f, "a film", err);
    if (st)
        unlink(beside);
    *bytes = (uint64_t)s.st_size;
    return st;
}

int glint_checkpoint_file_open(const struct glint_checkpoint_file *f, struct glint_error *err)
{
    char path[PATH_BYTES];
    path_of(f, "", path);
    const int fd = open(path, O_RDONLY | O_CLOEXEC);
    if (fd < 0)
        glint_fail(err, errno == ENOENT ? GLINT_E_NOT_FOUND : GLINT_E_IO, "", "%s: %s", path,
                   strerror(errno));
    return fd;
}

void glint_checkpoint_file_remove(const struct glint_checkpoint_file *f)
{
    char path[PATH_BYTES];
    path_of(f, "", path);
    unlink(path);
}

void glint_checkpoint_file_put_aside(const struct glint_checkpoint_file *f, const char *suffix)
{
    char from[PATH_BYTES], to[PATH_BYTES];
    path_of(f, "", from);
    path_of(f, suffix, to);
    rename(from, to);
}

uint64_t glint_checkpoint_file_bytes(const struct glint_checkpoint_file *f)
{
    char path[PATH_BYTES];
    struct stat s;
    path_of(f, "", path);
    return stat(path, &s) ? 0 : (uint64_t)s.st_size;
}

void glint_checkpoint_file_time(const struct glint_checkpoint_file *f, char text[32])
{
    char path[PATH_BYTES];
    struct stat s;
    struct tm parts;
    path_of(f, "", path);
    *text = '\0';
    if (!stat(path, &s) && gmtime_r(&s.st_mtime, &parts))
        strftime(text, 32, "%Y-%m-%dT%H:%M:%SZ", &parts);
}

void glint_checkpoint_files_list(const char *folder, void (*visit)(void *user, const char *name),
                                 void *user)
{
    DIR *dir = opendir(folder);
    for (struct dirent *e; dir && (e = readdir(dir));)
        if (e->d_name[0] != '.')
            visit(user, e->d_name);
    if (dir)
        closedir(dir);
}

bool glint_checkpoint_file_parse(const char *name, char job[33], uint64_t *number)
{
    char *end;
    if (strspn(name, "0123456789abcdef") != JOB_DIGITS || name[JOB_DIGITS] != '.')
        return false;
    const char *digits = name + JOB_DIGITS + 1;
    memcpy(job, name, JOB_DIGITS);
    job[JOB_DIGITS] = '\0';
    errno = 0;
    *number = strtoull(digits, &end, 10);
    return *digits >= '0' && *digits <= '9' && !*end && !errno;
}
