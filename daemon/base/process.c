#include "base/process.h"

#include <dirent.h>
#include <fcntl.h>
#include <stdio.h>
#include <string.h>
#include <sys/resource.h>
#include <unistd.h>

// The start of a file of /proc as text.
static void read_text(char *text, size_t size, const char *path)
{
    const int fd = open(path, O_RDONLY | O_CLOEXEC);
    const ssize_t n = fd < 0 ? 0 : read(fd, text, size - 1);
    text[n > 0 ? n : 0] = '\0';
    if (fd >= 0)
        close(fd);
}

// Seconds since 1970 at which the machine was started.
static double boot_time(void)
{
    char text[8192];
    unsigned long long seconds = 0;
    read_text(text, sizeof text, "/proc/stat");
    const char *line = strstr(text, "btime ");
    return line && sscanf(line, "btime %llu", &seconds) == 1 ? (double)seconds : 0;
}

// Fields from the third on of /proc/self/stat, see proc(5): the name before them may hold anything.
static void read_stat(struct glint_process *out)
{
    char text[1024];
    unsigned long long user = 0, system = 0, start = 0, bytes = 0, pages = 0;
    long threads = 0;
    read_text(text, sizeof text, "/proc/self/stat");
    const char *fields = strrchr(text, ')');
    if (!fields ||
        sscanf(fields,
               ") %*c %*d %*d %*d %*d %*d %*u %*u %*u %*u %*u %llu %llu %*d %*d %*d %*d %ld %*d "
               "%llu %llu %llu",
               &user, &system, &threads, &start, &bytes, &pages) != 6)
        return;
    const double ticks = (double)sysconf(_SC_CLK_TCK);
    out->cpu_seconds = (double)(user + system) / ticks;
    out->threads = (uint32_t)threads;
    out->virtual_bytes = bytes;
    out->resident_bytes = pages * (uint64_t)sysconf(_SC_PAGESIZE);
    const double boot = boot_time();
    out->started = boot > 0 ? boot + (double)start / ticks : 0;
}

static uint32_t count_files(void)
{
    DIR *folder = opendir("/proc/self/fd");
    uint32_t count = 0;
    if (!folder)
        return 0;
    for (const struct dirent *e; (e = readdir(folder));)
        count += e->d_name[0] != '.';
    closedir(folder);
    return count - 1; // the folder's own
}

void glint_process_look(struct glint_process *out)
{
    *out = (struct glint_process){.files = count_files()};
    struct rlimit limit;
    if (!getrlimit(RLIMIT_NOFILE, &limit))
        out->most_files = limit.rlim_cur < UINT32_MAX ? (uint32_t)limit.rlim_cur : UINT32_MAX;
    read_stat(out);
}
