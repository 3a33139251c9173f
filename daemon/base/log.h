// log.h - one line to standard error for each event, with the job and request it belongs to.
//
// Thread-safety: any thread; a line is written whole.
#ifndef GLINT_BASE_LOG_H
#define GLINT_BASE_LOG_H

#include <stdbool.h>

enum glint_log_level {
    GLINT_LOG_ERROR = 3,
    GLINT_LOG_WARNING = 4,
    GLINT_LOG_INFO = 6,
    GLINT_LOG_DEBUG = 7
};
enum glint_log_format { GLINT_LOG_TEXT, GLINT_LOG_JSON };

// Categories named in GLINT_DEBUG ("cl,http,jobs") print GLINT_LOG_DEBUG lines too.
void glint_log_start(enum glint_log_format format);

// `job` and `request` may be NULL. category: "cl", "http", "jobs", "scene", "main".
void glint_log(enum glint_log_level level, const char *category, const char *job,
               const char *request, const char *format, ...) __attribute__((format(printf, 5, 6)));

bool glint_log_enabled(const char *category);

#endif
