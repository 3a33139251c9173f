// accuracy_csv.h - the table of what was measured: accuracy.csv, and mattes.csv beside it.
//
// Every figure is drawn from these files alone. A row is one setting, seed and number of samples;
// rows of seed "all" hold the means over the seeds, bias and standard deviation.
//
// Thread-safety: one owner.
#ifndef GLINT_CLI_ACCURACY_CSV_H
#define GLINT_CLI_ACCURACY_CSV_H

#include "protocol/status.h"

#include <stdbool.h>
#include <stdint.h>

struct glint_accuracy_row {
    char scene[132], method[64], knob[64], value[32], seed[16];
    unsigned spp, threads;
    double rays[3], cpu, wall; // camera, bounce, shadow; NAN, here and below: not known
    double rmse61, relmse, relmse_trim, matte_mae, tv;
    double bias, sd; // bias: root of |bias^2|, with its sign
    double est_error, pred_cost;
    char ref_id[80], build[64]; // ref_id ends with ":limited" where the reference limits the row
    double matte_max, lost, within; // of mattes.csv
};

struct glint_accuracy_table {
    struct glint_accuracy_row *row;
    size_t rows, capacity;
};

// What the files of an earlier run hold; none of them: no rows.
//   GLINT_E_SYNTAX  one is not such a table; with its line
glint_status glint_accuracy_table_read(struct glint_accuracy_table *out, const char *folder,
                                       struct glint_error *err);
void glint_accuracy_table_finish(struct glint_accuracy_table *table);

// NULL without memory.
struct glint_accuracy_row *glint_accuracy_table_add(struct glint_accuracy_table *table);

// Of the setting, seed and samples; NULL: none.
const struct glint_accuracy_row *glint_accuracy_table_find(const struct glint_accuracy_table *table,
                                                           const char *knob, const char *value,
                                                           const char *seed, unsigned spp);
// Takes the rows out that `drop` says.
void glint_accuracy_table_drop(struct glint_accuracy_table *table,
                               bool (*drop)(void *user, const struct glint_accuracy_row *row),
                               void *user);

// Puts both files in place.
glint_status glint_accuracy_table_write(const struct glint_accuracy_table *table,
                                        const char *folder, struct glint_error *err);

#endif
