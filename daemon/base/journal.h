// journal.h - what the daemon has accepted, in a SQLite database that survives it.
//
// WAL with synchronous=FULL: what is committed is there after a power cut. One storage thread owns
// the database. Requests wait in a bounded queue; all that wait when the thread comes round are
// one transaction, because a commit costs some milliseconds however much is in it. When the queue
// is full the caller waits.
//
// A statement is SQL of the caller with one value for each '?'. The tables are those of
// journal_schema.c. A database of a newer schema, one that is not ours or one that is corrupt is
// refused as it is: nothing in it is changed.
//
// Threads: any but those that must not wait for a disk; create and destroy by one.
#ifndef GLINT_BASE_JOURNAL_H
#define GLINT_BASE_JOURNAL_H

#include "base/metrics.h"
#include "protocol/status.h"

#include <stdbool.h>
#include <stdint.h>

#define GLINT_JOURNAL_VALUES 20

typedef struct glint_journal glint_journal;

enum glint_value_kind {
    GLINT_VALUE_NULL,
    GLINT_VALUE_INTEGER,
    GLINT_VALUE_REAL,
    GLINT_VALUE_TEXT,
    GLINT_VALUE_BLOB
};

struct glint_value {
    enum glint_value_kind kind;
    int64_t integer;
    double real;
    const void *bytes; // TEXT, BLOB: borrowed until the call returns
    size_t length;
};

static inline struct glint_value glint_value_integer(int64_t integer)
{
    return (struct glint_value){.kind = GLINT_VALUE_INTEGER, .integer = integer};
}

static inline struct glint_value glint_value_real(double real)
{
    return (struct glint_value){.kind = GLINT_VALUE_REAL, .real = real};
}

struct glint_value glint_value_text(const char *text); // NULL: the SQL NULL
struct glint_value glint_value_blob(const void *bytes, size_t length);

struct glint_statement {
    const char *sql; // one statement, static
    struct glint_value value[GLINT_JOURNAL_VALUES];
    size_t values;
};

// Opens or makes FOLDER/journal.db. commit_seconds: a histogram, or NULL.
//   GLINT_E_CONFLICT  the schema is newer, or the file is not a journal of ours
//   GLINT_E_IO        it is corrupt, or cannot be opened or written
glint_status glint_journal_create(glint_journal **out, const char *folder,
                                  glint_metric *commit_seconds, struct glint_error *err);
void glint_journal_destroy(glint_journal **journal); // after the last call of anybody

// Runs the statements, all or none, and returns when they are on the disk.
//   GLINT_E_CAPACITY  the disk is full, or cannot be written any more; with figures
//   GLINT_E_IO        the database failed
glint_status glint_journal_commit(glint_journal *journal, const struct glint_statement *statement,
                                  size_t count, struct glint_error *err);

// Calls `row` for every row of the answer, on the storage thread, which waits meanwhile: it may not
// use the journal. A column that is not of the kind asked for reads as 0, 0.0, NULL.
struct glint_row;
int64_t glint_row_integer(const struct glint_row *row, int column);
double glint_row_real(const struct glint_row *row, int column);
const char *glint_row_text(const struct glint_row *row, int column); // until `row` returns
const void *glint_row_blob(const struct glint_row *row, int column, size_t *length);
glint_status glint_journal_read(glint_journal *journal, const struct glint_statement *statement,
                                void (*row)(void *user, const struct glint_row *row), void *user,
                                struct glint_error *err);

uint64_t glint_journal_bytes(const glint_journal *journal); // of its files

#endif
