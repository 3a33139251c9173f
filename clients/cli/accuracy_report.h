// accuracy_report.h - what comes of the table: plots, differences, costs, failures, the front.
//
// Thread-safety: one owner.
#ifndef GLINT_CLI_ACCURACY_REPORT_H
#define GLINT_CLI_ACCURACY_REPORT_H

#include "accuracy_run.h"
#include "accuracy_stat.h"

// One setting, summed up.
struct glint_accuracy_sum {
    const struct glint_accuracy_setting *setting;
    struct glint_accuracy_point point[GLINT_ACCURACY_STEPS]; // [run->steps], by ascending samples
    struct glint_accuracy_spread spread;                     // at the most samples
    struct glint_accuracy_interval ratio[GLINT_COSTS];       // of cost, over the exact twin's
    double
        loses[GLINT_COSTS]; // least samples at which more samples of the twin do better; NAN: none
    double by[GLINT_COSTS]; // its error there over the twin's at equal cost
};

// [run->plan->settings], malloc'd, in the order of the plan.
glint_status glint_accuracy_sum_up(struct glint_accuracy_sum **out,
                                   const struct glint_accuracy_run *run, struct glint_error *err);

// Puts a row of seed "all" for each setting into the table.
glint_status glint_accuracy_add_means(struct glint_accuracy_run *run,
                                      const struct glint_accuracy_sum *sum,
                                      struct glint_error *err);

// The document of PUT /v1/scenes/{scene}/front; a new object, or NULL without memory.
cJSON *glint_accuracy_front(const struct glint_accuracy_run *run,
                            const struct glint_accuracy_sum *sum, const char *revision);

// plots/KNOB.svg for every knob, and its name in *names, an array that is the caller's.
glint_status glint_accuracy_draw(const struct glint_accuracy_run *run,
                                 const struct glint_accuracy_sum *sum, cJSON **names,
                                 struct glint_error *err);

// differences/KNOB-VALUE.png: 8 times what separates the mean over the seeds from the reference.
glint_status glint_accuracy_show_differences(const struct glint_accuracy_run *run,
                                             struct glint_error *err);

// index.html, failures.html and accuracy.json.
glint_status glint_accuracy_write_pages(const struct glint_accuracy_run *run,
                                        const struct glint_accuracy_sum *sum,
                                        const cJSON *capabilities, const cJSON *plots,
                                        struct glint_error *err);

#endif
