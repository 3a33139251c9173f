// effect_worlds.h - for every row of the effects table, a picture that calls for it and one that does
// not: a ball before a wall. What is not in these lists fails tests/render/test_effects.
#ifndef GLINT_TESTS_EFFECT_WORLDS_H
#define GLINT_TESTS_EFFECT_WORLDS_H

#include "tests/render/offline.h"

// Scenes and jobs are written with ' for ".
struct effect_world {
    const char *light;  // top-level members
    const char *ball;   // members of the ball's material
    const char *camera; // members
    const char *more;   // instances
    int segments;       // of the ball
};

struct effect_order {
    const char *outputs, *filter, *more;
    int bounces;
};

extern const struct effect_world effect_sky, effect_lamp, effect_textured, effect_glossy,
    effect_polished, effect_glass, effect_image_sky;
extern const struct effect_order effect_beauty;

// malloc'd texts.
char *effect_scene(const struct effect_world *world);
char *effect_job(const struct effect_order *order, const uint32_t size[2], uint32_t samples);

// The bits of rows named "a|b"; no name for none. Fails the test where there is no such row.
uint64_t effect_bits(const char *names);

// A row, a picture that does not call for it, and what else its code needs to run.
struct effect_forcing {
    const char *effect;
    const struct effect_world *world;
    const char *with;
};
extern const struct effect_forcing effect_forcings[];
extern const size_t effect_forcing_count;

// Rows that cannot be forced: settings of a dial whose other setting is another image.
extern const char effect_twins[];

// Each cause switches on its own row, and no other than those that go with it.
struct effect_cause {
    const char *effect;
    struct effect_world world;
    struct effect_order order;
    const char *calls; // every row
};
extern const struct effect_cause effect_causes[];
extern const size_t effect_cause_count;

// The picture of a row's first cause, without the cause.
struct effect_comparison {
    const char *effect;
    const struct effect_world *world;
    const struct effect_order *order;
};
struct effect_comparison effect_without(const char *effect);

// Rows whose cause is none of these: the tracer's or the importer's own.
extern const char effect_by_facts[];

#endif
