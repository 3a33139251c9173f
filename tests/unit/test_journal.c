#include "base/journal.h"
#include "base/journal_schema.h"
#include "base/thread.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stdatomic.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include <cmocka.h>

static char folder[64];

static int make_folder(void **state)
{
    (void)state;
    strcpy(folder, "/tmp/glint-journal-XXXXXX");
    return mkdtemp(folder) ? 0 : -1;
}

static int remove_folder(void **state)
{
    (void)state;
    char command[128];
    snprintf(command, sizeof command, "rm -rf '%s'", folder);
    return system(command);
}

static glint_journal *open_journal(void)
{
    glint_journal *journal;
    assert_int_equal(glint_journal_create(&journal, folder, NULL, NULL), GLINT_OK);
    return journal;
}

static struct glint_statement put(const char *name, int64_t bytes)
{
    return (struct glint_statement){.sql = "INSERT INTO asset(name, bytes) VALUES(?,?)",
                                    .value = {glint_value_text(name), glint_value_integer(bytes)},
                                    .values = 2};
}

static glint_status put_one(glint_journal *journal, const char *name, int64_t bytes)
{
    const struct glint_statement s = put(name, bytes);
    return glint_journal_commit(journal, &s, 1, NULL);
}

struct sum {
    int rows;
    int64_t bytes;
    char names[256];
};

static void add(void *user, const struct glint_row *row)
{
    struct sum *sum = user;
    sum->rows++;
    sum->bytes += glint_row_integer(row, 1);
    strcat(sum->names, glint_row_text(row, 0));
}

static struct sum look(glint_journal *journal)
{
    struct sum sum = {0};
    const struct glint_statement all = {.sql = "SELECT name, bytes FROM asset ORDER BY name"};
    assert_int_equal(glint_journal_read(journal, &all, add, &sum, NULL), GLINT_OK);
    return sum;
}

static void what_is_committed_is_there_when_it_is_opened_again(void **state)
{
    (void)state;
    glint_journal *journal = open_journal();
    assert_int_equal(put_one(journal, "a", 1), GLINT_OK);
    assert_int_equal(put_one(journal, "b", 2), GLINT_OK);
    glint_journal_destroy(&journal);
    assert_null(journal);
    journal = open_journal();
    const struct sum sum = look(journal);
    assert_int_equal(sum.rows, 2);
    assert_int_equal(sum.bytes, 3);
    assert_string_equal(sum.names, "ab");
    assert_true(glint_journal_bytes(journal) > 0);
    glint_journal_destroy(&journal);
}

static void statements_of_one_commit_hold_all_or_none(void **state)
{
    (void)state;
    glint_journal *journal = open_journal();
    assert_int_equal(put_one(journal, "a", 1), GLINT_OK);
    const struct glint_statement both[2] = {put("c", 4), put("a", 8)}; // a is there already
    struct glint_error err = {0};
    assert_int_equal(glint_journal_commit(journal, both, 2, &err), GLINT_E_IO);
    assert_non_null(strstr(glint_error_text(&err), "UNIQUE"));
    glint_error_finish(&err);
    assert_string_equal(look(journal).names, "a");
    assert_int_equal(put_one(journal, "c", 4), GLINT_OK);
    glint_journal_destroy(&journal);
}

static void values_come_back_as_they_went(void **state)
{
    (void)state;
    glint_journal *journal = open_journal();
    const struct glint_statement in = {
        .sql = "INSERT INTO revision(id, parent, depth, form, data) VALUES(?,?,?,?,?)",
        .value = {glint_value_text("r"), glint_value_text(NULL), glint_value_integer(INT64_MIN),
                  glint_value_integer(2), glint_value_blob("\0\1\2", 3)},
        .values = 5};
    assert_int_equal(glint_journal_commit(journal, &in, 1, NULL), GLINT_OK);
    glint_journal_destroy(&journal);
}

static void check_kinds(void *user, const struct glint_row *row)
{
    size_t length;
    (*(int *)user)++;
    assert_int_equal(glint_row_integer(row, 0), 7);
    assert_true(glint_row_real(row, 1) == 0.5);
    assert_string_equal(glint_row_text(row, 2), "x");
    assert_memory_equal(glint_row_blob(row, 3, &length), "\0\1", 2);
    assert_int_equal(length, 2);
    assert_null(glint_row_text(row, 4));
    // of another kind than asked for
    assert_int_equal(glint_row_integer(row, 2), 0);
    assert_null(glint_row_text(row, 0));
    assert_null(glint_row_blob(row, 2, &length));
    assert_int_equal(length, 0);
}

static void columns_of_another_kind_read_as_nothing(void **state)
{
    (void)state;
    glint_journal *journal = open_journal();
    int rows = 0;
    const struct glint_statement s = {.sql = "SELECT ?, ?, ?, ?, ?",
                                      .value = {glint_value_integer(7), glint_value_real(0.5),
                                                glint_value_text("x"), glint_value_blob("\0\1", 2),
                                                glint_value_text(NULL)},
                                      .values = 5};
    assert_int_equal(glint_journal_read(journal, &s, check_kinds, &rows, NULL), GLINT_OK);
    assert_int_equal(rows, 1);
    glint_journal_destroy(&journal);
}

