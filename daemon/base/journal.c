#include "base/journal.h"

#include "base/clock.h"
#include "base/journal_schema.h"
#include "base/queue.h"
#include "base/storage.h"
#include "base/thread.h"

#include <fcntl.h>
#include <sqlite3.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#define REQUESTS 256     // that wait; who comes later waits for room
#define BUSY_MILLIS 5000 // for somebody who looks into the database by hand
#define CACHED 48u       // prepared statements

// Lives on its caller's stack until it is answered.
struct request {
    const struct glint_statement *statement;
    size_t count;
    void (*row)(void *user, const struct glint_row *row); // a read
    void *user;
    struct glint_error *err;
    glint_status status;
    bool answered;
};

struct cached {
    const char *sql;
    sqlite3_stmt *statement;
};

struct glint_journal {
    char *folder, *path;
    glint_metric *commit_seconds;
    glint_queue *requests; // of struct request *
    pthread_t thread;
    bool started;
    pthread_mutex_t mutex; // of `answered` in every request under way; a leaf
    pthread_cond_t answer;

    // the thread's, once it runs
    sqlite3 *db;
    struct cached cached[CACHED];
    size_t caches;
};

struct glint_row {
    sqlite3_stmt *statement;
};

struct glint_value glint_value_text(const char *text)
{
    return (struct glint_value){.kind = text ? GLINT_VALUE_TEXT : GLINT_VALUE_NULL,
                                .bytes = text,
                                .length = text ? strlen(text) : 0};
}

struct glint_value glint_value_blob(const void *bytes, size_t length)
{
    return (struct glint_value){.kind = GLINT_VALUE_BLOB, .bytes = bytes, .length = length};
}

// ---- faults

static bool is_lack(const glint_journal *j)
{
    const int code = sqlite3_errcode(j->db) & 0xff;
    return code == SQLITE_FULL || code == SQLITE_READONLY || code == SQLITE_CANTOPEN ||
           (code == SQLITE_IOERR && glint_storage_lacks(sqlite3_system_errno(j->db)));
}

static glint_status fault(const glint_journal *j, struct glint_error *err)
{
    if (is_lack(j))
        return glint_storage_full(err, j->folder, sqlite3_errmsg(j->db));
    return glint_fail(err, GLINT_E_IO, "", "%s: %s", j->path, sqlite3_errmsg(j->db));
}

// ---- statements

static sqlite3_stmt *prepared(glint_journal *j, const char *sql)
{
    for (size_t i = 0; i < j->caches; i++)
        if (j->cached[i].sql == sql)
            return j->cached[i].statement;
    sqlite3_stmt *statement = NULL;
    if (j->caches == CACHED) // more kinds of statement than the daemon has: the oldest goes
        sqlite3_finalize(j->cached[--j->caches].statement);
    if (sqlite3_prepare_v3(j->db, sql, -1, SQLITE_PREPARE_PERSISTENT, &statement, NULL))
        return NULL;
    j->cached[j->caches++] = (struct cached){sql, statement};
    return statement;
}

static int bind(sqlite3_stmt *statement, int index, const struct glint_value *v)
{
    switch (v->kind) {
    case GLINT_VALUE_INTEGER:
        return sqlite3_bind_int64(statement, index, v->integer);
    case GLINT_VALUE_REAL:
        return sqlite3_bind_double(statement, index, v->real);
    case GLINT_VALUE_TEXT:
        return sqlite3_bind_text64(statement, index, v->bytes, v->length, SQLITE_STATIC,
                                   SQLITE_UTF8);
    case GLINT_VALUE_BLOB:
        return sqlite3_bind_blob64(statement, index, v->bytes, v->length, SQLITE_STATIC);
    case GLINT_VALUE_NULL:
        break;
    }
    return sqlite3_bind_null(statement, index);
}

static glint_status run_statement(glint_journal *j, const struct glint_statement *s,
                                  const struct request *r)
{
    sqlite3_stmt *statement = prepared(j, s->sql);
    if (!statement)
        return fault(j, r->err);
    int code = SQLITE_OK;
    for (size_t i = 0; i < s->values && !code; i++)
        code = bind(statement, (int)i + 1, &s->value[i]);
    const struct glint_row row = {statement};
    while (!code && (code = sqlite3_step(statement)) == SQLITE_ROW) {
        if (r->row)
            r->row(r->user, &row);
        code = SQLITE_OK;
    }
    const glint_status st = code == SQLITE_DONE ? GLINT_OK : fault(j, r->err);
    sqlite3_reset(statement);
    sqlite3_clear_bindings(statement);
    return st;
}

