// import.c - the daemon's side of an import: two memfds and a pipe per request.
#include "scene/import.h"

#include "scene/import_answer.h"
#include "scene/import_helper.h"

#include <errno.h>
#include <fcntl.h>
#include <signal.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#define DEFAULT_MEMORY ((size_t)2 << 30)
#define DEFAULT_CPU 20.0

struct glint_importer {
    int socket;
    pid_t helper;
};

glint_status glint_importer_create(glint_importer **out, struct glint_error *err)
{
    *out = NULL;
    int pair[2];
    glint_importer *im = calloc(1, sizeof *im);
    if (!im)
        return glint_fail(err, GLINT_E_NOMEM, "", "no memory for the importer");
    if (socketpair(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC, 0, pair)) {
        free(im);
        return glint_fail(err, GLINT_E_INTERNAL, "", "no socket pair: %s", strerror(errno));
    }
    const pid_t daemon = getpid();
    im->socket = pair[0];
    im->helper = fork();
    if (im->helper == 0) {
        close(pair[0]);
        if (prctl(PR_SET_PDEATHSIG, SIGKILL) || getppid() != daemon)
            _exit(1);
        glint_helper_main(pair[1]);
    }
    close(pair[1]);
    if (im->helper < 0) {
        const int why = errno;
        close(im->socket);
        free(im);
        return glint_fail(err, GLINT_E_INTERNAL, "", "cannot fork the importer: %s", strerror(why));
    }
    *out = im;
    return GLINT_OK;
}

void glint_importer_destroy(glint_importer **importer)
{
    glint_importer *im = *importer;
    *importer = NULL;
    if (!im)
        return;
    close(im->socket);
    while (waitpid(im->helper, NULL, 0) < 0 && errno == EINTR) {
    }
    free(im);
}

// A sealed memfd with the bytes: nobody changes the input while it is read.
static int input_fd(const uint8_t *bytes, size_t size)
{
    const int fd = memfd_create("glint-import-input", MFD_CLOEXEC | MFD_ALLOW_SEALING);
    for (size_t done = 0; fd >= 0 && done < size;) {
        const ssize_t n = write(fd, bytes + done, size - done);
        if (n <= 0) {
            close(fd);
            return -1;
        }
        done += (size_t)n;
    }
    if (fd >= 0)
        fcntl(fd, F_ADD_SEALS, F_SEAL_WRITE | F_SEAL_GROW | F_SEAL_SHRINK | F_SEAL_SEAL);
    return fd;
}

struct call {
    int input, output;
    int reply[2]; // read end, write end
};

static void call_close(struct call *c)
{
    const int fd[] = {c->input, c->output, c->reply[0], c->reply[1]};
    for (size_t i = 0; i < sizeof fd / sizeof *fd; i++)
        if (fd[i] >= 0)
            close(fd[i]);
}

static bool call_open(struct call *c, const uint8_t *bytes, size_t size)
{
    *c = (struct call){-1, -1, {-1, -1}};
    c->input = input_fd(bytes, size);
    c->output = memfd_create("glint-import-output", MFD_CLOEXEC | MFD_ALLOW_SEALING);
    return c->input >= 0 && c->output >= 0 && pipe2(c->reply, O_CLOEXEC) == 0;
}

static bool send_request(int socket, const struct glint_import_request *request, struct call *c)
{
    const int fd[3] = {c->input, c->output, c->reply[1]};
    union {
        char bytes[CMSG_SPACE(sizeof fd)];
        struct cmsghdr align;
    } control = {0};
    struct iovec data = {(void *)request, sizeof *request};
    struct msghdr message = {.msg_iov = &data,
                             .msg_iovlen = 1,
                             .msg_control = control.bytes,
                             .msg_controllen = sizeof control.bytes};
    struct cmsghdr *m = CMSG_FIRSTHDR(&message);
    m->cmsg_level = SOL_SOCKET;
    m->cmsg_type = SCM_RIGHTS;
    m->cmsg_len = CMSG_LEN(sizeof fd);
    memcpy(CMSG_DATA(m), fd, sizeof fd);
    ssize_t n;
    do
        n = sendmsg(socket, &message, MSG_NOSIGNAL);
    while (n < 0 && errno == EINTR);
    // the copies that travel are the helper's: its end closes the pipe for the reader
    close(c->reply[1]);
    c->reply[1] = -1;
    return n == (ssize_t)sizeof *request;
}

static bool wait_for(int reply, struct glint_import_reply *out)
{
    ssize_t n;
    do
        n = read(reply, out, sizeof *out);
    while (n < 0 && errno == EINTR);
    return n == (ssize_t)sizeof *out;
}

// What a child's end means to whoever sent the file.
static glint_status explain(const struct glint_import_reply *r,
                            const struct glint_import_limits *limits, struct glint_error *err)
{
    const size_t mib = limits->memory_bytes >> 20;
    if (r->timed_out || r->signal == SIGXCPU)
        return glint_fail(err, GLINT_E_RANGE, "", "the import took longer than the %g s allowed",
                          limits->cpu_seconds);
    if (r->signal == SIGSYS)
        return glint_fail(err, GLINT_E_RANGE, "",
                          "the import was stopped at a system call that the sandbox forbids");
    if (r->signal == SIGXFSZ || (!r->signal && r->code == GLINT_CHILD_NO_ROOM))
        return glint_fail(err, GLINT_E_RANGE, "",
                          "the imported scene is larger than the %zu MiB allowed", mib);
    if (r->signal == SIGKILL)
        return glint_fail(err, GLINT_E_RANGE, "",
                          "the import was killed, most likely for want of memory");
    if (r->signal)
        return glint_fail(err, GLINT_E_RANGE, "", "the import crashed on this file (%s)",
                          strsignal(r->signal));
    if (r->code != GLINT_CHILD_NOT_CONFINED)
        return glint_fail(err, GLINT_E_RANGE, "", "the import crashed on this file (exit code %d)",
                          r->code);
    return glint_fail(err, GLINT_E_INTERNAL, "", "the import could not be confined");
}

static glint_status exchange(glint_importer *im, const struct glint_import_request *request,
                             struct call *c, struct glint_import **out, struct glint_error *err)
{
    struct glint_import_reply reply;
    if (!send_request(im->socket, request, c) || !wait_for(c->reply[0], &reply))
        return glint_fail(err, GLINT_E_INTERNAL, "", "the import helper is gone");
    if (reply.signal || reply.code != GLINT_CHILD_ANSWERED)
        return explain(&reply, &request->limits, err);
    fcntl(c->output, F_ADD_SEALS, F_SEAL_WRITE | F_SEAL_GROW | F_SEAL_SHRINK | F_SEAL_SEAL);
    return glint_answer_read(c->output, out, err);
}

glint_status glint_import_run(glint_importer *importer, enum glint_scene_type type,
                              const uint8_t *bytes, size_t size,
                              const struct glint_import_limits *limits, struct glint_import **out,
                              struct glint_error *err)
{
    *out = NULL;
    struct glint_import_request request = {.type = type, .size = size};
    if (limits)
        request.limits = *limits;
    if (!request.limits.memory_bytes)
        request.limits.memory_bytes = DEFAULT_MEMORY;
    if (!(request.limits.cpu_seconds > 0))
        request.limits.cpu_seconds = DEFAULT_CPU;

    struct call call;
    const glint_status status =
        call_open(&call, bytes, size)
            ? exchange(importer, &request, &call, out, err)
            : glint_fail(err, GLINT_E_NOMEM, "", "no memory to hand over %zu bytes", size);
    call_close(&call);
    return status;
}
