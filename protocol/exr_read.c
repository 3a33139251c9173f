// exr_read.c - every part of a file from anywhere into one frame.
//
// Nothing is allocated for pixels before the file's own size makes them plausible, and no pixel is
// taken from a chunk whose size is not what its channels need.
#include "protocol/exr.h"

#include "protocol/exr_stream.h"
#include "protocol/half.h"
#include "protocol/job.h"

#include <assert.h>
#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define MAX_PARTS 256
#define MAX_CHANNELS 1024
#define MAX_PLANE_BYTES (UINT64_C(4) << 30)
#define NAME_BYTES 31

// Most bytes of float planes that one byte of file can stand for: deflate gives at most 1032, the
// other methods less, and a half doubles.
#define EXPANSION 4096

struct part {
    exr_storage_t storage;
    exr_compression_t compression;
    exr_attr_box2i_t window;
    uint32_t width, height;
    uint32_t tile_width, tile_height; // of a chunk; a scanline chunk is as wide as the window
    const exr_attr_chlist_t *list;
    float **plane; // of each channel, at the frame's first pixel
};

struct reader {
    const struct glint_exr_stream *stream;
    exr_context_t context;
    struct glint_error *err;
    int parts;
    struct part part[MAX_PARTS];
    int32_t left, top, right, bottom; // union of the data windows, inclusive
    struct glint_frame *frame;
};

static glint_status damaged(const struct reader *r, exr_result_t result)
{
    return glint_exr_stream_fail(r->stream, result, GLINT_E_SYNTAX, r->err);
}

static glint_status check_channels(const struct reader *r, int index)
{
    const struct part *p = &r->part[index];
    if (p->list->num_channels < 1 || p->list->num_channels > MAX_CHANNELS)
        return glint_fail(r->err, GLINT_E_RANGE, "", "part %d has %d channels, not 1..%d", index,
                          p->list->num_channels, MAX_CHANNELS);
    for (int c = 0; c < p->list->num_channels; c++) {
        const exr_attr_chlist_entry_t *e = &p->list->entries[c];
        if (e->x_sampling != 1 || e->y_sampling != 1)
            return glint_fail(r->err, GLINT_E_RANGE, "", "the channel '%s' is subsampled",
                              e->name.str);
        if (e->name.length < 1 || e->name.length > NAME_BYTES)
            return glint_fail(r->err, GLINT_E_RANGE, "",
                              "the channel name '%s' is not of 1..%d bytes", e->name.str,
                              NAME_BYTES);
        if ((unsigned)e->pixel_type > EXR_PIXEL_FLOAT)
            return glint_fail(r->err, GLINT_E_SYNTAX, "", "the channel '%s' has the pixel type %d",
                              e->name.str, (int)e->pixel_type);
    }
    return GLINT_OK;
}

static glint_status check_window(struct reader *r, int index)
{
    struct part *p = &r->part[index];
    const exr_attr_box2i_t w = p->window;
    const int64_t width = (int64_t)w.max.x - w.min.x + 1, height = (int64_t)w.max.y - w.min.y + 1;
    if (width < 1 || width > GLINT_MAX_SIDE || height < 1 || height > GLINT_MAX_SIDE)
        return glint_fail(r->err, GLINT_E_RANGE, "",
                          "part %d is %" PRId64 "x%" PRId64 " pixels, not 1..%u on a side", index,
                          width, height, GLINT_MAX_SIDE);
    p->width = (uint32_t)width;
    p->height = (uint32_t)height;
    r->left = index && r->left < w.min.x ? r->left : w.min.x;
    r->top = index && r->top < w.min.y ? r->top : w.min.y;
    r->right = index && r->right > w.max.x ? r->right : w.max.x;
    r->bottom = index && r->bottom > w.max.y ? r->bottom : w.max.y;
    return GLINT_OK;
}

