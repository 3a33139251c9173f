// accuracy_run.h - the programme of `glint accuracy`: references, then seed by seed every setting,
// forth and back (A B B A), into the table.
//
// Thread-safety: one owner.
#ifndef GLINT_CLI_ACCURACY_RUN_H
#define GLINT_CLI_ACCURACY_RUN_H

#include "accuracy_csv.h"
#include "accuracy_metric.h"
#include "accuracy_plan.h"
#include "session.h"

#define GLINT_ACCURACY_STEPS 24

struct glint_accuracy_run {
    struct glint_session *session;
    const struct glint_accuracy_plan *plan;
    const char *folder, *scene, *build;
    unsigned threads, width, height, seeds; // of settings, 1..GLINT_ACCURACY_SEEDS
    unsigned ladder[GLINT_ACCURACY_STEPS];  // samples, ascending
    size_t steps;
    unsigned reference_samples;                 // of each half
    struct glint_accuracy_reference *reference; // [plan->groups], owned
    struct glint_accuracy_table table;          // what is there already, and comes
    size_t done, all;                           // jobs, of this run and before
    size_t rendered;                            // of this run, and
    double seconds;                             // what they took
};

// Renders what the table has not; rows are on the disk after every job.
glint_status glint_accuracy_run(struct glint_accuracy_run *run, struct glint_error *err);
void glint_accuracy_run_finish(struct glint_accuracy_run *run);

// Name of a setting's mean in the folder.
void glint_accuracy_mean_name(const struct glint_accuracy_run *run,
                              const struct glint_accuracy_setting *setting, char out[160]);

#endif
