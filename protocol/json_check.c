// json_check.c - the grammar of RFC 8259, checked before anything is allocated.
//
// The library accepts more: control characters, leading zeros, broken UTF-8, and U+0000, which cuts
// a string short. Nothing past this point has to think about that.
#include "protocol/json_lists.h"

#include "protocol/utf8.h"

#include <string.h>

#define MAX_DEPTH 64u
#define MAX_NUMBER 63u // characters: the library's buffer

struct scan {
    const char *at, *end, *start;
    size_t depth, values, numbers, arrays; // of values, those that are one
    const char *key;                       // of the value that comes next, NULL: it has none
    size_t key_length;
    const struct glint_json_limits *limits;
    struct glint_json_lists *lists; // NULL: not wanted
    struct glint_error *err;
};

static bool scan_value(struct scan *s);

static bool refuse(struct scan *s, glint_status status, const char *what)
{
    size_t line = 1;
    const char *begin = s->start;
    for (const char *c = s->start; c < s->at; c++)
        if (*c == '\n') {
            line++;
            begin = c + 1;
        }
    glint_fail(s->err, status, "", "line %zu, column %zu: %s", line, (size_t)(s->at - begin) + 1,
               what);
    return false;
}

static bool syntax(struct scan *s, const char *what)
{
    return refuse(s, GLINT_E_SYNTAX, what);
}

static int peek(const struct scan *s)
{
    return s->at < s->end ? (unsigned char)*s->at : -1;
}

static bool accept(struct scan *s, char c)
{
    if (peek(s) != c)
        return false;
    s->at++;
    return true;
}

static void skip_space(struct scan *s)
{
    while (s->at < s->end && (*s->at == ' ' || *s->at == '\t' || *s->at == '\n' || *s->at == '\r'))
        s->at++;
}

static bool digits(struct scan *s)
{
    const char *first = s->at;
    while (peek(s) >= '0' && peek(s) <= '9')
        s->at++;
    return s->at > first;
}

static bool scan_number(struct scan *s)
{
    const char *first = s->at;
    accept(s, '-');
    if (!accept(s, '0') && !digits(s))
        return syntax(s, "a digit is expected");
    if (accept(s, '.') && !digits(s))
        return syntax(s, "a digit is expected after the point");
    if (accept(s, 'e') || accept(s, 'E')) {
        if (!accept(s, '+'))
            accept(s, '-');
        if (!digits(s))
            return syntax(s, "a digit is expected in the exponent");
    }
    if ((size_t)(s->at - first) > MAX_NUMBER)
        return refuse(s, GLINT_E_TOO_LARGE, "a number of more than 63 characters");
    s->numbers++;
    return true;
}

static bool hex4(struct scan *s, unsigned *unit)
{
    *unit = 0;
    for (int i = 0; i < 4; i++, s->at++) {
        const int c = peek(s);
        const int lower = c | 0x20;
        if (c >= '0' && c <= '9')
            *unit = *unit * 16 + (unsigned)(c - '0');
        else if (lower >= 'a' && lower <= 'f')
            *unit = *unit * 16 + (unsigned)(lower - 'a' + 10);
        else
            return syntax(s, "four hexadecimal digits are expected after \\u");
    }
    return true;
}

static bool scan_unicode(struct scan *s)
{
    unsigned high, low;
    if (!hex4(s, &high))
        return false;
    if (high == 0)
        return refuse(s, GLINT_E_RANGE, "U+0000 has no place in a string here");
    if (high < 0xd800 || high > 0xdfff)
        return true;
    if (high > 0xdbff || !accept(s, '\\') || !accept(s, 'u'))
        return syntax(s, "half of a surrogate pair");
    if (!hex4(s, &low))
        return false;
    return (low >= 0xdc00 && low <= 0xdfff) || syntax(s, "half of a surrogate pair");
}

static bool scan_escape(struct scan *s)
{
    s->at++;
    if (accept(s, 'u'))
        return scan_unicode(s);
    const int c = peek(s);
    if (c <= 0 || !strchr("\"\\/bfnrt", c))
        return syntax(s, "no such escape");
    s->at++;
    return true;
}

static bool scan_character(struct scan *s)
{
    if ((unsigned char)*s->at < 0x20)
        return syntax(s, "a control character in a string");
    const size_t n = glint_utf8_sequence(s->at, (size_t)(s->end - s->at));
    if (!n)
        return syntax(s, "not UTF-8");
    s->at += n;
    return true;
}

