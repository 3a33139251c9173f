#include "base/sha256.h"
#include "base/vault.h"

#include <setjmp.h>
#include <signal.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/resource.h>
#include <unistd.h>

#include <cmocka.h>

static char folder[64], inside[80];

static int make_folder(void **state)
{
    (void)state;
    strcpy(folder, "/tmp/glint-vault-XXXXXX");
    const bool made = mkdtemp(folder);
    snprintf(inside, sizeof inside, "%s/assets", folder);
    return made ? 0 : -1;
}

static int remove_folder(void **state)
{
    (void)state;
    char command[128];
    snprintf(command, sizeof command, "rm -rf '%s'", folder);
    return system(command);
}

static glint_vault *open_vault(void)
{
    glint_vault *vault;
    assert_int_equal(glint_vault_create(&vault, inside, NULL), GLINT_OK);
    return vault;
}

static struct glint_content content(const char *text)
{
    struct glint_content c = {.bytes = text, .size = strlen(text)};
    glint_sha256(c.bytes, c.size, c.name);
    return c;
}

static void check_there(glint_vault *vault, const struct glint_content *c)
{
    const uint8_t *bytes;
    size_t size;
    assert_int_equal(glint_vault_map(vault, c->name, &bytes, &size, NULL), GLINT_OK);
    assert_int_equal(size, c->size);
    assert_memory_equal(bytes, c->bytes, size);
    munmap((void *)bytes, size);
}

static bool is_file(const struct glint_content *c, const char *suffix)
{
    char path[256];
    snprintf(path, sizeof path, "%s/%.2s/%s%s", inside, c->name, c->name, suffix);
    return !access(path, F_OK);
}

static void what_is_put_is_read_back_and_counted(void **state)
{
    (void)state;
    glint_vault *vault = open_vault();
    const struct glint_content all[3] = {content("one"), content("two"), content("one")};
    assert_int_equal(glint_vault_put(vault, all, 3, NULL), GLINT_OK);
    check_there(vault, &all[0]);
    check_there(vault, &all[1]);
    assert_int_equal(glint_vault_bytes(vault), 6);
    assert_int_equal(glint_vault_put(vault, all, 2, NULL), GLINT_OK); // again
    assert_int_equal(glint_vault_bytes(vault), 6);
    glint_vault_destroy(&vault);
    vault = open_vault();
    check_there(vault, &all[1]);
    assert_int_equal(glint_vault_bytes(vault), 6);
    glint_vault_destroy(&vault);
}

static void what_is_not_there_is_told(void **state)
{
    (void)state;
    glint_vault *vault = open_vault();
    const uint8_t *bytes;
    size_t size;
    const struct glint_content c = content("never");
    assert_int_equal(glint_vault_map(vault, c.name, &bytes, &size, NULL), GLINT_E_NOT_FOUND);
    assert_int_equal(glint_vault_map(vault, "../../etc/passwd", &bytes, &size, NULL),
                     GLINT_E_NOT_FOUND);
    glint_vault_destroy(&vault);
}

static void a_damaged_file_is_put_aside_and_can_be_put_again(void **state)
{
    (void)state;
    glint_vault *vault = open_vault();
    const struct glint_content c = content("whole");
    assert_int_equal(glint_vault_put(vault, &c, 1, NULL), GLINT_OK);
    char path[256];
    const uint8_t *bytes;
    size_t size;
    snprintf(path, sizeof path, "%s/%.2s/%s", inside, c.name, c.name);
    assert_int_equal(truncate(path, 2), 0);
    assert_int_equal(glint_vault_map(vault, c.name, &bytes, &size, NULL), GLINT_E_IO);
    assert_false(is_file(&c, ""));
    assert_true(is_file(&c, ".torn"));
    assert_int_equal(glint_vault_put(vault, &c, 1, NULL), GLINT_OK);
    check_there(vault, &c);
    glint_vault_destroy(&vault);
}

static void what_a_kill_left_is_removed(void **state)
{
    (void)state;
    const struct glint_content c = content("half");
    char path[256];
    glint_vault *vault = open_vault();
    glint_vault_destroy(&vault);
    snprintf(path, sizeof path, "%s/%.2s/%s.new", inside, c.name, c.name);
    fclose(fopen(path, "w"));
    vault = open_vault();
    assert_false(is_file(&c, ".new"));
    glint_vault_destroy(&vault);
}

static void what_does_not_fit_leaves_nothing(void **state)
{
    (void)state;
    static char large[300000];
    glint_vault *vault = open_vault();
    memset(large, 'x', sizeof large - 1);
    const struct glint_content all[2] = {content("small"), content(large)};
    struct rlimit before, small;
    struct glint_error err = {0};
    getrlimit(RLIMIT_FSIZE, &before);
    small = (struct rlimit){100000, before.rlim_max};
    signal(SIGXFSZ, SIG_IGN);
    setrlimit(RLIMIT_FSIZE, &small);
    const glint_status st = glint_vault_put(vault, all, 2, &err);
    setrlimit(RLIMIT_FSIZE, &before);
    assert_int_equal(st, GLINT_E_CAPACITY);
    assert_non_null(strstr(glint_error_text(&err), "MiB are free"));
    glint_error_finish(&err);
    assert_false(is_file(&all[0], "") || is_file(&all[0], ".new"));
    assert_false(is_file(&all[1], "") || is_file(&all[1], ".new"));
    assert_int_equal(glint_vault_bytes(vault), 0);
    assert_int_equal(glint_vault_put(vault, all, 2, NULL), GLINT_OK);
    glint_vault_destroy(&vault);
}

static bool is_one(void *user, const char *name)
{
    return !strcmp(name, ((const struct glint_content *)user)->name);
}

static void a_sweep_removes_what_is_not_needed(void **state)
{
    (void)state;
    glint_vault *vault = open_vault();
    struct glint_content all[3] = {content("one"), content("two"), content("three")};
    assert_int_equal(glint_vault_put(vault, all, 3, NULL), GLINT_OK);
    assert_true(glint_vault_sweep(vault, all[1].name, is_one, &all[0]));
    assert_true(is_file(&all[0], "") && !is_file(&all[1], "") && is_file(&all[2], ""));
    assert_true(glint_vault_sweep(vault, NULL, is_one, &all[0]));
    assert_true(is_file(&all[0], "") && !is_file(&all[2], ""));
    assert_int_equal(glint_vault_bytes(vault), 3);
    glint_vault_destroy(&vault);
}

#define WITH_FOLDER(test) cmocka_unit_test_setup_teardown(test, make_folder, remove_folder)

int main(void)
{
    const struct CMUnitTest tests[] = {
        WITH_FOLDER(what_is_put_is_read_back_and_counted),
        WITH_FOLDER(what_is_not_there_is_told),
        WITH_FOLDER(a_damaged_file_is_put_aside_and_can_be_put_again),
        WITH_FOLDER(what_a_kill_left_is_removed),
        WITH_FOLDER(what_does_not_fit_leaves_nothing),
        WITH_FOLDER(a_sweep_removes_what_is_not_needed),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