static bool quick(glint_journal *j, const char *sql)
{
    return sqlite3_exec(j->db, sql, NULL, NULL, NULL) == SQLITE_OK;
}

// ---- the thread

static void answer(glint_journal *j, struct request *r)
{
    pthread_mutex_lock(&j->mutex);
    r->answered = true;
    pthread_cond_broadcast(&j->answer);
    pthread_mutex_unlock(&j->mutex);
}

// A request of its own within the transaction: its fault undoes nobody else's.
static void run_request(glint_journal *j, struct request *r)
{
    if (!quick(j, "SAVEPOINT one")) {
        r->status = fault(j, r->err);
        return;
    }
    for (size_t i = 0; i < r->count && !r->status; i++)
        r->status = run_statement(j, &r->statement[i], r);
    // Where the disk is full the whole transaction may be gone, and with it the savepoint.
    if (r->status)
        quick(j, "ROLLBACK TO one");
    quick(j, "RELEASE one");
}

static void fail_all(glint_journal *j, struct request *const *group, size_t count)
{
    for (size_t i = 0; i < count; i++)
        if (!group[i]->status)
            group[i]->status = fault(j, group[i]->err);
}

static bool run_transaction(glint_journal *j, struct request *const *group, size_t count)
{
    if (!quick(j, "BEGIN IMMEDIATE")) {
        fail_all(j, group, count);
        return false;
    }
    for (size_t i = 0; i < count && !sqlite3_get_autocommit(j->db); i++)
        run_request(j, group[i]);
    // A fault may have undone everything: then there is nothing left to commit.
    if (!sqlite3_get_autocommit(j->db) && quick(j, "COMMIT"))
        return true;
    fail_all(j, group, count);
    if (!sqlite3_get_autocommit(j->db))
        quick(j, "ROLLBACK");
    return false;
}

// What one broken request has undone for the others is tried again, each by itself.
static void run_writes(glint_journal *j, struct request *const *group, size_t count)
{
    if (!count)
        return;
    const double start = glint_now();
    struct glint_error *err[REQUESTS];
    for (size_t i = 0; i < count; i++) {
        err[i] = group[i]->err;
        group[i]->err = count > 1 ? NULL : err[i];
    }
    const bool done = run_transaction(j, group, count);
    for (size_t i = 0; i < count; i++) {
        group[i]->err = err[i];
        if (count > 1 && (!done || group[i]->status)) {
            group[i]->status = GLINT_OK;
            run_transaction(j, group + i, 1);
        }
    }
    glint_metric_observe(j->commit_seconds, glint_now() - start);
    for (size_t i = 0; i < count; i++)
        answer(j, group[i]);
}

static void run_read(glint_journal *j, struct request *r)
{
    r->status = run_statement(j, r->statement, r);
    answer(j, r);
}

static void *serve(void *arg)
{
    glint_journal *j = arg;
    struct request *r, *group[REQUESTS];
    while (glint_queue_pop(j->requests, &r)) {
        size_t count = 0;
        do {
            if (!r->row) {
                group[count++] = r;
                continue;
            }
            run_writes(j, group, count); // a read sees what was asked before it
            count = 0;
            run_read(j, r);
        } while (count < REQUESTS && glint_queue_poll(j->requests, &r));
        run_writes(j, group, count);
    }
    return NULL;
}

static glint_status call(glint_journal *j, struct request *r)
{
    if (!glint_queue_push(j->requests, &r))
        return glint_fail(r->err, GLINT_E_BUSY, "", "the journal is closed");
    pthread_mutex_lock(&j->mutex);
    while (!r->answered)
        pthread_cond_wait(&j->answer, &j->mutex);
    pthread_mutex_unlock(&j->mutex);
    return r->status;
}