static exr_result_t get_chunk_size(struct reader *r, int index)
{
    struct part *p = &r->part[index];
    if (p->storage == EXR_STORAGE_TILED) {
        exr_tile_level_mode_t levels;
        exr_tile_round_mode_t rounding;
        return exr_get_tile_descriptor(r->context, index, &p->tile_width, &p->tile_height, &levels,
                                       &rounding);
    }
    int32_t lines = 0;
    const exr_result_t result = exr_get_scanlines_per_chunk(r->context, index, &lines);
    p->tile_width = GLINT_MAX_SIDE;
    p->tile_height = lines > 0 ? (uint32_t)lines : 0;
    return result;
}

static glint_status read_part_header(struct reader *r, int index)
{
    struct part *p = &r->part[index];
    exr_result_t result = exr_get_storage(r->context, index, &p->storage);
    if (!result && p->storage != EXR_STORAGE_SCANLINE && p->storage != EXR_STORAGE_TILED)
        return glint_fail(r->err, GLINT_E_RANGE, "", "part %d holds deep pixels", index);
    if (!result)
        result = exr_get_data_window(r->context, index, &p->window);
    if (!result)
        result = exr_get_compression(r->context, index, &p->compression);
    if (!result)
        result = exr_get_channels(r->context, index, &p->list);
    if (!result)
        result = get_chunk_size(r, index);
    if (result)
        return damaged(r, result);
    if (p->compression >= EXR_COMPRESSION_DWAA)
        return glint_fail(r->err, GLINT_E_RANGE, "",
                          "part %d is compressed with DWA, which cannot be "
                          "read",
                          index);
    if (p->tile_width < 1 || p->tile_height < 1)
        return glint_fail(r->err, GLINT_E_SYNTAX, "", "part %d has chunks of %ux%u pixels", index,
                          p->tile_width, p->tile_height);
    glint_status st = check_window(r, index);
    return st ? st : check_channels(r, index);
}

static glint_status check_bytes(const struct reader *r)
{
    const uint64_t plane =
        ((uint64_t)r->right - r->left + 1) * ((uint64_t)r->bottom - r->top + 1) * sizeof(float);
    uint64_t planes = 0;
    for (int i = 0; i < r->parts; i++)
        planes += (uint64_t)r->part[i].list->num_channels;
    if (plane > MAX_PLANE_BYTES || plane * planes > MAX_PLANE_BYTES)
        return glint_fail(r->err, GLINT_E_RANGE, "",
                          "%" PRIu64 " planes of %" PRIu64 " bytes are too much to read at once",
                          planes, plane);
    if (plane * planes > r->stream->size * EXPANSION)
        return glint_fail(r->err, GLINT_E_SYNTAX, "",
                          "%zu bytes of file cannot hold %" PRIu64 " planes of %" PRIu64 " bytes",
                          r->stream->size, planes, plane);
    return GLINT_OK;
}

static glint_status read_headers(struct reader *r)
{
    const exr_result_t result = exr_get_count(r->context, &r->parts);
    if (result)
        return damaged(r, result);
    if (r->parts < 1 || r->parts > MAX_PARTS)
        return glint_fail(r->err, GLINT_E_RANGE, "", "%d parts, not 1..%d", r->parts, MAX_PARTS);
    for (int i = 0; i < r->parts; i++) {
        glint_status st = read_part_header(r, i);
        if (st)
            return st;
    }
    if ((int64_t)r->right - r->left >= GLINT_MAX_SIDE ||
        (int64_t)r->bottom - r->top >= GLINT_MAX_SIDE)
        return glint_fail(r->err, GLINT_E_RANGE, "",
                          "the parts together are more than %u pixels "
                          "on a side",
                          GLINT_MAX_SIDE);
    return check_bytes(r);
}

