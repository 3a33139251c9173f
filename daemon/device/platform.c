// platform.c - finds PoCL's devices and says where it keeps what it compiles.
#include "device/compiler.h"
#include "device/internal.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#define MAX_PLATFORMS 16
#define POCL_NAME "Portable Computing Language"

// PoCL reads its device list once in a process; a later, larger set of workers has to find its
// devices there. An unused device costs 2 ms: PoCL asks the processor for each what it can do.
#define FEWEST_DEVICES 16u

static bool only_set;

glint_status glint_cl_fail(struct glint_error *err, const char *call, cl_int code)
{
    if (code == CL_OUT_OF_HOST_MEMORY || code == CL_MEM_OBJECT_ALLOCATION_FAILURE)
        return glint_fail(err, GLINT_E_NOMEM, "", "%s found no memory (%d)", call, code);
    return glint_fail(err, GLINT_E_DEVICE, "", "%s answered %d", call, code);
}

void glint_devices_once(void)
{
    only_set = true;
}

static void name_devices(uint32_t count)
{
    if (count < FEWEST_DEVICES && !only_set)
        count = FEWEST_DEVICES;
    char list[257 * sizeof "basic"] = "basic"; // as many workers as there may be, and the spare
    for (uint32_t i = 1; i < count; i++)
        strcat(list, " basic");
    setenv("POCL_DEVICES", list, 0);
}

// PoCL asks hwloc how much memory there is, and ends the process where a bare chroot has no /sys to
// answer from. Where there is, its questions to the processor itself, each of which leaves a virtual
// machine, would take 20 ms and add nothing that PoCL reads.
static void describe_machine(void)
{
    if (!access("/sys/devices/system/cpu", F_OK)) {
        setenv("HWLOC_COMPONENTS", "-x86", 0);
        return;
    }
    char text[96];
    snprintf(text, sizeof text, "node:1(memory=%lld) pu:%ld",
             (long long)sysconf(_SC_PHYS_PAGES) * sysconf(_SC_PAGESIZE),
             sysconf(_SC_NPROCESSORS_ONLN));
    setenv("HWLOC_SYNTHETIC", text, 0);
}

static void name_cache(const char *cache_dir, const char *folder)
{
    char *path = NULL;
    const char *xdg = getenv("XDG_CACHE_HOME"), *home = getenv("HOME");
    int n;
    if (cache_dir)
        n = asprintf(&path, "%s/%s", cache_dir, folder);
    else if (getenv("POCL_CACHE_DIR"))
        return;
    else if (xdg && *xdg)
        n = asprintf(&path, "%s/glint/%s", xdg, folder);
    else
        n = asprintf(&path, "%s/.cache/glint/%s", home && *home ? home : "/tmp", folder);
    if (n >= 0)
        setenv("POCL_CACHE_DIR", path, 1);
    free(n >= 0 ? path : NULL);
}

static bool is_pocl(cl_platform_id platform)
{
    char name[128] = "";
    return !clGetPlatformInfo(platform, CL_PLATFORM_NAME, sizeof name, name, NULL) &&
           !strcmp(name, POCL_NAME);
}

static glint_status find_platform(cl_platform_id *out, struct glint_error *err)
{
    cl_platform_id platform[MAX_PLATFORMS];
    cl_uint count = 0;
    cl_int code = clGetPlatformIDs(MAX_PLATFORMS, platform, &count);
    for (cl_uint i = 0; !code && i < count && i < MAX_PLATFORMS; i++)
        if (is_pocl(platform[i])) {
            *out = platform[i];
            return GLINT_OK;
        }
    return glint_fail(err, GLINT_E_DEVICE, "", "none of %u OpenCL platforms is PoCL (%d)", count,
                      code);
}

// PoCL 3.1 declares fine-grain buffers only, yet its CPU devices take any pointer of the process.
static bool shares_memory(cl_device_id device)
{
    cl_device_svm_capabilities how = 0;
    return !clGetDeviceInfo(device, CL_DEVICE_SVM_CAPABILITIES, sizeof how, &how, NULL) &&
           (how & CL_DEVICE_SVM_FINE_GRAIN_BUFFER);
}

glint_status glint_platform_open(cl_device_id *device, uint32_t count, const char *cache_dir,
                                 struct glint_error *err)
{
    static bool opened;
    cl_platform_id platform = NULL;
    if (!opened) {
        name_devices(count);
        describe_machine();
    }
    glint_status st = find_platform(&platform, err);
    if (st)
        return st;
    if (!opened) { // the platform has loaded LLVM, and PoCL has not yet looked for its cache
        char folder[GLINT_COMPILER_FOLDER], version[256] = "";
        clGetPlatformInfo(platform, CL_PLATFORM_VERSION, sizeof version, version, NULL);
        glint_compiler_set(folder, glint_sources, version);
        name_cache(cache_dir, folder);
        opened = true;
    }
    cl_uint found = 0;
    cl_int code = clGetDeviceIDs(platform, CL_DEVICE_TYPE_CPU, count, device, &found);
    if (code)
        return glint_cl_fail(err, "clGetDeviceIDs", code);
    if (found < count)
        return glint_fail(err, GLINT_E_DEVICE, "",
                          "PoCL offers %u devices for %u workers (POCL_DEVICES is \"%s\")", found,
                          count, getenv("POCL_DEVICES"));
    if (!shares_memory(device[0]))
        return glint_fail(err, GLINT_E_DEVICE, "", "the device does not share the host's memory");
    return GLINT_OK;
}