glint_status glint_journal_commit(glint_journal *j, const struct glint_statement *statement,
                                  size_t count, struct glint_error *err)
{
    struct request r = {.statement = statement, .count = count, .err = err};
    return call(j, &r);
}

static void ignore(void *user, const struct glint_row *row)
{
    (void)user;
    (void)row;
}

glint_status glint_journal_read(glint_journal *j, const struct glint_statement *statement,
                                void (*row)(void *user, const struct glint_row *row), void *user,
                                struct glint_error *err)
{
    struct request r = {
        .statement = statement, .count = 1, .row = row ? row : ignore, .user = user, .err = err};
    return call(j, &r);
}

int64_t glint_row_integer(const struct glint_row *row, int column)
{
    return sqlite3_column_type(row->statement, column) == SQLITE_INTEGER
               ? sqlite3_column_int64(row->statement, column)
               : 0;
}

double glint_row_real(const struct glint_row *row, int column)
{
    const int type = sqlite3_column_type(row->statement, column);
    return type == SQLITE_FLOAT || type == SQLITE_INTEGER
               ? sqlite3_column_double(row->statement, column)
               : 0;
}

const char *glint_row_text(const struct glint_row *row, int column)
{
    return sqlite3_column_type(row->statement, column) == SQLITE_TEXT
               ? (const char *)sqlite3_column_text(row->statement, column)
               : NULL;
}

const void *glint_row_blob(const struct glint_row *row, int column, size_t *length)
{
    *length = 0;
    if (sqlite3_column_type(row->statement, column) != SQLITE_BLOB)
        return NULL;
    const void *bytes = sqlite3_column_blob(row->statement, column);
    *length = (size_t)sqlite3_column_bytes(row->statement, column);
    return bytes;
}

uint64_t glint_journal_bytes(const glint_journal *j)
{
    return glint_storage_bytes(j->folder, "journal.db") +
           glint_storage_bytes(j->folder, "journal.db-wal") +
           glint_storage_bytes(j->folder, "journal.db-shm");
}

// ---- opening, by the creator, before there is a thread

static int64_t ask_number(glint_journal *j, const char *sql)
{
    sqlite3_stmt *statement;
    int64_t number = -1;
    if (sqlite3_prepare_v2(j->db, sql, -1, &statement, NULL))
        return -1;
    if (sqlite3_step(statement) == SQLITE_ROW)
        number = sqlite3_column_int64(statement, 0);
    sqlite3_finalize(statement);
    return number;
}

static glint_status corrupt(const glint_journal *j, const char *what, struct glint_error *err)
{
    return glint_fail(
        err, GLINT_E_IO, "",
        "%s is damaged (%s); nothing in it was changed. Put a copy of the state folder "
        "in its place, or move the folder away to begin with an empty one",
        j->path, what);
}

static glint_status check_pages(glint_journal *j, struct glint_error *err)
{
    sqlite3_stmt *statement;
    glint_status st = GLINT_OK;
    if (sqlite3_prepare_v2(j->db, "PRAGMA quick_check(1)", -1, &statement, NULL))
        return corrupt(j, sqlite3_errmsg(j->db), err);
    if (sqlite3_step(statement) != SQLITE_ROW)
        st = corrupt(j, sqlite3_errmsg(j->db), err);
    else if (strcmp((const char *)sqlite3_column_text(statement, 0), "ok"))
        st = corrupt(j, (const char *)sqlite3_column_text(statement, 0), err);
    sqlite3_finalize(statement);
    return st;
}

// Whose it is, and from when. Reads only.
static glint_status check_kind(glint_journal *j, bool *empty, struct glint_error *err)
{
    const int64_t tables = ask_number(j, "SELECT count(*) FROM sqlite_master");
    const int64_t application = ask_number(j, "PRAGMA application_id");
    const int64_t version = ask_number(j, "PRAGMA user_version");
    *empty = tables == 0;
    if (tables < 0 || application < 0 || version < 0)
        return is_lack(j) ? fault(j, err) : corrupt(j, sqlite3_errmsg(j->db), err);
    if (!*empty && application != GLINT_JOURNAL_APPLICATION)
        return glint_fail(err, GLINT_E_CONFLICT, "",
                          "%s is no journal of glintd; it was not changed", j->path);
    if (version > GLINT_JOURNAL_VERSION)
        return glint_fail(
            err, GLINT_E_CONFLICT, "",
            "%s was written by a newer glintd: its version is %lld, this one knows %d. "
            "Nothing was changed",
            j->path, (long long)version, GLINT_JOURNAL_VERSION);
    return *empty ? GLINT_OK : check_pages(j, err);
}

