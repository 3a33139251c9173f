// utf8.c - table 3-7 of the Unicode Standard.
#include "protocol/utf8.h"

#include <string.h>

static int within(unsigned char byte, unsigned char low, unsigned char high)
{
    return byte >= low && byte <= high;
}

static size_t sequence_bytes(unsigned char lead)
{
    if (lead < 0x80)
        return 1;
    if (within(lead, 0xc2, 0xdf))
        return 2;
    if (within(lead, 0xe0, 0xef))
        return 3;
    return within(lead, 0xf0, 0xf4) ? 4 : 0;
}

// The second byte decides what is overlong, a surrogate or too large.
static int second_fits(unsigned char lead, unsigned char second)
{
    const unsigned char low = lead == 0xe0 ? 0xa0 : lead == 0xf0 ? 0x90 : 0x80;
    const unsigned char high = lead == 0xed ? 0x9f : lead == 0xf4 ? 0x8f : 0xbf;
    return within(second, low, high);
}

size_t glint_utf8_sequence(const char *text, size_t length)
{
    const unsigned char *b = (const unsigned char *)text;
    const size_t n = length ? sequence_bytes(b[0]) : 0;
    if (n < 2)
        return n;
    if (n > length || !second_fits(b[0], b[1]))
        return 0;
    for (size_t i = 2; i < n; i++)
        if (!within(b[i], 0x80, 0xbf))
            return 0;
    return n;
}

void glint_utf8_clean(char *text)
{
    const char *end = text + strlen(text);
    while (text < end) {
        const size_t n = glint_utf8_sequence(text, (size_t)(end - text));
        if (n == 0)
            *text = '?';
        else if (n == 1 && ((unsigned char)*text < 0x20 || *text == 0x7f))
            *text = ' ';
        text += n ? n : 1;
    }
}
