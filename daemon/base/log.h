// log.h - one line for each event, with the job and request it belongs to.
//
// To standard error, as text or JSON; where that is the journal's ($JOURNAL_STREAM), to the journal
// with a field for each part: MESSAGE, PRIORITY, JOB_ID, REQUEST_ID, TRACE_ID, the rest with GLINT_
// in front.
//
// Thread-safety: any thread; a line is written whole.
#ifndef GLINT_BASE_LOG_H
#define GLINT_BASE_LOG_H

#include <stdbool.h>
#include <stddef.h>

enum glint_log_level {
    GLINT_LOG_ERROR = 3,
    GLINT_LOG_WARNING = 4,
    GLINT_LOG_INFO = 6,
    GLINT_LOG_DEBUG = 7
};
// AUTO: the journal, where it listens, or else text.
enum glint_log_format { GLINT_LOG_AUTO, GLINT_LOG_TEXT, GLINT_LOG_JSON };

// Once, before other threads exist. Lines up to GLINT_LOG_INFO are written, GLINT_LOG_DEBUG ones
// for the categories in $GLINT_DEBUG ("cl,http,jobs").
void glint_log_start(enum glint_log_format format);

// From now on lines up to `level`, and GLINT_LOG_DEBUG ones for the categories in `debug` (NULL:
// those in $GLINT_DEBUG). At any time.
void glint_log_filter(enum glint_log_level level, const char *debug);

// `job` and `request` may be NULL. category: "cl", "http", "jobs", "scene", "main".
void glint_log(enum glint_log_level level, const char *category, const char *job,
               const char *request, const char *format, ...) __attribute__((format(printf, 5, 6)));

struct glint_log_field {
    const char *name; // "request_id", static
    const char *text; // NULL: the field is left out
    bool number;      // `text` is one, and JSON says so
    bool said;        // the message says it too: text lines leave it out
};
#define GLINT_LOG_FIELDS 12 // at most

void glint_log_event(enum glint_log_level level, const char *category,
                     const struct glint_log_field *field, size_t fields, const char *format, ...)
    __attribute__((format(printf, 5, 6)));

// Whether GLINT_LOG_DEBUG lines of the category are written.
bool glint_log_enabled(const char *category);

#endif
