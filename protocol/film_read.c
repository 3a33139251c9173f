// film_read.c - films from files, which others may have written, cut off or damaged.
#include "protocol/film_file.h"

#include "kernels/gk_film.h"
#include "kernels/gk_matte.h"
#include "protocol/film_pack.h"
#include "protocol/film_words.h"

#include <errno.h>
#include <fcntl.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

struct tile {
    off_t offset; // of its record
    uint32_t samples, bytes;
};

struct glint_film_file {
    int fd;
    uint32_t tiles; // of the region
    uint32_t version;
    struct tile *tile;
    size_t tile_bytes, packed_bytes; // in memory; before packing
    struct glint_film_header *header;
};

// One pass over the file.
struct scan {
    glint_film_file *file;
    off_t at, end;
    uint32_t chain;
    uint8_t *packed; // room for any tile
    void *memory;    // of a tile
    struct glint_error *err;
};

static glint_status torn(const struct scan *s, const char *what)
{
    return glint_fail(s->err, GLINT_E_SYNTAX, "", "the film is torn at byte %lld: %s",
                      (long long)s->at, what);
}

static glint_status cannot_read(struct glint_error *err)
{
    return glint_fail(err, GLINT_E_IO, "", "a film cannot be read: %s", strerror(errno));
}

// Exactly `size` bytes. GLINT_E_SYNTAX: the file ends before, which has no fault yet.
static glint_status read_at(int fd, off_t offset, void *out, size_t size, struct glint_error *err)
{
    for (size_t done = 0; done < size;) {
        const ssize_t n = pread(fd, (uint8_t *)out + done, size - done, offset + (off_t)done);
        if (n < 0 && errno != EINTR)
            return cannot_read(err);
        if (n == 0)
            return GLINT_E_SYNTAX;
        done += n > 0 ? (size_t)n : 0;
    }
    return GLINT_OK;
}

static glint_status next(struct scan *s, void *out, size_t size)
{
    if ((off_t)size > s->end - s->at)
        return torn(s, "it ends here");
    const glint_status st = read_at(s->file->fd, s->at, out, size, s->err);
    if (st == GLINT_E_SYNTAX)
        return torn(s, "it ends here");
    s->at += st ? 0 : (off_t)size;
    return st;
}

// A record's words and CRC.
static glint_status next_words(struct scan *s, uint32_t *word, size_t words, uint32_t *crc)
{
    const glint_status st = next(s, word, words * 4);
    return st ? st : next(s, crc, 4);
}

static void chain(struct scan *s, uint32_t crc)
{
    s->chain = glint_film_crc(&s->chain, 4, &crc, 4);
}

// ---- the header

static glint_status check_head(struct scan *s, const uint32_t *word)
{
    if (memcmp(word, GLINT_FILM_MAGIC, 8))
        return glint_fail(s->err, GLINT_E_SYNTAX, "",
                          "it is no film: it does not begin with \"%s\"", GLINT_FILM_MAGIC);
    if (word[2] > GLINT_FILM_VERSION)
        return glint_fail(s->err, GLINT_E_VERSION, "",
                          "the film is of version %u; this program reads versions up to %u",
                          word[2], GLINT_FILM_VERSION);
    if (word[2] < 1 || word[3] != GLINT_FILM_PACKING_WORDS)
        return torn(s, "version or packing does not exist");
    if (word[4] > GLINT_MAX_FILM_HEADER || (off_t)word[4] > s->end - s->at)
        return torn(s, "its header does not end");
    return GLINT_OK;
}

static glint_status read_header(struct scan *s)
{
    uint32_t word[GLINT_FILM_HEAD_WORDS], crc;
    glint_status st = next_words(s, word, GLINT_FILM_HEAD_WORDS, &crc);
    if (!st)
        st = check_head(s, word);
    if (st)
        return st;
    char *text = malloc(word[4] + (size_t)1);
    if (!text)
        return glint_fail(s->err, GLINT_E_NOMEM, "", "no memory for a film's header");
    s->file->version = word[2];
    st = next(s, text, word[4]);
    if (!st && glint_film_crc(word, sizeof word, text, word[4]) != crc)
        st = torn(s, "the header before it is damaged");
    if (!st)
        st = glint_film_header_parse(&s->file->header, text, word[4], s->err);
    chain(s, crc);
    free(text);
    return st;
}

// ---- tiles

