// program.c - builds program variants and keeps them for the next job that needs one.
#include "device/program.h"

#include "base/log.h"
#include "device/ahead.h"
#include "device/bitcode.h"
#include "device/compiler.h"
#include "device/internal.h"
#include "device/listing.h"

#include <assert.h>
#include <limits.h>
#include <openssl/evp.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

// What every variant is built with. There is no fast-math flag: infinity is a value here. Whoever
// compiles ahead of the first launch needs to know the arguments of a kernel.
#define COMMON_OPTIONS "-cl-std=CL1.2 -cl-denorms-are-zero -cl-kernel-arg-info -DGK_DEVICE"

// Idle programs above this number are dropped, the longest unused first.
#define MAX_PROGRAMS 32

#define MAX_LOG 16384

bool glint_program_key_of(char key[65], const glint_devices *devices, const char *source,
                          const char *options)
{
    const char *part[] = {source,        options,         COMMON_OPTIONS, glint_compiler_options(),
                          devices->name, devices->version};
    unsigned char digest[32];
    EVP_MD_CTX *hash = EVP_MD_CTX_new();
    bool ok = hash && EVP_DigestInit_ex(hash, EVP_sha256(), NULL);
    for (size_t i = 0; ok && i < sizeof part / sizeof *part; i++)
        ok = EVP_DigestUpdate(hash, part[i], strlen(part[i]) + 1); // terminators keep parts apart
    ok = ok && EVP_DigestFinal_ex(hash, digest, NULL);
    EVP_MD_CTX_free(hash);
    for (size_t i = 0; ok && i < sizeof digest; i++)
        sprintf(key + 2 * i, "%02x", digest[i]);
    return ok;
}

static void fail_with_log(struct glint_error *err, cl_program program, cl_device_id device,
                          const char *options)
{
    size_t size = 0;
    clGetProgramBuildInfo(program, device, CL_PROGRAM_BUILD_LOG, 0, NULL, &size);
    char *log = calloc(1, size + 1);
    if (log)
        clGetProgramBuildInfo(program, device, CL_PROGRAM_BUILD_LOG, size, log, NULL);
    glint_fail(err, GLINT_E_DEVICE, "", "kernels do not build with \"%s\": %.*s", options, MAX_LOG,
               log ? log : "");
    free(log);
}

char *glint_program_options(const char *options)
{
    char *all = NULL;
    return asprintf(&all, COMMON_OPTIONS " %s %s", glint_compiler_options(), options) < 0 ? NULL
                                                                                          : all;
}

static glint_status compile_source(glint_program *p, glint_devices *devices, const char *source,
                                   const char *options, struct glint_error *err)
{
    cl_int code;
    p->object = clCreateProgramWithSource(devices->context, 1, &source, NULL, &code);
    if (code)
        return glint_cl_fail(err, "clCreateProgramWithSource", code);
    code = clBuildProgram(p->object, devices->slots, devices->device, options, NULL, NULL);
    if (code)
        fail_with_log(err, p->object, devices->device[0], options);
    return code ? GLINT_E_DEVICE : GLINT_OK;
}

// Of what was made of the source ahead. False: nothing is there, or nothing of use.
static bool recall(glint_program *p, glint_devices *devices, const char *options)
{
    char path[PATH_MAX];
    if (!devices->ahead ||
        !glint_listing_bitcode(glint_ahead_cache(devices->ahead), p->key, path, sizeof path))
        return false;
    p->object = glint_bitcode_program(devices, devices->slots, path);
    if (p->object &&
        !clBuildProgram(p->object, devices->slots, devices->device, options, NULL, NULL))
        return true;
    if (p->object)
        clReleaseProgram(p->object);
    p->object = NULL;
    return false;
}

static glint_status compile(glint_program *p, glint_devices *devices, const char *source,
                            const char *options, struct glint_error *err)
{
    char *all = glint_program_options(options);
    if (!all)
        return glint_fail(err, GLINT_E_NOMEM, "", "no memory for build options");
    const glint_status st =
        recall(p, devices, all) ? GLINT_OK : compile_source(p, devices, source, all, err);
    free(all);
    return st;
}

static void destroy(glint_program *p)
{
    for (uint32_t i = 0; p->kernels && i < p->slots; i++)
        for (size_t k = 0; k < p->kernels[i].count; k++)
            clReleaseKernel(p->kernels[i].kernel[k].object);
    if (p->object)
        clReleaseProgram(p->object);
    pthread_mutex_destroy(&p->names);
    free(p->kernels);
    free(p);
}

