#include "http/server.h"

static void fill(struct glint_http_limits *l)
{
    if (!l->job_bytes)
        l->job_bytes = (size_t)1 << 20;
    if (!l->scene_bytes)
        l->scene_bytes = (size_t)2 << 30;
    if (!l->spool_bytes)
        l->spool_bytes = 2 * l->scene_bytes;
    if (!l->connections)
        l->connections = 2048;
    if (!l->streams)
        l->streams = 1024;
    if (!(l->header_seconds > 0))
        l->header_seconds = 10;
    if (!(l->idle_seconds > 0))
        l->idle_seconds = 60;
    if (!(l->ping_seconds > 0))
        l->ping_seconds = 15;
}

void glint_http_set_limits(glint_http *http, const struct glint_http_limits *limits)
{
    struct glint_http_limits filled = *limits;
    fill(&filled);
    pthread_mutex_lock(&http->mutex);
    http->limits = filled;
    pthread_mutex_unlock(&http->mutex);
}

struct glint_http_limits glint_http_limits(glint_http *http)
{
    pthread_mutex_lock(&http->mutex);
    const struct glint_http_limits limits = http->limits;
    pthread_mutex_unlock(&http->mutex);
    return limits;
}