static bool samples_agree(const glint_film_file *f, uint32_t samples)
{
    const struct glint_film_moment *m = &f->header->moment;
    const uint32_t before = m->sample - f->header->info.job->sample_range[0];
    if (m->shares) // whoever goes on from it knows more
        return samples % GLINT_PILOT_SAMPLES == 0;
    return samples == before || (m->samples && samples == before + m->samples);
}

// Tables of version 1 get the other word, from the last to the first: what was lost is of bounces
// where there are any.
static void widen(const glint_film_file *f, void *memory)
{
    const struct glint_film_info *info = &f->header->info;
    const uint32_t slots = glint_film_info_slots(info), words = slots + GK_MATTE_LOST_WORDS;
    const bool bounces = glint_matte_classes(info->job) > 0;
    uint64_t *table = (uint64_t *)(void *)((uint8_t *)memory + glint_film_info_plane_bytes(info));
    for (size_t i = GK_TILE_PIXELS; i-- > 0;) {
        const uint64_t lost = table[i * (slots + 1) + slots];
        memmove(table + i * words, table + i * (slots + 1), slots * sizeof *table);
        table[i * words + slots + GK_MATTE_LOST_PRIMARY] = bounces ? 0 : lost;
        table[i * words + slots + GK_MATTE_LOST_BOUNCED] = bounces ? lost : 0;
    }
}

static bool unpack(const glint_film_file *f, const uint8_t *packed, size_t size, void *memory)
{
    if (!glint_film_unpack(packed, size, memory, f->packed_bytes))
        return false;
    if (f->packed_bytes < f->tile_bytes)
        widen(f, memory);
    return true;
}

// Keys of slots and of places are indices and classes.
static bool keys_exist(const glint_film_file *f, const void *memory)
{
    const struct glint_film_info *info = &f->header->info;
    const uint64_t *table = (const uint64_t *)(const void *)((const uint8_t *)memory +
                                                             glint_film_info_plane_bytes(info));
    const uint32_t slots = glint_film_info_slots(info), words = glint_film_info_words(info);
    const uint32_t lost = slots + GK_MATTE_LOST_WORDS, classes = glint_matte_classes(info->job);
    for (size_t i = 0; info->coverage && i < (size_t)GK_TILE_PIXELS * words; i++) {
        const uint32_t key = gk_matte_key(table[i]), word = (uint32_t)(i % words);
        const bool counts = word >= slots && word < lost;
        if (!counts && ((key & GK_MATTE_BASE_KEY) >= info->mattes || gk_matte_class(key) > classes))
            return false;
    }
    return true;
}

static glint_status check_tile(struct scan *s, const uint32_t *word, uint32_t crc)
{
    if (glint_film_crc(word, GLINT_FILM_TILE_WORDS * 4, s->packed, word[2]) != crc)
        return torn(s, "the tile before it is damaged");
    if (!samples_agree(s->file, word[1]))
        return torn(s, "the tile before it has samples that its pass has not");
    if (!unpack(s->file, s->packed, word[2], s->memory))
        return torn(s, "the tile before it does not unpack");
    if (!keys_exist(s->file, s->memory))
        return torn(s, "the tile before it has a key without names");
    return GLINT_OK;
}

static glint_status read_tile(struct scan *s, const uint32_t *word, uint32_t crc)
{
    struct tile *t = &s->file->tile[word[0]];
    if (!word[1] || word[2] > glint_film_pack_bound(s->file->tile_bytes))
        return torn(s, "a tile has no samples, or too many bytes");
    *t = (struct tile){s->at - (off_t)(GLINT_FILM_TILE_WORDS + 1) * 4, word[1], word[2]};
    glint_status st = next(s, s->packed, word[2]);
    if (!st)
        st = check_tile(s, word, crc);
    chain(s, crc);
    return st;
}

static glint_status check_end(struct scan *s, const uint32_t *word, uint32_t crc, uint32_t count)
{
    if (glint_film_crc(word, GLINT_FILM_TILE_WORDS * 4, NULL, 0) != crc)
        return torn(s, "the end before it is damaged");
    if (word[1] != count || word[2] != s->chain)
        return torn(s, "tiles before it are missing or of another film");
    return s->at == s->end ? GLINT_OK : torn(s, "something follows its end");
}