static glint_status create(glint_program **out, glint_devices *devices, const char *key,
                           const char *source, const char *options, struct glint_error *err)
{
    glint_program *p = calloc(1, sizeof *p);
    if (p)
        p->kernels = calloc(devices->slots, sizeof *p->kernels);
    if (!p || !p->kernels) {
        free(p);
        return glint_fail(err, GLINT_E_NOMEM, "", "no memory for a program");
    }
    p->slots = devices->slots;
    pthread_mutex_init(&p->names, NULL);
    strcpy(p->key, key);
    glint_status st = compile(p, devices, source, options, err);
    if (st) {
        destroy(p);
        return st;
    }
    glint_log(GLINT_LOG_DEBUG, "cl", NULL, NULL, "built program %.12s \"%s\"", key, options);
    *out = p;
    return GLINT_OK;
}

static glint_program *find(glint_devices *devices, const char *key)
{
    for (glint_program **at = &devices->program; *at; at = &(*at)->next) {
        glint_program *p = *at;
        if (strcmp(p->key, key))
            continue;
        *at = p->next; // to the front, below
        return p;
    }
    return NULL;
}

// Only the cache gives out references, under the mutex: a program that has just the cache's cannot
// gain another meanwhile.
static void drop_idle(glint_devices *devices)
{
    size_t count = 0;
    for (glint_program **at = &devices->program; *at;) {
        glint_program *p = *at;
        if (++count <= MAX_PROGRAMS ||
            atomic_load_explicit(&p->references, memory_order_acquire) > 1) {
            at = &p->next;
            continue;
        }
        *at = p->next;
        destroy(p);
    }
}

// The program, retained, or NULL where it is not loaded.
static glint_program *look_up(glint_devices *devices, const char *key)
{
    pthread_mutex_lock(&devices->build);
    glint_program *p = find(devices, key);
    if (p) {
        atomic_fetch_add_explicit(&p->references, 1, memory_order_relaxed);
        p->next = devices->program;
        devices->program = p;
    }
    pthread_mutex_unlock(&devices->build);
    return p;
}

// Another thread may have loaded it meanwhile.
static glint_status load(glint_program **out, glint_devices *devices, const char *key,
                         const char *source, const char *options, struct glint_error *err)
{
    glint_status st = GLINT_OK;
    pthread_mutex_lock(&devices->build);
    glint_program *p = find(devices, key);
    if (!p) {
        st = create(&p, devices, key, source, options, err);
        if (!st)
            atomic_init(&p->references, 1);
    }
    if (!st) {
        atomic_fetch_add_explicit(&p->references, 1, memory_order_relaxed);
        p->next = devices->program;
        devices->program = p;
        drop_idle(devices);
    }
    pthread_mutex_unlock(&devices->build);
    *out = p;
    return st;
}

glint_status glint_program_build(glint_program **out, glint_devices *devices, const char *source,
                                 const char *options, struct glint_error *err)
{
    char key[65];
    assert(out && devices && source && options);
    *out = NULL;
    if (!glint_program_key_of(key, devices, source, options))
        return glint_fail(err, GLINT_E_NOMEM, "", "no memory for a program's key");
    *out = look_up(devices, key);
    return *out ? GLINT_OK : load(out, devices, key, source, options, err);
}

// What the embedded kernels compile to is made ahead, beside those who find theirs loaded.
glint_status glint_program_get(glint_program **out, glint_devices *devices, const char *options,
                               struct glint_error *err)
{
    char key[65];
    assert(out && devices && options);
    *out = NULL;
    if (!glint_program_key_of(key, devices, devices->source, options))
        return glint_fail(err, GLINT_E_NOMEM, "", "no memory for a program's key");
    *out = look_up(devices, key);
    if (*out)
        return GLINT_OK;
    const glint_status st =
        devices->ahead ? glint_ahead_compile(devices->ahead, key, options, err) : GLINT_OK;
    return st ? st : load(out, devices, key, devices->source, options, err);
}

// Release order: what the holder did with the program happened before the cache destroys it.
void glint_program_release(glint_program **program)
{
    if (*program)
        atomic_fetch_sub_explicit(&(*program)->references, 1, memory_order_release);
    *program = NULL;
}

const char *glint_program_key(const glint_program *program)
{
    return program->key;
}

void glint_programs_destroy(glint_devices *devices)
{
    while (devices->program) {
        glint_program *p = devices->program;
        devices->program = p->next;
        assert(atomic_load(&p->references) == 1);
        destroy(p);
    }
}
