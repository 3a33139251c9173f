// filmed.h - a small scene with everything that a film keeps, and films of it in unnamed files.
#ifndef GLINT_TESTS_FILMED_H
#define GLINT_TESTS_FILMED_H

#include "protocol/film_file.h"
#include "tests/stability/stable.h"

// Glass, a lamp, something that moves, from two cameras "eye" and "side".
struct glint_posed filmed_scene(const struct offline *o);
// The glass is of segments * (segments - 2) triangles.
struct glint_posed filmed_scene_of(const struct offline *o, uint32_t segments);

// It, for a group of tests of offline_crew.
extern struct glint_posed filmed;
int filmed_start(void **state);
int filmed_stop(void **state);

// All outputs. `members`: more of the job, with ' for " and each ending with a comma.
struct glint_job *filmed_job(const char *members);
glint_render *filmed_render(const struct offline *o, const struct glint_posed *scene,
                            const char *members);

// Runs that many slices one after the other; fewer where there are no more. Returns their number.
uint32_t filmed_run(const struct offline *o, glint_render *render, uint32_t slices);

// The render's film in a file of its own, at its start; the caller closes it.
int filmed_write(glint_render *render);
int filmed_file(void);

// All of a frame as OpenEXR; malloc'd.
uint8_t *filmed_exr(glint_render *render, uint32_t outputs, size_t *size);
// Both have the same bytes there, and nothing else is different that a client sees, but times.
void filmed_assert_same(glint_render *a, glint_render *b);

#endif