static glint_status create_frame(struct reader *r)
{
    exr_attr_box2i_t d;
    const exr_result_t result = exr_get_display_window(r->context, 0, &d);
    if (result)
        return damaged(r, result);
    const int64_t width = (int64_t)d.max.x - d.min.x + 1, height = (int64_t)d.max.y - d.min.y + 1;
    const int64_t x = (int64_t)r->left - d.min.x, y = (int64_t)r->top - d.min.y;
    if (width < 1 || width > GLINT_MAX_SIDE || height < 1 || height > GLINT_MAX_SIDE ||
        x != (int32_t)x || y != (int32_t)y)
        return glint_fail(r->err, GLINT_E_RANGE, "",
                          "the display window is %" PRId64 "x%" PRId64
                          " pixels, not 1..%u on a side",
                          width, height, GLINT_MAX_SIDE);
    return glint_frame_create(&r->frame, (uint32_t)width, (uint32_t)height, (int32_t)x, (int32_t)y,
                              (uint32_t)(r->right - r->left + 1),
                              (uint32_t)(r->bottom - r->top + 1), r->err);
}

static glint_status add_channel(struct reader *r, int index, int c)
{
    static const enum glint_pixel_type type[] = {[EXR_PIXEL_UINT] = GLINT_PIXEL_UINT,
                                                 [EXR_PIXEL_HALF] = GLINT_PIXEL_HALF,
                                                 [EXR_PIXEL_FLOAT] = GLINT_PIXEL_FLOAT};
    const exr_attr_chlist_entry_t *e = &r->part[index].list->entries[c];
    const char *part = NULL;
    char name[2 * NAME_BYTES];
    snprintf(name, sizeof name, "%s", e->name.str);
    // Parts of many programs all have an "R"; the part's name tells them apart.
    if (glint_frame_find(r->frame, name) && !exr_get_name(r->context, index, &part) && part)
        snprintf(name, sizeof name, "%.*s.%s", NAME_BYTES, part, e->name.str);
    if (strlen(name) > NAME_BYTES || glint_frame_find(r->frame, name))
        return glint_fail(r->err, GLINT_E_RANGE, "",
                          "no name of at most %d bytes is left for the "
                          "channel '%s' of part %d",
                          NAME_BYTES, e->name.str, index);
    r->part[index].plane[c] = glint_frame_channel(r->frame, name, type[e->pixel_type]);
    if (!r->part[index].plane[c])
        return glint_fail(r->err, GLINT_E_NOMEM, "", "no memory for the channel '%s'", name);
    return GLINT_OK;
}

static glint_status add_channels(struct reader *r, int index)
{
    struct part *p = &r->part[index];
    p->plane = glint_arena_array(&r->frame->arena, (size_t)p->list->num_channels, sizeof *p->plane);
    if (!p->plane)
        return glint_fail(r->err, GLINT_E_NOMEM, "", "no memory for a list of channels");
    glint_status st = GLINT_OK;
    for (int c = 0; !st && c < p->list->num_channels; c++)
        st = add_channel(r, index, c);
    return st;
}

// Keeps an attribute of a kind that frames have; the first part that names it is right.
static glint_status add_attribute(struct glint_frame *f, const exr_attribute_t *a)
{
    if (a->name_length < 1 || a->name_length > NAME_BYTES || glint_frame_attribute(f, a->name))
        return GLINT_OK;
    float number[8];
    switch (a->type) {
    case EXR_ATTR_STRING:
        return a->string->str ? glint_frame_string(f, a->name, a->string->str) : GLINT_OK;
    case EXR_ATTR_INT:
        return glint_frame_int(f, a->name, a->i);
    case EXR_ATTR_FLOAT:
        return glint_frame_float(f, a->name, a->f);
    case EXR_ATTR_M44F:
        return glint_frame_matrix(f, a->name, a->m44f->m);
    case EXR_ATTR_CHROMATICITIES:
        memcpy(number, a->chromaticities, sizeof number);
        return strcmp(a->name, "chromaticities") ? GLINT_OK : glint_frame_chromaticities(f, number);
    default:
        return GLINT_OK;
    }
}

