// import_helper.c - takes requests, forks children, reports how they ended.
#include "scene/import_helper.h"

#include "base/clock.h"
#include "base/sha256.h"
#include "scene/import_child.h"
#include "scene/import_jail.h"

#include <errno.h>
#include <fcntl.h>
#include <poll.h>
#include <signal.h>
#include <stdlib.h>
#include <string.h>
#include <sys/prctl.h>
#include <sys/socket.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <unistd.h>

struct child {
    pid_t pid;
    int pidfd, reply;
    double deadline; // on the wall clock: a backstop, the processor time has its own limit
    bool timed_out;
};

struct helper {
    int socket;
    int count;
    struct child child[GLINT_IMPORT_CHILDREN];
};

enum { INPUT, ASSETS, OUTPUT, REPLY, FDS };

static void close_all(const int fd[FDS])
{
    for (int i = 0; i < FDS; i++)
        if (fd[i] >= 0)
            close(fd[i]);
}

static void take_descriptors(struct msghdr *message, int fd[FDS])
{
    const struct cmsghdr *c = CMSG_FIRSTHDR(message);
    if (c && c->cmsg_level == SOL_SOCKET && c->cmsg_type == SCM_RIGHTS &&
        c->cmsg_len == CMSG_LEN(FDS * sizeof(int)))
        memcpy(fd, CMSG_DATA(c), FDS * sizeof(int));
}

// 1: a request; 0: the socket is closed; -1: nothing that makes sense.
static int receive(int socket, struct glint_import_request *request, int fd[FDS])
{
    union {
        char bytes[CMSG_SPACE(FDS * sizeof(int))];
        struct cmsghdr align;
    } control;
    struct iovec data = {request, sizeof *request};
    struct msghdr message = {.msg_iov = &data,
                             .msg_iovlen = 1,
                             .msg_control = control.bytes,
                             .msg_controllen = sizeof control.bytes};
    memset(fd, -1, FDS * sizeof *fd);
    ssize_t n;
    do
        n = recvmsg(socket, &message, MSG_CMSG_CLOEXEC);
    while (n < 0 && errno == EINTR);
    if (n <= 0)
        return 0;
    take_descriptors(&message, fd);
    return n == sizeof *request && fd[REPLY] >= 0 ? 1 : -1;
}

static void answer(int reply, int signal, int code, bool timed_out)
{
    const struct glint_import_reply r = {signal, code, timed_out};
    if (write(reply, &r, sizeof r) != (ssize_t)sizeof r) {
        // whoever asked has gone
    }
    close(reply);
}

static int by_number(const void *a, const void *b)
{
    return *(const int *)a - *(const int *)b;
}

static void child_main(const struct glint_import_request *request, const int fd[FDS], pid_t helper)
{
    int keep[] = {fd[INPUT], fd[ASSETS], fd[OUTPUT]};
    qsort(keep, 3, sizeof *keep, by_number);
    if (!glint_jail_close_others(keep, 3) || !glint_jail_enter(&request->limits, helper))
        _exit(GLINT_CHILD_NOT_CONFINED);
    glint_import_child(request, fd[INPUT], fd[ASSETS], fd[OUTPUT]);
}

static void start(struct helper *h, const struct glint_import_request *request, const int fd[FDS])
{
    const pid_t helper = getpid();
    const pid_t pid = fork();
    if (pid == 0)
        child_main(request, fd, helper);
    const int pidfd = pid > 0 ? (int)syscall(SYS_pidfd_open, pid, 0) : -1;
    close(fd[INPUT]);
    close(fd[ASSETS]);
    close(fd[OUTPUT]);
    if (pidfd < 0) {
        if (pid > 0) {
            kill(pid, SIGKILL);
            waitpid(pid, NULL, 0);
        }
        answer(fd[REPLY], 0, GLINT_CHILD_NOT_CONFINED, false);
        return;
    }
    fcntl(pidfd, F_SETFD, FD_CLOEXEC);
    h->child[h->count++] =
        (struct child){.pid = pid,
                       .pidfd = pidfd,
                       .reply = fd[REPLY],
                       .deadline = glint_now() + 4 * request->limits.cpu_seconds + 10};
}

static void take_request(struct helper *h)
{
    struct glint_import_request request;
    int fd[FDS];
    const int got = receive(h->socket, &request, fd);
    if (got == 0)
        _exit(0); // the children die with this process
    if (got > 0)
        start(h, &request, fd);
    else
        close_all(fd);
}

static void reap(struct helper *h, int i)
{
    struct child *c = &h->child[i];
    int status = 0;
    while (waitpid(c->pid, &status, 0) < 0 && errno == EINTR) {
    }
    answer(c->reply, WIFSIGNALED(status) ? WTERMSIG(status) : 0,
           WIFEXITED(status) ? WEXITSTATUS(status) : 0, c->timed_out);
    close(c->pidfd);
    *c = h->child[--h->count];
}

static void end_the_late(struct helper *h)
{
    const double now = glint_now();
    for (int i = 0; i < h->count; i++) {
        if (now < h->child[i].deadline)
            continue;
        h->child[i].timed_out = true;
        kill(h->child[i].pid, SIGKILL);
    }
}

static void serve(struct helper *h)
{
    struct pollfd p[1 + GLINT_IMPORT_CHILDREN];
    for (int i = 0; i < h->count; i++)
        p[i] = (struct pollfd){.fd = h->child[i].pidfd, .events = POLLIN};
    const int children = h->count;
    p[children] =
        (struct pollfd){.fd = children < GLINT_IMPORT_CHILDREN ? h->socket : -1, .events = POLLIN};
    if (poll(p, (nfds_t)children + 1, children ? 1000 : -1) < 0)
        return;
    for (int i = children - 1; i >= 0; i--) // from the end: reaping moves the last into the gap
        if (p[i].revents)
            reap(h, i);
    end_the_late(h);
    if (p[children].revents)
        take_request(h);
}

// Handlers of the daemon have no business here: a crash must end a child. The terminal's and the
// service manager's signals reach the whole group; this process ends when the daemon closes its
// socket, so that a draining daemon can finish an import.
static void reset_signals(void)
{
    static const int ignored[] = {SIGINT, SIGTERM, SIGHUP, SIGUSR1, SIGPIPE};
    sigset_t none;
    for (int i = 1; i < NSIG; i++)
        signal(i, SIG_DFL);
    for (size_t i = 0; i < sizeof ignored / sizeof *ignored; i++)
        signal(ignored[i], SIG_IGN);
    sigemptyset(&none);
    sigprocmask(SIG_SETMASK, &none, NULL);
}

static void detach(void)
{
    reset_signals();
    const int null = open("/dev/null", O_RDWR);
    if (null >= 0) {
        dup2(null, 0);
        dup2(null, 1);
        if (fcntl(2, F_GETFD) < 0)
            dup2(null, 2); // else a request's descriptor could become the error stream
        if (null > 2)
            close(null);
    }
}

void glint_helper_main(int socket)
{
    prctl(PR_SET_NAME, "glint-import");
    detach();
    glint_jail_close_others(&socket, 1);
    char warm[65];
    glint_sha256("", 0, warm); // libcrypto starts here, not in every jail
    struct helper h = {.socket = socket};
    for (;;)
        serve(&h);
}
