// range.h - the Range header of RFC 9110 14.2, for one range of bytes.
//
// Thread-safety: reentrant.
#ifndef GLINT_HTTP_RANGE_H
#define GLINT_HTTP_RANGE_H

#include <stddef.h>

struct glint_range {
    size_t first, length;
};

enum glint_range_verdict {
    GLINT_RANGE_WHOLE,   // not understood, or several: the header is ignored, as it may be
    GLINT_RANGE_PART,    // *out is set
    GLINT_RANGE_OUTSIDE, // 416
};

// size: of the whole.
enum glint_range_verdict glint_range_parse(const char *header, size_t size,
                                           struct glint_range *out);

#endif
