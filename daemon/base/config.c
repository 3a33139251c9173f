#include "base/config.h"

#include "base/file.h"
#include "protocol/utf8.h"

#include <ctype.h>
#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

void glint_config_finish(struct glint_config *config)
{
    for (size_t i = 0; i < config->count; i++) {
        free(config->line[i].key);
        free(config->line[i].value);
    }
    free(config->line);
    *config = (struct glint_config){0};
}

static bool add(struct glint_config *config, const char *key, const char *value, unsigned number)
{
    struct glint_config_line *more =
        realloc(config->line, (config->count + 1) * sizeof *config->line);
    if (!more)
        return false;
    config->line = more;
    const struct glint_config_line line = {strdup(key), strdup(value), number};
    if (!line.key || !line.value) {
        free(line.key);
        free(line.value);
        return false;
    }
    more[config->count++] = line;
    return true;
}

// Without the blanks around it; cut in place.
static char *trim(char *text)
{
    while (isspace((unsigned char)*text))
        text++;
    for (size_t n = strlen(text); n && isspace((unsigned char)text[n - 1]);)
        text[--n] = '\0';
    return text;
}

static bool is_key(const char *text)
{
    return *text && !text[strspn(text, "abcdefghijklmnopqrstuvwxyz0123456789_")];
}

static bool is_printable(const char *text)
{
    for (size_t left = strlen(text), n; left; left -= n, text += n)
        if (!(n = glint_utf8_sequence(text, left)) || (unsigned char)*text < ' ' || *text == 0x7f)
            return false;
    return true;
}

static const struct glint_config_line *find(const struct glint_config *config, const char *key)
{
    for (size_t i = 0; i < config->count; i++)
        if (!strcmp(config->line[i].key, key))
            return &config->line[i];
    return NULL;
}

static glint_status read_line(struct glint_config *out, const char *name, char *text,
                              unsigned number, struct glint_error *err)
{
    text = trim(text);
    if (!*text || *text == '#')
        return GLINT_OK;
    char *value = strchr(text, '=');
    if (!value)
        return glint_fail(err, GLINT_E_RANGE, "", "%s:%u: a line is key = value", name, number);
    *value++ = '\0';
    const char *key = trim(text);
    value = trim(value);
    if (!is_key(key))
        return glint_fail(err, GLINT_E_RANGE, "", "%s:%u: \"%.64s\" is no key", name, number, key);
    if (!*value || !is_printable(value))
        return glint_fail(err, GLINT_E_RANGE, "", "%s:%u: %.64s has no value that can be read",
                          name, number, key);
    const struct glint_config_line *before = find(out, key);
    if (before)
        return glint_fail(err, GLINT_E_RANGE, "", "%s:%u: %.64s stands in line %u already", name,
                          number, key, before->number);
    return add(out, key, value, number)
               ? GLINT_OK
               : glint_fail(err, GLINT_E_NOMEM, "", "no memory for %s", name);
}

glint_status glint_config_parse(struct glint_config *out, const char *name, const char *text,
                                size_t length, struct glint_error *err)
{
    *out = (struct glint_config){0};
    if (memchr(text, '\0', length))
        return glint_fail(err, GLINT_E_RANGE, "", "%s: it is no text", name);
    char *copy = strndup(text, length);
    if (!copy)
        return glint_fail(err, GLINT_E_NOMEM, "", "no memory for %s", name);
    glint_status st = GLINT_OK;
    unsigned number = 0;
    for (char *rest = copy, *line; (line = strsep(&rest, "\n"));) {
        const glint_status one = read_line(out, name, line, ++number, err);
        st = st ? st : one;
    }
    free(copy);
    return st;
}

glint_status glint_config_read(struct glint_config *out, const char *path, struct glint_error *err)
{
    *out = (struct glint_config){0};
    char *text;
    size_t length;
    glint_status st = glint_file_read(&text, &length, path, GLINT_CONFIG_BYTES, err);
    if (st)
        return st;
    st = glint_config_parse(out, path, text, length, err);
    free(text);
    return st;
}

// Reads digits up to *end; false where there are none or too many.
static bool digits(const char *text, const char **end, uint64_t *out)
{
    const size_t length = strspn(text, "0123456789");
    *end = text + length;
    errno = 0;
    *out = length ? strtoull(text, NULL, 10) : 0;
    return length && !errno;
}

bool glint_config_whole(const char *text, uint64_t low, uint64_t high, uint64_t *out)
{
    const char *end;
    uint64_t value;
    if (!digits(text, &end, &value) || *end || value < low || value > high)
        return false;
    *out = value;
    return true;
}

bool glint_config_bytes(const char *text, uint64_t low, uint64_t high, uint64_t *out)
{
    static const char unit[] = "KMGT";
    const char *end;
    uint64_t value;
    if (!digits(text, &end, &value))
        return false;
    const char *found = *end ? strchr(unit, *end) : NULL;
    const unsigned shift = found ? 10 * (unsigned)(found - unit + 1) : 0;
    if ((*end && (!found || end[1])) || value > UINT64_MAX >> shift)
        return false;
    value <<= shift;
    if (value < low || value > high)
        return false;
    *out = value;
    return true;
}

bool glint_config_seconds(const char *text, double low, double high, double *out)
{
    if (!*text || text[strspn(text, "0123456789.")])
        return false;
    char *end;
    const double value = strtod(text, &end);
    if (*end || !(value >= low && value <= high))
        return false;
    *out = value;
    return true;
}
