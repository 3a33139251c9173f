#include "output.h"

#include <errno.h>
#include <fcntl.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>
#include <sys/stat.h>
#include <unistd.h>

// Length of the directory's part of a path, its slash included.
static int directory_length(const char *path)
{
    const char *slash = strrchr(path, '/');
    return slash ? (int)(slash + 1 - path) : 0;
}

static int create_temporary(struct glint_output_file *o)
{
    const int directory = directory_length(o->path);
    if (asprintf(&o->temporary, "%.*s.%.200s.XXXXXX", directory, o->path, o->path + directory) <
        0) {
        o->temporary = NULL;
        return -1;
    }
    const int fd = mkostemp(o->temporary, O_CLOEXEC);
    if (fd < 0)
        return -1;
    const mode_t mask = umask(0);
    umask(mask);
    fchmod(fd, 0666 & ~mask);
    return fd;
}

static glint_status fail(struct glint_output_file *o, const char *path, int error,
                         struct glint_error *err)
{
    free(o->path);
    free(o->temporary);
    *o = (struct glint_output_file){.fd = -1};
    return glint_fail(err, GLINT_E_IO, "", "%s: %s", path, strerror(error));
}

glint_status glint_output_open(struct glint_output_file *out, const char *path,
                               struct glint_error *err)
{
    struct stat info;
    const bool exists = stat(path, &info) == 0;
    *out = (struct glint_output_file){.fd = -1};
    // A link is followed, so that it goes on pointing at the file.
    out->path = exists ? realpath(path, NULL) : strdup(path);
    if (!out->path)
        return fail(out, path, errno, err);
    if (exists && S_ISDIR(info.st_mode))
        return fail(out, path, EISDIR, err);
    out->fd =
        exists && !S_ISREG(info.st_mode) ? open(path, O_WRONLY | O_CLOEXEC) : create_temporary(out);
    return out->fd < 0 ? fail(out, path, errno, err) : GLINT_OK;
}

bool glint_output_write(void *output, const void *bytes, size_t size)
{
    struct glint_output_file *o = output;
    for (const char *from = bytes; size && !o->error;) {
        const ssize_t wrote = write(o->fd, from, size);
        if (wrote < 0 && errno != EINTR)
            o->error = errno;
        if (wrote <= 0)
            continue;
        from += wrote;
        size -= (size_t)wrote;
        o->size += (uint64_t)wrote;
    }
    return !o->error;
}

// The name is durable once its directory is.
static void sync_directory(const char *path)
{
    char *directory = NULL;
    const int length = directory_length(path);
    if (asprintf(&directory, "%.*s.", length, path) < 0)
        return;
    const int fd = open(directory, O_RDONLY | O_DIRECTORY | O_CLOEXEC);
    if (fd >= 0) {
        fsync(fd);
        close(fd);
    }
    free(directory);
}

static int put_in_place(const struct glint_output_file *o)
{
    if (fsync(o->fd) != 0 || rename(o->temporary, o->path) != 0)
        return errno;
    sync_directory(o->path);
    return 0;
}

glint_status glint_output_close(struct glint_output_file *out, bool keep, struct glint_error *err)
{
    if (out->temporary && keep && !out->error)
        out->error = put_in_place(out);
    if (out->temporary && (!keep || out->error))
        unlink(out->temporary);
    close(out->fd);
    glint_status status = GLINT_OK;
    if (keep && out->error)
        status = glint_fail(err, GLINT_E_IO, "", "%s: %s", out->path, strerror(out->error));
    free(out->path);
    free(out->temporary);
    *out = (struct glint_output_file){.fd = -1};
    return status;
}

glint_status glint_output_check(const char *path, struct glint_error *err)
{
    struct stat info;
    if (stat(path, &info) == 0 && !S_ISREG(info.st_mode) && !S_ISDIR(info.st_mode))
        return GLINT_OK;
    struct glint_output_file probe;
    const glint_status status = glint_output_open(&probe, path, err);
    return status ? status : glint_output_close(&probe, false, err);
}

bool glint_output_is(const char *path, const char *extension)
{
    const char *dot = strrchr(path, '.');
    return dot && strcasecmp(dot + 1, extension) == 0;
}
