#include "interrupt.h"

#include <poll.h>
#include <signal.h>
#include <sys/signalfd.h>
#include <unistd.h>

static int signals = -1;
static bool pending, seen;

static void watched(sigset_t *set)
{
    sigemptyset(set);
    sigaddset(set, SIGINT);
    sigaddset(set, SIGTERM);
    sigaddset(set, SIGHUP);
}

bool glint_interrupt_watch(void)
{
    sigset_t set;
    watched(&set);
    if (sigprocmask(SIG_BLOCK, &set, NULL) != 0)
        return false;
    signals = signalfd(-1, &set, SFD_CLOEXEC | SFD_NONBLOCK);
    signal(SIGPIPE, SIG_IGN);
    return signals >= 0;
}

int glint_interrupt_fd(void)
{
    return signals;
}

bool glint_interrupt_pending(void)
{
    struct signalfd_siginfo info;
    while (read(signals, &info, sizeof info) == (ssize_t)sizeof info)
        pending = seen = true;
    return pending;
}

void glint_interrupt_clear(void)
{
    pending = false;
}

bool glint_interrupt_seen(void)
{
    return seen;
}

void glint_interrupt_unblock(void)
{
    sigset_t set;
    watched(&set);
    sigprocmask(SIG_UNBLOCK, &set, NULL);
    signal(SIGPIPE, SIG_DFL);
}

bool glint_interrupt_wait(int fd, int milliseconds)
{
    if (glint_interrupt_pending())
        return false;
    struct pollfd wait[2] = {{.fd = signals, .events = POLLIN}, {.fd = fd, .events = POLLIN}};
    poll(wait, fd < 0 ? 1 : 2, milliseconds);
    return !glint_interrupt_pending() && fd >= 0 && wait[1].revents;
}
