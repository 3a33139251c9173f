// text.c - a growing string that knows JSON.
#include "protocol/text.h"

#include "protocol/utf8.h"

#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static bool reserve(struct glint_text *t, size_t more)
{
    if (t->failed)
        return false;
    if (more < t->capacity - t->length)
        return true;
    size_t capacity = t->capacity ? t->capacity : 256;
    while (capacity - t->length <= more)
        capacity *= 2;
    char *bytes = realloc(t->bytes, capacity);
    if (!bytes) {
        t->failed = true;
        return false;
    }
    t->bytes = bytes;
    t->capacity = capacity;
    return true;
}

static void add_bytes(struct glint_text *t, const char *bytes, size_t n)
{
    if (!reserve(t, n))
        return;
    memcpy(t->bytes + t->length, bytes, n);
    t->length += n;
}

void glint_text_add(struct glint_text *t, const char *raw)
{
    add_bytes(t, raw, strlen(raw));
}

void glint_text_print(struct glint_text *t, const char *format, ...)
{
    char *text = NULL;
    va_list args;
    va_start(args, format);
    const int n = vasprintf(&text, format, args);
    va_end(args);
    if (n < 0) {
        t->failed = true;
        return;
    }
    add_bytes(t, text, (size_t)n);
    free(text);
}

void glint_text_item(struct glint_text *t)
{
    if (t->length && !strchr("{[:,\n", t->bytes[t->length - 1]))
        glint_text_add(t, ",");
}

void glint_text_key(struct glint_text *t, const char *key)
{
    glint_text_item(t);
    glint_text_string(t, key);
    glint_text_add(t, ":");
}

static const char *short_escape(char c)
{
    switch (c) {
    case '"':
        return "\\\"";
    case '\\':
        return "\\\\";
    case '\b':
        return "\\b";
    case '\f':
        return "\\f";
    case '\n':
        return "\\n";
    case '\r':
        return "\\r";
    case '\t':
        return "\\t";
    default:
        return NULL;
    }
}

void glint_text_string(struct glint_text *t, const char *value)
{
    const char *end = value + strlen(value);
    glint_text_add(t, "\"");
    while (value < end) {
        const size_t n = glint_utf8_sequence(value, (size_t)(end - value));
        const char *escape = short_escape(*value);
        if (escape)
            glint_text_add(t, escape);
        else if (n == 1 && ((unsigned char)*value < 0x20 || *value == 0x7f))
            glint_text_print(t, "\\u%04x", (unsigned char)*value);
        else if (n)
            add_bytes(t, value, n);
        else
            glint_text_add(t, "\xef\xbf\xbd");
        value += n ? n : 1;
    }
    glint_text_add(t, "\"");
}

// %g drops trailing zeros, so fewer digits than 6 (15) need no try of their own. Read back through
// a double, as the JSON reader does.
void glint_text_float(struct glint_text *t, float value)
{
    char text[32];
    for (int digits = 6; digits <= 9; digits++) {
        snprintf(text, sizeof text, "%.*g", digits, value);
        if ((float)strtod(text, NULL) == value)
            break;
    }
    glint_text_add(t, text);
}

void glint_text_double(struct glint_text *t, double value)
{
    char text[40];
    for (int digits = 15; digits <= 17; digits++) {
        snprintf(text, sizeof text, "%.*g", digits, value);
        if (strtod(text, NULL) == value)
            break;
    }
    glint_text_add(t, text);
}

void glint_text_floats(struct glint_text *t, const float *value, size_t count)
{
    glint_text_add(t, "[");
    for (size_t i = 0; i < count; i++) {
        glint_text_item(t);
        glint_text_float(t, value[i]);
    }
    glint_text_add(t, "]");
}

char *glint_text_take(struct glint_text *t, size_t *length)
{
    if (!t->bytes)
        t->failed |= !reserve(t, 1);
    char *text = t->failed ? NULL : t->bytes;
    if (text)
        text[t->length] = '\0';
    else
        free(t->bytes);
    if (length)
        *length = text ? t->length : 0;
    *t = (struct glint_text){0};
    return text;
}
