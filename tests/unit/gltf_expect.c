// gltf_expect.c - imports that must succeed, and refusals that must say why.
#include "tests/unit/gltf_expect.h"

#include "scene/gltf.h"
#include "tests/unit/glb_maker.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static struct glint_scene *take(uint8_t *glb, size_t size)
{
    struct glint_error err = {0};
    struct glint_scene *scene;
    const glint_status st = glint_gltf_import(&scene, glb, size, NULL, &err);
    if (st)
        fail_msg("%s: %s", err.count ? err.fault[0].pointer : "", glint_error_text(&err));
    free(glb);
    return scene;
}

struct glint_scene *gltf_quad(const char *rest)
{
    size_t size;
    uint8_t *glb = glb_quad(rest, &size);
    return take(glb, size);
}

struct glint_scene *gltf_data(const char *json, const void *bin, size_t bytes)
{
    size_t size;
    uint8_t *glb = glb_make(json, bin, bytes, &size);
    return take(glb, size);
}

void gltf_refused(uint8_t *glb, size_t size, glint_status status, const char *pointer,
                  const char *word)
{
    struct glint_error err = {0};
    struct glint_scene *scene;
    assert_int_equal(glint_gltf_import(&scene, glb, size, NULL, &err), status);
    assert_null(scene);
    assert_string_equal(err.fault[0].pointer, pointer);
    if (!strstr(err.fault[0].detail, word))
        fail_msg("\"%s\" does not say \"%s\"", err.fault[0].detail, word);
    glint_error_finish(&err);
    free(glb);
}

void gltf_refuse_quad(const char *rest, const char *pointer, const char *word)
{
    size_t size;
    uint8_t *glb = glb_quad(rest, &size);
    gltf_refused(glb, size, GLINT_E_RANGE, pointer, word);
}

bool gltf_warns(const struct glint_scene *s, const char *word)
{
    for (uint32_t i = 0; i < s->warnings; i++)
        if (strstr(s->warning[i], word))
            return true;
    return false;
}

void gltf_expect_warning(const struct glint_scene *s, const char *word)
{
    if (!gltf_warns(s, word))
        fail_msg("no warning says \"%s\"", word);
}

void gltf_floats_equal(const float *a, const float *b, size_t count, float tolerance)
{
    for (size_t i = 0; i < count; i++)
        if (!(fabsf(a[i] - b[i]) <= tolerance))
            fail_msg("number %zu is %.9g, not %.9g", i, (double)a[i], (double)b[i]);
}
