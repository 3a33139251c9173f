#include "device/bitcode.h"

#include "base/file.h"
#include "device/listing.h"
#include "device/program.h"

#include <glob.h>
#include <libgen.h>
#include <limits.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#define MOST_BYTES ((size_t)64 << 20)

cl_program glint_bitcode_program(glint_devices *devices, uint32_t count, const char *path)
{
    char *bytes;
    size_t size;
    if (glint_file_read(&bytes, &size, path, MOST_BYTES, NULL))
        return NULL;
    cl_program program = NULL;
    const unsigned char **text = calloc(count, sizeof *text);
    size_t *length = calloc(count, sizeof *length);
    for (uint32_t i = 0; text && length && i < count; i++) {
        text[i] = (const unsigned char *)bytes;
        length[i] = size;
    }
    if (text && length)
        program = clCreateProgramWithBinary(devices->context, count, devices->device, length, text,
                                            NULL, NULL);
    free(length);
    free(text);
    free(bytes);
    return program;
}

// ---- the link

// Folders of the cache's programs, "<cache>/XX/YYY", as glob() gives them.
static size_t find_programs(glob_t *found, const char *cache)
{
    char pattern[PATH_MAX];
    *found = (glob_t){0};
    snprintf(pattern, sizeof pattern, "%s/*/*/program.bc", cache);
    if (glob(pattern, GLOB_NOESCAPE, NULL, found))
        return 0;
    for (size_t i = 0; i < found->gl_pathc; i++)
        dirname(found->gl_pathv[i]);
    return found->gl_pathc;
}

// Has PoCL make a folder for the program of the bitcode.
static bool have_folder(glint_devices *devices, const char *options, const char *folder)
{
    char bitcode[PATH_MAX];
    snprintf(bitcode, sizeof bitcode, "%s/program.bc", folder);
    cl_program program = glint_bitcode_program(devices, 1, bitcode);
    char *all = glint_program_options(options);
    const bool made =
        program && all && !clBuildProgram(program, 1, devices->device, all, NULL, NULL);
    free(all);
    if (program)
        clReleaseProgram(program);
    return made;
}

static bool replace_by_link(const char *folder, const char *by)
{
    char target[PATH_MAX];
    const char *base = strrchr(by, '/');
    while (base > by && base[-1] != '/')
        base--;
    snprintf(target, sizeof target, "../%s", base);
    glint_folder_remove(folder);
    return symlink(target, folder) == 0;
}

bool glint_bitcode_link(glint_devices *devices, const char *options, const char *cache)
{
    glob_t before, after = {0};
    bool made = find_programs(&before, cache) == 1 &&
                have_folder(devices, options, before.gl_pathv[0]) &&
                find_programs(&after, cache) == 2;
    if (made) {
        const bool first = strcmp(after.gl_pathv[0], before.gl_pathv[0]) != 0;
        made = replace_by_link(after.gl_pathv[!first], before.gl_pathv[0]);
    }
    globfree(&before);
    globfree(&after);
    return made;
}
