#include "base/folders.h"
#include "base/memory.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cmocka.h>

static char root[] = "/tmp/glint-folders-XXXXXX";

static const char *below(const char *path)
{
    static char text[4][256];
    static unsigned turn;
    char *out = text[turn++ % 4];
    snprintf(out, sizeof text[0], "%s%s", root, path);
    return out;
}

static int make_root(void **state)
{
    (void)state;
    return mkdtemp(root) ? 0 : -1;
}

static int remove_root(void **state)
{
    (void)state;
    char command[128];
    snprintf(command, sizeof command, "rm -rf '%s'", root);
    return system(command);
}

static int clear(void **state)
{
    (void)state;
    static const char *const name[] = {"STATE_DIRECTORY", "CACHE_DIRECTORY", "XDG_STATE_HOME",
                                       "XDG_CACHE_HOME", "HOME"};
    for (size_t i = 0; i < sizeof name / sizeof *name; i++)
        unsetenv(name[i]);
    return 0;
}

static void assert_state(const char *wanted, const char *expected)
{
    char *folder;
    struct stat made;
    assert_int_equal(glint_folder_state(&folder, wanted, NULL), GLINT_OK);
    assert_string_equal(folder, expected);
    assert_int_equal(stat(folder, &made), 0);
    assert_true(S_ISDIR(made.st_mode));
    assert_int_equal(made.st_mode & 027, 0); // others: nothing; group: no writing
    free(folder);
}

static void the_state_folder_is_the_first_that_is_named(void **state)
{
    (void)state;
    setenv("HOME", below("/home"), 1);
    assert_state(NULL, below("/home/.local/state/glint"));
    setenv("XDG_STATE_HOME", below("/xdg"), 1);
    assert_state(NULL, below("/xdg/glint"));
    setenv("STATE_DIRECTORY", below("/service:/tmp/second"), 1);
    assert_state(NULL, below("/service"));
    assert_state(below("/a/b/c"), below("/a/b/c"));
    assert_state(below("/a/b/c"), below("/a/b/c")); // again: it exists by now
}

static void without_any_name_there_is_no_state(void **state)
{
    (void)state;
    char *folder;
    struct glint_error err = {0};
    assert_int_equal(glint_folder_state(&folder, NULL, &err), GLINT_E_IO);
    assert_null(folder);
    assert_int_equal(err.count, 1);
    glint_error_finish(&err);
}

static void a_file_in_the_way_is_named(void **state)
{
    (void)state;
    char *folder;
    struct glint_error err = {0};
    FILE *file = fopen(below("/file"), "w");
    assert_non_null(file);
    fclose(file);
    assert_int_equal(glint_folder_state(&folder, below("/file/below"), &err), GLINT_E_IO);
    assert_null(folder);
    assert_non_null(strstr(glint_error_text(&err), "/file/below"));
    glint_error_finish(&err);
}

static void the_cache_goes_into_the_state_where_it_has_no_place_of_its_own(void **state)
{
    (void)state;
    char *folder;
    assert_int_equal(glint_folder_cache(&folder, below("/s"), NULL), GLINT_OK);
    assert_string_equal(folder, below("/s/cache"));
    free(folder);
    setenv("HOME", "/proc/self", 1); // nobody can write there
    assert_int_equal(glint_folder_cache(&folder, below("/s"), NULL), GLINT_OK);
    assert_string_equal(folder, below("/s/cache"));
    free(folder);
    setenv("XDG_CACHE_HOME", below("/c"), 1);
    assert_int_equal(glint_folder_cache(&folder, below("/s"), NULL), GLINT_OK);
    assert_string_equal(folder, below("/c/glint"));
    free(folder);
}

static void memory_is_no_more_than_the_machine_has(void **state)
{
    (void)state;
    const uint64_t pages = (uint64_t)sysconf(_SC_PHYS_PAGES);
    const uint64_t total = glint_memory_total();
    assert_true(total <= pages * (uint64_t)sysconf(_SC_PAGESIZE));
    assert_true(total > 1u << 20); // this test alone needs more
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup(the_state_folder_is_the_first_that_is_named, clear),
        cmocka_unit_test_setup(without_any_name_there_is_no_state, clear),
        cmocka_unit_test_setup(a_file_in_the_way_is_named, clear),
        cmocka_unit_test_setup(the_cache_goes_into_the_state_where_it_has_no_place_of_its_own,
                               clear),
        cmocka_unit_test(memory_is_no_more_than_the_machine_has),
    };
    return cmocka_run_group_tests(tests, make_root, remove_root);
}
