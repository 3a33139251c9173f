// film.h - the accumulated pixels of a job and what goes with them, wherever they are: being
// rendered, in a file, or merged of several files. Frames and mattes are made here, so that the
// same sums give the same bytes.
//
// Tiles of 16x16 pixels cover the job's region row by row; gk_film.h says how one lies in memory.
//
// Thread-safety: reentrant; a source's calls say how far that is true of it.
#ifndef GLINT_PROTOCOL_FILM_H
#define GLINT_PROTOCOL_FILM_H

#include "frame.h"
#include "job.h"
#include "matte_types.h"

// Names of a key of the slot tables.
struct glint_matte_key {
    const char *name[3]; // object, material, asset ("" or NULL for none)
    uint32_t id[3];      // Cryptomatte IDs; 0 for no name
};

// What all tiles share; immutable.
struct glint_film_info {
    const struct glint_job *job;        // camera and scene as they were asked for
    bool aovs, flow, batches, coverage; // planes and tables that there are
    const char *software;               // that took the samples
    const char *revision;               // of the scene
    float to_camera[16];                // worldToCamera and worldToNDC of the frame, row-major
    float to_ndc[16];
    uint32_t mattes; // keys; 0 is no key, 1 the background
    const struct glint_matte_key *matte;
};

uint32_t glint_film_info_columns(const struct glint_film_info *info); // tiles in a row
uint32_t glint_film_info_rows(const struct glint_film_info *info);
size_t glint_film_info_plane_bytes(const struct glint_film_info *info); // of a tile
size_t glint_film_info_table_bytes(const struct glint_film_info *info); // 0: no coverage
uint32_t glint_film_info_slots(const struct glint_film_info *info);     // of a pixel
uint32_t glint_film_info_words(const struct glint_film_info *info);     // those, and what was lost
bool glint_film_info_wide(const struct glint_film_info *info);          // sums are doubles

// The pixels of a tile.
struct glint_film_pixels {
    const float *planes;
    const uint64_t *table;     // [256][glint_film_info_words()]
    uint32_t half[2];          // samples of each pixel: with even indices, and with odd ones
    const uint32_t (*each)[2]; // [256], the same where pixels differ; NULL: they do not
    // 0: none is coarse. Else 2, 4 or 8: only every step-th pixel of every step-th row has `half`,
    // the others have none, and what they hold has no meaning. In frames it stands for the square
    // of pixels to its right and below.
    uint32_t step;
};

// Whoever has the tiles. Between begin and end the pixels stay; any tile, one at a time.
struct glint_film_source {
    const struct glint_film_info *info;
    bool complete; // no sample is missing
    void *user;
    glint_status (*begin)(void *user, uint32_t tile, struct glint_film_pixels *out,
                          struct glint_error *err);
    void (*end)(void *user, uint32_t tile);
};

// Of the samples [first, first + samples): those with even indices, half 0, or odd ones, half 1.
uint32_t glint_film_half(uint32_t first, uint32_t samples, uint32_t half);

// Likewise those whose index is `part` modulo `parts`.
uint32_t glint_film_part(uint32_t first, uint32_t samples, uint32_t parts, uint32_t part);

// Words of a tile's planes before its batches, which are there with info->batches.
size_t glint_film_info_batch_words(const struct glint_film_info *info);

// Of pixel i: mean radiance of a batch that has n samples; `batches`: the planes from there on.
float glint_film_batch_mean(const float *batches, bool wide, uint32_t batch, uint32_t channel,
                            uint32_t i, uint32_t n);

// Of pixel i of a tile: mean radiance of a half that has n samples, 0 where it has none.
float glint_film_mean(const float *planes, bool wide, uint32_t half, uint32_t channel, uint32_t i,
                      uint32_t n);

// A frame over a rectangle of the display window inside the region: complete with all attributes of
// CONVENTIONS b. While tiles are coarse it starts at a corner of one. outputs: a subset of the job's. *samples: fewest among its pixels.
glint_status glint_film_frame(const struct glint_film_source *source, const uint32_t rect[4],
                              uint32_t outputs, struct glint_frame **out, uint32_t *samples,
                              struct glint_error *err);

struct glint_matte_total {
    const char *name;
    uint32_t id;
    double coverage[GLINT_MAX_MATTE_CLASSES]; // pixels, by class
};
struct glint_matte_totals {
    struct glint_matte_total *of[GLINT_MATTE_LAYERS]; // by name; malloc'd, the names in the block
    size_t count[GLINT_MATTE_LAYERS];
    double lost[2]; // pixels of coverage that found no slot: of what is seen directly, of the rest
};
// Every name of the scene in the layers, bits 1 << layer, with its coverage over the frame by each
// class. GLINT_E_RANGE without a Cryptomatte output; then, and on any failure, *out is empty.
glint_status glint_film_mattes(const struct glint_film_source *source, uint32_t layers,
                               struct glint_matte_totals *out, struct glint_error *err);
void glint_matte_totals_finish(struct glint_matte_totals *totals);

// What covers a pixel of the display window inside the region: the ranks of each type of those
// outputs, as many as a frame has.
struct glint_matte_found {
    struct glint_matte_type type;
    const char *name; // "": of nothing in the scene
    uint32_t id;
    float coverage;
};
// *out malloc'd, the names in the same block.
glint_status glint_film_pick(const struct glint_film_source *source, uint32_t x, uint32_t y,
                             uint32_t outputs, struct glint_matte_found **out, size_t *count,
                             struct glint_error *err);

// Union coverage of the named; an unknown name is GLINT_E_NOT_FOUND at /name. One plane "A".
glint_status glint_film_matte(const struct glint_film_source *source, enum glint_matte_layer layer,
                              uint32_t classes, const char *const *names, size_t count,
                              struct glint_frame **out, struct glint_error *err);

#endif
