// image_file.h - an EXR file with Cryptomatte layers, of this renderer or another: what its mattes
// are called and what they cover.
//
// Thread-safety: one owner.
#ifndef GLINT_CLI_IMAGE_FILE_H
#define GLINT_CLI_IMAGE_FILE_H

#include "protocol/frame.h"

#include <cjson/cJSON.h>

struct glint_image_file {
    struct glint_frame *frame;
    char *directory; // where manifests that are files of their own stand, or NULL: nowhere
};

// GLINT_E_IO, or what is wrong with the file.
glint_status glint_image_file_read(struct glint_image_file *out, const char *path,
                                   struct glint_error *err);
glint_status glint_image_file_parse(struct glint_image_file *out, const void *bytes, size_t size,
                                    struct glint_error *err);
void glint_image_file_finish(struct glint_image_file *file);

// The Cryptomatte type that `layer` means: for NULL the only one, else object; one so called, the one of what is seen
// directly, else the only one whose name ends with it in any case ("object": CryptoObject, ViewLayer.CryptoObject). The text lives as long as the
// frame. GLINT_E_NOT_FOUND names the types that there are.
glint_status glint_image_file_type(const struct glint_image_file *file, const char *layer,
                                   const char **type, struct glint_error *err);

// The IDs of the names, from the type's manifest; in a file without one they are hashed.
// GLINT_E_NOT_FOUND for each name that the manifest has not.
glint_status glint_image_file_ids(const struct glint_image_file *file, const char *type,
                                  const char *const *names, size_t count, uint32_t *ids,
                                  struct glint_error *err);

#endif
