// multipart.h - the stream of tiles: multipart/mixed (RFC 2046) whose parts state their length.
//
// A stream is head, body, head, body, ..., end. Each head opens with the line break that ends what
// was before it, so a stream may stop after any body.
//
// Thread-safety: a reader has one owner; the rest is reentrant.
#ifndef GLINT_PROTOCOL_MULTIPART_H
#define GLINT_PROTOCOL_MULTIPART_H

#include "status.h"

#include <stdbool.h>
#include <stdint.h>

#define GLINT_MULTIPART_BOUNDARY "glint-5f0c1c9d2a7e4b38"
#define GLINT_MULTIPART_TYPE "multipart/mixed; boundary=" GLINT_MULTIPART_BOUNDARY
#define GLINT_MULTIPART_END "\r\n--" GLINT_MULTIPART_BOUNDARY "--\r\n"
#define GLINT_MULTIPART_HEAD_BYTES 512 // room that every head fits into

// Headers of one part. Of a part that was read, what it did not say is zero or "".
struct glint_multipart_head {
    char type[64];   // Content-Type
    uint64_t length; // Content-Length
    bool has_tile;
    uint32_t tile[4];  // Glint-Tile: x y w h, pixels of the display window
    uint64_t samples;  // Glint-Samples: fewest samples of its pixels
    uint64_t sequence; // Glint-Seq: grows along the stream
    char revision[80]; // Glint-Revision: the scene's, visible ASCII
};

// Writes the delimiter and headers that go before a body of head->length bytes. Returns the bytes
// written, without the terminator.
size_t glint_multipart_write_head(char out[GLINT_MULTIPART_HEAD_BYTES],
                                  const struct glint_multipart_head *head);

typedef struct glint_multipart_reader glint_multipart_reader;

// Takes one part. `body` is valid during the call. Any status but GLINT_OK ends the reading and is
// what glint_multipart_feed() returns.
typedef glint_status glint_multipart_part(void *user, const struct glint_multipart_head *head,
                                          const uint8_t *body);

struct glint_multipart_params {
    const char *content_type; // of the whole stream; names the boundary
    uint64_t max_part_bytes;  // longer ones are refused before they are stored
    glint_multipart_part *part;
    void *user;
};

// `params` is only read during the call.
//   GLINT_E_MEDIA_TYPE  not multipart/..., or no boundary of 1..70 of the characters of RFC 2046
glint_status glint_multipart_reader_create(glint_multipart_reader **out,
                                           const struct glint_multipart_params *params,
                                           struct glint_error *err);
void glint_multipart_reader_destroy(glint_multipart_reader **reader);

// Takes the next bytes of the stream, cut anywhere. After a failure every call fails alike.
//   GLINT_E_SYNTAX     not such a stream: no Content-Length, a header twice, a body that is not
//                      followed by the boundary, ...
//   GLINT_E_TOO_LARGE  a part is over the limit
glint_status glint_multipart_feed(glint_multipart_reader *reader, const void *bytes, size_t size,
                                  struct glint_error *err);

// Whether the stream was closed by its last delimiter. Bytes after that are ignored.
bool glint_multipart_ended(const glint_multipart_reader *reader);

#endif
