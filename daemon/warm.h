// warm.h - what a daemon does while nobody wants anything of it yet: tables that most scenes need,
// program variants that most jobs want. One thread, that a job is never behind.
//
// Threads: main's.
#ifndef GLINT_WARM_H
#define GLINT_WARM_H

#include "device/device.h"

typedef struct glint_warm glint_warm;

glint_status glint_warm_start(glint_warm **out, glint_devices *devices, struct glint_error *err);
// Gives up what is under way.
void glint_warm_destroy(glint_warm **warm);

#endif
