// settings.h - what an administrator decides: by file, by the command line, which counts more.
//
// glintd.conf(5) says what each means. One table names them all; the command line takes each as an
// option, with - for _.
//
// Thread-safety: main's.
#ifndef GLINT_SETTINGS_H
#define GLINT_SETTINGS_H

#include "base/config.h"
#include "base/log.h"
#include "http/http.h"
#include "jobs/jobs.h"

struct glint_settings {
    char *listen, *state; // owned, like every text; state NULL: where the system keeps it
    uint32_t threads;     // 0: one per core
    enum glint_log_format log_format;
    enum glint_log_level log_level;
    char *debug; // NULL: $GLINT_DEBUG
    char *token_file, *tls_cert, *tls_key;
    double checkpoint_seconds, drain_seconds;
    size_t film_bytes; // on the disk, 0: half of what is free
    struct glint_jobs_limits jobs;
    struct glint_http_limits http;
};

// Where settings come from.
struct glint_settings_source {
    const char *file;          // NULL: $CONFIGURATION_DIRECTORY/glintd.conf, if it is there
    struct glint_config given; // on the command line
};

// Reads *out anew: the defaults, the file's over them, over these the given ones. Files that
// $CREDENTIALS_DIRECTORY has (tokens, tls.crt, tls.key) stand for settings that nobody made.
//   GLINT_E_IO     the file cannot be read
//   GLINT_E_RANGE  a setting is unknown or its value wrong, each named with its line; a
//                  certificate without a key
glint_status glint_settings_read(struct glint_settings *out,
                                 const struct glint_settings_source *source,
                                 struct glint_error *err);
void glint_settings_finish(struct glint_settings *settings);

// Names in the order of the table, NULL behind the last.
const char *glint_settings_name(size_t index);

// Sets one. `label` names it in the fault: "--threads", "glintd.conf:3: threads".
//   GLINT_E_RANGE  there is no such setting, or it does not take this value
glint_status glint_settings_set(struct glint_settings *settings, const char *name,
                                const char *value, const char *label, struct glint_error *err);

// Calls `changed` with the name of each setting that differs and cannot change while the daemon
// runs.
void glint_settings_compare(const struct glint_settings *old, const struct glint_settings *new,
                            void (*changed)(const char *name));

#endif
