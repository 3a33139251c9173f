// routes.h - one table: method, path, where and by what it is answered.
#ifndef GLINT_HTTP_ROUTES_H
#define GLINT_HTTP_ROUTES_H

#include "http/request.h"

struct glint_route {
    const char *method;  // HEAD goes with GET
    const char *pattern; // "/v1/jobs/{}": {} is one segment that is not empty
    void (*handle)(struct glint_request *r);
    enum glint_lane lane;
    enum glint_body_kind body;
    const char *query;   // names of the parameters, each followed by a blank; '*': may repeat
    const char *summary; // for people
};

extern const struct glint_route glint_route_table[]; // method NULL ends it

// Sets r->route and r->argument, or answers 404 or 405.
void glint_route_find(struct glint_request *r, const char *method);

#endif
