// device.h - OpenCL devices, one worker each, the program cache and resident buffers.
// The only folder that names cl_*; others pass these handles about.
//
// One PoCL `basic` device per worker, all in one context: a kernel runs in the thread that
// enqueues it, and buffers are host memory that kernels take as it is, so Embree reads them in place.
//
// Threads: create/destroy by main; glint_program_* by whoever prepares a job; everything that
// takes a worker by that worker only.
#ifndef GLINT_DEVICE_DEVICE_H
#define GLINT_DEVICE_DEVICE_H

#include "protocol/status.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

typedef struct glint_devices glint_devices;
typedef struct glint_worker glint_worker;   // index, device, in-order queue, kernel objects
typedef struct glint_program glint_program; // one variant, built for every worker
typedef struct glint_buffer glint_buffer;   // memory that kernels and host share

// Before the first glint_devices_create() of a process that will call it once: there need be no room
// for a larger set of workers, and a start is 30 ms shorter.
void glint_devices_once(void);

// workers: 1..256 (0: one per core). Sets the environment PoCL reads, so call it before any thread
// is started. cache_dir: where PoCL keeps compiled kernels, NULL for its default.
glint_status glint_devices_create(glint_devices **out, uint32_t workers, const char *cache_dir,
                                  struct glint_error *err);
void glint_devices_destroy(glint_devices **devices);

uint32_t glint_devices_workers(const glint_devices *devices);
glint_worker *glint_devices_worker(glint_devices *devices, uint32_t index);
// One worker more, that renders nothing: PoCL compiles a kernel when it is first launched, seconds
// of work, so whoever prepares a job launches its kernels here before any real worker does. One
// thread at a time. The grid must be the widest that any worker will use: PoCL 3.1 makes a new entry
// of its cache for every wider one but counts uses at the newest, so that workers who bring a wider
// grid while another runs the kernel end the process (pocl_release_dlhandle_cache: ref_count > 0).
glint_worker *glint_devices_spare(glint_devices *devices);
uint32_t glint_worker_index(const glint_worker *worker);

// Sets rounding and flush-to-zero for the calling thread: every thread that runs kernels or traces
// rays calls it first, so that results do not depend on the thread.
void glint_worker_enter(glint_worker *worker);

const char *glint_devices_name(const glint_devices *devices);    // of the first device
const char *glint_devices_version(const glint_devices *devices); // driver version

// Looks the variant up by (source, options) or builds it; retained for the caller.
// options: "-DGK_HAS_ENV ...", in a fixed order. GLINT_E_DEVICE: the build log is in *err.
glint_status glint_program_get(glint_program **out, glint_devices *devices, const char *options,
                               struct glint_error *err);
void glint_program_release(glint_program **program);

// Compiles a variant for later, in idle time: given up as soon as anybody wants another that is not
// compiled yet, or after glint_devices_hurry(). False: given up.
bool glint_program_foresee(glint_devices *devices, const char *options);
// The same for what other releases of these kernels were compiled to, here and not long ago; what
// nobody has used for a month goes.
bool glint_program_foresee_known(glint_devices *devices);
void glint_devices_hurry(glint_devices *devices);
// Loads what was used last, in this process or one before: the next job most likely wants it too.
// False: there is nothing.
bool glint_program_recall(glint_devices *devices);

// Page-aligned zeroed memory of `bytes`, visible to kernels as it is. GLINT_E_CAPACITY over 1 GiB.
// Counted: retain and destroy by any thread, the last destroy frees.
glint_status glint_buffer_create(glint_buffer **out, glint_devices *devices, size_t bytes,
                                 struct glint_error *err);
glint_buffer *glint_buffer_retain(glint_buffer *buffer);
void glint_buffer_destroy(glint_buffer **buffer);
void *glint_buffer_host(glint_buffer *buffer);
size_t glint_buffer_bytes(const glint_buffer *buffer);

// One argument of a launch.
struct glint_arg {
    glint_buffer *buffer; // or NULL: the value; where that is NULL too, a null pointer
    const void *value;
    size_t size;
};

// Runs `items` work-items of the named kernel (a multiple of `group`) to completion.
glint_status glint_launch(glint_worker *worker, glint_program *program, const char *kernel,
                          size_t items, size_t group, const struct glint_arg *args, size_t count,
                          struct glint_error *err);

#endif
