// In which order a film file comes to the disk: the calls that decide it are recorded.
#include "jobs/checkpoint_file.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>
#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#define JOB "0123456789abcdef0123456789abcdef"

static char folder[] = "/tmp/glint-film-XXXXXX", calls[64];
static const char *broken; // the call that fails, NULL: none

static int record(const char *call)
{
    strncat(calls, call, sizeof calls - strlen(calls) - 1);
    errno = EIO;
    return broken && !strcmp(call, broken) ? -1 : 0;
}

glint_status __wrap_glint_render_film(glint_render *r, int fd, struct glint_error *err)
{
    (void)r;
    record("write ");
    return write(fd, "film", 4) == 4 ? GLINT_OK : glint_fail(err, GLINT_E_IO, "", "no film");
}

int __real_fsync(int fd);
int __wrap_fsync(int fd)
{
    struct stat s;
    if (fstat(fd, &s))
        return -1;
    return record(S_ISDIR(s.st_mode) ? "sync-folder " : "sync ") ? -1 : __real_fsync(fd);
}

int __real_rename(const char *from, const char *to);
int __wrap_rename(const char *from, const char *to)
{
    return record("rename ") ? -1 : __real_rename(from, to);
}

static const struct glint_checkpoint_file file = {folder, JOB, 7};

static glint_status write_film(const char *breaks)
{
    uint64_t bytes;
    struct glint_error err = {0};
    *calls = '\0';
    broken = breaks;
    const glint_status st = glint_checkpoint_file_write(&file, NULL, &bytes, &err);
    if (!st)
        assert_int_equal(bytes, 4);
    glint_error_finish(&err);
    return st;
}

static void a_film_is_on_the_disk_before_it_has_its_name(void **state)
{
    (void)state;
    assert_int_equal(write_film(NULL), GLINT_OK);
    assert_string_equal(calls, "write sync rename sync-folder ");
    assert_int_equal(glint_checkpoint_file_bytes(&file), 4);
}

static void a_film_that_could_not_be_synced_gets_no_name(void **state)
{
    (void)state;
    glint_checkpoint_file_remove(&file);
    assert_int_equal(write_film("sync "), GLINT_E_IO);
    assert_string_equal(calls, "write sync ");
    assert_int_equal(glint_checkpoint_file_bytes(&file), 0);
}

static void a_name_that_is_not_on_the_disk_is_a_fault(void **state)
{
    (void)state;
    assert_int_equal(write_film("sync-folder "), GLINT_E_IO);
    assert_int_equal(write_film("rename "), GLINT_E_IO);
}

static int make_folder(void **state)
{
    (void)state;
    return mkdtemp(folder) ? 0 : -1;
}

static int remove_folder(void **state)
{
    (void)state;
    glint_checkpoint_file_remove(&file);
    return rmdir(folder);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_film_is_on_the_disk_before_it_has_its_name),
        cmocka_unit_test(a_film_that_could_not_be_synced_gets_no_name),
        cmocka_unit_test(a_name_that_is_not_on_the_disk_is_a_fault),
    };
    return cmocka_run_group_tests(tests, make_folder, remove_folder);
}
