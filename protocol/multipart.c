// multipart.c - heads are printed and parsed here; bodies pass by their stated length.
#include "protocol/multipart.h"

#include <assert.h>
#include <ctype.h>
#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

#define BOUNDARY_BYTES 70
#define LINE_BYTES 1024
#define MAX_LINES 64 // of a head, or before the first delimiter

size_t glint_multipart_write_head(char out[GLINT_MULTIPART_HEAD_BYTES],
                                  const struct glint_multipart_head *head)
{
    char tile[64] = "";
    if (head->has_tile)
        snprintf(tile, sizeof tile, "Glint-Tile: %u %u %u %u\r\n", head->tile[0], head->tile[1],
                 head->tile[2], head->tile[3]);
    const int length = snprintf(
        out, GLINT_MULTIPART_HEAD_BYTES,
        "\r\n--" GLINT_MULTIPART_BOUNDARY "\r\nContent-Type: %s\r\nContent-Length: %" PRIu64
        "\r\n%sGlint-Samples: %" PRIu64 "\r\nGlint-Seq: %" PRIu64 "\r\nGlint-Revision: %s\r\n\r\n",
        head->type, head->length, tile, head->samples, head->sequence, head->revision);
    assert(length > 0 && length < GLINT_MULTIPART_HEAD_BYTES);
    return (size_t)length;
}

enum state {
    BEFORE_FIRST, // lines up to the first delimiter
    IN_HEAD,
    IN_BODY,
    AFTER_BODY, // the line break that belongs to the delimiter
    AT_DELIMITER,
    ENDED,
    FAILED
};

// Headers that a part may say once; bits of glint_multipart_reader.seen.
enum header { TYPE, LENGTH, TILE, SAMPLES, SEQUENCE, REVISION, HEADERS };

struct glint_multipart_reader {
    char delimiter[2 + BOUNDARY_BYTES + 1];
    uint64_t max_part_bytes;
    glint_multipart_part *part;
    void *user;
    enum state state;
    glint_status failure; // in state FAILED
    char line[LINE_BYTES];
    size_t line_bytes;
    unsigned lines; // of the head, or before the first delimiter
    unsigned seen;
    struct glint_multipart_head head;
    uint8_t *body; // owned
    size_t body_bytes, body_capacity;
};

// RFC 2046: what a boundary may consist of; a space may not end it.
static bool is_boundary(const char *text, size_t length)
{
    for (size_t i = 0; i < length; i++)
        if (!isalnum((unsigned char)text[i]) && !strchr("'()+_,-./:=? ", text[i]))
            return false;
    return length >= 1 && length <= BOUNDARY_BYTES && text[length - 1] != ' ';
}

// The value of the parameter `boundary`, quoted or not; NULL where there is none.
static const char *find_boundary(const char *content_type, size_t *length)
{
    if (strncasecmp(content_type, "multipart/", 10))
        return NULL;
    const char *at = strchr(content_type, ';');
    while (at) {
        at += 1 + strspn(at + 1, " \t");
        if (!strncasecmp(at, "boundary=", 9)) {
            at += 9;
            const bool quoted = *at == '"';
            *length = strcspn(at + quoted, quoted ? "\"" : "; \t");
            return at + quoted;
        }
        at = strchr(at, ';');
    }
    return NULL;
}

glint_status glint_multipart_reader_create(glint_multipart_reader **out,
                                           const struct glint_multipart_params *params,
                                           struct glint_error *err)
{
    *out = NULL;
    size_t length = 0;
    const char *boundary = find_boundary(params->content_type, &length);
    if (!boundary || !is_boundary(boundary, length))
        return glint_fail(err, GLINT_E_MEDIA_TYPE, "", "'%s' is no multipart type with a boundary",
                          params->content_type);
    glint_multipart_reader *r = calloc(1, sizeof *r);
    if (!r)
        return glint_fail(err, GLINT_E_NOMEM, "", "no memory for a stream's reader");
    snprintf(r->delimiter, sizeof r->delimiter, "--%.*s", (int)length, boundary);
    r->max_part_bytes = params->max_part_bytes;
    r->part = params->part;
    r->user = params->user;
    *out = r;
    return GLINT_OK;
}

void glint_multipart_reader_destroy(glint_multipart_reader **reader)
{
    if (*reader)
        free((*reader)->body);
    free(*reader);
    *reader = NULL;
}

