// sha256.c - libcrypto's digest, which uses the processor's instructions where it has them.
#include "base/sha256.h"

#include <openssl/sha.h>

void glint_sha256(const void *bytes, size_t size, char hex[65])
{
    static const char digit[] = "0123456789abcdef";
    unsigned char digest[SHA256_DIGEST_LENGTH];
    SHA256(bytes, size, digest);
    for (size_t i = 0; i < sizeof digest; i++) {
        hex[2 * i] = digit[digest[i] >> 4];
        hex[2 * i + 1] = digit[digest[i] & 15];
    }
    hex[64] = '\0';
}
