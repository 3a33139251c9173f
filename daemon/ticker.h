// ticker.h - a thread that does one thing again and again.
//
// Threads: create and destroy by one; `tick` runs on the ticker's.
#ifndef GLINT_TICKER_H
#define GLINT_TICKER_H

#include "protocol/status.h"

typedef struct glint_ticker glint_ticker;

// Calls `tick` now and `seconds` after it has returned, until destroyed.
glint_status glint_ticker_create(glint_ticker **out, const char *name, double seconds,
                                 void (*tick)(void *user), void *user, struct glint_error *err);
// Waits for a tick that runs.
void glint_ticker_destroy(glint_ticker **ticker);

#endif
