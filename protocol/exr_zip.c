// exr_zip.c - byte planes, differences, deflate.
#include "protocol/exr_zip.h"

#include <limits.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

// Source: OpenEXR File Layout, "ZIP": the bytes at even places, then those at odd places, and of
// these the differences, 128 more than they are.
static void predict(uint8_t *to, const uint8_t *from, size_t count)
{
    const size_t even = (count + 1) / 2;
    for (size_t i = 0; i < even; i++)
        to[i] = from[2 * i];
    for (size_t i = 0; i < count / 2; i++)
        to[even + i] = from[2 * i + 1];
    for (size_t i = count; i-- > 1;)
        to[i] = (uint8_t)(to[i] - to[i - 1] + 128);
}

// A buffer of the pipeline with room for `bytes`; its content is lost.
static void *reserve(void **buffer, size_t *capacity, size_t bytes)
{
    if (bytes <= *capacity)
        return *buffer;
    free(*buffer);
    *buffer = malloc(bytes);
    *capacity = *buffer ? bytes : 0;
    return *buffer;
}

static int restart(struct glint_exr_zip *zip, int level)
{
    if (zip->ready)
        return deflateReset(&zip->stream);
    const int result = deflateInit(&zip->stream, level);
    zip->ready = result == Z_OK;
    return result;
}

exr_result_t glint_exr_zip_compress(struct glint_exr_zip *zip, int level,
                                    exr_encode_pipeline_t *pipe)
{
    const size_t size = pipe->packed_bytes;
    if (size > INT_MAX)
        return EXR_ERR_INVALID_ARGUMENT;
    uint8_t *planes = reserve(&pipe->scratch_buffer_1, &pipe->scratch_alloc_size_1, size);
    uint8_t *out = reserve(&pipe->compressed_buffer, &pipe->compressed_alloc_size, size);
    if (!planes || !out || restart(zip, level) != Z_OK)
        return EXR_ERR_OUT_OF_MEMORY;
    predict(planes, pipe->packed_buffer, size);
    zip->stream.next_in = planes;
    zip->stream.avail_in = (uInt)size;
    zip->stream.next_out = out;
    zip->stream.avail_out = (uInt)size;
    const bool smaller = deflate(&zip->stream, Z_FINISH) == Z_STREAM_END && zip->stream.avail_out;
    if (!smaller)
        memcpy(out, pipe->packed_buffer, size);
    pipe->compressed_bytes = smaller ? zip->stream.total_out : size;
    return EXR_ERR_SUCCESS;
}

void glint_exr_zip_finish(struct glint_exr_zip *zip)
{
    if (zip->ready)
        deflateEnd(&zip->stream);
    *zip = (struct glint_exr_zip){0};
}
