#include "base/file.h"

#include <errno.h>
#include <fcntl.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

static glint_status check(int fd, const char *path, size_t most, size_t *size,
                          struct glint_error *err)
{
    struct stat st;
    if (fstat(fd, &st))
        return glint_fail(err, GLINT_E_IO, "", "%s: %s", path, strerror(errno));
    if (!S_ISREG(st.st_mode))
        return glint_fail(err, GLINT_E_IO, "", "%s: it is no file", path);
    if (st.st_mode & S_IWOTH)
        return glint_fail(err, GLINT_E_IO, "", "%s: everybody may write it", path);
    if ((uint64_t)st.st_size > most)
        return glint_fail(err, GLINT_E_IO, "", "%s: it has over %zu bytes", path, most);
    *size = (size_t)st.st_size;
    return GLINT_OK;
}

// As much of `size` as there is.
static glint_status read_all(char *out, size_t *length, int fd, const char *path, size_t size,
                             struct glint_error *err)
{
    *length = 0;
    while (*length < size) {
        const ssize_t n = read(fd, out + *length, size - *length);
        if (n < 0 && errno != EINTR)
            return glint_fail(err, GLINT_E_IO, "", "%s: %s", path, strerror(errno));
        if (!n)
            break;
        *length += n > 0 ? (size_t)n : 0;
    }
    out[*length] = '\0';
    return GLINT_OK;
}

glint_status glint_file_read(char **text, size_t *length, const char *path, size_t most,
                             struct glint_error *err)
{
    *text = NULL;
    *length = 0;
    const int fd = open(path, O_RDONLY | O_CLOEXEC | O_NONBLOCK);
    if (fd < 0)
        return glint_fail(err, GLINT_E_IO, "", "%s: %s", path, strerror(errno));
    size_t size = 0;
    glint_status st = check(fd, path, most, &size, err);
    if (!st && !(*text = malloc(size + 1)))
        st = glint_fail(err, GLINT_E_NOMEM, "", "%s: no memory for it", path);
    if (!st)
        st = read_all(*text, length, fd, path, size, err);
    close(fd);
    if (st) {
        free(*text);
        *text = NULL;
    }
    return st;
}