// What the file format itself asks for; a writer makes it anew.
static bool is_structure(const char *name)
{
    static const char *const names[] = {"name",
                                        "type",
                                        "version",
                                        "chunkCount",
                                        "pixelAspectRatio",
                                        "screenWindowWidth",
                                        "maxSamplesPerPixel"};
    for (size_t i = 0; i < sizeof names / sizeof *names; i++)
        if (!strcmp(name, names[i]))
            return true;
    return false;
}

static glint_status add_attributes(struct reader *r, int index)
{
    int32_t count = 0;
    exr_result_t result = exr_get_attribute_count(r->context, index, &count);
    for (int32_t i = 0; !result && i < count; i++) {
        const exr_attribute_t *a;
        result = exr_get_attribute_by_index(r->context, index, EXR_ATTR_LIST_FILE_ORDER, i, &a);
        if (!result && !is_structure(a->name) && add_attribute(r->frame, a))
            return glint_fail(r->err, GLINT_E_NOMEM, "", "no memory for the attribute '%s'",
                              a->name);
    }
    return result ? damaged(r, result) : GLINT_OK;
}

static size_t bytes_of(const exr_attr_chlist_entry_t *e)
{
    return e->pixel_type == EXR_PIXEL_HALF ? 2 : 4;
}

static void unpack_row(float *to, const uint8_t *from, size_t width, size_t pixel_bytes)
{
    if (pixel_bytes == 4) {
        memcpy(to, from, width * 4);
        return;
    }
    for (size_t x = 0; x < width; x++) {
        uint16_t half;
        memcpy(&half, from + 2 * x, sizeof half);
        to[x] = glint_float_from_half(half);
    }
}

// A chunk of `width` x `height` pixels whose first is at `x`, `y` of its part's window.
struct area {
    uint32_t x, y, width, height;
};

static void unpack(const struct reader *r, const struct part *p, const struct area *area,
                   const uint8_t *from)
{
    const size_t left = (size_t)((int64_t)p->window.min.x - r->left) + area->x;
    const size_t top = (size_t)((int64_t)p->window.min.y - r->top) + area->y;
    for (size_t line = 0; line < area->height; line++)
        for (int c = 0; c < p->list->num_channels; c++) {
            const size_t bytes = bytes_of(&p->list->entries[c]);
            unpack_row(p->plane[c] + (top + line) * r->frame->width + left, from, area->width,
                       bytes);
            from += area->width * bytes;
        }
}

static uint64_t packed_bytes(const struct part *p, const struct area *area)
{
    uint64_t pixel = 0;
    for (int c = 0; c < p->list->num_channels; c++)
        pixel += bytes_of(&p->list->entries[c]);
    return pixel * area->width * area->height;
}

static exr_result_t find_chunk(const struct reader *r, int index, const struct area *area,
                               exr_chunk_info_t *chunk)
{
    const struct part *p = &r->part[index];
    if (p->storage == EXR_STORAGE_TILED)
        return exr_read_tile_chunk_info(r->context, index, (int)(area->x / p->tile_width),
                                        (int)(area->y / p->tile_height), 0, 0, chunk);
    return exr_read_scanline_chunk_info(r->context, index, p->window.min.y + (int)area->y, chunk);
}

// The decoded chunk stays in pipe->unpacked_buffer.
static exr_result_t keep(exr_decode_pipeline_t *pipe)
{
    (void)pipe;
    return EXR_ERR_SUCCESS;
}

static exr_result_t decode(const struct reader *r, int index, const exr_chunk_info_t *chunk,
                           exr_decode_pipeline_t *pipe)
{
    exr_result_t result = pipe->context ? exr_decoding_update(r->context, index, chunk, pipe)
                                        : exr_decoding_initialize(r->context, index, chunk, pipe);
    if (!result)
        result = exr_decoding_choose_default_routines(r->context, index, pipe);
    pipe->unpack_and_convert_fn = keep;
    return result ? result : exr_decoding_run(r->context, index, pipe);
}

