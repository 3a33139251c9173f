// launch.c - runs a kernel to completion on the calling worker's device.
//
// PoCL 3.1 counts the launches under way of each kernel that it has loaded, and ends the process
// when a count would fall below zero. It looks loaded code up by kernel, group and "at least as
// large a launch", but gives it back to the first of that kernel and group: while one worker runs
// a kernel, another that launches it larger than ever before loads it once more, and each takes
// the other's count. So a launch that may load runs alone, all others side by side. Code is thrown
// out, the longest unused first, when 128 kernels are loaded; from then on any that rested might be
// loaded again.
#include "device/internal.h"

#include <assert.h>
#include <string.h>

// A few less than PoCL's 128.
#define POCL_KEEPS 120u

// Launches hold it for reading, loads for writing. Loads go first: launches follow each other
// without a gap. What was loaded outlives the devices, so both are the process's.
static pthread_rwlock_t loads = PTHREAD_RWLOCK_WRITER_NONRECURSIVE_INITIALIZER_NP;
static unsigned loaded; // how often so far

static struct code *find_code(glint_program *program, const char *name, size_t group)
{
    pthread_mutex_lock(&program->names);
    struct code *code = program->code, *end = code + program->codes;
    while (code < end && (code->group != group || strcmp(code->name, name)))
        code++;
    if (code == end && program->codes < GLINT_MAX_KERNELS && strlen(name) < sizeof code->name) {
        strcpy(code->name, name);
        code->group = group;
        program->codes++;
        end++;
    }
    pthread_mutex_unlock(&program->names);
    return code < end ? code : NULL;
}

static glint_status make_kernel(struct kernel **out, glint_program *program, struct kernels *own,
                                const char *name, size_t group, struct glint_error *err)
{
    struct kernel *k = &own->kernel[own->count];
    struct code *code = find_code(program, name, group);
    if (!code || own->count == GLINT_MAX_KERNELS)
        return glint_fail(err, GLINT_E_INTERNAL, "", "kernel %s does not fit the table", name);
    cl_int failure;
    k->code = code;
    k->object = clCreateKernel(program->object, name, &failure);
    if (failure == CL_INVALID_KERNEL_NAME)
        return glint_fail(err, GLINT_E_DEVICE, "", "the program has no kernel %s", name);
    if (failure)
        return glint_cl_fail(err, "clCreateKernel", failure);
    own->count++;
    *out = k;
    return GLINT_OK;
}

static glint_status find_kernel(struct kernel **out, const glint_worker *worker,
                                glint_program *program, const char *name, size_t group,
                                struct glint_error *err)
{
    struct kernels *own = &program->kernels[worker->index];
    for (size_t i = 0; i < own->count; i++)
        if (own->kernel[i].code->group == group && !strcmp(own->kernel[i].code->name, name)) {
            *out = &own->kernel[i];
            return GLINT_OK;
        }
    return make_kernel(out, program, own, name, group, err);
}

static glint_status set_args(cl_kernel kernel, const char *name, const struct glint_arg *args,
                             size_t count, struct glint_error *err)
{
    for (size_t i = 0; i < count; i++) {
        const struct glint_arg *a = &args[i];
        cl_int code = a->value ? clSetKernelArg(kernel, (cl_uint)i, a->size, a->value)
                               : clSetKernelArgSVMPointer(kernel, (cl_uint)i,
                                                          a->buffer ? a->buffer->host : NULL);
        if (code)
            return glint_fail(err, GLINT_E_DEVICE, "", "kernel %s refuses argument %zu (%d)", name,
                              i, code);
    }
    return GLINT_OK;
}

static cl_int run(const glint_worker *worker, const struct kernel *kernel, size_t items)
{
    const size_t group = kernel->code->group;
    cl_int failure = clEnqueueNDRangeKernel(worker->queue, kernel->object, 1, NULL, &items, &group,
                                            0, NULL, NULL);
    return failure ? failure : clFinish(worker->queue);
}

