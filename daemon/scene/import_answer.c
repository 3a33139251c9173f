// import_answer.c - writing and distrustful reading of the answer memfd.
#include "scene/import_answer.h"

#include "base/sha256.h"
#include "base/thread.h"

#include <stdatomic.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <unistd.h>

#define MAGIC 0x474c4e41u // "GLNA"
#define BLOB_ALIGN 64u    // assets are read in place as arrays of floats

struct span {
    uint64_t offset, length; // strings: without the NUL that follows
};

struct header {
    uint32_t magic, status;
    uint32_t faults, warnings, assets, reserved;
    double seconds;
    struct span text;
};

struct fault_row {
    struct span pointer, detail;
};

struct asset_row {
    char sha256[72];
    struct span bytes;
};

// --- writing

struct writer {
    int fd;
    uint64_t at; // where the next byte of the strings and blobs goes
    bool failed;
};

static void put(struct writer *w, uint64_t offset, const void *bytes, size_t size)
{
    const char *from = bytes;
    while (size && !w->failed) {
        const ssize_t n = pwrite(w->fd, from, size, (off_t)offset);
        w->failed = n <= 0;
        if (n > 0) {
            from += n;
            offset += (uint64_t)n;
            size -= (size_t)n;
        }
    }
}

static struct span put_string(struct writer *w, const char *text, size_t length)
{
    const struct span s = {w->at, length};
    put(w, w->at, text, length);
    put(w, w->at + length, "", 1);
    w->at += length + 1;
    return s;
}

static struct span put_blob(struct writer *w, const void *bytes, size_t size)
{
    w->at = (w->at + BLOB_ALIGN - 1) / BLOB_ALIGN * BLOB_ALIGN;
    const struct span s = {w->at, size};
    put(w, w->at, bytes, size);
    w->at += size;
    return s;
}

static uint64_t tables_end(const struct header *h)
{
    return sizeof *h + (uint64_t)h->faults * sizeof(struct fault_row) +
           (uint64_t)h->warnings * sizeof(struct span) +
           (uint64_t)h->assets * sizeof(struct asset_row);
}

static uint64_t put_faults(struct writer *w, uint64_t table, const struct glint_error *error)
{
    for (size_t i = 0; i < error->count; i++) {
        const struct glint_fault *f = &error->fault[i];
        const struct fault_row row = {put_string(w, f->pointer, strlen(f->pointer)),
                                      put_string(w, f->detail, strlen(f->detail))};
        put(w, table, &row, sizeof row);
        table += sizeof row;
    }
    return table;
}

static uint64_t put_warnings(struct writer *w, uint64_t table, const struct glint_answer *a)
{
    for (size_t i = 0; i < a->warnings; i++) {
        const struct span row = put_string(w, a->warning[i], strlen(a->warning[i]));
        put(w, table, &row, sizeof row);
        table += sizeof row;
    }
    return table;
}

static void put_assets(struct writer *w, uint64_t table, const struct glint_answer *a)
{
    for (size_t i = 0; i < a->assets; i++) {
        struct asset_row row = {.bytes = put_blob(w, a->asset[i].bytes, a->asset[i].size)};
        memcpy(row.sha256, a->asset[i].sha256, sizeof a->asset[i].sha256);
        put(w, table, &row, sizeof row);
        table += sizeof row;
    }
}

glint_status glint_answer_write(int fd, const struct glint_answer *a)
{
    struct header h = {.magic = MAGIC,
                       .status = a->error->status,
                       .faults = (uint32_t)a->error->count,
                       .warnings = (uint32_t)a->warnings,
                       .assets = (uint32_t)a->assets,
                       .seconds = a->seconds};
    struct writer w = {.fd = fd, .at = tables_end(&h)};
    uint64_t table = put_faults(&w, sizeof h, a->error);
    table = put_warnings(&w, table, a);
    put_assets(&w, table, a);
    if (a->text)
        h.text = put_string(&w, a->text, a->length);
    put(&w, 0, &h, sizeof h);
    return w.failed ? GLINT_E_IO : GLINT_OK;
}

// --- reading

struct answer {
    const uint8_t *base;
    uint64_t size;
    bool alone;
    struct header header;
};

static bool inside(const struct answer *a, struct span s)
{
    return s.offset <= a->size && s.length <= a->size - s.offset;
}

// The string, which lies in the mapping with its NUL, or NULL.
static char *string_at(const struct answer *a, struct span s)
{
    if (!inside(a, s) || s.length >= a->size - s.offset)
        return NULL;
    char *text = (char *)a->base + s.offset;
    return text[s.length] == '\0' && strlen(text) == s.length ? text : NULL;
}

static bool read_faults(const struct answer *a, struct glint_error *err)
{
    const glint_status status = (glint_status)a->header.status;
    if (!a->header.faults) // there was no memory to say more
        glint_fail(err, status, "", "%s", glint_status_title(status));
    for (uint32_t i = 0; i < a->header.faults; i++) {
        struct fault_row row;
        memcpy(&row, a->base + sizeof a->header + i * sizeof row, sizeof row);
        const char *pointer = string_at(a, row.pointer), *detail = string_at(a, row.detail);
        if (!pointer || !detail)
            return false;
        glint_fail(err, status, pointer, "%s", detail);
    }
    return true;
}

