// film_file.h - films in files: what checkpoints are, what GET .../film sends and what merge adds
// up.
//
// Little-endian words:
//
//   "GLNTFILM", version, packing, bytes of the header, CRC of all that stands before and the header
//   the header: JSON, film_header.h
//   for each tile with samples, in order:
//     tile, samples, bytes, CRC of these three words and the bytes
//     the bytes: the tile's planes and then its tables, packed
//   0xffffffff, number of tiles, CRC of the CRCs above, CRC of these three words
//
// CRCs are CRC-32 as in zlib. Where no end is, the file is torn.
//
// Thread-safety: a writer has one owner; a file is read by any thread.
#ifndef GLINT_PROTOCOL_FILM_FILE_H
#define GLINT_PROTOCOL_FILM_FILE_H

#include "film_header.h"

#define GLINT_FILM_VERSION 2u // 1 had one word for what was lost of a pixel
#define GLINT_FILM_MEDIA_TYPE "application/vnd.glint.film"

// How tiles are packed: a bit for each 32-bit word, then the words that are not zero. Of 286 bytes
// a pixel, with all outputs and 64 samples of an interior, 136 are left, at 0.9 ns a byte; zlib at
// its level 1 leaves 80, at 7.5 ns.
#define GLINT_FILM_PACKING_WORDS 1u

// Zero-initialise before use.
struct glint_film_writer {
    int fd;
    size_t tile_bytes;      // of planes and tables
    uint8_t *buffer, *tile; // to be written; a packed tile
    size_t used;            // of the buffer
    uint32_t tiles, chain;  // so far; CRC of CRCs
    uint32_t next;          // least number of the next tile
};

// Writes to `fd` from its offset on; header's info says how large tiles are. Each may fail with
// GLINT_E_IO or GLINT_E_NOMEM, after which only finish is allowed.
glint_status glint_film_writer_begin(struct glint_film_writer *w, int fd,
                                     const struct glint_film_header *header,
                                     struct glint_error *err);
// Tiles in ascending order; samples > 0.
glint_status glint_film_writer_tile(struct glint_film_writer *w, uint32_t tile, uint32_t samples,
                                    const void *memory, struct glint_error *err);
glint_status glint_film_writer_end(struct glint_film_writer *w, struct glint_error *err);
void glint_film_writer_finish(struct glint_film_writer *w);

typedef struct glint_film_file glint_film_file;

// Reads the whole file once, from the offset of `fd` on, and keeps a descriptor of its own: every
// length, CRC, tile and key is checked.
//   GLINT_E_SYNTAX   no film, torn, or damaged
//   GLINT_E_RANGE    its header says what cannot be
//   GLINT_E_VERSION  of a format that came later
//   GLINT_E_IO, GLINT_E_NOMEM
glint_status glint_film_file_open(glint_film_file **out, int fd, struct glint_error *err);
void glint_film_file_close(glint_film_file **file); // a pointer to NULL is fine

const struct glint_film_header *glint_film_file_header(const glint_film_file *file);
size_t glint_film_file_tile_bytes(const glint_film_file *file);
uint32_t glint_film_file_samples(const glint_film_file *file, uint32_t tile);
// Planes and then tables of a tile that has samples. GLINT_E_IO: they are not any more what they
// were.
glint_status glint_film_file_tile(const glint_film_file *file, uint32_t tile, void *memory,
                                  struct glint_error *err);

#endif
