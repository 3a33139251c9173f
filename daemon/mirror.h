// mirror.h - metrics of what the store, the jobs and the kernel count themselves.
//
// Threads: create and destroy by main; read by whoever reads the metrics.
#ifndef GLINT_MIRROR_H
#define GLINT_MIRROR_H

#include "base/metrics.h"
#include "device/device.h"
#include "jobs/jobs.h"
#include "scene/store.h"

typedef struct glint_mirror glint_mirror;

// Registers itself with glint_metrics_on_read: jobs and store must live while metrics are read.
glint_status glint_mirror_create(glint_mirror **out, glint_metrics *metrics, glint_jobs *jobs,
                                 glint_store *store, const glint_devices *devices,
                                 struct glint_error *err);
void glint_mirror_destroy(glint_mirror **mirror);

#endif
