#include "base/log.h"

#include "base/clock.h"
#include "protocol/utf8.h"

#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#define LINE_BYTES 4096
#define VALUE_BYTES 256    // of a category, job or request, escaped; longer ones are cut
#define MESSAGE_BYTES 3072 // likewise
_Static_assert(3 * VALUE_BYTES + MESSAGE_BYTES + 256 <= LINE_BYTES, "a line holds all its parts");

// Written by glint_log_start before other threads exist, read afterwards.
static enum glint_log_format log_format;
static const char *debug_categories = "";

struct line {
    char text[LINE_BYTES];
    size_t length;
};

void glint_log_start(enum glint_log_format format)
{
    log_format = format;
    const char *named = getenv("GLINT_DEBUG");
    debug_categories = named ? named : "";
}

bool glint_log_enabled(const char *category)
{
    const size_t length = strlen(category);
    for (const char *at = debug_categories; *at;) {
        const size_t span = strcspn(at, ",");
        if (span == length && !strncmp(at, category, span))
            return true;
        at += span + (at[span] == ',');
    }
    return false;
}

static void append(struct line *line, const char *text, size_t length)
{
    memcpy(line->text + line->length, text, length);
    line->length += length;
}

static void append_text(struct line *line, const char *text)
{
    append(line, text, strlen(text));
}

// What clients send reaches the log: neither a line break nor a quote of theirs may forge a line.
static void append_escaped(struct line *line, const char *text, bool quotes, size_t most)
{
    const size_t end = line->length + most - 8; // room for the longest escape
    for (size_t left = strlen(text); left && line->length < end;) {
        const size_t length = glint_utf8_sequence(text, left);
        const unsigned char c = (unsigned char)*text;
        char escaped[8];
        if (!length)
            append_text(line, "\xef\xbf\xbd");
        else if (c < 0x20 || c == 0x7f)
            append(line, escaped, (size_t)snprintf(escaped, sizeof escaped, "\\u%04x", c));
        else if (quotes && (c == '"' || c == '\\'))
            append(line, escaped, (size_t)snprintf(escaped, sizeof escaped, "\\%c", c));
        else
            append(line, text, length);
        text += length ? length : 1;
        left -= length ? length : 1;
    }
}

static const char *level_name(enum glint_log_level level)
{
    return level == GLINT_LOG_ERROR     ? "error"
           : level == GLINT_LOG_WARNING ? "warning"
           : level == GLINT_LOG_INFO    ? "info"
                                        : "debug";
}

static void append_member(struct line *line, const char *name, const char *value, size_t most)
{
    if (!value)
        return;
    append_text(line, line->length ? ",\"" : "{\"");
    append_text(line, name);
    append_text(line, "\":\"");
    append_escaped(line, value, true, most);
    append_text(line, "\"");
}

static void append_word(struct line *line, const char *name, const char *value, size_t most)
{
    if (!value)
        return;
    append_text(line, name);
    append_escaped(line, value, false, most);
}

static void format_json(struct line *line, enum glint_log_level level, const char *category,
                        const char *job, const char *request, const char *message)
{
    char time[32];
    glint_utc(time);
    append_member(line, "time", time, 32);
    append_member(line, "level", level_name(level), 16);
    append_member(line, "category", category, VALUE_BYTES);
    append_member(line, "job_id", job, VALUE_BYTES);
    append_member(line, "request_id", request, VALUE_BYTES);
    append_member(line, "message", message, MESSAGE_BYTES);
    append_text(line, "}");
}

static void format_text(struct line *line, enum glint_log_level level, const char *category,
                        const char *job, const char *request, const char *message)
{
    const char priority[] = {'<', (char)('0' + level), '>', '\0'};
    append_text(line, priority);
    append_word(line, "", category, VALUE_BYTES);
    append_word(line, " job=", job, VALUE_BYTES);
    append_word(line, " request=", request, VALUE_BYTES);
    append_word(line, ": ", message, MESSAGE_BYTES);
}

void glint_log(enum glint_log_level level, const char *category, const char *job,
               const char *request, const char *format, ...)
{
    if (level == GLINT_LOG_DEBUG && !glint_log_enabled(category))
        return;
    char message[MESSAGE_BYTES];
    va_list args;
    va_start(args, format);
    vsnprintf(message, sizeof message, format, args);
    va_end(args);

    struct line line = {.length = 0};
    (log_format == GLINT_LOG_JSON ? format_json : format_text)(&line, level, category, job, request,
                                                               message);
    append_text(&line, "\n");
    // One write keeps the line whole beside those of other threads; a lost log stops nothing.
    const ssize_t written = write(STDERR_FILENO, line.text, line.length);
    (void)written;
}
