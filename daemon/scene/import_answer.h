// import_answer.h - what an import child says, as bytes of a memfd.
//
// One header, three tables (faults, warnings, assets), then the strings and blobs that they and the
// header point at by offset. The child writes it in one go; the parent, which trusts none of it,
// bounds every offset, length and terminator before it is used.
//
// Thread-safety: reentrant.
#ifndef GLINT_SCENE_IMPORT_ANSWER_H
#define GLINT_SCENE_IMPORT_ANSWER_H

#include "scene/import.h"

// What the child has to say. Borrows everything.
struct glint_answer {
    const struct glint_error *error; // error->status is the outcome
    const char *text;                // native JSON; NULL unless GLINT_OK
    size_t length;
    const struct glint_asset *asset;
    size_t assets;
    char *const *warning;
    size_t warnings;
    double seconds;
};

// GLINT_E_IO: the memfd took no more (the file size limit); what it holds then is no answer.
glint_status glint_answer_write(int fd, const struct glint_answer *answer);

// Maps the memfd and reads the answer. On GLINT_OK *out is the import, which owns the mapping.
// The child's own faults are appended to *err and its status returned; an answer that breaks the
// layout or names an asset wrongly is GLINT_E_RANGE, because the file brought it about. `fd` may be
// closed afterwards. alone: by the calling thread; else all cores check the names.
glint_status glint_answer_read(int fd, bool alone, struct glint_import **out,
                               struct glint_error *err);

#endif