static glint_status read_tiles(struct scan *s)
{
    uint32_t word[GLINT_FILM_TILE_WORDS], crc, count = 0;
    glint_status st = GLINT_OK;
    for (uint32_t least = 0; !st; least = word[0] + 1) {
        st = next_words(s, word, GLINT_FILM_TILE_WORDS, &crc);
        if (!st && word[0] == GLINT_FILM_END)
            return check_end(s, word, crc, count);
        if (!st && (word[0] < least || word[0] >= s->file->tiles))
            return torn(s, "there is no such tile after the one before");
        if (!st)
            st = read_tile(s, word, crc);
        count++;
    }
    return st;
}

// A film whose moment says that all tiles have samples has all tiles.
static glint_status check_missing(struct scan *s)
{
    const struct glint_film_header *h = s->file->header;
    const uint32_t first = h->moment.shares ? GLINT_PILOT_SAMPLES : 0;
    if (h->moment.sample == h->info.job->sample_range[0] + first)
        return GLINT_OK;
    for (uint32_t t = 0; t < s->file->tiles; t++)
        if (!s->file->tile[t].samples)
            return torn(s, "a tile before it is missing");
    return GLINT_OK;
}

static glint_status make_room(struct scan *s)
{
    glint_film_file *f = s->file;
    const struct glint_film_info *info = &f->header->info;
    f->tiles = glint_film_info_columns(info) * glint_film_info_rows(info);
    f->tile_bytes = glint_film_info_plane_bytes(info) + glint_film_info_table_bytes(info);
    f->packed_bytes = f->tile_bytes;
    if (f->version == 1 && info->coverage)
        f->packed_bytes -= (size_t)GK_TILE_PIXELS * 8;
    f->tile = calloc(f->tiles, sizeof *f->tile);
    s->packed = malloc(glint_film_pack_bound(f->tile_bytes));
    s->memory = malloc(f->tile_bytes);
    return f->tile && s->packed && s->memory
               ? GLINT_OK
               : glint_fail(s->err, GLINT_E_NOMEM, "", "no memory for %u tiles", f->tiles);
}

static glint_status read_all(struct scan *s)
{
    struct stat about;
    s->at = lseek(s->file->fd, 0, SEEK_CUR);
    if (s->at < 0 || fstat(s->file->fd, &about))
        return cannot_read(s->err);
    s->end = about.st_size;
    glint_status st = read_header(s);
    st = st ? st : make_room(s);
    st = st ? st : read_tiles(s);
    return st ? st : check_missing(s);
}

glint_status glint_film_file_open(glint_film_file **out, int fd, struct glint_error *err)
{
    *out = NULL;
    glint_film_file *f = calloc(1, sizeof *f);
    if (!f)
        return glint_fail(err, GLINT_E_NOMEM, "", "no memory for a film");
    struct scan s = {.file = f, .err = err};
    f->fd = fcntl(fd, F_DUPFD_CLOEXEC, 3);
    const glint_status st = f->fd < 0 ? cannot_read(err) : read_all(&s);
    free(s.packed);
    free(s.memory);
    if (st)
        glint_film_file_close(&f);
    *out = f;
    return st;
}

void glint_film_file_close(glint_film_file **file)
{
    glint_film_file *f = *file;
    *file = NULL;
    if (!f)
        return;
    if (f->fd >= 0)
        close(f->fd);
    glint_film_header_destroy(&f->header);
    free(f->tile);
    free(f);
}

const struct glint_film_header *glint_film_file_header(const glint_film_file *f)
{
    return f->header;
}

size_t glint_film_file_tile_bytes(const glint_film_file *f)
{
    return f->tile_bytes;
}

uint32_t glint_film_file_samples(const glint_film_file *f, uint32_t tile)
{
    return f->tile[tile].samples;
}

glint_status glint_film_file_tile(const glint_film_file *f, uint32_t tile, void *memory,
                                  struct glint_error *err)
{
    const struct tile *t = &f->tile[tile];
    const size_t head = (GLINT_FILM_TILE_WORDS + 1) * 4, size = head + t->bytes;
    uint8_t *record = malloc(size);
    if (!record)
        return glint_fail(err, GLINT_E_NOMEM, "", "no memory for a tile");
    uint32_t crc;
    glint_status st = read_at(f->fd, t->offset, record, size, err);
    memcpy(&crc, record + head - 4, 4);
    if (!st && (glint_film_crc(record, head - 4, record + head, t->bytes) != crc ||
                !unpack(f, record + head, t->bytes, memory)))
        st = GLINT_E_SYNTAX;
    free(record);
    return st == GLINT_E_SYNTAX
               ? glint_fail(err, GLINT_E_IO, "", "tile %u of a film is not what it was", tile)
               : st;
}
