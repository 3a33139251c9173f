// scene_text.h - native scenes as text with ' for ", parsed or refused. For tests.
#ifndef GLINT_TESTS_SCENE_TEXT_H
#define GLINT_TESTS_SCENE_TEXT_H

#include "protocol/scene_parts.h"

char *json(const char *quoted); // malloc'd

// A scene with every member somewhere; %s is the hash of an image of 2 x 1 pixels, rgba8.
extern const char *const scene_rich;

// The scene, or the test fails and names the first fault.
struct glint_scene *parse(const char *quoted);
struct glint_scene *parse_with(const char *quoted, const struct glint_asset *asset, size_t n);
struct glint_scene *reparse(const char *text, size_t length, const struct glint_asset *asset,
                            size_t n, const struct glint_scene *checked); // text as it is

// The faults of the text must be at exactly these pointers, in any order, "|" between; the detail
// of one has the words after "=".
void refuse(const char *quoted, const char *pointers);
void refuse_with(const char *quoted, const struct glint_asset *asset, size_t n,
                 const char *pointers);

// An asset that borrows the bytes.
struct glint_asset name_asset(const void *bytes, size_t size);

#endif
