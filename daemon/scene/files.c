#include "scene/files.h"

#include <stdlib.h>
#include <string.h>
#include <strings.h>

void glint_files_tidy(char *path)
{
    char *to = path;
    for (const char *from = path; *from; from++)
        *to++ = *from == '\\' ? '/' : *from;
    *to = '\0';
    size_t skip = 0;
    while (path[skip] == '.' && path[skip + 1] == '/')
        skip += 2 + strspn(path + skip + 2, "/");
    memmove(path, path + skip, strlen(path + skip) + 1);
}

static const char *last_part(const char *path)
{
    const char *slash = strrchr(path, '/');
    return slash ? slash + 1 : path;
}

static struct glint_file *find_tidy(struct glint_files *files, const char *path)
{
    struct glint_file *only = NULL;
    uint32_t alike = 0;
    for (uint32_t i = 0; i < files->count; i++)
        if (!strcmp(files->file[i].name, path))
            return &files->file[i];
    for (uint32_t i = 0; i < files->count; i++)
        if (!strcasecmp(last_part(files->file[i].name), last_part(path))) {
            only = &files->file[i];
            alike++;
        }
    return alike == 1 ? only : NULL;
}

struct glint_file *glint_files_find(struct glint_files *files, const char *path)
{
    char *tidy = files ? strdup(path) : NULL;
    if (!tidy)
        return NULL;
    glint_files_tidy(tidy);
    struct glint_file *file = *last_part(tidy) ? find_tidy(files, tidy) : NULL;
    if (file)
        file->used = true;
    free(tidy);
    return file;
}

static int hex_digit(char c)
{
    if (c >= '0' && c <= '9')
        return c - '0';
    if (c >= 'a' && c <= 'f')
        return c - 'a' + 10;
    return c >= 'A' && c <= 'F' ? c - 'A' + 10 : -1;
}

// In place; false where an escape is malformed or stands for the end of a string.
static bool unescape(char *text)
{
    char *to = text;
    for (const char *from = text; *from; from++) {
        if (*from != '%') {
            *to++ = *from;
            continue;
        }
        const int high = hex_digit(from[1]), low = high < 0 ? -1 : hex_digit(from[2]);
        if (low < 0 || high + low == 0)
            return false;
        *to++ = (char)(high << 4 | low);
        from += 2;
    }
    *to = '\0';
    return true;
}

static bool stays_inside(const char *path)
{
    int depth = 0;
    if (*path == '/' || *path == '\\' || strstr(path, "://"))
        return false;
    while (*path && depth >= 0) {
        const size_t length = strcspn(path, "/\\");
        if (length == 2 && !strncmp(path, "..", 2))
            depth--;
        else if (length && (length > 1 || *path != '.'))
            depth++;
        path += length + (path[length] != '\0');
    }
    return depth >= 0;
}

struct glint_file *glint_files_find_uri(struct glint_files *files, const char *uri)
{
    char *path = files ? strdup(uri) : NULL;
    struct glint_file *file = NULL;
    if (path && unescape(path) && stays_inside(path))
        file = glint_files_find(files, path);
    free(path);
    return file;
}