// A load may have thrown out any code that was not launched since the load before it.
static void forget_idle(glint_devices *devices)
{
    pthread_mutex_lock(&devices->build);
    for (glint_program *p = devices->program; p; p = p->next) {
        pthread_mutex_lock(&p->names);
        for (size_t i = 0; i < p->codes; i++)
            if (atomic_load_explicit(&p->code[i].used_at, memory_order_relaxed) + 1 < loaded)
                p->code[i].largest = 0;
        pthread_mutex_unlock(&p->names);
    }
    pthread_mutex_unlock(&devices->build);
}

static cl_int run_alone(const glint_worker *worker, const struct kernel *kernel, size_t items)
{
    struct code *code = kernel->code;
    pthread_rwlock_wrlock(&loads);
    const cl_int failure = run(worker, kernel, items);
    if (!failure && items > code->largest) { // else another has loaded it meanwhile
        code->largest = items;
        atomic_store_explicit(&code->used_at, ++loaded, memory_order_relaxed);
        if (loaded >= POCL_KEEPS)
            forget_idle(worker->devices);
    }
    pthread_rwlock_unlock(&loads);
    return failure;
}

static cl_int run_safely(const glint_worker *worker, const struct kernel *kernel, size_t items)
{
    struct code *code = kernel->code;
    cl_int failure = CL_SUCCESS;
    pthread_rwlock_rdlock(&loads);
    const bool found = items <= code->largest;
    if (found) {
        if (atomic_load_explicit(&code->used_at, memory_order_relaxed) != loaded)
            atomic_store_explicit(&code->used_at, loaded, memory_order_relaxed);
        failure = run(worker, kernel, items);
    }
    pthread_rwlock_unlock(&loads);
    return found ? failure : run_alone(worker, kernel, items);
}

// Enqueued behind an event that never comes: PoCL compiles what it is given at once, ready or not.
// (Where such an event fails, PoCL 3.1 unlocks what it has not locked and ends the process.)
static cl_int run_never(const glint_worker *worker, const struct kernel *kernel, size_t items)
{
    static cl_event never; // of the one thread that compiles
    const size_t group = kernel->code->group;
    cl_int failure = CL_SUCCESS;
    if (!never)
        never = clCreateUserEvent(worker->devices->context, &failure);
    return failure ? failure
                   : clEnqueueNDRangeKernel(worker->queue, kernel->object, 1, NULL, &items, &group,
                                            1, &never, NULL);
}

glint_status glint_compile(glint_worker *worker, glint_program *program, const char *kernel,
                           size_t items, size_t group, const struct glint_arg *args, size_t count,
                           struct glint_error *err)
{
    assert(group && items && items % group == 0);
    struct kernel *k = NULL;
    glint_status st = find_kernel(&k, worker, program, kernel, group, err);
    if (!st)
        st = set_args(k->object, kernel, args, count, err);
    if (st)
        return st;
    const cl_int failure = run_never(worker, k, items);
    return failure ? glint_fail(err, GLINT_E_DEVICE, "", "kernel %s does not compile (%d)", kernel,
                                failure)
                   : GLINT_OK;
}

glint_status glint_launch(glint_worker *worker, glint_program *program, const char *kernel,
                          size_t items, size_t group, const struct glint_arg *args, size_t count,
                          struct glint_error *err)
{
    assert(group && items % group == 0);
    struct kernel *k = NULL;
    if (!items)
        return GLINT_OK;
    glint_status st = find_kernel(&k, worker, program, kernel, group, err);
    if (!st)
        st = set_args(k->object, kernel, args, count, err);
    if (st)
        return st;
    const cl_int failure = run_safely(worker, k, items);
    return failure
               ? glint_fail(err, GLINT_E_DEVICE, "", "kernel %s does not run (%d)", kernel, failure)
               : GLINT_OK;
}
