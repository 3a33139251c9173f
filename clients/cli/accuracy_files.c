#include "accuracy_files.h"

#include "output.h"
#include "protocol/exr.h"

#include <ctype.h>
#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

#define MAX_FILE ((size_t)1 << 30)

static glint_status no_memory(struct glint_error *err)
{
    return glint_fail(err, GLINT_E_NOMEM, "", "no memory for a file");
}

char *glint_accuracy_path(const char *folder, const char *name)
{
    const size_t size = strlen(folder) + strlen(name) + 2;
    char *path = malloc(size);
    if (path)
        snprintf(path, size, "%s/%s", folder, name);
    return path;
}

static glint_status make_folder(const char *path, struct glint_error *err)
{
    if (mkdir(path, 0777) == 0 || errno == EEXIST)
        return GLINT_OK;
    return glint_fail(err, GLINT_E_IO, "", "%s: %s", path, strerror(errno));
}

glint_status glint_accuracy_folders(const char *folder, struct glint_error *err)
{
    static const char *const inner[] = {"plots", "differences", "work"};
    glint_status st = make_folder(folder, err);
    for (size_t i = 0; i < sizeof inner / sizeof *inner && !st; i++) {
        char *path = glint_accuracy_path(folder, inner[i]);
        st = path ? make_folder(path, err) : no_memory(err);
        free(path);
    }
    return st;
}

glint_status glint_accuracy_save_bytes(const char *folder, const char *name, const void *bytes,
                                       size_t size, struct glint_error *err)
{
    struct glint_output_file file;
    char *path = glint_accuracy_path(folder, name);
    if (!path)
        return no_memory(err);
    glint_status st = glint_output_open(&file, path, err);
    if (!st) {
        const bool written = glint_output_write(&file, bytes, size);
        const int error = file.error;
        st = glint_output_close(&file, written, err);
        if (!st && !written)
            st = glint_fail(err, GLINT_E_IO, "", "%s: %s", path, strerror(error));
    }
    free(path);
    return st;
}

glint_status glint_accuracy_save(const char *folder, const char *name, struct glint_text *text,
                                 struct glint_error *err)
{
    size_t length;
    char *bytes = glint_text_take(text, &length);
    const glint_status st =
        bytes ? glint_accuracy_save_bytes(folder, name, bytes, length, err) : no_memory(err);
    free(bytes);
    return st;
}

static glint_status read_all(FILE *file, const char *path, char **bytes, size_t *size,
                             struct glint_error *err)
{
    struct stat about;
    if (fstat(fileno(file), &about) || !S_ISREG(about.st_mode) || (size_t)about.st_size > MAX_FILE)
        return glint_fail(err, GLINT_E_IO, "", "%s is no file of at most 1 GiB", path);
    *size = (size_t)about.st_size;
    *bytes = malloc(*size + 1);
    if (!*bytes)
        return no_memory(err);
    (*bytes)[*size] = '\0';
    if (fread(*bytes, 1, *size, file) == *size)
        return GLINT_OK;
    free(*bytes);
    *bytes = NULL;
    return glint_fail(err, GLINT_E_IO, "", "%s cannot be read", path);
}

static glint_status load(char **bytes, size_t *size, const char *folder, const char *name,
                         struct glint_error *err)
{
    *bytes = NULL;
    char *path = glint_accuracy_path(folder, name);
    if (!path)
        return no_memory(err);
    glint_status st = GLINT_OK;
    FILE *file = fopen(path, "rb");
    if (file) {
        st = read_all(file, path, bytes, size, err);
        fclose(file);
    } else if (errno != ENOENT) {
        st = glint_fail(err, GLINT_E_IO, "", "%s: %s", path, strerror(errno));
    }
    free(path);
    return st;
}

glint_status glint_accuracy_load(char **text, const char *folder, const char *name,
                                 struct glint_error *err)
{
    size_t size;
    return load(text, &size, folder, name, err);
}

glint_status glint_accuracy_load_frame(struct glint_frame **frame, const char *folder,
                                       const char *name, struct glint_error *err)
{
    char *bytes;
    size_t size;
    *frame = NULL;
    glint_status st = load(&bytes, &size, folder, name, err);
    if (!st && bytes)
        st = glint_exr_read(frame, (const uint8_t *)bytes, size, err);
    free(bytes);
    return st;
}

glint_status glint_accuracy_save_frame(const struct glint_frame *frame, const char *folder,
                                       const char *name, struct glint_error *err)
{
    const struct glint_exr_options options = {.compression = GLINT_EXR_ZIP, .foreign = true};
    uint8_t *bytes;
    size_t size;
    glint_status st = glint_exr_write(frame, &options, &bytes, &size, NULL, err);
    if (st)
        return st;
    st = glint_accuracy_save_bytes(folder, name, bytes, size, err);
    free(bytes);
    return st;
}

void glint_accuracy_file_name(const char *text, char *out, size_t size)
{
    size_t n = 0;
    for (; text[n] && n + 1 < size; n++)
        out[n] = isalnum((unsigned char)text[n]) || text[n] == '.' ? text[n] : '-';
    out[n] = '\0';
}
