#include "base/notify.h"

#include <inttypes.h>
#include <stdarg.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <systemd/sd-daemon.h>
#include <time.h>
#include <unistd.h>

#define STATUS_BYTES 256
#define SOCKET_NAME "http"

// `state` and a status of one line.
static void tell(const char *state, const char *format, va_list args)
{
    char status[STATUS_BYTES];
    vsnprintf(status, sizeof status, format, args);
    status[strcspn(status, "\n")] = '\0';
    sd_notifyf(0, "%sSTATUS=%s", state, status);
}

void glint_notify_ready(const char *format, ...)
{
    va_list args;
    va_start(args, format);
    tell("READY=1\n", format, args);
    va_end(args);
}

void glint_notify_status(const char *format, ...)
{
    va_list args;
    va_start(args, format);
    tell("", format, args);
    va_end(args);
}

void glint_notify_reloading(void)
{
    struct timespec now;
    clock_gettime(CLOCK_MONOTONIC, &now);
    sd_notifyf(0, "RELOADING=1\nMONOTONIC_USEC=%" PRIu64 "\nSTATUS=reading its settings again",
               (uint64_t)now.tv_sec * 1000000 + (uint64_t)now.tv_nsec / 1000);
}

void glint_notify_stopping(void)
{
    sd_notify(0, "STOPPING=1\nSTATUS=ending");
}

void glint_notify_more_time(double seconds)
{
    sd_notifyf(0, "EXTEND_TIMEOUT_USEC=%" PRIu64, (uint64_t)(seconds * 1e6));
}

double glint_notify_watchdog(void)
{
    uint64_t microseconds = 0;
    return sd_watchdog_enabled(0, &microseconds) > 0 ? (double)microseconds * 1e-6 : 0;
}

void glint_notify_alive(void)
{
    sd_notify(0, "WATCHDOG=1");
}

// The index of the socket to serve, -1: none of them.
static int choose(char *const *name, int count)
{
    if (count == 1)
        return 0;
    int chosen = -1;
    for (int i = 0; i < count; i++)
        if (!strcmp(name[i], SOCKET_NAME))
            chosen = chosen < 0 ? i : count;
    return chosen < count ? chosen : -1;
}

glint_status glint_notify_socket(int *fd, struct glint_error *err)
{
    *fd = -1;
    char **name = NULL;
    const int count = sd_listen_fds_with_names(1, &name);
    const int chosen = count > 0 ? choose(name, count) : -1;
    for (int i = 0; i < count; i++) {
        free(name[i]);
        if (i == chosen)
            *fd = SD_LISTEN_FDS_START + i;
        else
            close(SD_LISTEN_FDS_START + i);
    }
    free(name);
    if (count < 0)
        return glint_fail(err, GLINT_E_RANGE, "", "LISTEN_FDS makes no sense: %s",
                          strerror(-count));
    if (count && chosen < 0)
        return glint_fail(err, GLINT_E_RANGE, "",
                          "%d sockets were passed and not just one is named " SOCKET_NAME, count);
    return GLINT_OK;
}
