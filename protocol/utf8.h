// utf8.h - well-formed UTF-8 (RFC 3629), one sequence at a time.
//
// Thread-safety: reentrant.
#ifndef GLINT_PROTOCOL_UTF8_H
#define GLINT_PROTOCOL_UTF8_H

#include <stddef.h>

// Bytes of the sequence that starts at `text`, 1..4, or 0 when none of at most `length` bytes does:
// overlong forms, surrogates, code points past U+10FFFF and cut sequences are not UTF-8.
size_t glint_utf8_sequence(const char *text, size_t length);

// Replaces each byte that belongs to no sequence with '?' and control characters with ' '.
void glint_utf8_clean(char *text);

#endif
