#include "sse.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static bool append(struct glint_sse_text *t, const char *bytes, size_t size)
{
    if (size > GLINT_SSE_LINE - t->size)
        return false;
    if (t->size + size + 1 > t->capacity) {
        const size_t capacity = 2 * (t->size + size) + 256;
        char *grown = realloc(t->bytes, capacity);
        if (!grown)
            return false;
        t->bytes = grown;
        t->capacity = capacity;
    }
    memcpy(t->bytes + t->size, bytes, size);
    t->size += size;
    t->bytes[t->size] = '\0';
    return true;
}

// An empty line: the event is complete, unless it has no data.
static bool dispatch(struct glint_sse *sse)
{
    bool more = true;
    memcpy(sse->id, sse->next_id, sizeof sse->id);
    if (sse->data.size) {
        sse->data.bytes[sse->data.size - 1] = '\0'; // the last line feed
        more = sse->event(sse->user, sse->name[0] ? sse->name : "message", sse->data.bytes);
    }
    sse->data.size = 0;
    sse->name[0] = '\0';
    return more;
}

static bool take_line(struct glint_sse *sse)
{
    char *line = sse->line.bytes;
    const size_t length = sse->line.size;
    sse->line.size = 0;
    if (!length)
        return dispatch(sse);
    char *colon = memchr(line, ':', length);
    if (colon == line)
        return true; // a comment
    const char *value = "";
    if (colon) {
        *colon = '\0';
        value = colon[1] == ' ' ? colon + 2 : colon + 1;
    }
    if (strcmp(line, "data") == 0)
        return append(&sse->data, value, strlen(value)) && append(&sse->data, "\n", 1);
    if (strcmp(line, "event") == 0)
        snprintf(sse->name, sizeof sse->name, "%s", value);
    else if (strcmp(line, "id") == 0)
        snprintf(sse->next_id, sizeof sse->next_id, "%s", value);
    return true;
}

bool glint_sse_feed(struct glint_sse *sse, const void *bytes, size_t size)
{
    for (const char *c = bytes, *end = c + size; c < end; c++) {
        const bool second_half = sse->after_cr && *c == '\n';
        sse->after_cr = *c == '\r';
        if (second_half)
            continue;
        if (*c == '\n' || *c == '\r') {
            if (!take_line(sse))
                return false;
        } else if (!append(&sse->line, c, 1)) {
            return false;
        }
    }
    return true;
}

void glint_sse_restart(struct glint_sse *sse)
{
    sse->line.size = sse->data.size = 0;
    sse->name[0] = '\0';
    memcpy(sse->next_id, sse->id, sizeof sse->id);
    sse->after_cr = false;
}

void glint_sse_finish(struct glint_sse *sse)
{
    free(sse->line.bytes);
    free(sse->data.bytes);
    *sse = (struct glint_sse){0};
}
