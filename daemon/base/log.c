#include "base/log.h"

#include "base/clock.h"
#include "protocol/utf8.h"

#include <assert.h>
#include <ctype.h>
#include <pthread.h>
#include <stdarg.h>
#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <sys/uio.h>
#include <systemd/sd-journal.h>
#include <unistd.h>

#define VALUE_BYTES 256    // of a category or field, escaped; longer ones are cut
#define MESSAGE_BYTES 3072 // likewise
#define NAME_BYTES 24      // of a field, with what JSON and text put around it
#define LINE_BYTES 7168
#define DEBUG_BYTES 128 // of the list of categories
_Static_assert((GLINT_LOG_FIELDS + 1) * (VALUE_BYTES + NAME_BYTES) + MESSAGE_BYTES + 256 <=
                   LINE_BYTES,
               "a line holds all its parts");

// Written by glint_log_start before other threads exist, read afterwards.
static enum glint_log_format log_format;
static bool to_journal;

// Relaxed: a line more or less while it changes does not matter.
static atomic_int log_level = GLINT_LOG_INFO;
static atomic_bool debugs; // anything at all
static pthread_mutex_t debug_mutex = PTHREAD_MUTEX_INITIALIZER;
static char debug_categories[DEBUG_BYTES]; // under debug_mutex

struct line {
    char text[LINE_BYTES];
    size_t length;
};

// Whether standard error is the journal's, and its socket is there.
static bool is_journal(void)
{
    const char *named = getenv("JOURNAL_STREAM");
    unsigned long long device, inode;
    struct stat st;
    return named && sscanf(named, "%llu:%llu", &device, &inode) == 2 &&
           !fstat(STDERR_FILENO, &st) && st.st_dev == device && st.st_ino == inode &&
           !access("/run/systemd/journal/socket", W_OK);
}

void glint_log_start(enum glint_log_format format)
{
    log_format = format;
    to_journal = format == GLINT_LOG_AUTO && is_journal();
    glint_log_filter(GLINT_LOG_INFO, NULL);
}

void glint_log_filter(enum glint_log_level level, const char *debug)
{
    const char *named = debug ? debug : getenv("GLINT_DEBUG");
    pthread_mutex_lock(&debug_mutex);
    snprintf(debug_categories, sizeof debug_categories, "%s", named ? named : "");
    atomic_store_explicit(&debugs, *debug_categories, memory_order_relaxed);
    pthread_mutex_unlock(&debug_mutex);
    atomic_store_explicit(&log_level, level, memory_order_relaxed);
}

static bool listed(const char *category)
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

bool glint_log_enabled(const char *category)
{
    if (atomic_load_explicit(&log_level, memory_order_relaxed) >= GLINT_LOG_DEBUG)
        return true;
    if (!atomic_load_explicit(&debugs, memory_order_relaxed))
        return false;
    pthread_mutex_lock(&debug_mutex);
    const bool found = listed(category);
    pthread_mutex_unlock(&debug_mutex);
    return found;
}

static bool wanted(enum glint_log_level level, const char *category)
{
    return (int)level <= atomic_load_explicit(&log_level, memory_order_relaxed) ||
           (level == GLINT_LOG_DEBUG && glint_log_enabled(category));
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
    append_text(line, line->length ? ",\"" : "{\"");
    append_text(line, name);
    append_text(line, "\":\"");
    append_escaped(line, value, true, most);
    append_text(line, "\"");
}

static void append_number(struct line *line, const char *name, const char *value)
{
    append_text(line, ",\"");
    append_text(line, name);
    append_text(line, "\":");
    append_escaped(line, value, true, VALUE_BYTES);
}

// What a line is made of.
struct event {
    enum glint_log_level level;
    const char *category, *message;
    const struct glint_log_field *field;
    size_t fields;
};

static void format_json(struct line *line, const struct event *e)
{
    char time[32];
    glint_utc(time);
    append_member(line, "time", time, 32);
    append_member(line, "level", level_name(e->level), 16);
    append_member(line, "category", e->category, VALUE_BYTES);
    for (size_t i = 0; i < e->fields; i++)
        if (e->field[i].text && e->field[i].number)
            append_number(line, e->field[i].name, e->field[i].text);
        else if (e->field[i].text)
            append_member(line, e->field[i].name, e->field[i].text, VALUE_BYTES);
    append_member(line, "message", e->message, MESSAGE_BYTES);
    append_text(line, "}");
}

