#include "uri.h"

#include <errno.h>
#include <fcntl.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>
#include <sys/stat.h>
#include <unistd.h>

static int hex_digit(char c)
{
    if (c >= '0' && c <= '9')
        return c - '0';
    if (c >= 'a' && c <= 'f')
        return c - 'a' + 10;
    return c >= 'A' && c <= 'F' ? c - 'A' + 10 : -1;
}

char *glint_uri_decode(const char *text)
{
    char *out = malloc(strlen(text) + 1), *to = out;
    for (; out && *text; text++) {
        if (*text != '%') {
            *to++ = *text;
            continue;
        }
        const int high = hex_digit(text[1]), low = high < 0 ? -1 : hex_digit(text[2]);
        if (low < 0 || high + low == 0) {
            free(out);
            return NULL;
        }
        *to++ = (char)(high << 4 | low);
        text += 2;
    }
    if (out)
        *to = '\0';
    return out;
}

static int base64_digit(char c)
{
    static const char digits[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    const char *at = c ? strchr(digits, c) : NULL;
    return at ? (int)(at - digits) : -1;
}

// Bytes written to `out` (which holds 3/4 of the length), or -1.
static long decode_base64(const char *text, uint8_t *out)
{
    size_t length = strlen(text);
    if (length % 4)
        return -1;
    while (length && text[length - 1] == '=' && length % 4 != 2)
        length--;
    uint8_t *to = out;
    uint32_t bits = 0;
    for (size_t i = 0; i < length; i++) {
        const int digit = base64_digit(text[i]);
        if (digit < 0)
            return -1;
        bits = bits << 6 | (uint32_t)digit;
        if (i % 4 == 0)
            continue;
        *to++ = (uint8_t)(bits >> (6 - 2 * (i % 4)));
    }
    return to - out;
}

// data:MEDIA[;parameters];base64,TEXT
static glint_status read_data(const char *uri, struct glint_blob *out, const char *pointer,
                              struct glint_error *err)
{
    const char *media = uri + strlen("data:"), *comma = strchr(media, ',');
    const size_t suffix = strlen(";base64");
    if (!comma || (size_t)(comma - media) < suffix ||
        strncasecmp(comma - suffix, ";base64", suffix) != 0)
        return glint_fail(err, GLINT_E_RANGE, pointer, "a data URI that is not base64");
    snprintf(out->media, sizeof out->media, "%.*s", (int)strcspn(media, ";,"), media);
    out->bytes = malloc(strlen(comma) + 1);
    const long size = out->bytes ? decode_base64(comma + 1, out->bytes) : -1;
    if (size >= 0) {
        out->size = (size_t)size;
        return GLINT_OK;
    }
    free(out->bytes);
    out->bytes = NULL;
    return glint_fail(err, GLINT_E_RANGE, pointer, "a data URI with malformed base64");
}

static bool read_all(int fd, struct glint_blob *out)
{
    for (size_t done = 0; done < out->size;) {
        const ssize_t got = read(fd, out->bytes + done, out->size - done);
        if (got <= 0)
            return false;
        done += (size_t)got;
    }
    out->bytes[out->size] = 0;
    return true;
}

glint_status glint_uri_read_file(const char *path, struct glint_blob *out, const char *pointer,
                                 struct glint_error *err)
{
    struct stat info;
    *out = (struct glint_blob){0};
    const int fd = open(path, O_RDONLY | O_CLOEXEC | O_NONBLOCK); // a pipe must not block here
    if (fd < 0)
        return glint_fail(err, GLINT_E_IO, pointer, "%s: %s", path, strerror(errno));
    glint_status status = GLINT_OK;
    if (fstat(fd, &info) != 0 || !S_ISREG(info.st_mode)) {
        status = glint_fail(err, GLINT_E_IO, pointer, "%s: not a regular file", path);
    } else if ((uint64_t)info.st_size > UINT32_MAX) {
        status = glint_fail(err, GLINT_E_TOO_LARGE, pointer, "%s: more than 4 GiB", path);
    } else {
        out->size = (size_t)info.st_size;
        out->bytes = malloc(out->size + 1);
        if (!out->bytes || !read_all(fd, out)) {
            status = glint_fail(err, GLINT_E_IO, pointer, "%s: cannot be read", path);
            free(out->bytes);
            *out = (struct glint_blob){0};
        }
    }
    close(fd);
    return status;
}

// True if the real path `path` lies in the real path `directory`.
static bool inside(const char *directory, const char *path)
{
    const size_t length = strlen(directory);
    return strncmp(path, directory, length) == 0 &&
           (path[length] == '/' || directory[length - 1] == '/');
}

glint_status glint_uri_read_path(const char *directory, const char *name, struct glint_blob *out,
                                 const char *pointer, struct glint_error *err)
{
    char *path = NULL;
    *out = (struct glint_blob){0};
    if (asprintf(&path, "%s/%s", directory, name) < 0)
        return glint_fail(err, GLINT_E_NOMEM, pointer, "no memory");
    char *real = realpath(path, NULL);
    glint_status status;
    if (!real)
        status = glint_fail(err, GLINT_E_RANGE, pointer, "%s: %s", name, strerror(errno));
    else if (!inside(directory, real))
        status =
            glint_fail(err, GLINT_E_RANGE, pointer, "%s: outside the directory of the file", name);
    else
        status = glint_uri_read_file(real, out, pointer, err);
    free(real);
    free(path);
    return status;
}

glint_status glint_uri_read(const char *directory, const char *uri, struct glint_blob *out,
                            const char *pointer, struct glint_error *err)
{
    *out = (struct glint_blob){0};
    if (strncasecmp(uri, "data:", 5) == 0)
        return read_data(uri, out, pointer, err);
    if (strstr(uri, "://") || uri[0] == '/')
        return glint_fail(err, GLINT_E_RANGE, pointer, "%.200s: not a relative path", uri);
    char *name = glint_uri_decode(uri);
    if (!name)
        return glint_fail(err, GLINT_E_RANGE, pointer, "%.200s: a malformed escape", uri);
    const glint_status status = glint_uri_read_path(directory, name, out, pointer, err);
    free(name);
    return status;
}
