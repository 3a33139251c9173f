// sha256.h - the name of an asset: SHA-256 of its bytes in lower-case hex.
//
// Thread-safety: reentrant.
#ifndef GLINT_BASE_SHA256_H
#define GLINT_BASE_SHA256_H

#include <stddef.h>

void glint_sha256(const void *bytes, size_t size, char hex[65]);

#endif
