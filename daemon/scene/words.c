#include "scene/words.h"

#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <string.h>

#define MANTISSA_LIMIT 1000000000000000000u // one more digit still fits 64 bits
#define MAX_EXPONENT 100000                 // beyond it every number is 0 or infinite

void glint_words_start(struct glint_words *w, const void *text, size_t size,
                       struct glint_error *err)
{
    const char *from = text;
    *w = (struct glint_words){
        .at = from, .end = from, .next = from, .text_end = from + size, .err = err};
}

// The line break that ends a line, or the end of the text.
static const char *find_end(struct glint_words *w, bool joins)
{
    const char *stop = w->at;
    while ((stop = memchr(stop, '\n', (size_t)(w->text_end - stop)))) {
        const char *last = stop > w->at && stop[-1] == '\r' ? stop - 1 : stop;
        if (!joins || last == w->at || last[-1] != '\\')
            return stop;
        stop++;
        w->joined++;
    }
    return w->text_end;
}

bool glint_words_line(struct glint_words *w, bool joins)
{
    if (w->next == w->text_end)
        return false;
    w->line += 1 + w->joined;
    w->joined = 0;
    w->at = w->next;
    w->end = find_end(w, joins);
    w->next = w->end < w->text_end ? w->end + 1 : w->text_end;
    return true;
}

static bool blank(char c)
{
    return c == ' ' || c == '\t' || c == '\r' || c == '\n' || c == '\v' || c == '\f' || c == '\0';
}

// A backslash that joins two lines is blank too.
static bool separates(const char *at, const char *end)
{
    return blank(*at) || (*at == '\\' && at + 1 < end && (at[1] == '\n' || at[1] == '\r'));
}

struct glint_word glint_words_next(struct glint_words *w)
{
    while (w->at < w->end && separates(w->at, w->end))
        w->at++;
    const struct glint_word word = {.text = w->at};
    while (w->at < w->end && !separates(w->at, w->end))
        w->at++;
    return (struct glint_word){word.text, (size_t)(w->at - word.text)};
}

struct glint_word glint_words_rest(const struct glint_words *w)
{
    const char *from = w->at, *to = w->end;
    while (from < to && blank(*from))
        from++;
    while (to > from && blank(to[-1]))
        to--;
    return (struct glint_word){from, (size_t)(to - from)};
}

static char lower(char c)
{
    return c >= 'A' && c <= 'Z' ? (char)(c + 'a' - 'A') : c;
}

bool glint_word_is(struct glint_word word, const char *text)
{
    size_t i = 0;
    while (i < word.length && text[i] && lower(word.text[i]) == lower(text[i]))
        i++;
    return i == word.length && !text[i];
}

bool glint_word_equal(struct glint_word a, struct glint_word b)
{
    return a.length == b.length && !memcmp(a.text, b.text, a.length);
}

// ---- numbers

struct digits {
    uint64_t mantissa;
    int exponent; // of ten
    unsigned count;
};

static size_t read_digits(struct glint_word word, size_t at, bool fraction, struct digits *d)
{
    for (; at < word.length && word.text[at] >= '0' && word.text[at] <= '9'; at++) {
        d->count++;
        if (d->mantissa < MANTISSA_LIMIT) {
            d->mantissa = d->mantissa * 10 + (uint64_t)(word.text[at] - '0');
            d->exponent -= fraction;
        } else {
            d->exponent += !fraction;
        }
    }
    return at;
}

static size_t sign(struct glint_word word, size_t at, bool *negative)
{
    *negative = at < word.length && word.text[at] == '-';
    return at + (at < word.length && (word.text[at] == '-' || word.text[at] == '+'));
}

// "e-5" from `at` on; an e without digits is not part of the number.
static size_t read_exponent(struct glint_word word, size_t at, struct digits *d)
{
    bool negative;
    struct digits e = {0};
    if (at >= word.length || lower(word.text[at]) != 'e')
        return at;
    const size_t end = read_digits(word, sign(word, at + 1, &negative), false, &e);
    if (!e.count)
        return at;
    const int value = e.exponent || e.mantissa > MAX_EXPONENT ? MAX_EXPONENT : (int)e.mantissa;
    d->exponent += negative ? -value : value;
    return end;
}

size_t glint_word_number(struct glint_word word, double *out)
{
    bool negative;
    struct digits d = {0};
    size_t at = read_digits(word, sign(word, 0, &negative), false, &d);
    if (at < word.length && word.text[at] == '.')
        at = read_digits(word, at + 1, true, &d);
    if (!d.count)
        return 0;
    at = read_exponent(word, at, &d);
    // Powers up to 10^22 are exact, and so is the mantissa of what people write.
    const double power = pow(10, d.exponent < 0 ? -(double)d.exponent : d.exponent);
    const double value = !d.mantissa      ? 0
                         : d.exponent < 0 ? (double)d.mantissa / power
                                          : (double)d.mantissa * power;
    *out = negative ? -value : value;
    return at;
}

bool glint_word_integer(struct glint_word word, int64_t low, int64_t high, int64_t *out)
{
    bool negative;
    struct digits d = {0};
    const size_t at = read_digits(word, sign(word, 0, &negative), false, &d);
    if (!d.count || at != word.length || d.exponent)
        return false;
    const int64_t value = negative ? -(int64_t)d.mantissa : (int64_t)d.mantissa;
    if (value < low || value > high)
        return false;
    *out = value;
    return true;
}

// ---- faults

bool glint_words_fault(const struct glint_words *w, const char *format, ...)
{
    char text[400];
    va_list args;
    va_start(args, format);
    vsnprintf(text, sizeof text, format, args);
    va_end(args);
    glint_fail(w->err, GLINT_E_RANGE, "", "%s%sline %u: %s", w->file ? w->file : "",
               w->file ? ", " : "", w->line, text);
    return false;
}

bool glint_words_floats(struct glint_words *w, size_t count, float limit, float *out)
{
    for (size_t i = 0; i < count; i++) {
        const struct glint_word word = glint_words_next(w);
        double value = 0;
        if (!word.length)
            return glint_words_fault(w, "%zu numbers are expected, %zu are there", count, i);
        if (!glint_word_number(word, &value))
            return glint_words_fault(w, "\"%.*s\" is no number", glint_word_shown(word), word.text);
        if (!(fabs(value) <= limit))
            return glint_words_fault(w, "%.*s is outside of -%g to %g", glint_word_shown(word),
                                     word.text, limit, limit);
        out[i] = (float)value;
    }
    return true;
}
