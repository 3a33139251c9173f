// interrupt.h - Ctrl-C and termination as something to wait for, instead of something that happens.
//
// SIGINT, SIGTERM and SIGHUP are blocked for the life of the process and read from a descriptor at
// the places that wait, so that a job can be cancelled and a private daemon stopped in good order.
//
// Thread-safety: one thread.
#ifndef GLINT_CLI_INTERRUPT_H
#define GLINT_CLI_INTERRUPT_H

#include <stdbool.h>

// Call once, before any request. False: no descriptor is to be had.
bool glint_interrupt_watch(void);

// Readable while a signal waits to be noticed.
int glint_interrupt_fd(void);

// True once a signal came, until cleared: what runs should stop.
bool glint_interrupt_pending(void);

// The signal has been answered; what tidies up may run until the next one.
void glint_interrupt_clear(void);

// True if there ever was one.
bool glint_interrupt_seen(void);

// Gives a child back the signals it was born without. Async-signal-safe.
void glint_interrupt_unblock(void);

// Waits until `fd` (or -1) is readable, a signal is pending or the time is up. True: `fd` is readable.
bool glint_interrupt_wait(int fd, int milliseconds);

#endif
