#include "http/range.h"

#include <ctype.h>
#include <errno.h>
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

// Digits up to the next character that is none. False: no digits, or too many.
static bool number(const char **p, unsigned long long *out)
{
    if (!isdigit((unsigned char)**p))
        return false;
    errno = 0;
    char *end;
    *out = strtoull(*p, &end, 10);
    *p = end;
    return !errno;
}

enum glint_range_verdict glint_range_parse(const char *header, size_t size, struct glint_range *out)
{
    unsigned long long first, last;
    if (strncasecmp(header, "bytes=", 6))
        return GLINT_RANGE_WHOLE;
    const char *p = header + 6;
    const bool from_end = *p == '-';
    p += from_end;
    if (!number(&p, &first))
        return GLINT_RANGE_WHOLE;
    if (from_end) {
        if (*p)
            return GLINT_RANGE_WHOLE;
        if (!first || !size)
            return GLINT_RANGE_OUTSIDE;
        out->length = first < size ? (size_t)first : size;
        out->first = size - out->length;
        return GLINT_RANGE_PART;
    }
    if (*p++ != '-')
        return GLINT_RANGE_WHOLE;
    last = size - 1;
    if (*p && (!number(&p, &last) || *p || last < first))
        return GLINT_RANGE_WHOLE;
    if (first >= size)
        return GLINT_RANGE_OUTSIDE;
    out->first = (size_t)first;
    out->length = (last < size ? (size_t)last : size - 1) - out->first + 1;
    return GLINT_RANGE_PART;
}
