// tev_packet.h - messages to the image viewer tev.
//
// Source: CONVENTIONS e. Little-endian; a packet is its length, itself included, a type and what
// belongs to that; texts are UTF-8 and end in NUL.
//
// Thread-safety: reentrant.
#ifndef GLINT_CLI_TEV_PACKET_H
#define GLINT_CLI_TEV_PACKET_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

struct glint_tev_packet {
    uint8_t *bytes; // owned; NULL when memory ran out
    size_t size, capacity;
};

// Each begins *packet anew, keeping its memory. False: no memory.

// A new image, shown at once where `grab`.
bool glint_tev_write_create(struct glint_tev_packet *packet, bool grab, const char *name,
                            int32_t width, int32_t height, size_t channels,
                            const char *const *channel);

// Pixels of a rectangle x, y, w, h: plane[channel] has rows of `stride` floats.
bool glint_tev_write_update(struct glint_tev_packet *packet, const char *name,
                            const int32_t rect[4], size_t channels, const char *const *channel,
                            const float *const *plane, size_t stride);

bool glint_tev_write_close(struct glint_tev_packet *packet, const char *name);

void glint_tev_packet_finish(struct glint_tev_packet *packet);

#endif