static bool read_warnings(const struct answer *a, struct glint_import *im)
{
    const uint8_t *table =
        a->base + sizeof a->header + (size_t)a->header.faults * sizeof(struct fault_row);
    for (uint32_t i = 0; i < a->header.warnings; i++) {
        struct span row;
        memcpy(&row, table + i * sizeof row, sizeof row);
        im->warning[i] = string_at(a, row);
        if (!im->warning[i])
            return false;
    }
    im->warnings = a->header.warnings;
    return true;
}

struct reading {
    const struct answer *answer;
    struct glint_import *import;
    atomic_bool broken; // relaxed: the end of all publishes it
};

static bool read_asset(const struct answer *a, const struct asset_row *row, struct glint_asset *out)
{
    if (!inside(a, row->bytes) || row->bytes.offset % BLOB_ALIGN)
        return false;
    out->bytes = a->base + row->bytes.offset;
    out->size = row->bytes.length;
    glint_sha256(out->bytes, out->size, out->sha256);
    return memcmp(out->sha256, row->sha256, sizeof out->sha256) == 0;
}

static void read_row(void *user, size_t i)
{
    struct reading *r = user;
    const struct answer *a = r->answer;
    struct asset_row row;
    memcpy(&row, a->base + tables_end(&a->header) - (a->header.assets - i) * sizeof row,
           sizeof row);
    if (!read_asset(a, &row, &r->import->asset[i]))
        atomic_store_explicit(&r->broken, true, memory_order_relaxed);
}

static bool read_assets(const struct answer *a, struct glint_import *im)
{
    struct reading r = {.answer = a, .import = im};
    const size_t assets = a->header.assets;
    if (!a->alone)
        glint_thread_each("assets", assets, read_row, &r);
    for (size_t i = 0; a->alone && i < assets; i++)
        read_row(&r, i);
    im->assets = assets;
    return !r.broken;
}

static bool read_header(struct answer *a)
{
    if (a->size < sizeof a->header)
        return false;
    memcpy(&a->header, a->base, sizeof a->header);
    const struct header *h = &a->header;
    return h->magic == MAGIC && h->status < GLINT_STATUS_COUNT && tables_end(h) <= a->size &&
           h->faults <= GLINT_MAX_FAULTS && (h->status != GLINT_OK || h->faults == 0);
}

static glint_status broken(struct glint_error *err)
{
    return glint_fail(err, GLINT_E_RANGE, "", "the importer gave an answer that makes no sense");
}

static glint_status read_import(const struct answer *a, struct glint_import *im,
                                struct glint_error *err)
{
    im->text = string_at(a, a->header.text);
    im->length = a->header.text.length;
    im->seconds = a->header.seconds;
    im->warning = calloc(a->header.warnings + 1u, sizeof *im->warning);
    im->asset = calloc(a->header.assets + 1u, sizeof *im->asset);
    if (!im->warning || !im->asset)
        return glint_fail(err, GLINT_E_NOMEM, "", "no memory for %u assets", a->header.assets);
    if (!im->text || !read_warnings(a, im) || !read_assets(a, im))
        return broken(err);
    return GLINT_OK;
}

static glint_status read_answer(struct answer *a, struct glint_import *im, struct glint_error *err)
{
    if (!read_header(a))
        return broken(err);
    if (a->header.status == GLINT_OK)
        return read_import(a, im, err);
    return read_faults(a, err) ? (glint_status)a->header.status : broken(err);
}

static void unmap(void *base, size_t bytes)
{
    munmap(base, bytes);
}

// NULL without memory.
static glint_memory_ref *map(int fd, struct answer *a)
{
    void *base = mmap(NULL, a->size, PROT_READ, MAP_PRIVATE, fd, 0);
    if (base == MAP_FAILED)
        return NULL;
    glint_memory_ref *memory = glint_memory_ref_create(base, a->size, unmap);
    if (!memory)
        munmap(base, a->size);
    a->base = base;
    return memory;
}

glint_status glint_answer_read(int fd, bool alone, struct glint_import **out,
                               struct glint_error *err)
{
    *out = NULL;
    const off_t size = lseek(fd, 0, SEEK_END); // in the jail too, where fstat is not to be had
    if (size <= 0)
        return broken(err);
    struct answer a = {.size = (uint64_t)size, .alone = alone};
    struct glint_import *im = calloc(1, sizeof *im);
    if (im)
        im->memory = map(fd, &a);
    if (!im || !im->memory) {
        free(im);
        return glint_fail(err, GLINT_E_NOMEM, "", "no memory to read %lld bytes of import",
                          (long long)size);
    }
    const glint_status status = read_answer(&a, im, err);
    if (status)
        glint_import_destroy(&im);
    *out = im;
    return status;
}

void glint_import_destroy(struct glint_import **import)
{
    struct glint_import *im = *import;
    *import = NULL;
    if (!im)
        return;
    if (im->asset != im->set.asset)
        free(im->asset);
    glint_asset_set_release(&im->set);
    glint_memory_ref_release(&im->memory);
    free(im->warning);
    free(im);
}