static bool scan_string(struct scan *s)
{
    if (!accept(s, '"'))
        return syntax(s, "a string is expected");
    while (peek(s) != '"') {
        if (s->at == s->end)
            return syntax(s, "the string does not end");
        if (*s->at == '\\' ? !scan_escape(s) : !scan_character(s))
            return false;
    }
    s->at++;
    return true;
}

static bool scan_key(struct scan *s)
{
    const char *first = s->at;
    if (!scan_string(s))
        return false;
    if ((size_t)(s->at - first) > GLINT_MAX_NAME)
        return refuse(s, GLINT_E_TOO_LARGE, "a key of more than 4096 bytes");
    s->key = first + 1;
    s->key_length = (size_t)(s->at - first) - 2;
    skip_space(s);
    return accept(s, ':') || syntax(s, "a colon is expected");
}

// The inside of an array or an object and its closing bracket.
static bool scan_items(struct scan *s, char close, bool keyed)
{
    s->at++;
    skip_space(s);
    if (accept(s, close))
        return true;
    do {
        skip_space(s);
        s->key = NULL;
        if ((keyed && !scan_key(s)) || !scan_value(s))
            return false;
        skip_space(s);
    } while (accept(s, ','));
    return accept(s, close) ||
           syntax(s, keyed ? "a comma or } is expected" : "a comma or ] is expected");
}

static bool scan_container(struct scan *s)
{
    const size_t limit = s->limits->depth < MAX_DEPTH ? s->limits->depth : MAX_DEPTH;
    if (s->depth == limit)
        return refuse(s, GLINT_E_TOO_LARGE, "arrays and objects are nested too deeply");
    s->depth++;
    const bool keyed = *s->at == '{';
    const bool fine = scan_items(s, keyed ? '}' : ']', keyed);
    s->depth--;
    return fine;
}

// Whether what comes next is an array under one of the keys of lists, as they are written.
static bool listed(const struct scan *s)
{
    const char *const *key = s->limits->lists;
    if (!s->lists || !key || !s->key || *s->at != '[')
        return false;
    while (*key && (strlen(*key) != s->key_length || memcmp(*key, s->key, s->key_length) != 0))
        key++;
    return *key != NULL;
}

static bool scan_array(struct scan *s)
{
    struct glint_json_list list = {.begin = (size_t)(s->at - s->start), .array = s->arrays++};
    const size_t values = s->values, numbers = s->numbers;
    const bool wanted = listed(s);
    if (!scan_container(s))
        return false;
    list.end = (size_t)(s->at - s->start);
    list.numbers = s->numbers - numbers;
    if (!wanted || !list.numbers || list.numbers != s->values - values)
        return true;
    return glint_json_lists_add(s->lists, &list) ||
           refuse(s, GLINT_E_NOMEM, "no memory for an array");
}

static bool scan_word(struct scan *s)
{
    static const char *const words[] = {"true", "false", "null"};
    for (size_t i = 0; i < sizeof words / sizeof *words; i++) {
        const size_t n = strlen(words[i]);
        if ((size_t)(s->end - s->at) >= n && memcmp(s->at, words[i], n) == 0) {
            s->at += n;
            return true;
        }
    }
    return syntax(s, s->at == s->end ? "the text ends too early" : "a value is expected");
}

static bool scan_value(struct scan *s)
{
    skip_space(s);
    if (++s->values > s->limits->values)
        return refuse(s, GLINT_E_TOO_LARGE, "more values than the limit");
    const int c = peek(s);
    if (c == '[')
        return scan_array(s);
    if (c == '{')
        return scan_container(s);
    if (c == '"')
        return scan_string(s);
    return c == '-' || (c >= '0' && c <= '9') ? scan_number(s) : scan_word(s);
}

glint_status glint_json_find_lists(const char *text, size_t length,
                                   const struct glint_json_limits *limits,
                                   struct glint_json_lists *lists, struct glint_error *err)
{
    if (length > limits->bytes)
        return glint_fail(err, GLINT_E_TOO_LARGE, "", "%zu bytes of JSON; the limit is %zu", length,
                          limits->bytes);
    struct glint_error local = {0}; // so that the code is known even without `err`
    struct scan s = {.at = text,
                     .start = text,
                     .end = text + length,
                     .limits = limits,
                     .lists = lists,
                     .err = &local};
    if (scan_value(&s)) {
        skip_space(&s);
        if (s.at < s.end)
            syntax(&s, "something follows the value");
    }
    const glint_status status = local.status;
    if (status)
        glint_fail(err, status, "", "%s", glint_error_text(&local));
    glint_error_finish(&local);
    return status;
}

glint_status glint_json_check(const char *text, size_t length,
                              const struct glint_json_limits *limits, struct glint_error *err)
{
    return glint_json_find_lists(text, length, limits, NULL, err);
}
