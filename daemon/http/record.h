// record.h - what is left of a request when it is over: a line in the log, and counts.
//
// Threads: the HTTP library's.
#ifndef GLINT_HTTP_RECORD_H
#define GLINT_HTTP_RECORD_H

#include "http/request.h"

#define GLINT_MAX_ROUTES 64

// Makes the series of glint_record_request known to the server's metrics.
glint_status glint_record_create(struct glint_record **out, glint_metrics *metrics,
                                 struct glint_error *err);
void glint_record_destroy(struct glint_record **record);

// Before the request is freed. complete: its answer was sent to the end.
void glint_record_request(struct glint_request *r, bool complete);

#endif
