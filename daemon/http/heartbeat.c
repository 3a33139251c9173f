// heartbeat.c - whether the library's threads still come round.
#include "http/server.h"

#include <fcntl.h>
#include <poll.h>
#include <string.h>
#include <sys/socket.h>
#include <unistd.h>

static const char request[] =
    "GET /healthz HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\n\r\n";

// Anything that comes back will do: bytes, or the end, which is what TLS makes of a plain request.
static bool answered(int fd, double seconds)
{
    struct pollfd p = {.fd = fd, .events = POLLIN};
    return send(fd, request, strlen(request), MSG_NOSIGNAL) > 0 &&
           poll(&p, 1, (int)(seconds * 1000)) > 0;
}

// The library picks a thread by the number of the descriptor, which what hangs would decide: it keeps
// those that it was given.
static int number_for(unsigned thread, int fd)
{
    while (fd >= 0 && (unsigned)fd % GLINT_HTTP_THREADS != thread) {
        const int next = fcntl(fd, F_DUPFD_CLOEXEC, fd + 1);
        close(fd);
        fd = next;
    }
    return fd;
}

// A connection that needs no network, which the service may not reach.
bool glint_http_beats(glint_http *http, double seconds)
{
    static unsigned turn;
    const struct sockaddr nobody = {.sa_family = AF_UNIX};
    int pair[2];
    if (socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0, pair))
        return false;
    const int theirs = number_for(turn++ % GLINT_HTTP_THREADS, pair[0]);
    // The library closes its end, on failure too.
    const bool alive = theirs >= 0 &&
                       MHD_add_connection(http->mhd, theirs, &nobody, sizeof nobody) == MHD_YES &&
                       answered(pair[1], seconds);
    close(pair[1]);
    return alive;
}
