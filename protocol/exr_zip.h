// exr_zip.h - the ZIP and ZIPS methods of OpenEXR with one deflate state for all chunks of a file.
//
// The library makes a state of 256 KiB for every chunk, which for a tile costs as much as
// compressing it.
//
// Thread-safety: one owner at a time.
#ifndef GLINT_PROTOCOL_EXR_ZIP_H
#define GLINT_PROTOCOL_EXR_ZIP_H

#include <openexr.h>
#include <stdbool.h>
#include <zlib.h>

#define GLINT_EXR_ZIP_LEVEL 4 // where none is asked for

// Zero-initialise before use.
struct glint_exr_zip {
    z_stream stream;
    bool ready; // there is a state, to be reset for the next chunk
};

// Compresses the packed bytes of a chunk into a buffer that the pipeline owns; as they are, if they
// do not get smaller. level: 1..9, the same for every chunk.
exr_result_t glint_exr_zip_compress(struct glint_exr_zip *zip, int level,
                                    exr_encode_pipeline_t *pipe);

void glint_exr_zip_finish(struct glint_exr_zip *zip);

#endif
