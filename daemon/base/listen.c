#include "base/listen.h"

#include <arpa/inet.h>
#include <errno.h>
#include <netdb.h>
#include <netinet/in.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/socket.h>
#include <unistd.h>

#define BACKLOG 128

// Splits at the last colon, outside brackets; false if there is none or the port is no number.
static bool split(const char *address, char host[256], char port[8])
{
    const char *colon = strrchr(address, ':');
    size_t length = colon ? (size_t)(colon - address) : 0;
    if (!length || length > 255 || strlen(colon + 1) > 5)
        return false;
    const size_t digits = strspn(colon + 1, "0123456789");
    if (!digits || colon[1 + digits] || atoi(colon + 1) > 65535)
        return false;
    strcpy(port, colon + 1);
    const bool brackets = address[0] == '[' && address[length - 1] == ']';
    address += brackets;
    length -= 2 * brackets;
    memcpy(host, address, length);
    host[length] = '\0';
    return brackets || !strchr(host, ':');
}

static bool is_loopback(const struct sockaddr *at)
{
    if (at->sa_family == AF_INET)
        return ntohl(((const struct sockaddr_in *)(const void *)at)->sin_addr.s_addr) >> 24 == 127;
    return at->sa_family == AF_INET6 &&
           IN6_IS_ADDR_LOOPBACK(&((const struct sockaddr_in6 *)(const void *)at)->sin6_addr);
}

static glint_status check_guard(const struct sockaddr *at, const char *address,
                                struct glint_guard guard, struct glint_error *err)
{
    if ((guard.tokens && guard.tls) || is_loopback(at))
        return GLINT_OK;
    return glint_fail(err, GLINT_E_RANGE, "",
                      "%s is not a loopback address: another is served with tokens and TLS only, "
                      "and there %s",
                      address,
                      guard.tokens ? "is no certificate"
                      : guard.tls  ? "are no tokens"
                                   : "is neither");
}

static glint_status say_url(int fd, char url[GLINT_URL_BYTES], struct glint_guard guard,
                            struct glint_error *err)
{
    struct sockaddr_storage at;
    socklen_t length = sizeof at;
    char host[INET6_ADDRSTRLEN], port[8];
    if (getsockname(fd, (struct sockaddr *)&at, &length) ||
        getnameinfo((struct sockaddr *)&at, length, host, sizeof host, port, sizeof port,
                    NI_NUMERICHOST | NI_NUMERICSERV))
        return glint_fail(err, GLINT_E_UNAVAILABLE, "", "the socket's address is not to be had");
    const bool six = at.ss_family == AF_INET6;
    snprintf(url, GLINT_URL_BYTES, "http%s://%s%s%s:%s", guard.tls ? "s" : "", six ? "[" : "", host,
             six ? "]" : "", port);
    return GLINT_OK;
}

static glint_status open_socket(int *fd, const struct addrinfo *at, const char *address,
                                struct glint_error *err)
{
    const int yes = 1;
    *fd = socket(at->ai_family, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);
    if (*fd >= 0 && !setsockopt(*fd, SOL_SOCKET, SO_REUSEADDR, &yes, sizeof yes) &&
        !bind(*fd, at->ai_addr, at->ai_addrlen) && !listen(*fd, BACKLOG))
        return GLINT_OK;
    const int failure = errno;
    if (*fd >= 0)
        close(*fd);
    *fd = -1;
    return glint_fail(err, GLINT_E_UNAVAILABLE, "", "cannot listen on %s: %s", address,
                      strerror(failure));
}

glint_status glint_listen(int *fd, char url[GLINT_URL_BYTES], const char *address,
                          struct glint_guard guard, struct glint_error *err)
{
    *fd = -1;
    char host[256], port[8];
    if (!split(address, host, port))
        return glint_fail(err, GLINT_E_RANGE, "", "\"%s\" is not ADDR:PORT", address);
    struct addrinfo *at = NULL;
    const struct addrinfo hints = {.ai_flags = AI_NUMERICSERV, .ai_socktype = SOCK_STREAM};
    const int failure = getaddrinfo(host, port, &hints, &at);
    if (failure)
        return glint_fail(err, GLINT_E_RANGE, "", "%s: %s", address, gai_strerror(failure));
    glint_status st = check_guard(at->ai_addr, address, guard, err);
    if (!st)
        st = open_socket(fd, at, address, err);
    freeaddrinfo(at);
    if (!st)
        st = say_url(*fd, url, guard, err);
    if (st && *fd >= 0) {
        close(*fd);
        *fd = -1;
    }
    return st;
}

static int option(int fd, int name)
{
    int value = -1;
    socklen_t length = sizeof value;
    return getsockopt(fd, SOL_SOCKET, name, &value, &length) ? -1 : value;
}

glint_status glint_listen_adopt(int fd, char url[GLINT_URL_BYTES], struct glint_guard guard,
                                struct glint_error *err)
{
    struct sockaddr_storage at = {0};
    socklen_t length = sizeof at;
    const int family = option(fd, SO_DOMAIN);
    if (option(fd, SO_TYPE) != SOCK_STREAM || (family != AF_INET && family != AF_INET6) ||
        option(fd, SO_ACCEPTCONN) != 1 || getsockname(fd, (struct sockaddr *)&at, &length))
        return glint_fail(err, GLINT_E_RANGE, "", "descriptor %d is no listening TCP socket", fd);
    const glint_status st = say_url(fd, url, guard, err);
    return st ? st : check_guard((struct sockaddr *)&at, url, guard, err);
}
