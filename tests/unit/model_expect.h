// model_expect.h - mesh files in tests: read them, or see them refused.
#ifndef GLINT_TESTS_MODEL_EXPECT_H
#define GLINT_TESTS_MODEL_EXPECT_H

#include "scene/model.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

typedef glint_status model_reader(struct glint_scene **out, const uint8_t *bytes, size_t size,
                                  struct glint_error *err);

// The scene; the test fails with the first fault where there is none. The bytes are read from a
// copy of their exact size, so that a sanitizer sees a step too far.
static inline struct glint_scene *model_read(model_reader *read, const void *bytes, size_t size)
{
    struct glint_scene *scene = NULL;
    struct glint_error err = {0};
    uint8_t *copy = malloc(size ? size : 1);
    memcpy(copy, bytes, size);
    if (read(&scene, copy, size, &err))
        fail_msg("%s", glint_error_text(&err));
    free(copy);
    return scene;
}

static inline void model_refused(model_reader *read, const void *bytes, size_t size,
                                 glint_status status, const char *words)
{
    struct glint_scene *scene = NULL;
    struct glint_error err = {0};
    uint8_t *copy = malloc(size ? size : 1);
    memcpy(copy, bytes, size);
    const glint_status st = read(&scene, copy, size, &err);
    free(copy);
    assert_null(scene);
    if (st != status || !strstr(err.fault[0].detail, words))
        fail_msg("status %d, \"%s\" without \"%s\"", st, glint_error_text(&err), words);
    glint_error_finish(&err);
}

static inline bool model_warns(const struct glint_scene *scene, const char *words)
{
    for (uint32_t i = 0; i < scene->warnings; i++)
        if (strstr(scene->warning[i], words))
            return true;
    return false;
}

// Twice the area vector of a triangle's sum over the mesh: 0 for a closed one.
static inline double model_area(const struct glint_mesh *m, double sum[3])
{
    double area = 0;
    memset(sum, 0, 3 * sizeof *sum);
    for (uint32_t t = 0; t < m->triangles; t++) {
        const float *p[3];
        double u[3], v[3], n[3], square = 0;
        for (int k = 0; k < 3; k++)
            p[k] = m->position + 3 * (size_t)m->index[3 * (size_t)t + (size_t)k];
        for (int i = 0; i < 3; i++) {
            u[i] = (double)p[1][i] - p[0][i];
            v[i] = (double)p[2][i] - p[0][i];
        }
        for (int i = 0; i < 3; i++) {
            n[i] = (u[(i + 1) % 3] * v[(i + 2) % 3] - u[(i + 2) % 3] * v[(i + 1) % 3]) / 2;
            sum[i] += n[i];
            square += n[i] * n[i];
        }
        area += __builtin_sqrt(square);
    }
    return area;
}

#endif
