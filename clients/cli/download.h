// download.h - images from the daemon to files.
#ifndef GLINT_CLI_DOWNLOAD_H
#define GLINT_CLI_DOWNLOAD_H

#include "session.h"

// "exr" or "png" by the file's extension, or NULL for another.
const char *glint_download_kind(const char *file);

// GETs `path` into `file`, which appears whole or not at all. *size (may be NULL): its bytes.
glint_status glint_download_file(struct glint_session *s, const char *path, const char *file,
                                 uint64_t *size, struct glint_error *err);

// The job's frame as the file's extension says. outputs: a comma-separated list or NULL; a PNG
// shows the one named. wait: until the job is done.
struct glint_frame_request {
    const char *job, *outputs, *exposure;
    bool wait;
};
glint_status glint_download_frame(struct glint_session *s, const struct glint_frame_request *frame,
                                  const char *file, uint64_t *size, struct glint_error *err);

// Tells of the file: a line, or {"file", "bytes"}.
void glint_download_report(const struct glint_session *s, const char *file, uint64_t size);

#endif
