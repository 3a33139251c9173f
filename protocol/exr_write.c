// exr_write.c - a frame as a scanline file, in one part or one for each layer.
#include "protocol/exr.h"

#include "protocol/cryptomatte.h"
#include "protocol/exr_stream.h"
#include "protocol/exr_zip.h"
#include "protocol/half.h"

#include <assert.h>
#include <stdlib.h>
#include <string.h>

_Static_assert(__BYTE_ORDER__ == __ORDER_LITTLE_ENDIAN__,
               "pixels are stored as they lie in memory");

struct part {
    const char *name;                   // NULL in a file of one part
    const struct glint_attribute *type; // of the Cryptomatte ranks it holds, or NULL
    const struct glint_channel **channel;
    uint32_t channels;
};

struct writer {
    const struct glint_frame *frame;
    const struct glint_exr_options *options;
    const struct glint_channel **channel; // all, sorted bytewise
    struct part *part;
    uint32_t parts;
    struct glint_arena arena; // owns all of the above
    uint64_t clamped;
    struct glint_exr_zip zip;
    exr_context_t context;
};

static int by_name(const void *a, const void *b)
{
    return strcmp((*(const struct glint_channel *const *)a)->name,
                  (*(const struct glint_channel *const *)b)->name);
}

static glint_status sort_channels(struct writer *w)
{
    const uint32_t count = w->frame->channels;
    w->channel = glint_arena_array(&w->arena, count, sizeof *w->channel);
    w->part = glint_arena_array(&w->arena, count, sizeof *w->part);
    if (!w->channel || !w->part)
        return GLINT_E_NOMEM;
    for (uint32_t i = 0; i < count; i++)
        w->channel[i] = &w->frame->channel[i];
    qsort(w->channel, count, sizeof *w->channel, by_name);
    return GLINT_OK;
}

// What a channel shares with those of its part: the Cryptomatte type, "rgba", or its layer.
static const char *part_name(struct writer *w, const char *channel)
{
    const struct glint_attribute *type = glint_cryptomatte_type_of(w->frame, channel);
    if (type)
        return type->text;
    if (channel[0] && !channel[1] && strchr("RGBA", channel[0]))
        return "rgba";
    const char *dot = strrchr(channel, '.');
    return dot ? glint_arena_print(&w->arena, "%.*s", (int)(dot - channel), channel) : channel;
}

static struct part *find_or_add_part(struct writer *w, const char *name)
{
    for (uint32_t i = 0; i < w->parts; i++)
        if (!strcmp(w->part[i].name, name))
            return &w->part[i];
    struct part *p = &w->part[w->parts];
    p->name = name;
    p->channel = glint_arena_array(&w->arena, w->frame->channels, sizeof *p->channel);
    w->parts += p->channel != NULL;
    return p->channel ? p : NULL;
}

static glint_status split_parts(struct writer *w)
{
    // Readers look for layers in the first part only, so colour comes first where there is any.
    if (glint_frame_find(w->frame, "R") && !find_or_add_part(w, "rgba"))
        return GLINT_E_NOMEM;
    for (uint32_t i = 0; i < w->frame->channels; i++) {
        const char *name = part_name(w, w->channel[i]->name);
        struct part *p = name ? find_or_add_part(w, name) : NULL;
        if (!p)
            return GLINT_E_NOMEM;
        if (!p->type)
            p->type = glint_cryptomatte_type_of(w->frame, w->channel[i]->name);
        p->channel[p->channels++] = w->channel[i];
    }
    return GLINT_OK;
}

static glint_status plan_parts(struct writer *w)
{
    glint_status st = sort_channels(w);
    if (st)
        return st;
    if (w->options->layout == GLINT_EXR_MULTIPART)
        return split_parts(w);
    w->part[0] = (struct part){.channel = w->channel, .channels = w->frame->channels};
    w->parts = 1;
    return GLINT_OK;
}

static exr_result_t set_attribute(exr_context_t c, int part, const struct glint_attribute *a)
{
    exr_attr_m44f_t m;
    exr_attr_chromaticities_t p;
    switch (a->kind) {
    case GLINT_ATTR_STRING:
        return exr_attr_set_string(c, part, a->name, a->text);
    case GLINT_ATTR_INT:
        return exr_attr_set_int(c, part, a->name, a->integer);
    case GLINT_ATTR_FLOAT:
        return exr_attr_set_float(c, part, a->name, a->number[0]);
    case GLINT_ATTR_M44F:
        memcpy(&m, a->number, sizeof m);
        return exr_attr_set_m44f(c, part, a->name, &m);
    case GLINT_ATTR_CHROMATICITIES:
        memcpy(&p, a->number, sizeof p);
        return exr_attr_set_chromaticities(c, part, a->name, &p);
    }
    return EXR_ERR_INVALID_ATTR;
}

