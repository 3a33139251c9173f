// words.h - text files of lines and words: OBJ, MTL, and the ASCII forms of PLY and STL.
//
// Nothing is copied and no terminator is needed. Numbers are read the same in every locale.
//
// Thread-safety: reentrant.
#ifndef GLINT_SCENE_WORDS_H
#define GLINT_SCENE_WORDS_H

#include "protocol/status.h"

#include <stdbool.h>
#include <stdint.h>

struct glint_word {
    const char *text; // not terminated
    size_t length;    // 0: there is none
};

struct glint_words {
    const char *at, *end;        // what is left of the line that is read
    const char *next, *text_end; // the lines after it
    uint32_t line;               // its number, from 1
    uint32_t joined;             // lines that it goes on for
    const char *file;            // that faults name beside the line, or NULL
    struct glint_error *err;
};

void glint_words_start(struct glint_words *w, const void *text, size_t size,
                       struct glint_error *err);

// Goes to the next line; false at the end. A backslash at the end of a line joins it with the next
// where `joins`.
bool glint_words_line(struct glint_words *w, bool joins);

// The next word of the line.
struct glint_word glint_words_next(struct glint_words *w);
// What is left of the line, without blanks around it.
struct glint_word glint_words_rest(const struct glint_words *w);

// How much of it a sentence shows: the precision of "%.*s".
static inline int glint_word_shown(struct glint_word word)
{
    return word.length < 60 ? (int)word.length : 60;
}

bool glint_word_is(struct glint_word word, const char *text); // whatever the case of its letters
bool glint_word_equal(struct glint_word a, struct glint_word b);

// How much of the word is a decimal number, 0: it does not begin with one. *out may be infinite.
size_t glint_word_number(struct glint_word word, double *out);
// The whole word, within the bounds, else false.
bool glint_word_integer(struct glint_word word, int64_t low, int64_t high, int64_t *out);

// Appends a fault that begins with the line's number; returns false.
bool glint_words_fault(const struct glint_words *w, const char *format, ...)
    __attribute__((format(printf, 2, 3)));

// Reads `count` numbers of at most `limit`; a fault where one is missing, is none or is out of
// bounds.
bool glint_words_floats(struct glint_words *w, size_t count, float limit, float *out);

#endif
