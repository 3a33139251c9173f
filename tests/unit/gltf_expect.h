// gltf_expect.h - what the tests of the glTF import expect. Each fails the test that calls it.
#ifndef GLINT_TESTS_UNIT_GLTF_EXPECT_H
#define GLINT_TESTS_UNIT_GLTF_EXPECT_H

#include "protocol/scene.h"

// A scene of one node "n" that shows mesh 0.
#define ONE_NODE "'scene':0,'scenes':[{'nodes':[0]}],'nodes':[{'name':'n','mesh':0}]"

// The scene of glb_quad(rest), or of glb_make(json, bin, bytes).
struct glint_scene *gltf_quad(const char *rest);
struct glint_scene *gltf_data(const char *json, const void *bin, size_t bytes);

// A refusal at `pointer` whose sentence holds `word`. Frees the GLB.
void gltf_refused(uint8_t *glb, size_t size, glint_status status, const char *pointer,
                  const char *word);
// The same of glb_quad(rest), GLINT_E_RANGE.
void gltf_refuse_quad(const char *rest, const char *pointer, const char *word);

bool gltf_warns(const struct glint_scene *scene, const char *word);
void gltf_expect_warning(const struct glint_scene *scene, const char *word);
void gltf_floats_equal(const float *a, const float *b, size_t count, float tolerance);

#endif
