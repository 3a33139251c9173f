// client.h - HTTP to one daemon.
//
// A request waits for its answer, or until a signal is pending (interrupt.h): then it is dropped
// and answers GLINT_E_BUSY.
//
// Thread-safety: one owner.
#ifndef GLINT_CLI_CLIENT_H
#define GLINT_CLI_CLIENT_H

#include "protocol/status.h"

#include <cjson/cJSON.h>
#include <stdbool.h>
#include <stdint.h>

typedef struct glint_client glint_client;

#define GLINT_MAX_ANSWER ((size_t)64 << 20) // bytes of an answer that is kept in memory

struct glint_body {
    const char *type;     // media type
    const uint8_t *bytes; // or NULL: read from `fd`
    int fd;
    uint64_t size;
};

struct glint_request {
    const char *method;            // "GET"
    const char *path;              // "/v1/jobs?...", escaped
    const struct glint_body *body; // or NULL
    const char *idempotency_key;   // or NULL
    const char *last_event_id;     // or NULL
    const char *if_match;          // or NULL
    bool steady;                   // runs through signals; for requests that answer at once
    bool stream;                   // the server sends something at least every 60 s
    long connect_ms;               // 0: 10 s
    // Takes what a 2xx answer brings, piece by piece; false ends the transfer, which then is a
    // success. NULL: the body is kept in the answer.
    bool (*receive)(void *user, const void *bytes, size_t size);
    void (*idle)(void *user); // of one that runs beside: called ten times a second; or NULL
    void *user;
};

struct glint_answer {
    long http;
    char *body; // terminated, owned; "" where `receive` took it
    size_t size;
};

// `url` is http://HOST[:PORT] or https://...; without a scheme http is meant.
glint_status glint_client_create(glint_client **out, const char *url, struct glint_error *err);
void glint_client_destroy(glint_client **client);

// Who asks: a token that every request carries from now on, and a file of certificates (PEM) to
// trust instead of the system's; NULL leaves either as it is. GLINT_E_RANGE: the token cannot stand
// in a header, or would cross a network in the clear.
glint_status glint_client_identify(glint_client *client, const char *token,
                                   const char *certificates, struct glint_error *err);

const char *glint_client_url(const glint_client *client);

// GLINT_E_UNAVAILABLE where nobody answers; what a problem+json says where the answer is no 2xx.
// `answer` may be NULL; its body is to be freed on success.
glint_status glint_client_send(glint_client *client, const struct glint_request *request,
                               struct glint_answer *answer, struct glint_error *err);

// Sends a request that has `receive` and runs beside whatever is sent from now on, until its answer
// ends; what becomes of it shows in what was received. `request` and its texts must live as long.
glint_status glint_client_begin(glint_client *client, const struct glint_request *request,
                                struct glint_error *err);
bool glint_client_runs(const glint_client *client);
void glint_client_end(glint_client *client);                    // nothing runs beside any more
void glint_client_wait(glint_client *client, int milliseconds); // lets it run for that long

// Sends and parses the JSON object that must come back.
glint_status glint_client_json(glint_client *client, const struct glint_request *request,
                               cJSON **out, struct glint_error *err);

// The JSON object at before + escaped name + after (name NULL: at `before`).
glint_status glint_client_get(glint_client *client, const char *before, const char *name,
                              const char *after, cJSON **out, struct glint_error *err);

// `text` as a part of a path or query; malloc'd, or NULL without memory.
char *glint_client_escape(const char *text);

// before + escaped name + after; malloc'd, or NULL without memory.
char *glint_client_path(const char *before, const char *name, const char *after);

// `path` with ?name=value or &name=value; takes `path`, which may be NULL. value NULL adds nothing.
char *glint_client_query(char *path, const char *name, const char *value);

#endif