static void format_text(struct line *line, const struct event *e)
{
    const char priority[] = {'<', (char)('0' + e->level), '>', '\0'};
    append_text(line, priority);
    append_escaped(line, e->category, false, VALUE_BYTES);
    for (size_t i = 0; i < e->fields; i++) {
        if (!e->field[i].text || e->field[i].said)
            continue;
        const char *name = e->field[i].name, *id = strstr(name, "_id");
        append_text(line, " ");
        append(line, name, id ? (size_t)(id - name) : strlen(name)); // request=, for short
        append_text(line, "=");
        append_escaped(line, e->field[i].text, false, VALUE_BYTES);
    }
    append_text(line, ": ");
    append_escaped(line, e->message, false, MESSAGE_BYTES);
}

// "request_id" is REQUEST_ID like other programs' fields, "path" GLINT_PATH.
static void name_field(char out[NAME_BYTES + 8], const char *name)
{
    snprintf(out, NAME_BYTES + 8, "%s%s", strstr(name, "_id") ? "" : "GLINT_", name);
    for (char *c = out; *c; c++)
        *c = (char)toupper((unsigned char)*c);
}

static void add_field(struct line *line, struct iovec *part, const char *name, const char *value,
                      size_t most)
{
    part->iov_base = line->text + line->length;
    append_text(line, name);
    append_text(line, "=");
    append(line, value, strnlen(value, most));
    part->iov_len = (size_t)(line->text + line->length - (char *)part->iov_base);
}

static void write_journal(struct line *line, const struct event *e)
{
    struct iovec part[GLINT_LOG_FIELDS + 3];
    const char priority[] = {(char)('0' + e->level), '\0'};
    int parts = 0;
    add_field(line, &part[parts++], "MESSAGE", e->message, MESSAGE_BYTES);
    add_field(line, &part[parts++], "PRIORITY", priority, 1);
    add_field(line, &part[parts++], "GLINT_CATEGORY", e->category, VALUE_BYTES);
    for (size_t i = 0; i < e->fields; i++) {
        char name[NAME_BYTES + 8];
        if (!e->field[i].text)
            continue;
        name_field(name, e->field[i].name);
        add_field(line, &part[parts++], name, e->field[i].text, VALUE_BYTES);
    }
    sd_journal_sendv(part, parts);
}

static void write_event(const struct event *e)
{
    struct line line;
    line.length = 0;
    if (to_journal) {
        write_journal(&line, e);
        return;
    }
    (log_format == GLINT_LOG_JSON ? format_json : format_text)(&line, e);
    append_text(&line, "\n");
    // One write keeps the line whole beside those of other threads; a lost log stops nothing.
    const ssize_t written = write(STDERR_FILENO, line.text, line.length);
    (void)written;
}

static void log_event(enum glint_log_level level, const char *category,
                      const struct glint_log_field *field, size_t fields, const char *format,
                      va_list args)
{
    char message[MESSAGE_BYTES];
    vsnprintf(message, sizeof message, format, args);
    const struct event e = {level, category, message, field, fields};
    write_event(&e);
}

void glint_log(enum glint_log_level level, const char *category, const char *job,
               const char *request, const char *format, ...)
{
    if (!wanted(level, category))
        return;
    const struct glint_log_field field[] = {{.name = "job_id", .text = job},
                                            {.name = "request_id", .text = request}};
    va_list args;
    va_start(args, format);
    log_event(level, category, field, 2, format, args);
    va_end(args);
}

void glint_log_event(enum glint_log_level level, const char *category,
                     const struct glint_log_field *field, size_t fields, const char *format, ...)
{
    assert(fields <= GLINT_LOG_FIELDS);
    if (!wanted(level, category))
        return;
    va_list args;
    va_start(args, format);
    log_event(level, category, field, fields, format, args);
    va_end(args);
}
