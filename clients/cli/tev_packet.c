#include "tev_packet.h"

#include <stdlib.h>
#include <string.h>

enum { CLOSE = 2, CREATE = 4, UPDATE = 6 };

static bool add(struct glint_tev_packet *p, const void *bytes, size_t size)
{
    if (p->size + size > p->capacity) {
        const size_t capacity = 2 * (p->size + size) + 64;
        uint8_t *grown = realloc(p->bytes, capacity);
        if (!grown)
            return false;
        p->bytes = grown;
        p->capacity = capacity;
    }
    memcpy(p->bytes + p->size, bytes, size);
    p->size += size;
    return true;
}

static bool add_number(struct glint_tev_packet *p, uint64_t value, size_t bytes)
{
    uint8_t little[8];
    for (size_t i = 0; i < bytes; i++)
        little[i] = (uint8_t)(value >> 8 * i);
    return add(p, little, bytes);
}

static bool add_text(struct glint_tev_packet *p, const char *text)
{
    return add(p, text, strlen(text) + 1);
}

static bool add_channels(struct glint_tev_packet *p, size_t channels, const char *const *channel)
{
    bool ok = add_number(p, channels, 4);
    for (size_t c = 0; ok && c < channels; c++)
        ok = add_text(p, channel[c]);
    return ok;
}

static bool begin(struct glint_tev_packet *p, int type)
{
    p->size = 0;
    return add_number(p, 0, 4) && add_number(p, (uint64_t)type, 1);
}

static bool end(struct glint_tev_packet *p)
{
    for (size_t i = 0; i < 4; i++)
        p->bytes[i] = (uint8_t)(p->size >> 8 * i);
    return true;
}

bool glint_tev_write_create(struct glint_tev_packet *packet, bool grab, const char *name,
                            int32_t width, int32_t height, size_t channels,
                            const char *const *channel)
{
    return begin(packet, CREATE) && add_number(packet, grab, 1) && add_text(packet, name) &&
           add_number(packet, (uint32_t)width, 4) && add_number(packet, (uint32_t)height, 4) &&
           add_channels(packet, channels, channel) && end(packet);
}

static bool add_float(struct glint_tev_packet *p, float value)
{
    uint32_t bits;
    memcpy(&bits, &value, sizeof bits);
    return add_number(p, bits, 4);
}

// The planes one after the other, without gaps.
static bool add_planes(struct glint_tev_packet *p, const int32_t rect[4], size_t channels,
                       const float *const *plane, size_t stride)
{
    const size_t w = (size_t)rect[2], h = (size_t)rect[3];
    bool ok = true;
    for (size_t c = 0; c < channels; c++)
        ok = ok && add_number(p, c * w * h, 8); // where each begins, in floats
    for (size_t c = 0; c < channels; c++)
        ok = ok && add_number(p, 1, 8); // from one of its pixels to the next
    for (size_t c = 0; c < channels; c++)
        for (size_t y = 0; y < h; y++)
            for (size_t x = 0; x < w; x++)
                ok = ok && add_float(p, plane[c][y * stride + x]);
    return ok;
}

bool glint_tev_write_update(struct glint_tev_packet *packet, const char *name,
                            const int32_t rect[4], size_t channels, const char *const *channel,
                            const float *const *plane, size_t stride)
{
    bool ok = begin(packet, UPDATE) && add_number(packet, 0, 1) && add_text(packet, name) &&
              add_channels(packet, channels, channel);
    for (int i = 0; i < 4; i++)
        ok = ok && add_number(packet, (uint32_t)rect[i], 4);
    return ok && add_planes(packet, rect, channels, plane, stride) && end(packet);
}

bool glint_tev_write_close(struct glint_tev_packet *packet, const char *name)
{
    return begin(packet, CLOSE) && add_text(packet, name) && end(packet);
}

void glint_tev_packet_finish(struct glint_tev_packet *packet)
{
    free(packet->bytes);
    *packet = (struct glint_tev_packet){0};
}
