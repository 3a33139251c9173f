// internal.h - what the files of device/ know of each other.
#ifndef GLINT_DEVICE_INTERNAL_H
#define GLINT_DEVICE_INTERNAL_H

#include "device/ahead.h"
#include "device/device.h"

#include <CL/cl.h>
#include <pthread.h>
#include <stdatomic.h>

struct glint_worker {
    glint_devices *devices; // borrowed
    uint32_t index;
    cl_command_queue queue; // in-order, on the device of this index
};

struct glint_devices {
    cl_context context;
    cl_device_id *device; // [slots]
    glint_worker *worker; // [slots]
    uint32_t workers;
    uint32_t slots; // the workers and the spare
    char *name, *version;
    char *source;           // the embedded kernels, expanded
    glint_ahead *ahead;     // NULL: kernels are compiled when they are launched
    pthread_mutex_t build;  // guards `program`, held while one is built
    glint_program *program; // most recently used first
};

#define GLINT_MAX_KERNELS 64

// The code of a kernel for one size of group, as PoCL has loaded it into the process.
struct code {
    char name[64];
    size_t group;
    size_t largest;      // launch that the loaded code is found for, 0: none; see launch.c
    atomic_uint used_at; // number of loads when it was last launched
};

// Kernel objects hold their arguments, so each worker has its own, made at its first launch.
struct kernel {
    struct code *code; // of the program
    cl_kernel object;
};

struct kernels {
    size_t count;
    struct kernel kernel[GLINT_MAX_KERNELS];
};

struct glint_program {
    glint_program *next;
    atomic_uint references; // one is the cache's
    char key[65];
    cl_program object;
    uint32_t slots;
    struct kernels *kernels; // [slots]: each owned by its worker
    pthread_mutex_t names;   // guards the growth of `code`; entries stay where they are
    size_t codes;
    struct code code[GLINT_MAX_KERNELS];
};

struct glint_buffer {
    atomic_uint references;
    void *host; // from mmap
    size_t bytes, mapped;
};

// Fills device[0..count) with PoCL's `basic` devices; see platform.c.
glint_status glint_platform_open(cl_device_id *device, uint32_t count, const char *cache_dir,
                                 struct glint_error *err);

// Appends GLINT_E_DEVICE with the name of the call and of the code.
glint_status glint_cl_fail(struct glint_error *err, const char *call, cl_int code);

void glint_programs_destroy(glint_devices *devices);

// Compiles what a launch of `items` would run, into PoCL's cache, and runs nothing. The launch waits for
// ever, so neither worker nor devices can be destroyed afterwards: for a process of one thread that
// does nothing else.
glint_status glint_compile(glint_worker *worker, glint_program *program, const char *kernel,
                           size_t items, size_t group, const struct glint_arg *args, size_t count,
                           struct glint_error *err);

#endif