// The first part lists every Cryptomatte, another one only its own.
static bool belongs(const struct glint_attribute *a, uint32_t part,
                    const struct glint_attribute *type)
{
    if (part == 0 || strncmp(a->name, "cryptomatte/", 12))
        return true;
    return type && !strncmp(a->name, type->name, strlen(type->name) - strlen("name"));
}

static exr_compression_t compression_of(const struct writer *w, const struct part *part)
{
    static const exr_compression_t table[] = {[GLINT_EXR_NONE] = EXR_COMPRESSION_NONE,
                                              [GLINT_EXR_ZIP] = EXR_COMPRESSION_ZIP,
                                              [GLINT_EXR_ZIPS] = EXR_COMPRESSION_ZIPS};
    // Whoever reads one ID reads one line then, and sixteen lines of IDs compress no better.
    if (part->type && w->options->compression != GLINT_EXR_NONE)
        return EXR_COMPRESSION_ZIPS;
    return table[w->options->compression];
}

static enum glint_pixel_type type_of(const struct writer *w, const struct glint_channel *c)
{
    return w->options->floats && c->type == GLINT_PIXEL_HALF ? GLINT_PIXEL_FLOAT : c->type;
}

static exr_result_t declare_part(struct writer *w, uint32_t index)
{
    static const exr_pixel_type_t type[] = {[GLINT_PIXEL_HALF] = EXR_PIXEL_HALF,
                                            [GLINT_PIXEL_FLOAT] = EXR_PIXEL_FLOAT,
                                            [GLINT_PIXEL_UINT] = EXR_PIXEL_UINT};
    const struct glint_frame *f = w->frame;
    const struct part *p = &w->part[index];
    const exr_attr_box2i_t display = {
        {.arr = {0, 0}}, {.arr = {(int)f->display_width - 1, (int)f->display_height - 1}}};
    const exr_attr_box2i_t data = {{.arr = {f->x, f->y}},
                                   {.arr = {f->x + (int)f->width - 1, f->y + (int)f->height - 1}}};
    const exr_attr_v2f_t centre = {.arr = {0, 0}};
    int at;
    exr_result_t r = exr_add_part(w->context, p->name, EXR_STORAGE_SCANLINE, &at);
    if (!r)
        r = exr_initialize_required_attr(w->context, at, &display, &data, 1, &centre, 1,
                                         EXR_LINEORDER_INCREASING_Y, compression_of(w, p));
    for (uint32_t i = 0; !r && i < p->channels; i++)
        r = exr_add_channel(w->context, at, p->channel[i]->name, type[type_of(w, p->channel[i])],
                            EXR_PERCEPTUALLY_LOGARITHMIC, 1, 1);
    for (uint32_t i = 0; !r && i < f->attributes; i++)
        if (belongs(&f->attribute[i], index, p->type))
            r = set_attribute(w->context, at, &f->attribute[i]);
    return r;
}

// Packs a chunk: its lines from the top, in each the channels' pixels one after the other.
static exr_result_t pack(exr_encode_pipeline_t *pipe)
{
    struct writer *w = pipe->encoding_user_data;
    const struct part *p = &w->part[pipe->part_index];
    const size_t width = w->frame->width;
    uint8_t *to = pipe->packed_buffer;
    for (int line = 0; line < pipe->chunk.height; line++) {
        const size_t row = (size_t)(pipe->chunk.start_y - w->frame->y + line) * width;
        for (uint32_t c = 0; c < p->channels; c++) {
            const float *from = p->channel[c]->plane + row;
            if (type_of(w, p->channel[c]) != GLINT_PIXEL_HALF) {
                memcpy(to, from, width * sizeof *from);
                to += width * sizeof *from;
                continue;
            }
            for (size_t x = 0; x < width; x++, to += 2) {
                const uint16_t half = glint_half_from_float(from[x], &w->clamped);
                memcpy(to, &half, sizeof half);
            }
        }
    }
    pipe->packed_bytes = (uint64_t)(to - (uint8_t *)pipe->packed_buffer);
    return EXR_ERR_SUCCESS;
}

static exr_result_t zip(exr_encode_pipeline_t *pipe)
{
    struct writer *w = pipe->encoding_user_data;
    const int level = w->options->zip_level ? w->options->zip_level : GLINT_EXR_ZIP_LEVEL;
    return glint_exr_zip_compress(&w->zip, level, pipe);
}

