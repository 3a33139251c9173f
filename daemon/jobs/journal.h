// journal.h - the rows of jobs in the journal: what was accepted, and how far it has come.
//
// Threads: any that may wait for a disk.
#ifndef GLINT_JOBS_JOURNAL_H
#define GLINT_JOBS_JOURNAL_H

#include "base/journal.h"
#include "jobs/table.h"

// What a row says of an entry at one moment. Zero-initialise before use.
struct glint_job_progress {
    enum glint_job_state state;
    char *changes; // JSON, owned: what a PATCH has changed, and why it failed
    double seconds, worker_seconds;
    struct glint_render_state rendered;
    uint64_t sequence, film, film_before;
    bool resumed; // goes on, whether it was cancelled or not
};

// The entry as it is now. `render`: what it is asked of, NULL: what is known of it. `table` is that
// of the entry. False without memory.
bool glint_job_progress_take(struct glint_job_progress *out, struct glint_job_table *table,
                             const struct glint_entry *entry, glint_render *render);
void glint_job_progress_finish(struct glint_job_progress *progress);

// A job that was just admitted. GLINT_E_CAPACITY, GLINT_E_IO: it is not kept.
glint_status glint_job_row_add(glint_journal *journal, const struct glint_entry *entry,
                               struct glint_error *err);
// Overwrites what was said at an earlier moment.
glint_status glint_job_row_set(glint_journal *journal, const char *id,
                               const struct glint_job_progress *progress, struct glint_error *err);
// Whatever its row says: it is, or becomes, cancelled.
glint_status glint_job_row_cancel(glint_journal *journal, const char *id, struct glint_error *err);
glint_status glint_job_row_remove(glint_journal *journal, const char *id, struct glint_error *err);

// A row as it was read. Owned strings; NULL where the row has none, which only `key` and `request`
// may.
struct glint_job_row {
    char *id, *text, *scene, *revision, *client, *request, *key, *created, *warnings, *state;
    char *changes, *rendered;
    double accepted, seconds, worker_seconds;
    uint64_t film_bytes, scene_bytes, sequence, film, film_before;
    bool cancelled;
};
// All, in order of submission, in a malloc'd array.
glint_status glint_job_rows_read(glint_journal *journal, struct glint_job_row **out, size_t *count,
                                 struct glint_error *err);
void glint_job_rows_free(struct glint_job_row *row, size_t count);

// The members of glint_render_state that a row keeps.
char *glint_job_rendered_write(const struct glint_render_state *state); // malloc'd JSON
void glint_job_rendered_read(struct glint_render_state *out, const char *text);

#endif
