// data_uri.c - base64 and percent decoding of untrusted text.
#include "scene/data_uri.h"

#include <stdlib.h>
#include <string.h>
#include <strings.h>

bool glint_data_uri_is(const char *uri)
{
    return strncasecmp(uri, "data:", 5) == 0;
}

static int sextet(char c)
{
    if (c >= 'A' && c <= 'Z')
        return c - 'A';
    if (c >= 'a' && c <= 'z')
        return c - 'a' + 26;
    if (c >= '0' && c <= '9')
        return c - '0' + 52;
    return c == '+' ? 62 : c == '/' ? 63 : -1;
}

// Returns false at a character that is not base64; out has room for 3 bytes per 4 characters.
static bool base64(const char *text, size_t length, uint8_t *out, size_t *size)
{
    const size_t unpadded = length % 4 == 0 && length >= 4 ? length - 2 : length;
    while (length > unpadded && text[length - 1] == '=')
        length--;
    if (length % 4 == 1)
        return false;
    uint32_t bits = 0;
    *size = 0;
    for (size_t i = 0; i < length; i++) {
        const int v = sextet(text[i]);
        if (v < 0)
            return false;
        bits = bits << 6 | (uint32_t)v;
        if (i % 4 != 0)
            out[(*size)++] = (uint8_t)(bits >> (6 - 2 * (i % 4)));
    }
    return true;
}

static int hex(char c)
{
    if (c >= '0' && c <= '9')
        return c - '0';
    c |= 0x20;
    return c >= 'a' && c <= 'f' ? c - 'a' + 10 : -1;
}

static bool percent(const char *text, size_t length, uint8_t *out, size_t *size)
{
    *size = 0;
    for (size_t i = 0; i < length; i++) {
        if (text[i] != '%') {
            out[(*size)++] = (uint8_t)text[i];
            continue;
        }
        const int high = i + 2 < length ? hex(text[i + 1]) : -1;
        const int low = i + 2 < length ? hex(text[i + 2]) : -1;
        if (high < 0 || low < 0)
            return false;
        out[(*size)++] = (uint8_t)(high << 4 | low);
        i += 2;
    }
    return true;
}

glint_status glint_data_uri_decode(const char *uri, uint8_t **bytes, size_t *size,
                                   const char *pointer, struct glint_error *err)
{
    const char *comma = glint_data_uri_is(uri) ? strchr(uri, ',') : NULL;
    if (!comma)
        return glint_fail(err, GLINT_E_RANGE, pointer, "\"%.40s\" is not a data URI", uri);
    const bool is_base64 = comma - uri >= 12 && strncasecmp(comma - 7, ";base64", 7) == 0;
    const size_t length = strlen(comma + 1);
    uint8_t *out = malloc(length + 1);
    if (!out)
        return glint_fail(err, GLINT_E_NOMEM, pointer, "no memory for a data URI of %zu bytes",
                          length);
    if (!(is_base64 ? base64 : percent)(comma + 1, length, out, size)) {
        free(out);
        return glint_fail(err, GLINT_E_RANGE, pointer, "the data URI is not valid %s",
                          is_base64 ? "base64" : "percent-encoding");
    }
    *bytes = out;
    return GLINT_OK;
}
