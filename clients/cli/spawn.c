#include "spawn.h"
#include "interrupt.h"

#include <errno.h>
#include <fcntl.h>
#include <ftw.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/prctl.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <time.h>
#include <unistd.h>

#define START_MS 120000 // a first start may have kernels to compile
#define STOP_MS 10000
#define FAREWELL_MS 1000
#define LOG_TAIL 1500 // bytes of the log that an error quotes

static const char announcement[] = "glintd: listening on ";

struct glint_daemon {
    pid_t pid; // 0: ended and waited for
    int pidfd; // readable once it has ended
    char *state, *log;
    char url[160];
};

// The path to run, malloc'd; a name without a slash is looked up on PATH by exec.
static char *find_program(void)
{
    char self[4096], *path = NULL;
    const ssize_t n = readlink("/proc/self/exe", self, sizeof self - 1);
    if (n > 0) {
        self[n] = '\0';
        char *slash = strrchr(self, '/');
        if (slash && asprintf(&path, "%.*s/glintd", (int)(slash - self), self) >= 0 &&
            access(path, X_OK) == 0)
            return path;
        free(path);
    }
    const char installed[] = GLINT_LIBEXECDIR "/glintd";
    return strdup(access(installed, X_OK) == 0 ? installed : "glintd");
}

static char *make_state(void)
{
    const char *root = getenv("TMPDIR");
    char *path = NULL;
    if (asprintf(&path, "%s/glint.XXXXXX", root && *root ? root : "/tmp") < 0)
        return NULL;
    if (mkdtemp(path))
        return path;
    free(path);
    return NULL;
}

static _Noreturn void become_daemon(const char *program, const glint_daemon *d, int out,
                                    pid_t parent)
{
    glint_interrupt_unblock();
    setpgid(0, 0); // Ctrl-C is for the client, which then cancels its job
    prctl(PR_SET_PDEATHSIG, SIGTERM);
    const int log = open(d->log, O_WRONLY | O_CREAT | O_APPEND, 0600);
    if (getppid() != parent || log < 0 || dup2(out, STDOUT_FILENO) < 0 ||
        dup2(log, STDERR_FILENO) < 0)
        _exit(126);
    execlp(program, program, "--listen", "127.0.0.1:0", "--state", d->state, (char *)NULL);
    dprintf(STDERR_FILENO, "%s: %s\n", program, strerror(errno));
    _exit(127);
}

static bool launch(glint_daemon *d, int *reader)
{
    int ends[2];
    char *program = find_program();
    if (!program || pipe2(ends, O_CLOEXEC) != 0) {
        free(program);
        return false;
    }
    const pid_t parent = getpid();
    d->pid = fork();
    if (d->pid == 0)
        become_daemon(program, d, ends[1], parent);
    free(program);
    close(ends[1]);
    if (d->pid > 0)
        d->pidfd = (int)syscall(SYS_pidfd_open, d->pid, 0);
    if (d->pid < 0 || d->pidfd < 0) {
        d->pid = d->pid < 0 ? 0 : d->pid;
        close(ends[0]);
        return false;
    }
    *reader = ends[0];
    return true;
}

static bool take_url(glint_daemon *d, char *text)
{
    char *at = strstr(text, announcement), *end = at ? strchr(at, '\n') : NULL;
    if (!end)
        return false;
    *end = '\0';
    snprintf(d->url, sizeof d->url, "%s", at + strlen(announcement));
    return true;
}

static long now_ms(void)
{
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return t.tv_sec * 1000L + t.tv_nsec / 1000000L;
}

// Reads the daemon's stdout until it says where it listens.
static bool await_url(glint_daemon *d, int reader)
{
    char text[1024];
    size_t size = 0;
    const long end = now_ms() + START_MS;
    for (long left; (left = end - now_ms()) > 0 && size < sizeof text - 1;) {
        if (!glint_interrupt_wait(reader, (int)left))
            return false;
        const ssize_t got = read(reader, text + size, sizeof text - 1 - size);
        if (got <= 0)
            return false;
        size += (size_t)got;
        text[size] = '\0';
        if (take_url(d, text))
            return true;
    }
    return false;
}

static void quote_log(const glint_daemon *d, struct glint_error *err)
{
    char text[LOG_TAIL + 1];
    const int fd = open(d->log, O_RDONLY | O_CLOEXEC);
    const off_t size = fd >= 0 ? lseek(fd, 0, SEEK_END) : 0;
    const ssize_t got =
        size > 0 ? pread(fd, text, LOG_TAIL, size > LOG_TAIL ? size - LOG_TAIL : 0) : 0;
    if (fd >= 0)
        close(fd);
    text[got > 0 ? got : 0] = '\0';
    for (char *line, *rest = text; (line = strtok_r(rest, "\n", &rest));)
        glint_fail(err, GLINT_E_UNAVAILABLE, "", "glintd said: %s", line);
}

glint_status glint_spawn_start(glint_daemon **out, struct glint_error *err)
{
    *out = NULL;
    int reader = -1;
    glint_daemon *d = calloc(1, sizeof *d);
    if (d)
        d->pidfd = -1;
    if (!d || !(d->state = make_state()) || asprintf(&d->log, "%s/glintd.log", d->state) < 0 ||
        !launch(d, &reader)) {
        glint_fail(err, GLINT_E_UNAVAILABLE, "", "cannot start a daemon: %s", strerror(errno));
        glint_spawn_stop(&d);
        return GLINT_E_UNAVAILABLE;
    }
    const bool serves = await_url(d, reader);
    close(reader);
    if (serves) {
        *out = d;
        return GLINT_OK;
    }
    glint_fail(err, GLINT_E_UNAVAILABLE, "",
               glint_interrupt_seen() ? "interrupted" : "the private daemon did not start");
    quote_log(d, err);
    glint_spawn_stop(&d);
    return GLINT_E_UNAVAILABLE;
}

const char *glint_spawn_url(const glint_daemon *daemon)
{
    return daemon->url;
}

static bool ended(glint_daemon *d)
{
    if (d->pid && waitpid(d->pid, NULL, WNOHANG) == d->pid)
        d->pid = 0;
    return !d->pid;
}

void glint_spawn_explain(glint_daemon *daemon, struct glint_error *err)
{
    if (err->status == GLINT_E_UNAVAILABLE)
        glint_interrupt_wait(daemon->pidfd, FAREWELL_MS);
    if (!ended(daemon))
        return;
    glint_fail(err, GLINT_E_UNAVAILABLE, "", "the private daemon has ended");
    quote_log(daemon, err);
}

// A second signal from the user cuts the wait short.
static void terminate(glint_daemon *d)
{
    glint_interrupt_clear();
    kill(d->pid, SIGTERM);
    if (!glint_interrupt_wait(d->pidfd, STOP_MS))
        kill(d->pid, SIGKILL);
    waitpid(d->pid, NULL, 0);
    d->pid = 0;
}

static int remove_entry(const char *path, const struct stat *info, int kind, struct FTW *at)
{
    (void)info, (void)kind, (void)at;
    return remove(path);
}

void glint_spawn_stop(glint_daemon **daemon)
{
    glint_daemon *d = *daemon;
    *daemon = NULL;
    if (!d)
        return;
    if (!ended(d))
        terminate(d);
    if (d->pidfd >= 0)
        close(d->pidfd);
    if (d->state)
        nftw(d->state, remove_entry, 16, FTW_DEPTH | FTW_PHYS);
    free(d->state);
    free(d->log);
    free(d);
}
