// compiler.c - what PoCL's LLVM is told, so that it vectorises across work-items and compiles each
// kernel once.
//
// PoCL writes three copies of a kernel: by itself, as `_workgroup`, which its CPU devices call, and
// as `_workgroup_fast`, which nobody does. The two that are not called are left as they are
// (measured: a kernel is compiled in 0.4 of the time, and its machine code is the same).
#include "device/compiler.h"
#include "base/log.h"

#include <dlfcn.h>
#include <link.h>
#include <openssl/evp.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define MAX_OPTIONS 512

struct options {
    int count;
    char *text[MAX_OPTIONS];
};

static void add(struct options *o, const char *format, const char *a, const char *b)
{
    if (o->count < MAX_OPTIONS && asprintf(&o->text[o->count], format, a, b) >= 0)
        o->count++;
}

// LLVM's superword pass runs before the vectoriser of the work-item loop and leaves it code that
// it gives up on (measured: the rest of a path costs 3 times as much). It takes half of an AVX-512
// register by itself, for fear of a lower clock; whole ones give the same bits and shade surfaces
// in 0.7 of the time (measured).
static void set_vectoriser(struct options *o)
{
    add(o, "-vectorize-slp=false", NULL, NULL);
#ifdef __x86_64__
    if (__builtin_cpu_supports("avx512f"))
        add(o, "-force-vector-width=16", NULL, NULL);
    else if (__builtin_cpu_supports("avx2"))
        add(o, "-force-vector-width=8", NULL, NULL);
#endif
}

// With AVX-512 LLVM uses gathers.
const char *glint_compiler_options(void)
{
#ifdef __x86_64__
    if (__builtin_cpu_supports("avx512f"))
        return "";
#endif
    return "-DGK_NO_GATHERS";
}

static void leave_alone(struct options *o, const char *kernel, const char *copy)
{
    add(o, "-force-remove-attribute=_pocl_kernel_%s%s:alwaysinline", kernel, copy);
    add(o, "-force-attribute=_pocl_kernel_%s%s:optnone", kernel, copy);
    add(o, "-force-attribute=_pocl_kernel_%s%s:noinline", kernel, copy);
}

// The name of the kernel whose definition begins at `at`, malloc'd.
static char *kernel_name(const char *at, const char *end)
{
    size_t length = 0;
    while (at + length < end && at[length] != '(')
        length++;
    return strndup(at, length);
}

static void compile_once(struct options *o, const struct glint_source *table)
{
    static const char definition[] = "__kernel void ";
    for (; table->name; table++) {
        const char *at = table->text, *end = at + table->length;
        while ((at = memmem(at, (size_t)(end - at), definition, sizeof definition - 1))) {
            at += sizeof definition - 1;
            char *kernel = kernel_name(at, end);
            if (kernel) {
                leave_alone(o, kernel, "");
                leave_alone(o, kernel, "_workgroup_fast");
            }
            free(kernel);
        }
    }
}

static int is_llvm(struct dl_phdr_info *info, size_t size, void *path)
{
    (void)size;
    const char *base = strrchr(info->dlpi_name, '/');
    if (strncmp(base ? base + 1 : info->dlpi_name, "libLLVM", 7))
        return 0;
    *(const char **)path = info->dlpi_name;
    return 1;
}

// The options of a loaded LLVM can be set once in a process: a second attempt would end it.
static bool tell_llvm(const struct options *o)
{
    const char *path = NULL;
    dl_iterate_phdr(is_llvm, &path);
    void *llvm = path ? dlopen(path, RTLD_NOW | RTLD_NOLOAD) : NULL;
    void (*parse)(int, const char *const *, const char *) = NULL;
    if (llvm)
        *(void **)&parse = dlsym(llvm, "LLVMParseCommandLineOptions");
    if (!parse) {
        glint_log(GLINT_LOG_WARNING, "cl", NULL, NULL,
                  "no libLLVM to set the vectoriser of: kernels will be slow");
        return false;
    }
    parse(o->count, (const char *const *)o->text, "");
    glint_log(GLINT_LOG_DEBUG, "cl", NULL, NULL, "%s is given %d options", path, o->count);
    return true;
}

static bool digest(const struct options *o, const char *platform, unsigned char out[32])
{
    EVP_MD_CTX *hash = EVP_MD_CTX_new();
    bool ok = hash && EVP_DigestInit_ex(hash, EVP_sha256(), NULL) &&
              EVP_DigestUpdate(hash, platform, strlen(platform) + 1);
    for (int i = 0; ok && i < o->count; i++)
        ok = EVP_DigestUpdate(hash, o->text[i], strlen(o->text[i]) + 1);
    ok = ok && EVP_DigestFinal_ex(hash, out, NULL);
    EVP_MD_CTX_free(hash);
    return ok;
}

static void name_folder(char *folder, const struct options *o, const char *platform)
{
    unsigned char sum[32] = {0};
    if (!digest(o, platform, sum))
        glint_log(GLINT_LOG_WARNING, "cl", NULL, NULL, "the kernel cache has no name of its own");
    char *at = folder + sprintf(folder, "pocl-");
    for (int i = 0; i < 8; i++)
        at += sprintf(at, "%02x", sum[i]);
}

static void fill(struct options *o, const struct glint_source *table)
{
    add(o, "glintd", NULL, NULL);
    set_vectoriser(o);
    compile_once(o, table);
}

static void empty(struct options *o)
{
    while (o->count > 0)
        free(o->text[--o->count]);
}

void glint_compiler_name(char folder[GLINT_COMPILER_FOLDER], const struct glint_source *table,
                         const char *platform)
{
    struct options o = {0};
    fill(&o, table);
    name_folder(folder, &o, platform);
    empty(&o);
}

void glint_compiler_set(char folder[GLINT_COMPILER_FOLDER], const struct glint_source *table,
                        const char *platform)
{
    struct options o = {0};
    fill(&o, table);
    if (!tell_llvm(&o))
        empty(&o);
    name_folder(folder, &o, platform);
    empty(&o);
}
