// viewer.h - the files of clients/web, embedded by the build.
#ifndef GLINT_HTTP_VIEWER_H
#define GLINT_HTTP_VIEWER_H

#include "device/sources.h"

extern const struct glint_source glint_viewer[]; // names without a folder; name NULL ends it

#endif
