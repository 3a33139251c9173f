// import_jail.c - resource limits and the system call filter.
#include "scene/import_jail.h"

#include <errno.h>
#include <fcntl.h>
#include <math.h>
#include <seccomp.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <unistd.h>

static bool limit(int resource, rlim_t soft, rlim_t hard)
{
    const struct rlimit r = {soft, hard};
    return setrlimit(resource, &r) == 0;
}

// Bytes of address space in use; 0 if the kernel does not say.
static size_t address_space(void)
{
    char text[64] = "";
    const int fd = open("/proc/self/statm", O_RDONLY | O_CLOEXEC);
    if (fd < 0)
        return 0;
    const ssize_t n = read(fd, text, sizeof text - 1);
    close(fd);
    return n > 0 ? strtoul(text, NULL, 10) * (size_t)sysconf(_SC_PAGESIZE) : 0;
}

static bool limit_resources(const struct glint_import_limits *limits)
{
    const size_t used = address_space();
    const rlim_t memory = used + limits->memory_bytes;
    const rlim_t cpu = (rlim_t)ceil(limits->cpu_seconds);
    return used && limit(RLIMIT_AS, memory, memory) && limit(RLIMIT_CPU, cpu, cpu + 1) &&
           limit(RLIMIT_FSIZE, limits->memory_bytes, limits->memory_bytes) &&
           limit(RLIMIT_CORE, 0, 0) && limit(RLIMIT_NPROC, 0, 0);
}

static const int allowed[] = {
    SCMP_SYS(read),          SCMP_SYS(pread64),      SCMP_SYS(write),
    SCMP_SYS(pwrite64),      SCMP_SYS(lseek),        SCMP_SYS(close),
    SCMP_SYS(fstat),         SCMP_SYS(brk),          SCMP_SYS(munmap),
    SCMP_SYS(mremap),        SCMP_SYS(madvise),      SCMP_SYS(futex),
    SCMP_SYS(exit),          SCMP_SYS(exit_group),   SCMP_SYS(getrandom),
    SCMP_SYS(clock_gettime), SCMP_SYS(rt_sigreturn), SCMP_SYS(rt_sigprocmask),
    SCMP_SYS(rt_sigaction),  SCMP_SYS(sigaltstack),  SCMP_SYS(gettid),
    SCMP_SYS(getpid),        SCMP_SYS(sched_yield),  SCMP_SYS(sysinfo), // qsort of much
};

// What libraries ask in passing and can do without.
static const int denied[] = {
    SCMP_SYS(open),       SCMP_SYS(openat),   SCMP_SYS(access), SCMP_SYS(faccessat),
    SCMP_SYS(faccessat2), SCMP_SYS(stat),     SCMP_SYS(lstat),  SCMP_SYS(newfstatat),
    SCMP_SYS(statx),      SCMP_SYS(readlink), SCMP_SYS(getcwd), SCMP_SYS(readlinkat),
    SCMP_SYS(ioctl),
};

static int add_rules(scmp_filter_ctx filter)
{
    int failed = 0;
    for (size_t i = 0; i < sizeof allowed / sizeof *allowed; i++)
        failed |= seccomp_rule_add(filter, SCMP_ACT_ALLOW, allowed[i], 0);
    for (size_t i = 0; i < sizeof denied / sizeof *denied; i++)
        failed |= seccomp_rule_add(filter, SCMP_ACT_ERRNO(EACCES), denied[i], 0);
    const struct scmp_arg_cmp not_executable = {
        .arg = 2, .op = SCMP_CMP_MASKED_EQ, .datum_a = PROT_EXEC, .datum_b = 0};
    const struct scmp_arg_cmp itself = {
        .arg = 0, .op = SCMP_CMP_EQ, .datum_a = (scmp_datum_t)getpid()};
    failed |= seccomp_rule_add(filter, SCMP_ACT_ALLOW, SCMP_SYS(mmap), 1, not_executable);
    failed |= seccomp_rule_add(filter, SCMP_ACT_ALLOW, SCMP_SYS(mprotect), 1, not_executable);
    // abort() signals the process itself
    failed |= seccomp_rule_add(filter, SCMP_ACT_ALLOW, SCMP_SYS(tgkill), 1, itself);
    return failed;
}

static bool filter_system_calls(void)
{
    scmp_filter_ctx filter = seccomp_init(SCMP_ACT_KILL_PROCESS);
    // systemd 252's @system-service denies seccomp(2): libseccomp then goes by prctl(2), which knows
    // only the older action. In a process of one thread the two are the same.
    if (!filter)
        filter = seccomp_init(SCMP_ACT_KILL_THREAD);
    if (!filter)
        return false;
    const bool done = add_rules(filter) == 0 && seccomp_load(filter) == 0;
    seccomp_release(filter);
    return done;
}

bool glint_jail_enter(const struct glint_import_limits *limits, int parent)
{
    if (prctl(PR_SET_PDEATHSIG, SIGKILL) || getppid() != parent)
        return false;
    return prctl(PR_SET_DUMPABLE, 0) == 0 && limit_resources(limits) && filter_system_calls();
}

bool glint_jail_close_others(const int *keep, int count)
{
    unsigned from = 3;
    bool done = true;
    for (int i = 0; i < count; i++) {
        if ((unsigned)keep[i] > from)
            done &= close_range(from, (unsigned)keep[i] - 1, 0) == 0;
        from = (unsigned)keep[i] + 1;
    }
    return done && close_range(from, ~0u, 0) == 0;
}
