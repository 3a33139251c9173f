#include "memory_file.h"

#include <errno.h>
#include <string.h>
#include <sys/mman.h>
#include <unistd.h>

glint_status glint_memory_file_open(struct glint_memory_file *out, struct glint_error *err)
{
    *out = (struct glint_memory_file){.fd = memfd_create("glint", MFD_CLOEXEC)};
    return out->fd < 0 ? glint_fail(err, GLINT_E_NOMEM, "", "no memory: %s", strerror(errno))
                       : GLINT_OK;
}

bool glint_memory_file_write(void *file, const void *bytes, size_t size)
{
    struct glint_memory_file *f = file;
    for (const char *from = bytes; size && !f->error;) {
        const ssize_t wrote = write(f->fd, from, size);
        if (wrote < 0 && errno != EINTR)
            f->error = errno;
        if (wrote <= 0)
            continue;
        from += wrote;
        size -= (size_t)wrote;
        f->size += (size_t)wrote;
    }
    return !f->error;
}

glint_status glint_memory_file_map(struct glint_memory_file *file, struct glint_error *err)
{
    void *bytes = MAP_FAILED;
    if (!file->error && file->size)
        bytes = mmap(NULL, file->size, PROT_READ, MAP_PRIVATE, file->fd, 0);
    if (bytes == MAP_FAILED)
        return glint_fail(err, GLINT_E_NOMEM, "", "no memory for %zu bytes", file->size);
    file->bytes = bytes;
    return GLINT_OK;
}

void glint_memory_file_close(struct glint_memory_file *file)
{
    if (file->bytes)
        munmap((void *)(uintptr_t)file->bytes, file->size);
    close(file->fd);
    *file = (struct glint_memory_file){.fd = -1};
}
