// clock.h - the clocks that anything in the daemon reads.
//
// Thread-safety: any thread.
#ifndef GLINT_BASE_CLOCK_H
#define GLINT_BASE_CLOCK_H

double glint_now(void);        // seconds, CLOCK_MONOTONIC
double glint_wall_clock(void); // seconds since 1970
double glint_thread_cpu(void); // CPU seconds of the calling thread
void glint_utc(char text[32]); // RFC 3339, seconds

#endif