static glint_status make_tables(glint_journal *j, struct glint_error *err)
{
    char stamp[96];
    snprintf(stamp, sizeof stamp, "PRAGMA application_id=%d; PRAGMA user_version=%d",
             GLINT_JOURNAL_APPLICATION, GLINT_JOURNAL_VERSION);
    const bool made = quick(j, "BEGIN IMMEDIATE") && quick(j, glint_journal_schema) &&
                      quick(j, glint_journal_additions) && quick(j, stamp) && quick(j, "COMMIT");
    return made ? GLINT_OK : fault(j, err);
}

// A daemon that cannot write should say so before it takes work. What older ones did not have is
// added.
static bool can_write(glint_journal *j)
{
    char stamp[64];
    snprintf(stamp, sizeof stamp, "PRAGMA user_version=%d", GLINT_JOURNAL_VERSION);
    return quick(j, "BEGIN IMMEDIATE") && quick(j, glint_journal_additions) && quick(j, stamp) &&
           quick(j, "COMMIT");
}

static glint_status open_database(glint_journal *j, struct glint_error *err)
{
    bool empty;
    // The library would let everybody read it. Where this fails, its own word says why.
    const int fd = open(j->path, O_RDWR | O_CREAT | O_CLOEXEC, 0640);
    if (fd >= 0)
        close(fd);
    if (sqlite3_open_v2(j->path, &j->db, SQLITE_OPEN_READWRITE | SQLITE_OPEN_CREATE, NULL))
        return glint_fail(err, GLINT_E_IO, "", "%s: %s", j->path, sqlite3_errmsg(j->db));
    sqlite3_extended_result_codes(j->db, 1);
    sqlite3_busy_timeout(j->db, BUSY_MILLIS);
    const glint_status st = check_kind(j, &empty, err);
    if (st)
        return st;
    if (!quick(j, "PRAGMA journal_mode=WAL") || !quick(j, "PRAGMA synchronous=FULL") ||
        !quick(j, "PRAGMA foreign_keys=ON"))
        return fault(j, err);
    if (empty)
        return make_tables(j, err);
    return can_write(j) ? GLINT_OK : fault(j, err);
}

glint_status glint_journal_create(glint_journal **out, const char *folder,
                                  glint_metric *commit_seconds, struct glint_error *err)
{
    glint_journal *j = *out = calloc(1, sizeof *j);
    if (!j)
        return glint_fail(err, GLINT_E_NOMEM, "", "no memory for the journal");
    pthread_mutex_init(&j->mutex, NULL);
    pthread_cond_init(&j->answer, NULL);
    j->commit_seconds = commit_seconds;
    j->folder = strdup(folder);
    if (!j->folder || asprintf(&j->path, "%s/journal.db", folder) < 0) {
        j->path = NULL;
        glint_journal_destroy(out);
        return glint_fail(err, GLINT_E_NOMEM, "", "no memory for the journal");
    }
    glint_status st = open_database(j, err);
    if (!st)
        st = glint_queue_create(&j->requests, REQUESTS, sizeof(struct request *), err);
    if (!st)
        st = glint_thread_start(&j->thread, "journal", serve, j, err);
    j->started = !st;
    if (st)
        glint_journal_destroy(out);
    return st;
}

void glint_journal_destroy(glint_journal **journal)
{
    glint_journal *j = *journal;
    *journal = NULL;
    if (!j)
        return;
    if (j->started) {
        glint_queue_close(j->requests);
        pthread_join(j->thread, NULL);
    }
    glint_queue_destroy(&j->requests);
    for (size_t i = 0; i < j->caches; i++)
        sqlite3_finalize(j->cached[i].statement);
    sqlite3_close(j->db);
    pthread_cond_destroy(&j->answer);
    pthread_mutex_destroy(&j->mutex);
    free(j->path);
    free(j->folder);
    free(j);
}
