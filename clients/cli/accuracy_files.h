// accuracy_files.h - the folder of a report: texts, pictures and images that appear whole.
//
// Thread-safety: one owner.
#ifndef GLINT_CLI_ACCURACY_FILES_H
#define GLINT_CLI_ACCURACY_FILES_H

#include "protocol/frame.h"
#include "protocol/text.h"

// Makes the folder and those in it.
glint_status glint_accuracy_folders(const char *folder, struct glint_error *err);

// folder/name; malloc'd, NULL without memory.
char *glint_accuracy_path(const char *folder, const char *name);

// Takes the text.
glint_status glint_accuracy_save(const char *folder, const char *name, struct glint_text *text,
                                 struct glint_error *err);
glint_status glint_accuracy_save_bytes(const char *folder, const char *name, const void *bytes,
                                       size_t size, struct glint_error *err);

// *text is malloc'd, NULL where there is no such file.
glint_status glint_accuracy_load(char **text, const char *folder, const char *name,
                                 struct glint_error *err);

// *frame is NULL where there is no such file.
glint_status glint_accuracy_load_frame(struct glint_frame **frame, const char *folder,
                                       const char *name, struct glint_error *err);
glint_status glint_accuracy_save_frame(const struct glint_frame *frame, const char *folder,
                                       const char *name, struct glint_error *err);

// `text` as a part of a file's name: all else than letters, digits, '.' and '-' is '-'.
void glint_accuracy_file_name(const char *text, char *out, size_t size);

#endif
