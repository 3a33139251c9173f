#include "pixel.h"
#include "options.h"

#include <math.h>
#include <stdio.h>
#include <string.h>
#include <strings.h>

double glint_rgb_luminance(struct glint_rgb colour)
{
    return 0.2126 * colour.c[0] + 0.7152 * colour.c[1] + 0.0722 * colour.c[2];
}

// IEC 61966-2-1.
static double from_srgb(unsigned value)
{
    const double v = value / 255.0;
    return v <= 0.04045 ? v / 12.92 : pow((v + 0.055) / 1.055, 2.4);
}

static bool read_hex(const char *digits, struct glint_rgb *out)
{
    const size_t length = strlen(digits), each = length / 3;
    if ((length != 3 && length != 6) || strspn(digits, "0123456789abcdefABCDEF") != length)
        return false;
    for (size_t i = 0; i < 3; i++) {
        unsigned value;
        char pair[3] = {digits[i * each], digits[i * each + each - 1], '\0'};
        sscanf(pair, "%x", &value);
        out->c[i] = from_srgb(value);
    }
    return true;
}

bool glint_rgb_read(const char *text, struct glint_rgb *out)
{
    if (*text == '#')
        return read_hex(text + 1, out);
    for (int i = 0; i < 3; i++) {
        char number[64];
        const size_t length = i < 2 ? strcspn(text, ",") : strlen(text);
        if (length >= sizeof number || (i < 2 && !text[length]))
            return false;
        memcpy(number, text, length);
        number[length] = '\0';
        if (!glint_read_number(number, &out->c[i]) || out->c[i] < 0 || out->c[i] > 1e6)
            return false;
        text += length + 1;
    }
    return true;
}

static float *find_plane(const struct glint_frame *frame, const char *name)
{
    for (uint32_t i = 0; i < frame->channels; i++)
        if (strcasecmp(frame->channel[i].name, name) == 0)
            return frame->channel[i].plane;
    return NULL;
}

bool glint_rgb_planes(const struct glint_frame *frame, const char *prefix, float *plane[3])
{
    for (int i = 0; i < 3; i++) {
        char name[256];
        snprintf(name, sizeof name, "%s%s%c", prefix, *prefix ? "." : "", "RGB"[i]);
        plane[i] = find_plane(frame, name);
        if (!plane[i])
            return false;
    }
    return true;
}
