// film_write.c - films into files.
#include "protocol/film_file.h"

#include "protocol/film_pack.h"
#include "protocol/film_words.h"

#include <assert.h>
#include <errno.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#define BUFFER ((size_t)1 << 20)

static glint_status flush(struct glint_film_writer *w, struct glint_error *err)
{
    for (size_t done = 0; done < w->used;) {
        const ssize_t n = write(w->fd, w->buffer + done, w->used - done);
        if (n < 0 && errno != EINTR)
            return glint_fail(err, GLINT_E_IO, "", "a film cannot be written: %s", strerror(errno));
        done += n > 0 ? (size_t)n : 0;
    }
    w->used = 0;
    return GLINT_OK;
}

static glint_status put(struct glint_film_writer *w, const void *bytes, size_t size,
                        struct glint_error *err)
{
    glint_status st = GLINT_OK;
    for (const uint8_t *p = bytes; !st && size > 0;) {
        const size_t n = size < BUFFER - w->used ? size : BUFFER - w->used;
        memcpy(w->buffer + w->used, p, n);
        w->used += n;
        p += n;
        size -= n;
        if (w->used == BUFFER)
            st = flush(w, err);
    }
    return st;
}

// Words, then their CRC and that of the bytes after them.
static glint_status put_record(struct glint_film_writer *w, const uint32_t *word, size_t words,
                               const void *bytes, size_t size, struct glint_error *err)
{
    const uint32_t crc = glint_film_crc(word, words * 4, bytes, size);
    w->chain = glint_film_crc(&w->chain, 4, &crc, 4);
    glint_status st = put(w, word, words * 4, err);
    st = st ? st : put(w, &crc, 4, err);
    return st ? st : put(w, bytes, size, err);
}

static glint_status put_header(struct glint_film_writer *w, const struct glint_film_header *header,
                               struct glint_error *err)
{
    size_t length = 0;
    char *text = glint_film_header_write(header, &length);
    if (!text)
        return glint_fail(err, GLINT_E_NOMEM, "", "no memory for a film's header");
    uint32_t word[GLINT_FILM_HEAD_WORDS];
    memcpy(word, GLINT_FILM_MAGIC, 8);
    word[2] = GLINT_FILM_VERSION;
    word[3] = GLINT_FILM_PACKING_WORDS;
    word[4] = (uint32_t)length;
    const glint_status st =
        length <= GLINT_MAX_FILM_HEADER
            ? put_record(w, word, GLINT_FILM_HEAD_WORDS, text, length, err)
            : glint_fail(err, GLINT_E_RANGE, "", "a film's header of %zu bytes", length);
    free(text);
    return st;
}

glint_status glint_film_writer_begin(struct glint_film_writer *w, int fd,
                                     const struct glint_film_header *header,
                                     struct glint_error *err)
{
    *w = (struct glint_film_writer){.fd = fd};
    w->tile_bytes =
        glint_film_info_plane_bytes(&header->info) + glint_film_info_table_bytes(&header->info);
    w->buffer = malloc(BUFFER);
    w->tile = malloc(glint_film_pack_bound(w->tile_bytes));
    if (!w->buffer || !w->tile)
        return glint_fail(err, GLINT_E_NOMEM, "", "no memory to write a film");
    return put_header(w, header, err);
}

glint_status glint_film_writer_tile(struct glint_film_writer *w, uint32_t tile, uint32_t samples,
                                    const void *memory, struct glint_error *err)
{
    assert(samples > 0 && tile >= w->next);
    const size_t size = glint_film_pack(memory, w->tile_bytes, w->tile);
    const uint32_t word[GLINT_FILM_TILE_WORDS] = {tile, samples, (uint32_t)size};
    w->tiles++;
    w->next = tile + 1;
    return put_record(w, word, GLINT_FILM_TILE_WORDS, w->tile, size, err);
}

glint_status glint_film_writer_end(struct glint_film_writer *w, struct glint_error *err)
{
    const uint32_t word[GLINT_FILM_TILE_WORDS] = {GLINT_FILM_END, w->tiles, w->chain};
    const glint_status st = put_record(w, word, GLINT_FILM_TILE_WORDS, NULL, 0, err);
    return st ? st : flush(w, err);
}

void glint_film_writer_finish(struct glint_film_writer *w)
{
    free(w->buffer);
    free(w->tile);
    *w = (struct glint_film_writer){0};
}
