// session.h - one command being run: where its daemon is and how it answers its user.
//
// Thread-safety: one owner.
#ifndef GLINT_CLI_SESSION_H
#define GLINT_CLI_SESSION_H

#include "client.h"
#include "options.h"
#include "progress.h"
#include "spawn.h"

typedef struct glint_tev_stream glint_tev_stream;

struct glint_session {
    glint_client *client;
    glint_daemon *daemon;  // the private one, or NULL
    glint_tev_stream *tev; // pictures of the job that is followed, or NULL
    struct glint_progress progress;
    bool json;      // stdout carries one JSON document
    bool usage;     // the fault is in the command line
    bool cancelled; // the job was, by whomever
};

#define GLINT_DEFAULT_SERVER "http://127.0.0.1:7745"

// Connects to --server, else $GLINT_SERVER, else the default. With `spawn`, starts a private
// daemon where none answers there. Requests carry the token of --token-file, else $GLINT_TOKEN.
glint_status glint_session_open(struct glint_session *s, const struct glint_arguments *a,
                                bool spawn, struct glint_error *err);

// Closes the connection and stops the private daemon. err: what the command failed with, to which
// is added that this daemon has died, or NULL.
void glint_session_close(struct glint_session *s, struct glint_error *err);

// Marks what is wrong as the user's command line and appends it (printf); GLINT_E_RANGE.
glint_status glint_session_usage(struct glint_session *s, struct glint_error *err,
                                 const char *format, ...) __attribute__((format(printf, 3, 4)));

// Prints a document, takes it.
void glint_session_print(cJSON *document);

#endif
