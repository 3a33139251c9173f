// device.c - the context, one device and queue for each worker, and the worker's arithmetic.
#include "device/internal.h"

#include "device/program.h"

#include <assert.h>
#include <fenv.h>
#include <sched.h>
#include <stdlib.h>
#ifdef __SSE2__
#include <immintrin.h>
#endif

#define MAX_WORKERS 256u

static uint32_t cores(void)
{
    cpu_set_t set;
    if (sched_getaffinity(0, sizeof set, &set))
        return 1;
    const int n = CPU_COUNT(&set);
    return n < 1 ? 1 : n > (int)MAX_WORKERS ? MAX_WORKERS : (uint32_t)n;
}

static char *device_text(cl_device_id device, cl_device_info what)
{
    size_t size = 0;
    if (clGetDeviceInfo(device, what, 0, NULL, &size) || !size)
        return NULL;
    char *text = malloc(size);
    if (text && clGetDeviceInfo(device, what, size, text, NULL)) {
        free(text);
        return NULL;
    }
    return text;
}

static glint_status open_queues(glint_devices *d, struct glint_error *err)
{
    for (uint32_t i = 0; i < d->slots; i++) {
        cl_int code;
        d->worker[i] = (glint_worker){.devices = d, .index = i};
        d->worker[i].queue =
            clCreateCommandQueueWithProperties(d->context, d->device[i], NULL, &code);
        if (code)
            return glint_cl_fail(err, "clCreateCommandQueueWithProperties", code);
    }
    return GLINT_OK;
}

static glint_status open_context(glint_devices *d, const char *cache_dir, struct glint_error *err)
{
    glint_status st = glint_platform_open(d->device, d->slots, cache_dir, err);
    if (st)
        return st;
    cl_int code;
    d->context = clCreateContext(NULL, d->slots, d->device, NULL, NULL, &code);
    if (code)
        return glint_cl_fail(err, "clCreateContext", code);
    d->name = device_text(d->device[0], CL_DEVICE_NAME);
    d->version = device_text(d->device[0], CL_DRIVER_VERSION);
    if (!d->name || !d->version)
        return glint_fail(err, GLINT_E_DEVICE, "", "the device does not tell its name and version");
    return open_queues(d, err);
}

glint_status glint_devices_create(glint_devices **out, uint32_t workers, const char *cache_dir,
                                  struct glint_error *err)
{
    assert(out);
    *out = NULL;
    if (workers > MAX_WORKERS)
        return glint_fail(err, GLINT_E_RANGE, "", "%u workers: at most %u", workers, MAX_WORKERS);
    glint_devices *d = calloc(1, sizeof *d);
    if (!d)
        return glint_fail(err, GLINT_E_NOMEM, "", "no memory for devices");
    pthread_mutex_init(&d->build, NULL);
    d->workers = workers ? workers : cores();
    d->slots = d->workers + 1;
    d->device = calloc(d->slots, sizeof *d->device);
    d->worker = calloc(d->slots, sizeof *d->worker);
    glint_status st = !d->device || !d->worker
                          ? glint_fail(err, GLINT_E_NOMEM, "", "no memory for %u workers", workers)
                          : open_context(d, cache_dir, err);
    if (!st)
        st = glint_source_expand(&d->source, glint_sources, err);
    if (!st)
        st = glint_ahead_create(&d->ahead, getenv("POCL_CACHE_DIR"), NULL, err);
    if (st)
        glint_devices_destroy(&d);
    *out = d;
    return st;
}

void glint_devices_destroy(glint_devices **devices)
{
    glint_devices *d = *devices;
    if (!d)
        return;
    *devices = NULL;
    glint_programs_destroy(d);
    glint_ahead_destroy(&d->ahead);
    for (uint32_t i = 0; d->worker && i < d->slots; i++)
        if (d->worker[i].queue)
            clReleaseCommandQueue(d->worker[i].queue);
    if (d->context)
        clReleaseContext(d->context);
    pthread_mutex_destroy(&d->build);
    free(d->source);
    free(d->version);
    free(d->name);
    free(d->worker);
    free(d->device);
    free(d);
}

uint32_t glint_devices_workers(const glint_devices *devices)
{
    return devices->workers;
}

glint_worker *glint_devices_worker(glint_devices *devices, uint32_t index)
{
    assert(index < devices->workers);
    return &devices->worker[index];
}

glint_worker *glint_devices_spare(glint_devices *devices)
{
    return &devices->worker[devices->workers];
}

uint32_t glint_worker_index(const glint_worker *worker)
{
    return worker->index;
}

// Kernels get the same setting from -cl-denorms-are-zero: PoCL sets it around each launch.
void glint_worker_enter(glint_worker *worker)
{
    (void)worker;
    fesetround(FE_TONEAREST);
#ifdef __SSE2__
    const unsigned flush_to_zero = 0x8000, denormals_are_zero = 0x0040;
    _mm_setcsr(_mm_getcsr() | flush_to_zero | denormals_are_zero);
#endif
}

const char *glint_devices_name(const glint_devices *devices)
{
    return devices->name;
}

const char *glint_devices_version(const glint_devices *devices)
{
    return devices->version;
}
