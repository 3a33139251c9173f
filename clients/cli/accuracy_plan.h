// accuracy_plan.h - what `glint accuracy` renders: the exact twins, and every setting that leaves one.
//
// The table of knobs comes from the daemon (GET /v1), and what the scene calls for from the plan of
// a job with every dial at its exact setting.
//
// Thread-safety: one owner.
#ifndef GLINT_CLI_ACCURACY_PLAN_H
#define GLINT_CLI_ACCURACY_PLAN_H

#include "protocol/status.h"

#include <cjson/cJSON.h>
#include <stdbool.h>
#include <stddef.h>

#define GLINT_ACCURACY_NAME 64
#define GLINT_ACCURACY_VALUE 32

struct glint_accuracy_setting {
    char method[GLINT_ACCURACY_NAME]; // its line: all settings of one knob; "exact", "joint"
    char knob[GLINT_ACCURACY_NAME];   // "accuracy.gi", "max_bounces", "twin", "preset"
    char value[GLINT_ACCURACY_VALUE];
    size_t group;
    bool twin, unbiased, joint;
    bool
        other_question; // it asks for another picture than the twin: what separates them is no error
    bool chosen;        // may be picked by price: it changes the picture and nothing of the mattes
    cJSON *job;         // without seed and stop
};

// Settings that are compared with one reference.
struct glint_accuracy_group {
    char name[GLINT_ACCURACY_NAME];
    bool matte;
    size_t twin; // index of its exact twin
};

struct glint_accuracy_plan {
    struct glint_accuracy_setting *setting;
    size_t settings, capacity;
    struct glint_accuracy_group *group;
    size_t groups;
    cJSON *skipped; // [{"knob", "why"}]: what the scene does not call for
};

// base: scene, camera and resolution of every job. wanted: comma-separated knobs, NULL: all.
struct glint_accuracy_wish {
    const cJSON *capabilities, *plan, *base;
    const char *wanted;
};
//   GLINT_E_RANGE  a wanted knob that there is not
glint_status glint_accuracy_plan_make(struct glint_accuracy_plan *out,
                                      const struct glint_accuracy_wish *wish,
                                      struct glint_error *err);
void glint_accuracy_plan_finish(struct glint_accuracy_plan *plan);

// The job with every dial at the exact twin's setting, whose plan tells what a scene calls for; a
// new object, or NULL without memory.
cJSON *glint_accuracy_twin(const cJSON *capabilities, const cJSON *base, bool matte);

#endif
