// import.c - the daemon's side of an import: memfds and a pipe per request.
#include "scene/import.h"

#include "base/log.h"
#include "scene/import_answer.h"
#include "scene/import_helper.h"

#include <errno.h>
#include <fcntl.h>
#include <poll.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#define DEFAULT_MEMORY ((size_t)2 << 30)
#define DEFAULT_CPU 20.0

static const char *const type_name[GLINT_SCENE_TYPES] = {
    [GLINT_SCENE_GLB] = "GLB",
    [GLINT_SCENE_NATIVE] = "native",
    [GLINT_SCENE_GLTF] = "glTF",
    [GLINT_SCENE_OBJ] = "OBJ",
    [GLINT_SCENE_PLY] = "PLY",
    [GLINT_SCENE_STL] = "STL",
    [GLINT_SCENE_MULTIPART] = "multipart",
};

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

#define SEALS (F_SEAL_WRITE | F_SEAL_GROW | F_SEAL_SHRINK | F_SEAL_SEAL)

// A memfd with the bytes, which nobody changes while they are read; they may be in one already.
static int input_fd(const struct glint_import_source *source)
{
    if (source->fd > 0)
        return fcntl(source->fd, F_ADD_SEALS, SEALS) ? -1 : fcntl(source->fd, F_DUPFD_CLOEXEC, 3);
    const int fd = memfd_create("glint-import-input", MFD_CLOEXEC | MFD_ALLOW_SEALING);
    for (size_t done = 0; fd >= 0 && done < source->size;) {
        const ssize_t n = write(fd, source->bytes + done, source->size - done);
        if (n <= 0) {
            close(fd);
            return -1;
        }
        done += (size_t)n;
    }
    if (fd >= 0)
        fcntl(fd, F_ADD_SEALS, SEALS);
    return fd;
}

// A memfd with the assets that the text may name, laid out like an answer; the input again where
// there are none, so that there is something to send.
static int assets_fd(const struct glint_asset_set *given, int input)
{
    if (!given->count)
        return fcntl(input, F_DUPFD_CLOEXEC, 3);
    const struct glint_error none = {0};
    const struct glint_answer a = {
        .error = &none, .text = "", .asset = given->asset, .assets = given->count};
    const int fd = memfd_create("glint-import-assets", MFD_CLOEXEC);
    if (fd >= 0 && glint_answer_write(fd, &a)) {
        close(fd);
        return -1;
    }
    return fd;
}

struct call {
    int input, assets, output;
    int reply[2]; // read end, write end
};

static void call_close(struct call *c)
{
    const int fd[] = {c->input, c->assets, c->output, c->reply[0], c->reply[1]};
    for (size_t i = 0; i < sizeof fd / sizeof *fd; i++)
        if (fd[i] >= 0)
            close(fd[i]);
}

static bool call_open(struct call *c, const struct glint_import_source *source,
                      const struct glint_asset_set *given)
{
    *c = (struct call){-1, -1, -1, {-1, -1}};
    c->input = input_fd(source);
    c->assets = c->input >= 0 ? assets_fd(given, c->input) : -1;
    c->output = memfd_create("glint-import-output", MFD_CLOEXEC | MFD_ALLOW_SEALING);
    return c->input >= 0 && c->assets >= 0 && c->output >= 0 && pipe2(c->reply, O_CLOEXEC) == 0;
}

static bool send_request(int socket, const struct glint_import_request *request, struct call *c)
{
    const int fd[] = {c->input, c->assets, c->output, c->reply[1]};
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

// Not every end is told to who sent the file in so many words; who runs the daemon wants to know.
static glint_status log_end(const struct glint_import_reply *r,
                            const struct glint_import_request *request, glint_status status)
{
    glint_log(GLINT_LOG_WARNING, "import", NULL, NULL,
              "the import of %llu bytes (%s) ended by signal %d, exit code %d%s",
              (unsigned long long)request->size, type_name[request->type], r->signal, r->code,
              r->timed_out ? ", out of time" : "");
    return status;
}

bool glint_importer_lives(const glint_importer *im)
{
    struct pollfd end = {.fd = im->socket};
    return poll(&end, 1, 0) == 0 || !(end.revents & (POLLHUP | POLLERR));
}

static glint_status exchange(glint_importer *im, const struct glint_import_request *request,
                             struct call *c, struct glint_import **out, struct glint_error *err)
{
    struct glint_import_reply reply;
    if (!send_request(im->socket, request, c) || !wait_for(c->reply[0], &reply))
        return glint_fail(err, GLINT_E_INTERNAL, "", "the import helper is gone");
    if (reply.signal || reply.code != GLINT_CHILD_ANSWERED)
        return log_end(&reply, request, explain(&reply, &request->limits, err));
    fcntl(c->output, F_ADD_SEALS, SEALS);
    return glint_answer_read(c->output, false, out, err);
}

// The child's assets become those of the store, and those that the text names are held by it.
static glint_status adopt(struct glint_import *im, glint_assets *assets, struct glint_error *err)
{
    glint_status st = GLINT_OK;
    size_t added = 0;
    glint_asset_ref **ref = calloc(im->assets + 1, sizeof *ref);
    if (!ref)
        return glint_fail(err, GLINT_E_NOMEM, "", "no memory for %zu assets", im->assets);
    while (!st && added < im->assets) {
        st = glint_assets_add(assets, &im->asset[added], im->memory, &ref[added], err);
        added += !st;
    }
    if (!st)
        st = glint_assets_gather(assets, im->text, im->length, &im->set, err);
    if (!st) {
        free(im->asset);
        im->asset = im->set.asset;
        im->assets = im->set.count;
    }
    for (size_t i = 0; i < added; i++)
        glint_asset_ref_release(&ref[i]);
    free(ref);
    return st;
}

static glint_status run(glint_importer *importer, const struct glint_import_source *source,
                        const struct glint_import_request *request,
                        const struct glint_asset_set *given, struct glint_import **out,
                        struct glint_error *err)
{
    struct call call;
    glint_status st =
        call_open(&call, source, given)
            ? exchange(importer, request, &call, out, err)
            : glint_fail(err, GLINT_E_NOMEM, "", "no memory to hand over %zu bytes", source->size);
    call_close(&call);
    if (!st && source->assets)
        st = adopt(*out, source->assets, err);
    if (st)
        glint_import_destroy(out);
    return st;
}

glint_status glint_import_run(glint_importer *importer, const struct glint_import_source *source,
                              const struct glint_import_limits *limits, struct glint_import **out,
                              struct glint_error *err)
{
    *out = NULL;
    struct glint_import_request request = {.type = source->type, .size = source->size};
    struct glint_asset_set given = {0};
    if (limits)
        request.limits = *limits;
    if (!request.limits.memory_bytes)
        request.limits.memory_bytes = DEFAULT_MEMORY;
    if (!(request.limits.cpu_seconds > 0))
        request.limits.cpu_seconds = DEFAULT_CPU;
    if (source->boundary)
        snprintf(request.boundary, sizeof request.boundary, "%s", source->boundary);
    glint_status st = GLINT_OK;
    if (source->assets && source->type == GLINT_SCENE_NATIVE)
        st = glint_assets_gather(source->assets, (const char *)source->bytes, source->size, &given,
                                 err);
    request.assets = given.count != 0;
    if (!st)
        st = run(importer, source, &request, &given, out, err);
    glint_asset_set_release(&given);
    return st;
}
