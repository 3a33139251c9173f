// form.h - multipart/form-data to files. The body is untrusted and read in the import child.
//
// Source: RFC 7578, RFC 2046 section 5.1. Every part must be a file, that is have a filename.
//
// Thread-safety: reentrant.
#ifndef GLINT_SCENE_FORM_H
#define GLINT_SCENE_FORM_H

#include "protocol/status.h"
#include "scene/files.h"

#define GLINT_MAX_FORM_FILES 4096u

// The files' bytes stay in the body.
//   GLINT_E_SYNTAX  not such a body, or two files of one name
//   GLINT_E_NOMEM
glint_status glint_form_read(struct glint_files *out, struct glint_arena *arena,
                             const char *boundary, const uint8_t *bytes, size_t size,
                             struct glint_error *err);

#endif
