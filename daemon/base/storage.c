#include "base/storage.h"

#include <errno.h>
#include <fcntl.h>
#include <stdio.h>
#include <string.h>
#include <sys/stat.h>
#include <sys/statvfs.h>
#include <unistd.h>

bool glint_storage_lacks(int why)
{
    return why == ENOSPC || why == EDQUOT || why == EFBIG || why == EROFS || why == EACCES ||
           why == EPERM;
}

glint_status glint_storage_full(struct glint_error *err, const char *folder, const char *what)
{
    struct statvfs s;
    if (statvfs(folder, &s))
        return glint_fail(err, GLINT_E_CAPACITY, "", "%s cannot be written: %s", folder, what);
    const double mib = 1 << 20, unit = (double)s.f_frsize;
    return glint_fail(err, GLINT_E_CAPACITY, "",
                      "%s cannot be written: %s; %.1f of %.1f MiB are free there%s", folder, what,
                      (double)s.f_bavail * unit / mib, (double)s.f_blocks * unit / mib,
                      s.f_flag & ST_RDONLY ? ", which is read-only" : "");
}

glint_status glint_storage_fault(struct glint_error *err, const char *folder, const char *what,
                                 int why)
{
    char text[160];
    snprintf(text, sizeof text, "%s: %s", what, strerror(why));
    return glint_storage_lacks(why) ? glint_storage_full(err, folder, text)
                                    : glint_fail(err, GLINT_E_IO, "", "%s: %s", folder, text);
}

uint64_t glint_storage_free(const char *folder)
{
    struct statvfs s;
    return statvfs(folder, &s) ? 0 : (uint64_t)s.f_bavail * s.f_frsize;
}

bool glint_storage_sync_folder(const char *path)
{
    const int fd = open(path, O_RDONLY | O_DIRECTORY | O_CLOEXEC);
    if (fd < 0)
        return false;
    const bool synced = !fsync(fd);
    const int why = errno;
    close(fd);
    errno = why;
    return synced;
}

uint64_t glint_storage_bytes(const char *folder, const char *name)
{
    char path[4096];
    struct stat s;
    snprintf(path, sizeof path, "%s/%s", folder, name);
    return stat(path, &s) ? 0 : (uint64_t)s.st_size;
}
