// accuracy_stat.h - means over seeds with their intervals, ratios of costs, and who is on the front.
//
// Thread-safety: reentrant.
#ifndef GLINT_CLI_ACCURACY_STAT_H
#define GLINT_CLI_ACCURACY_STAT_H

#include "accuracy_csv.h"

#include <stddef.h>

enum glint_accuracy_cost { GLINT_COST_RAYS, GLINT_COST_CPU, GLINT_COSTS };

struct glint_accuracy_interval {
    double middle, low, high; // 95%
};

// Mean with Student's interval; n >= 1, one value has none.
struct glint_accuracy_interval glint_accuracy_mean_of(const double *value, size_t n);

// Median with an interval by bootstrap, of a fixed seed.
struct glint_accuracy_interval glint_accuracy_median_of(const double *value, size_t n);

// One setting at one number of samples, over the seeds of the table.
struct glint_accuracy_point {
    unsigned spp, seeds;
    double cost[GLINT_COSTS];             // means
    struct glint_accuracy_interval error; // rmse61, or the total variation of mattes
    bool front[GLINT_COSTS];              // no other point is better in both
    bool limited;                         // by the reference, for any seed
};
// False: the table has none.
bool glint_accuracy_point_of(struct glint_accuracy_point *out,
                             const struct glint_accuracy_table *table, const char *knob,
                             const char *value, unsigned spp);
void glint_accuracy_mark_front(struct glint_accuracy_point *point, size_t count);

// Cost of a setting over that of its twin, seed by seed, at the same samples; false: none.
bool glint_accuracy_ratio(struct glint_accuracy_interval *out,
                          const struct glint_accuracy_table *table,
                          const struct glint_accuracy_row *setting,
                          const struct glint_accuracy_row *twin, enum glint_accuracy_cost cost);

// Error that a line, of points by ascending cost, has at a cost: between points along the power law
// through them, beyond them as Monte Carlo does, with the root of the cost. NAN: no points.
double glint_accuracy_error_at(const struct glint_accuracy_point *line, size_t count,
                               enum glint_accuracy_cost cost, double at);

#endif