#define THREADS 8
#define EACH 25

struct crowd {
    glint_journal *journal;
    atomic_int next, refused;
};

static void *put_many(void *arg)
{
    struct crowd *crowd = arg;
    const int first = atomic_fetch_add(&crowd->next, EACH);
    for (int i = first; i < first + EACH; i++) {
        char name[16];
        snprintf(name, sizeof name, "%d", i % 5 ? i : 0); // every fifth is there already, but one
        if (put_one(crowd->journal, name, 1))
            atomic_fetch_add(&crowd->refused, 1);
    }
    return NULL;
}

static void a_fault_undoes_nothing_of_others_in_the_same_transaction(void **state)
{
    (void)state;
    struct crowd crowd = {.journal = open_journal()};
    pthread_t thread[THREADS];
    for (int i = 0; i < THREADS; i++)
        assert_int_equal(glint_thread_start(&thread[i], "crowd", put_many, &crowd, NULL), GLINT_OK);
    for (int i = 0; i < THREADS; i++)
        pthread_join(thread[i], NULL);
    struct sum sum = {0};
    const struct glint_statement count = {.sql = "SELECT '', count(*) FROM asset"};
    glint_journal_read(crowd.journal, &count, add, &sum, NULL);
    assert_int_equal(sum.bytes, THREADS * EACH * 4 / 5 + 1);
    assert_int_equal(crowd.refused, THREADS * EACH / 5 - 1);
    glint_journal_destroy(&crowd.journal);
}

static void what_the_first_version_lacks_is_added(void **state)
{
    (void)state;
    glint_journal *journal = open_journal();
    const struct glint_statement none = {.sql = "DROP TABLE front"},
                                 older = {.sql = "PRAGMA user_version=1"},
                                 fronts = {.sql = "SELECT scene, text FROM front"};
    assert_int_equal(glint_journal_commit(journal, &none, 1, NULL), GLINT_OK);
    assert_int_equal(glint_journal_read(journal, &older, NULL, NULL, NULL), GLINT_OK);
    glint_journal_destroy(&journal);
    journal = open_journal();
    assert_int_equal(glint_journal_read(journal, &fronts, NULL, NULL, NULL), GLINT_OK);
    glint_journal_destroy(&journal);
}

static void an_unknown_version_is_refused(void **state)
{
    (void)state;
    glint_journal *journal = open_journal();
    const struct glint_statement newer = {.sql = "PRAGMA user_version=99"};
    assert_int_equal(glint_journal_read(journal, &newer, NULL, NULL, NULL), GLINT_OK);
    glint_journal_destroy(&journal);
    struct glint_error err = {0};
    assert_int_equal(glint_journal_create(&journal, folder, NULL, &err), GLINT_E_CONFLICT);
    assert_null(journal);
    assert_non_null(strstr(glint_error_text(&err), "newer"));
    glint_error_finish(&err);
}

static void a_file_that_is_no_database_is_refused_and_stays(void **state)
{
    (void)state;
    char path[128], text[32] = "";
    snprintf(path, sizeof path, "%s/journal.db", folder);
    FILE *file = fopen(path, "w");
    for (int i = 0; i < 1000; i++)
        fputs("not a database", file);
    fclose(file);
    glint_journal *journal;
    struct glint_error err = {0};
    assert_int_equal(glint_journal_create(&journal, folder, NULL, &err), GLINT_E_IO);
    assert_non_null(strstr(glint_error_text(&err), "damaged"));
    glint_error_finish(&err);
    file = fopen(path, "r");
    assert_non_null(fgets(text, 15, file));
    fclose(file);
    assert_string_equal(text, "not a database");
}

static void a_missing_folder_is_told(void **state)
{
    (void)state;
    glint_journal *journal;
    assert_int_equal(glint_journal_create(&journal, "/nowhere/at/all", NULL, NULL), GLINT_E_IO);
    assert_null(journal);
}

#define WITH_FOLDER(test) cmocka_unit_test_setup_teardown(test, make_folder, remove_folder)

int main(void)
{
    const struct CMUnitTest tests[] = {
        WITH_FOLDER(what_is_committed_is_there_when_it_is_opened_again),
        WITH_FOLDER(statements_of_one_commit_hold_all_or_none),
        WITH_FOLDER(values_come_back_as_they_went),
        WITH_FOLDER(columns_of_another_kind_read_as_nothing),
        WITH_FOLDER(a_fault_undoes_nothing_of_others_in_the_same_transaction),
        WITH_FOLDER(what_the_first_version_lacks_is_added),
        WITH_FOLDER(an_unknown_version_is_refused),
        WITH_FOLDER(a_file_that_is_no_database_is_refused_and_stays),
        cmocka_unit_test(a_missing_folder_is_told),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
