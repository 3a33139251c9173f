#include "tests/render/picture.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static char *base64(const char *prefix, const uint8_t *bytes, size_t size)
{
    static const char digit[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    char *text = malloc(strlen(prefix) + (size + 2) / 3 * 4 + 1), *to = text;
    if (!text)
        abort();
    to += sprintf(to, "%s", prefix);
    for (size_t i = 0; i < size; i += 3) {
        const size_t n = size - i < 3 ? size - i : 3;
        uint32_t group = 0;
        for (size_t k = 0; k < 3; k++)
            group = group << 8 | (k < n ? bytes[i + k] : 0);
        for (size_t k = 0; k < 4; k++)
            *to++ = k <= n ? digit[group >> (18 - 6 * k) & 63] : '=';
    }
    *to = 0;
    return text;
}

char *picture_uri(const struct glint_png_image *image)
{
    uint8_t *bytes = NULL;
    size_t size;
    const struct glint_png_options options = {0};
    if (glint_png_color(image, &options, &bytes, &size, NULL))
        abort();
    char *uri = base64("data:image/png;base64,", bytes, size);
    free(bytes);
    return uri;
}

char *picture_checkerboard(void)
{
    float white[64];
    for (int i = 0; i < 64; i++)
        white[i] = (i % 8 + i / 8) % 2 ? 0.0f : 1.0f;
    return picture_uri(&(struct glint_png_image){8, 8, white, white, white, white});
}