bool glint_multipart_ended(const glint_multipart_reader *reader)
{
    return reader->state == ENDED;
}

// Reads one decimal number of 1..19 digits and steps over it.
static bool take_number(const char **at, uint64_t *out)
{
    const size_t digits = strspn(*at, "0123456789");
    if (digits < 1 || digits > 19)
        return false;
    *out = strtoull(*at, NULL, 10);
    *at += digits;
    return true;
}

static bool parse_number(const char *value, uint64_t *out)
{
    return take_number(&value, out) && !*value;
}

static bool parse_tile(const char *value, struct glint_multipart_head *head)
{
    for (int i = 0; i < 4; i++) {
        uint64_t n;
        if (!take_number(&value, &n) || n > UINT32_MAX || *value != (i < 3 ? ' ' : 0))
            return false;
        head->tile[i] = (uint32_t)n;
        value++;
    }
    head->has_tile = true;
    return true;
}

static bool parse_text(const char *value, char *out, size_t capacity)
{
    for (const char *c = value; *c; c++)
        if (*c < 0x20 || *c > 0x7e)
            return false;
    return (size_t)snprintf(out, capacity, "%s", value) < capacity;
}

static bool parse_value(enum header header, const char *value, struct glint_multipart_head *head)
{
    switch (header) {
    case TYPE:
        return parse_text(value, head->type, sizeof head->type);
    case LENGTH:
        return parse_number(value, &head->length);
    case TILE:
        return parse_tile(value, head);
    case SAMPLES:
        return parse_number(value, &head->samples);
    case SEQUENCE:
        return parse_number(value, &head->sequence);
    case REVISION:
        return parse_text(value, head->revision, sizeof head->revision);
    case HEADERS:
        break;
    }
    return true;
}

static enum header find_header(const char *name)
{
    static const char *const names[HEADERS] = {
        [TYPE] = "Content-Type",     [LENGTH] = "Content-Length", [TILE] = "Glint-Tile",
        [SAMPLES] = "Glint-Samples", [SEQUENCE] = "Glint-Seq",    [REVISION] = "Glint-Revision"};
    enum header h = 0;
    while (h < HEADERS && strcasecmp(name, names[h]))
        h++;
    return h;
}

static glint_status take_header(glint_multipart_reader *r, struct glint_error *err)
{
    char *colon = strchr(r->line, ':');
    if (!colon || colon == r->line)
        return glint_fail(err, GLINT_E_SYNTAX, "", "a part's header is no 'name: value': '%s'",
                          r->line);
    *colon = 0;
    const char *value = colon + 1 + strspn(colon + 1, " \t");
    const enum header header = find_header(r->line);
    if (header == HEADERS)
        return GLINT_OK;
    if (r->seen >> header & 1)
        return glint_fail(err, GLINT_E_SYNTAX, "", "a part says %s twice", r->line);
    r->seen |= 1u << header;
    if (!parse_value(header, value, &r->head))
        return glint_fail(err, GLINT_E_SYNTAX, "", "a part's %s is '%s'", r->line, value);
    return GLINT_OK;
}

static glint_status give_part(glint_multipart_reader *r)
{
    r->state = AFTER_BODY;
    return r->part(r->user, &r->head, r->body);
}

static glint_status begin_body(glint_multipart_reader *r, struct glint_error *err)
{
    if (!(r->seen >> LENGTH & 1))
        return glint_fail(err, GLINT_E_SYNTAX, "", "a part has no Content-Length");
    if (r->head.length > r->max_part_bytes)
        return glint_fail(err, GLINT_E_TOO_LARGE, "",
                          "a part of %" PRIu64 " bytes, more than %" PRIu64, r->head.length,
                          r->max_part_bytes);
    r->state = IN_BODY;
    r->body_bytes = 0;
    return r->head.length ? GLINT_OK : give_part(r);
}

static void begin_head(glint_multipart_reader *r)
{
    r->state = IN_HEAD;
    r->lines = 0;
    r->seen = 0;
    r->head = (struct glint_multipart_head){0};
}

