#include "http/accept.h"

#include "base/thread.h"

#include <errno.h>
#include <fcntl.h>
#include <poll.h>
#include <stdlib.h>
#include <sys/eventfd.h>
#include <sys/socket.h>
#include <unistd.h>

#define SCARCE_MS 50 // until the system is asked again

struct glint_accept {
    struct MHD_Daemon *mhd;
    int fd, stop;
    pthread_t thread;
};

// False: the system has nothing for one more, no descriptor mostly.
static bool take_all(const glint_accept *a)
{
    for (;;) {
        struct sockaddr_storage address;
        socklen_t length = sizeof address;
        const int client =
            accept4(a->fd, (struct sockaddr *)&address, &length, SOCK_CLOEXEC | SOCK_NONBLOCK);
        if (client >= 0) // which closes it where it has no room
            MHD_add_connection(a->mhd, client, (struct sockaddr *)&address, length);
        else if (errno != ECONNABORTED && errno != EINTR)
            return errno == EAGAIN;
    }
}

static void *serve(void *arg)
{
    const glint_accept *a = arg;
    struct pollfd of[2] = {{.fd = a->stop, .events = POLLIN}, {.fd = a->fd, .events = POLLIN}};
    for (bool scarce = false;;) {
        const int ready = poll(of, scarce ? 1 : 2, scarce ? SCARCE_MS : -1);
        if (ready > 0 && of[0].revents)
            return NULL;
        scarce = !take_all(a);
    }
}

static void release(glint_accept *a)
{
    if (a->stop >= 0)
        close(a->stop);
    free(a);
}

glint_status glint_accept_start(glint_accept **out, struct MHD_Daemon *mhd, int fd,
                                struct glint_error *err)
{
    *out = NULL;
    glint_accept *a = calloc(1, sizeof *a);
    if (!a)
        return glint_fail(err, GLINT_E_NOMEM, "", "no memory for the listener");
    *a = (glint_accept){.mhd = mhd, .fd = fd, .stop = eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK)};
    glint_status st = GLINT_OK;
    if (a->stop < 0 || fcntl(fd, F_SETFL, fcntl(fd, F_GETFL) | O_NONBLOCK))
        st = glint_fail(err, GLINT_E_IO, "", "no descriptors for the listener");
    if (!st)
        st = glint_thread_start(&a->thread, "http-accept", serve, a, err);
    if (st)
        release(a);
    else
        *out = a;
    return st;
}

void glint_accept_stop(glint_accept **accept)
{
    glint_accept *a = *accept;
    *accept = NULL;
    if (!a)
        return;
    eventfd_write(a->stop, 1);
    pthread_join(a->thread, NULL);
    close(a->fd);
    release(a);
}
