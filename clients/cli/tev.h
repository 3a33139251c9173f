// tev.h - an image in the viewer tev, kept up to date over TCP.
//
// Nothing here waits. What the viewer has not been sent is remembered tile by tile, newest pixels
// only; a viewer that is not there, or falls behind so far that a packet is cut, is tried again later
// and then gets the whole image. Tiles whose pixels are what it has are not sent.
//
// Thread-safety: one owner.
#ifndef GLINT_CLI_TEV_H
#define GLINT_CLI_TEV_H

#include "protocol/frame.h"

#include <stdbool.h>

typedef struct glint_tev glint_tev;

#define GLINT_TEV_PORT "14158"

// address: HOST[:PORT] or [ADDRESS]:PORT. name: of the image, which is copied.
//   GLINT_E_RANGE        no such address
//   GLINT_E_UNAVAILABLE  the host is not known
glint_status glint_tev_create(glint_tev **out, const char *address, const char *name,
                              struct glint_error *err);
void glint_tev_destroy(glint_tev **tev);

// Takes a tile with planes R, G, B, A: its data window in the display window, which is the image.
// GLINT_E_RANGE: it is not of the image that came first.
glint_status glint_tev_take(glint_tev *tev, const struct glint_frame *tile,
                            struct glint_error *err);

// Sends what can be sent at once. Call it often.
void glint_tev_push(glint_tev *tev);

// The viewer is there and has not been sent everything yet.
bool glint_tev_behind(const glint_tev *tev);

#endif