static glint_status read_chunk(const struct reader *r, int index, const struct area *area,
                               exr_decode_pipeline_t *pipe)
{
    const struct part *p = &r->part[index];
    exr_chunk_info_t chunk;
    exr_result_t result = find_chunk(r, index, area, &chunk);
    if (result)
        return damaged(r, result);
    const uint64_t wanted = packed_bytes(p, area);
    if (chunk.unpacked_size != wanted ||
        (p->compression == EXR_COMPRESSION_NONE && chunk.packed_size != wanted))
        return glint_fail(r->err, GLINT_E_SYNTAX, "",
                          "the chunk at %u,%u of part %d has %" PRIu64 " bytes, not %" PRIu64,
                          area->x, area->y, index, chunk.unpacked_size, wanted);
    result = decode(r, index, &chunk, pipe);
    if (result)
        return damaged(r, result);
    unpack(r, p, area, pipe->unpacked_buffer);
    return GLINT_OK;
}

static uint32_t least(uint32_t a, uint32_t b)
{
    return a < b ? a : b;
}

static glint_status read_part(struct reader *r, int index)
{
    const struct part *p = &r->part[index];
    exr_decode_pipeline_t pipe = EXR_DECODE_PIPELINE_INITIALIZER;
    glint_status st = GLINT_OK;
    for (uint32_t y = 0; !st && y < p->height; y += least(p->tile_height, GLINT_MAX_SIDE))
        for (uint32_t x = 0; !st && x < p->width; x += least(p->tile_width, GLINT_MAX_SIDE)) {
            const struct area area = {x, y, least(p->tile_width, p->width - x),
                                      least(p->tile_height, p->height - y)};
            st = read_chunk(r, index, &area, &pipe);
        }
    exr_decoding_destroy(r->context, &pipe);
    return st;
}

static glint_status read_all(struct reader *r)
{
    glint_status st = read_headers(r);
    if (!st)
        st = create_frame(r);
    for (int i = 0; !st && i < r->parts; i++) {
        st = add_attributes(r, i);
        if (!st)
            st = add_channels(r, i);
        if (!st)
            st = read_part(r, i);
    }
    return st;
}

static size_t allocation_limit(size_t file_bytes)
{
    const size_t least_needed = (size_t)16 << 20; // the tables of PIZ and DWA
    const size_t limit =
        file_bytes > MAX_PLANE_BYTES / EXPANSION ? MAX_PLANE_BYTES : file_bytes * EXPANSION;
    return limit > least_needed ? limit : least_needed;
}

static glint_status open_and_read(struct reader *r, const exr_context_initializer_t *init)
{
    const exr_result_t result = exr_start_read(&r->context, "memory", init);
    if (result)
        return damaged(r, result);
    glint_status st = read_all(r);
    exr_finish(&r->context);
    return st;
}

glint_status glint_exr_read(struct glint_frame **out, const uint8_t *bytes, size_t size,
                            struct glint_error *err)
{
    *out = NULL;
    if (size < 4 || memcmp(bytes, "\x76\x2f\x31\x01", 4))
        return glint_fail(err, GLINT_E_SYNTAX, "", "this is no OpenEXR file");
    struct reader *r = calloc(1, sizeof *r);
    if (!r)
        return glint_fail(err, GLINT_E_NOMEM, "", "no memory to read a file");
    struct glint_exr_stream stream = {
        .source = bytes, .size = size, .allocation_limit = allocation_limit(size)};
    r->stream = &stream;
    r->err = err;
    exr_context_initializer_t init;
    glint_exr_stream_open(&stream, &init);
    init.max_image_width = init.max_image_height = GLINT_MAX_SIDE;
    init.max_tile_width = init.max_tile_height = GLINT_MAX_SIDE;
    init.flags = EXR_CONTEXT_FLAG_DISABLE_CHUNK_RECONSTRUCTION;
    glint_status st = open_and_read(r, &init);
    glint_exr_stream_close(&stream);
    if (st)
        glint_frame_destroy(&r->frame);
    *out = r->frame;
    free(r);
    return st;
}
