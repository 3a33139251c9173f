// A small film in a file, for tests of such files.
#pragma once

#include "protocol/film_file.h"

#include <stddef.h>
#include <stdint.h>

#define FILM_HEAD 24 // bytes before the header

extern const char *const film_job;

struct film_bytes {
    uint8_t *at;
    size_t size;
};

// The next of a sequence of numbers below `sides` that `*seed` stands for.
uint32_t film_dice(uint64_t *seed, uint32_t sides);

// Its plan and seconds are the caller's.
struct glint_film_header film_header(struct glint_job *job);
// Words of tile `tile`: few are not zero.
void film_fill(const struct glint_film_info *info, uint32_t tile, uint32_t *memory);
// Two tiles, the second with the samples of the pass. The bytes are the caller's.
struct film_bytes film_example(void);
// The same whose tables have one word of what was lost, in pixel 3 with 77 units in it.
struct film_bytes film_example_of_version_1(void);

int film_descriptor(struct film_bytes b);
glint_status film_open(struct film_bytes b, glint_film_file **out, struct glint_error *err);
// `status` 0: any.
void film_assert_refused(struct film_bytes b, glint_status status);

uint32_t film_word(const struct film_bytes *b, size_t at);
void film_set_word(const struct film_bytes *b, size_t at, uint32_t w);
// Puts the CRCs of all records right as far as their lengths lead.
void film_seal(const struct film_bytes *b);
