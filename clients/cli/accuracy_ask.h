// accuracy_ask.h - what `glint accuracy` was asked for, from its command line.
//
// Thread-safety: one owner.
#ifndef GLINT_CLI_ACCURACY_ASK_H
#define GLINT_CLI_ACCURACY_ASK_H

#include "accuracy_run.h"

struct glint_accuracy_ask {
    const char *file;    // the scene to upload, or NULL: the daemon has it
    char scene[129];     // its name
    const char *dials;   // comma-separated, NULL: all that the scene calls for
    const char *folder;  // of the report
    cJSON *base;         // scene, camera and resolution of every job
    bool spawn, publish; // a private daemon where none answers; the front is put
    unsigned width, height, seeds, reference_samples;
    unsigned ladder[GLINT_ACCURACY_STEPS];
    size_t steps;
};

extern const struct glint_option glint_accuracy_options[];

// What is wrong is a usage fault, each named.
glint_status glint_accuracy_ask(struct glint_accuracy_ask *out, struct glint_session *s,
                                const struct glint_arguments *a, struct glint_error *err);
void glint_accuracy_ask_finish(struct glint_accuracy_ask *ask);

#endif
