// file.h - small files that an administrator writes: settings, tokens, certificates.
//
// Thread-safety: reentrant.
#ifndef GLINT_BASE_FILE_H
#define GLINT_BASE_FILE_H

#include "protocol/status.h"

// The whole of a regular file of at most `most` bytes, malloc'd, a zero behind it.
//   GLINT_E_IO     it cannot be read, is no file, is larger, or everybody may write it
//   GLINT_E_NOMEM
glint_status glint_file_read(char **text, size_t *length, const char *path, size_t most,
                             struct glint_error *err);

#endif
