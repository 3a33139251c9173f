// things.h - scenes of quads, renders of them with their mattes, and a Cryptomatte decoder of its own.
//
// A pixel is one unit wide on the plane z = 0: pixel (x, y) of a frame of WIDTH x HEIGHT is
// [x - WIDTH/2, x + 1 - WIDTH/2] by [HEIGHT/2 - y - 1, HEIGHT/2 - y].
#ifndef GLINT_TESTS_THINGS_H
#define GLINT_TESTS_THINGS_H

#include "protocol/film_parts.h"
#include "tests/render/offline.h"

#define WIDTH 24
#define HEIGHT 16
#define COUNT(a) (sizeof(a) / sizeof *(a))

// Importer and devices of the program, as fixtures of a cmocka group.
extern struct offline things_crew;
int things_start(void **state);
int things_finish(void **state);

// A quad of its own object and material that faces the camera.
struct thing {
    const char *name, *material, *asset;
    double x, y, z, w, h;
    const char *image; // with holes where its alpha is 0; of one thing at most
    bool hidden;
};

// Ten things that overlap each other at several depths: three materials, one asset; the last two
// have one name.
#define CROWD 10
extern const struct thing crowd[CROWD];

// Members of a camera, of a job.
#define LENS ",\"lens_radius\":0.5,\"focus_distance\":15"
#define BOX "\"filter\":{\"kind\":\"box\",\"width\":1},"
#define ALL_RANKS "\"mattes\":{\"levels\":16,\"slots\":32},"

glint_resident *load_things(const struct thing *t, size_t n, const char *lens);

struct shot {
    struct glint_job *job;
    glint_render *render;
    struct glint_frame *frame;
};

void shoot(struct shot *s, glint_resident *scene, const char *job);
// A frame of WIDTH x HEIGHT. members: more of the job, each ending with a comma.
void shoot_things(struct shot *s, const struct thing *t, size_t n, const char *lens,
                  const char *members, uint32_t samples);
void finish_shot(struct shot *s);

// Pixels of coverage that found no slot.
double lost_in(const struct shot *s);

size_t pixels(const struct glint_frame *f);
// ID or coverage of a rank of type "CryptoObject" and so on; NULL beyond the last layer.
const float *layer_plane(const struct glint_frame *f, const char *type, uint32_t rank,
                         bool coverage);
uint32_t rank_id(const struct glint_frame *f, const char *type, uint32_t rank, size_t pixel);
float rank_coverage(const struct glint_frame *f, const char *type, uint32_t rank, size_t pixel);
// Sum over the ranks.
double coverage_of_id(const struct glint_frame *f, const char *type, uint32_t id, size_t pixel);
double coverage_of(const struct glint_frame *f, const char *type, const char *name, size_t pixel);

#endif