// The library wants to see a source for every channel, though only pack() reads them.
static void set_sources(exr_encode_pipeline_t *pipe, const struct part *part)
{
    assert((uint32_t)pipe->channel_count == part->channels);
    for (int c = 0; c < pipe->channel_count; c++) {
        assert(!strcmp(pipe->channels[c].channel_name, part->channel[c]->name));
        pipe->channels[c].encode_from_ptr = (const uint8_t *)part->channel[c]->plane;
    }
}

static exr_result_t encode_chunk(struct writer *w, int part, int y, exr_encode_pipeline_t *pipe)
{
    exr_chunk_info_t chunk;
    exr_result_t r = exr_write_scanline_chunk_info(w->context, part, y, &chunk);
    if (r)
        return r;
    if (pipe->context)
        r = exr_encoding_update(w->context, part, &chunk, pipe);
    else
        r = exr_encoding_initialize(w->context, part, &chunk, pipe);
    if (r)
        return r;
    set_sources(pipe, &w->part[part]);
    r = exr_encoding_choose_default_routines(w->context, part, pipe);
    pipe->convert_and_pack_fn = pack;
    if (pipe->compress_fn)
        pipe->compress_fn = zip;
    pipe->encoding_user_data = w;
    return r ? r : exr_encoding_run(w->context, part, pipe);
}

static exr_result_t encode_part(struct writer *w, int part)
{
    exr_encode_pipeline_t pipe = EXR_ENCODE_PIPELINE_INITIALIZER;
    int32_t lines;
    exr_result_t r = exr_get_scanlines_per_chunk(w->context, part, &lines);
    for (int y = 0; !r && y < (int)w->frame->height; y += lines)
        r = encode_chunk(w, part, w->frame->y + y, &pipe);
    exr_encoding_destroy(w->context, &pipe);
    return r;
}

static exr_result_t encode(struct writer *w, const exr_context_initializer_t *init)
{
    exr_result_t r = exr_start_write(&w->context, "memory", EXR_WRITE_FILE_DIRECTLY, init);
    if (r)
        return r;
    for (uint32_t i = 0; !r && i < w->parts; i++)
        r = declare_part(w, i);
    if (!r)
        r = exr_write_header(w->context);
    for (uint32_t i = 0; !r && i < w->parts; i++)
        r = encode_part(w, (int)i);
    // It answers success for a file with missing chunks: an earlier error stands.
    const exr_result_t finish = exr_finish(&w->context);
    return r ? r : finish;
}

static glint_status check(const struct glint_frame *frame, bool foreign, struct glint_error *err)
{
    if (!frame->channels)
        return glint_fail(err, GLINT_E_RANGE, "", "a frame without channels is no image");
    glint_status st = foreign ? GLINT_OK : glint_cryptomatte_check(frame, err);
    for (uint32_t i = 0; i < frame->channels && !foreign; i++) {
        const struct glint_channel *c = &frame->channel[i];
        if (c->type != GLINT_PIXEL_FLOAT && glint_cryptomatte_type_of(frame, c->name))
            st = glint_fail(err, GLINT_E_RANGE, "", "the Cryptomatte channel '%s' is not float",
                            c->name);
    }
    return st;
}

glint_status glint_exr_write(const struct glint_frame *frame,
                             const struct glint_exr_options *options, uint8_t **bytes, size_t *size,
                             uint64_t *clamped, struct glint_error *err)
{
    assert(options->zip_level >= 0 && options->zip_level <= 9);
    *bytes = NULL;
    *size = 0;
    struct writer w = {.frame = frame, .options = options};
    glint_status st = check(frame, options->foreign, err);
    if (st)
        return st;
    st = plan_parts(&w);
    if (st) {
        glint_arena_finish(&w.arena);
        return glint_fail(err, st, "", "no memory for a list of %u channels", frame->channels);
    }
    struct glint_exr_stream stream = {.allocation_limit = SIZE_MAX};
    exr_context_initializer_t init;
    glint_exr_stream_open(&stream, &init);
    const exr_result_t r = encode(&w, &init);
    glint_exr_stream_close(&stream);
    glint_exr_zip_finish(&w.zip);
    glint_arena_finish(&w.arena);
    if (r) {
        free(stream.sink);
        return glint_exr_stream_fail(&stream, r, GLINT_E_INTERNAL, err);
    }
    *bytes = stream.sink;
    *size = stream.size;
    if (clamped)
        *clamped = w.clamped;
    return GLINT_OK;
}