// What follows the delimiter on the line, less trailing blanks; NULL where it is another line.
static const char *after_delimiter(glint_multipart_reader *r)
{
    const size_t length = strlen(r->delimiter);
    size_t end = r->line_bytes;
    while (end && strchr(" \t", r->line[end - 1]))
        r->line[--end] = 0;
    return strncmp(r->line, r->delimiter, length) ? NULL : r->line + length;
}

static glint_status take_delimiter(glint_multipart_reader *r, struct glint_error *err)
{
    const char *rest = after_delimiter(r);
    if (rest && !*rest) {
        begin_head(r);
        return GLINT_OK;
    }
    if (rest && !strcmp(rest, "--")) {
        r->state = ENDED;
        return GLINT_OK;
    }
    if (r->state == BEFORE_FIRST && ++r->lines <= MAX_LINES)
        return GLINT_OK;
    return glint_fail(err, GLINT_E_SYNTAX, "", "the boundary '%s' is missing", r->delimiter);
}

// Takes a line, which stands in r->line without its line break.
static glint_status take_line(glint_multipart_reader *r, struct glint_error *err)
{
    switch (r->state) {
    case IN_HEAD:
        if (++r->lines > MAX_LINES)
            return glint_fail(err, GLINT_E_SYNTAX, "", "a part has more than %d headers",
                              MAX_LINES);
        return r->line_bytes ? take_header(r, err) : begin_body(r, err);
    case AFTER_BODY:
        if (r->line_bytes)
            return glint_fail(err, GLINT_E_SYNTAX, "", "a part is longer than its Content-Length");
        r->state = AT_DELIMITER;
        return GLINT_OK;
    default:
        return take_delimiter(r, err);
    }
}

// Collects a line; returns the bytes used.
static size_t feed_line(glint_multipart_reader *r, const char *bytes, size_t size, glint_status *st,
                        struct glint_error *err)
{
    const char *end = memchr(bytes, '\n', size);
    const size_t used = end ? (size_t)(end - bytes) + 1 : size;
    if (r->line_bytes + used >= LINE_BYTES || memchr(bytes, 0, used)) {
        *st = glint_fail(err, GLINT_E_SYNTAX, "", "a line between parts is too long or not text");
        return used;
    }
    memcpy(r->line + r->line_bytes, bytes, used);
    r->line_bytes += used;
    if (!end)
        return used;
    if (r->line_bytes < 2 || r->line[r->line_bytes - 2] != '\r') {
        *st = glint_fail(err, GLINT_E_SYNTAX, "", "a line between parts does not end in CR LF");
        return used;
    }
    r->line_bytes -= 2;
    r->line[r->line_bytes] = 0;
    *st = take_line(r, err);
    r->line_bytes = 0;
    return used;
}

// Memory follows what has arrived, never what was announced.
static bool reserve(glint_multipart_reader *r, size_t wanted)
{
    if (wanted <= r->body_capacity)
        return true;
    const size_t capacity = wanted < 32768 ? 65536 : 2 * wanted;
    uint8_t *body = realloc(r->body, capacity);
    if (!body)
        return false;
    r->body = body;
    r->body_capacity = capacity;
    return true;
}

static size_t feed_body(glint_multipart_reader *r, const char *bytes, size_t size, glint_status *st,
                        struct glint_error *err)
{
    const uint64_t left = r->head.length - r->body_bytes;
    const size_t used = size < left ? size : (size_t)left;
    if (!reserve(r, r->body_bytes + used)) {
        *st = glint_fail(err, GLINT_E_NOMEM, "", "no memory for a part of %" PRIu64 " bytes",
                         r->head.length);
        return used;
    }
    memcpy(r->body + r->body_bytes, bytes, used);
    r->body_bytes += used;
    if (r->body_bytes == r->head.length)
        *st = give_part(r);
    return used;
}

glint_status glint_multipart_feed(glint_multipart_reader *reader, const void *bytes, size_t size,
                                  struct glint_error *err)
{
    if (reader->state == FAILED)
        return glint_fail(err, reader->failure, "", "the stream was broken before");
    const char *at = bytes;
    glint_status st = GLINT_OK;
    while (!st && size && reader->state != ENDED) {
        const size_t used = reader->state == IN_BODY ? feed_body(reader, at, size, &st, err)
                                                     : feed_line(reader, at, size, &st, err);
        at += used;
        size -= used;
    }
    if (st) {
        reader->state = FAILED;
        reader->failure = st;
    }
    return st;
}
