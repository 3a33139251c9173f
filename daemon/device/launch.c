// launch.c - runs a kernel to completion on the calling worker's device.
#include "device/internal.h"

#include <assert.h>
#include <string.h>

static glint_status make_kernel(cl_kernel *out, glint_program *program, struct kernels *own,
                                const char *name, struct glint_error *err)
{
    struct kernel *k = &own->kernel[own->count];
    if (own->count == GLINT_MAX_KERNELS || strlen(name) >= sizeof k->name)
        return glint_fail(err, GLINT_E_INTERNAL, "", "kernel %s does not fit the table", name);
    cl_int code;
    k->object = clCreateKernel(program->object, name, &code);
    if (code == CL_INVALID_KERNEL_NAME)
        return glint_fail(err, GLINT_E_DEVICE, "", "the program has no kernel %s", name);
    if (code)
        return glint_cl_fail(err, "clCreateKernel", code);
    strcpy(k->name, name);
    own->count++;
    *out = k->object;
    return GLINT_OK;
}

static glint_status find_kernel(cl_kernel *out, const glint_worker *worker, glint_program *program,
                                const char *name, struct glint_error *err)
{
    struct kernels *own = &program->kernels[worker->index];
    for (size_t i = 0; i < own->count; i++)
        if (!strcmp(own->kernel[i].name, name)) {
            *out = own->kernel[i].object;
            return GLINT_OK;
        }
    return make_kernel(out, program, own, name, err);
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

glint_status glint_launch(glint_worker *worker, glint_program *program, const char *kernel,
                          size_t items, size_t group, const struct glint_arg *args, size_t count,
                          struct glint_error *err)
{
    assert(group && items % group == 0);
    cl_kernel object = NULL;
    if (!items)
        return GLINT_OK;
    glint_status st = find_kernel(&object, worker, program, kernel, err);
    if (!st)
        st = set_args(object, kernel, args, count, err);
    if (st)
        return st;
    cl_int code =
        clEnqueueNDRangeKernel(worker->queue, object, 1, NULL, &items, &group, 0, NULL, NULL);
    if (!code)
        code = clFinish(worker->queue);
    return code ? glint_fail(err, GLINT_E_DEVICE, "", "kernel %s does not run (%d)", kernel, code)
                : GLINT_OK;
}
