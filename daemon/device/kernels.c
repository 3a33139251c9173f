// kernels.c - glint-kernels: compiles the kernels of one variant into PoCL's cache.
//
// glint-kernels KEY OPTIONS FOLDER STEPS: started by glintd, several at a time; each takes the
// kernels that no other has taken yet, which a file of that name in FOLDER says, and one makes the
// link by which the program is known by its bitcode. KEY: the variant as glintd knows it; another
// release's helper makes nothing that glintd would find, and says so. STEPS: of nice.
#include "base/thread.h"
#include "device/ahead.h"
#include "device/bitcode.h"
#include "device/internal.h"
#include "device/program.h"

#include <fcntl.h>
#include <limits.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/prctl.h>
#include <unistd.h>

#define MAX_ARGUMENTS 64
#define MAX_NAMES 4096 // bytes

// What every kernel would find in its buffers.
#define ZEROS 65536

static bool take(const char *folder, const char *kernel)
{
    char path[PATH_MAX + MAX_NAMES];
    snprintf(path, sizeof path, "%s/%s", folder, kernel);
    const int fd = open(path, O_CREAT | O_EXCL | O_WRONLY | O_CLOEXEC, 0600);
    if (fd >= 0)
        close(fd);
    return fd >= 0;
}

// Anything: nothing is run.
static glint_status set_arguments(cl_kernel kernel, struct glint_arg *args, cl_uint count,
                                  glint_buffer *zeros, struct glint_error *err)
{
    static const cl_uint zero = 0;
    for (cl_uint i = 0; i < count; i++) {
        cl_kernel_arg_address_qualifier where;
        const cl_int code = clGetKernelArgInfo(kernel, i, CL_KERNEL_ARG_ADDRESS_QUALIFIER,
                                               sizeof where, &where, NULL);
        if (code)
            return glint_cl_fail(err, "clGetKernelArgInfo", code);
        if (where == CL_KERNEL_ARG_ADDRESS_PRIVATE)
            args[i] = (struct glint_arg){.value = &zero, .size = sizeof zero};
        else
            args[i] = (struct glint_arg){.buffer = zeros};
    }
    return GLINT_OK;
}

static glint_status compile(glint_devices *devices, glint_program *program, const char *name,
                            glint_buffer *zeros, struct glint_error *err)
{
    struct glint_arg args[MAX_ARGUMENTS];
    cl_uint count = 0;
    cl_int code;
    cl_kernel kernel = clCreateKernel(program->object, name, &code);
    if (code)
        return glint_cl_fail(err, "clCreateKernel", code);
    code = clGetKernelInfo(kernel, CL_KERNEL_NUM_ARGS, sizeof count, &count, NULL);
    glint_status st = code || count > MAX_ARGUMENTS
                          ? glint_cl_fail(err, "clGetKernelInfo", code)
                          : set_arguments(kernel, args, count, zeros, err);
    clReleaseKernel(kernel);
    if (!st)
        st = glint_compile(glint_devices_spare(devices), program, name, GLINT_AHEAD_ITEMS,
                           GLINT_AHEAD_GROUP, args, count, err);
    return st;
}

// From the last name on: by chance the longest comes first.
static glint_status compile_all(glint_devices *devices, glint_program *program, const char *folder,
                                struct glint_error *err)
{
    char names[MAX_NAMES];
    glint_buffer *zeros;
    const cl_int code =
        clGetProgramInfo(program->object, CL_PROGRAM_KERNEL_NAMES, sizeof names, names, NULL);
    if (code)
        return glint_cl_fail(err, "clGetProgramInfo", code);
    glint_status st = glint_buffer_create(&zeros, devices, ZEROS, err);
    for (char *name = names; !st && name;) {
        char *last = strrchr(names, ';');
        name = last ? last + 1 : names;
        if (take(folder, name))
            st = compile(devices, program, name, zeros, err);
        if (last)
            *last = 0;
        else
            name = NULL;
    }
    glint_buffer_destroy(&zeros);
    return st;
}

// Who is the first to find nothing to compile. Without the link a start takes longer, no more.
static void link_bitcode(glint_devices *devices, const char *options, const char *folder)
{
    const char *cache = getenv("POCL_CACHE_DIR");
    if (cache && take(folder, ".bitcode"))
        glint_bitcode_link(devices, options, cache);
}

static int run(const char *key, const char *options, const char *folder, struct glint_error *err)
{
    glint_devices *devices;
    glint_program *program = NULL;
    int code = EXIT_FAILURE;
    glint_devices_once();
    if (glint_devices_create(&devices, 1, NULL, err))
        return code;
    if (glint_program_get(&program, devices, options, err))
        code = GLINT_AHEAD_REFUSED;
    else if (strcmp(glint_program_key(program), key))
        glint_fail(err, GLINT_E_VERSION, "", "the helper is of another release than the daemon");
    else if (!compile_all(devices, program, folder, err)) {
        link_bitcode(devices, options, folder);
        code = EXIT_SUCCESS;
    }
    return code; // with devices on which launches wait for ever
}

int main(int argc, char **argv)
{
    struct glint_error err = {0};
    if (argc != 5) {
        fputs("glint-kernels is started by glintd\n", stderr);
        return 64;
    }
    prctl(PR_SET_PDEATHSIG, SIGKILL);
    glint_thread_yield_to_others(atoi(argv[4]));
    const int code = run(argv[1], argv[2], argv[3], &err);
    if (code)
        fprintf(stderr, "%s\n", glint_error_text(&err));
    _exit(code); // the devices are left to the end of the process
}
