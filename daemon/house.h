// house.h - the parts of a running daemon, in the order in which they start.
//
// Threads: main's.
#ifndef GLINT_HOUSE_H
#define GLINT_HOUSE_H

#include "base/keeper.h"
#include "base/listen.h"
#include "base/metrics.h"
#include "base/tokens.h"
#include "device/device.h"
#include "http/http.h"
#include "jobs/jobs.h"
#include "mirror.h"
#include "scene/store.h"
#include "settings.h"
#include "warm.h"

struct glint_house {
    struct glint_settings_source source;
    struct glint_settings settings;
    int listen_fd; // until the HTTP server has it
    char url[GLINT_URL_BYTES];
    char *state, *cache; // folders, owned
    glint_importer *importer;
    glint_tokens *tokens; // NULL: none are needed
    glint_tls *tls;       // NULL: plain HTTP
    glint_devices *devices;
    glint_metrics *metrics;
    glint_keeper *keeper;
    glint_store *store;
    glint_jobs *jobs;
    glint_mirror *mirror;
    glint_http *http;
    glint_warm *warm;
};

#endif
