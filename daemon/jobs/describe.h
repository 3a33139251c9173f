// describe.h - a job, and a list of them, as PROTOCOL's resource.
//
// Thread-safety: any thread that holds the entry, without the table's mutex.
#ifndef GLINT_JOBS_DESCRIBE_H
#define GLINT_JOBS_DESCRIBE_H

#include "jobs/table.h"

// A new object, NULL without memory.
cJSON *glint_entry_describe(struct glint_job_table *table, struct glint_entry *entry);

// As glint_jobs_list().
cJSON *glint_entries_describe(struct glint_job_table *table, const struct glint_jobs_filter *filter,
                              struct glint_error *err);

#endif
