// text.h - JSON text, written piece by piece.
//
// Commas come by themselves: a key or an item looks at what stands before it. Numbers are the
// shortest that read back the same; LC_NUMERIC must be "C". Running out of memory is remembered
// and shows when the text is taken.
//
// Thread-safety: one owner.
#ifndef GLINT_PROTOCOL_TEXT_H
#define GLINT_PROTOCOL_TEXT_H

#include <stdbool.h>
#include <stddef.h>

// Zero-initialise before use.
struct glint_text {
    char *bytes;
    size_t length, capacity;
    bool failed;
};

void glint_text_add(struct glint_text *t, const char *raw);
void glint_text_print(struct glint_text *t, const char *format, ...)
    __attribute__((format(printf, 2, 3)));

// A comma if one is due.
void glint_text_item(struct glint_text *t);
// A comma if one is due, the quoted key and a colon.
void glint_text_key(struct glint_text *t, const char *key);

// Quoted and escaped; bytes that are not UTF-8 become U+FFFD.
void glint_text_string(struct glint_text *t, const char *value);
// Finite only.
void glint_text_float(struct glint_text *t, float value);
void glint_text_double(struct glint_text *t, double value);
void glint_text_floats(struct glint_text *t, const float *value, size_t count); // an array

// The text, malloc'd and terminated, or NULL if memory ran out. *t is zeroed.
char *glint_text_take(struct glint_text *t, size_t *length);

#endif
