#include "base/sha256.h"
#include "scene/assets.h"
#include "scene/form.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>
#include <pthread.h>
#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static atomic_int freed;

static void count(void *base, size_t bytes)
{
    (void)bytes;
    free(base);
    atomic_fetch_add(&freed, 1);
}

static glint_memory_ref *memory_of(const char *text, struct glint_asset *asset)
{
    char *copy = strdup(text);
    asset->bytes = (uint8_t *)copy;
    asset->size = strlen(text);
    glint_sha256(copy, asset->size, asset->sha256);
    return glint_memory_ref_create(copy, asset->size, count);
}

// Puts it as a client does; false where it was there.
static glint_status put(glint_assets *assets, const char *text, bool *created,
                        struct glint_error *err)
{
    struct glint_asset asset;
    glint_memory_ref *memory = memory_of(text, &asset);
    const glint_status st = glint_assets_put(assets, &asset, memory, created, err);
    glint_memory_ref_release(&memory);
    return st;
}

static glint_asset_ref *add(glint_assets *assets, const char *text)
{
    struct glint_asset asset;
    glint_asset_ref *ref;
    glint_memory_ref *memory = memory_of(text, &asset);
    assert_int_equal(glint_assets_add(assets, &asset, memory, &ref, NULL), GLINT_OK);
    glint_memory_ref_release(&memory);
    return ref;
}

static glint_assets *open_store(uint64_t limit)
{
    glint_assets *assets;
    atomic_store(&freed, 0);
    assert_int_equal(glint_assets_create(&assets, limit, NULL), GLINT_OK);
    return assets;
}

static void equal_bytes_are_kept_once(void **state)
{
    (void)state;
    glint_assets *assets = open_store(100);
    glint_asset_ref *a = add(assets, "hello"), *b = add(assets, "hello");
    struct glint_assets_stats stats;
    assert_ptr_equal(a, b);
    assert_int_equal(atomic_load(&freed), 1); // the second's memory
    glint_assets_stats(assets, &stats);
    assert_int_equal(stats.count, 1);
    assert_int_equal(stats.bytes, 5);
    assert_int_equal(stats.put_bytes, 0);
    glint_asset_ref_release(&a);
    glint_asset_ref *found = glint_assets_find(assets, glint_asset_ref_bytes(b)->sha256);
    assert_ptr_equal(found, b);
    glint_asset_ref_release(&found);
    glint_asset_ref_release(&b);
    assert_int_equal(atomic_load(&freed), 2); // nobody refers to it any more
    glint_assets_stats(assets, &stats);
    assert_int_equal(stats.count, 0);
    glint_assets_destroy(&assets);
}

static void what_a_client_puts_stays_without_a_scene(void **state)
{
    (void)state;
    glint_assets *assets = open_store(100);
    struct glint_assets_stats stats;
    bool created;
    assert_int_equal(put(assets, "hello", &created, NULL), GLINT_OK);
    assert_true(created);
    assert_int_equal(put(assets, "hello", &created, NULL), GLINT_OK);
    assert_false(created);
    glint_asset_ref *ref = add(assets, "hello");
    glint_assets_stats(assets, &stats);
    assert_int_equal(stats.put_bytes, 5);
    assert_int_equal(stats.idle_bytes, 0);
    glint_asset_ref_release(&ref);
    glint_assets_stats(assets, &stats);
    assert_int_equal(stats.idle_bytes, 5);
    glint_assets_destroy(&assets);
    assert_int_equal(atomic_load(&freed), 3);
}

static void the_limit_is_told_with_figures(void **state)
{
    (void)state;
    glint_assets *assets = open_store(10);
    struct glint_error err = {0};
    bool created;
    assert_int_equal(put(assets, "12345", &created, NULL), GLINT_OK);
    assert_int_equal(put(assets, "123456", &created, &err), GLINT_E_CAPACITY);
    assert_non_null(strstr(err.fault[0].detail, "6 bytes do not fit: 1 assets hold 5 of 10 bytes"));
    glint_error_finish(&err);
    glint_asset_ref *used = add(assets, "an import's own is not counted");
    assert_int_equal(put(assets, "54321", &created, NULL), GLINT_OK); // exactly full
    assert_int_equal(put(assets, "01234567890", &created, NULL), GLINT_E_CAPACITY);
    glint_asset_ref_release(&used);
    glint_assets_destroy(&assets);
}

static void nothing(void *base, size_t bytes)
{
    (void)base;
    (void)bytes;
}

// Bytes that nobody reads, under the name of a number.
static glint_status put_numbered(glint_assets *assets, unsigned number, size_t size,
                                 struct glint_error *err)
{
    static uint8_t bytes[1];
    struct glint_asset asset = {.bytes = bytes, .size = size};
    bool created;
    snprintf(asset.sha256, sizeof asset.sha256, "%04x%060x", number & 0xffff, number);
    glint_memory_ref *memory = glint_memory_ref_create(bytes, size, nothing);
    const glint_status st = glint_assets_put(assets, &asset, memory, &created, err);
    glint_memory_ref_release(&memory);
    return st;
}

static void no_more_large_ones_are_held_than_there_are_mappings_for(void **state)
{
    (void)state;
    glint_assets *assets = open_store(UINT64_MAX);
    struct glint_error err = {0};
    unsigned n = 0;
    for (; n < GLINT_MOST_LARGE_ASSETS; n++)
        assert_int_equal(put_numbered(assets, n, GLINT_LARGE_ASSET_BYTES, NULL), GLINT_OK);
    assert_int_equal(put_numbered(assets, n, GLINT_LARGE_ASSET_BYTES, &err), GLINT_E_CAPACITY);
    assert_non_null(strstr(err.fault[0].detail, "32768 are held"));
    glint_error_finish(&err);
    assert_int_equal(put_numbered(assets, n, GLINT_LARGE_ASSET_BYTES - 1, NULL), GLINT_OK);
    glint_assets_unput(assets, "0000000000000000000000000000000000000000000000000000000000000000");
    assert_int_equal(put_numbered(assets, n + 1, GLINT_LARGE_ASSET_BYTES, NULL), GLINT_OK);
    glint_assets_destroy(&assets);
}

static void a_text_names_its_assets_once_each(void **state)
{
    (void)state;
    glint_assets *assets = open_store(100);
    glint_asset_ref *a = add(assets, "a"), *b = add(assets, "b");
    const char *name = glint_asset_ref_bytes(a)->sha256;
    char text[600];
    const int length =
        snprintf(text, sizeof text, "{\"x\":\"%s\",\"y\":\"%s\",\"z\":\"%.63s\",\"%s0\":\"%064d\"}",
                 name, name, name, glint_asset_ref_bytes(b)->sha256, 0);
    struct glint_asset_set set;
    assert_int_equal(glint_assets_gather(assets, text, (size_t)length, &set, NULL), GLINT_OK);
    assert_int_equal(set.count, 1);
    assert_string_equal(set.asset[0].sha256, name);
    glint_asset_ref_release(&a);
    glint_asset_ref_release(&b);
    assert_int_equal(atomic_load(&freed), 1); // the set holds the first
    glint_asset_set_release(&set);
    assert_int_equal(atomic_load(&freed), 2);
    for (int n = 0; n <= length; n++) { // whatever is cut
        char *cut = malloc((size_t)n + 1);
        memcpy(cut, text, (size_t)n);
        assert_int_equal(glint_assets_gather(assets, cut, (size_t)n, &set, NULL), GLINT_OK);
        assert_int_equal(set.count, 0);
        free(cut);
    }
    glint_assets_destroy(&assets);
}

static void *use(void *user)
{
    glint_assets *assets = user;
    for (int i = 0; i < 2000; i++) {
        char text[16];
        snprintf(text, sizeof text, "%d", i % 7);
        glint_asset_ref *ref = add(assets, text);
        glint_asset_ref *more = glint_asset_ref_retain(ref);
        glint_asset_ref_release(&ref);
        assert_int_equal(glint_asset_ref_bytes(more)->bytes[0], text[0]);
        glint_asset_ref_release(&more);
    }
    return NULL;
}

static void threads_add_and_release_at_once(void **state)
{
    (void)state;
    glint_assets *assets = open_store(100);
    struct glint_assets_stats stats;
    pthread_t thread[4];
    for (int i = 0; i < 4; i++)
        assert_int_equal(pthread_create(&thread[i], NULL, use, assets), 0);
    for (int i = 0; i < 4; i++)
        pthread_join(thread[i], NULL);
    glint_assets_stats(assets, &stats);
    assert_int_equal(stats.count, 0);
    assert_int_equal(atomic_load(&freed), 8000);
    glint_assets_destroy(&assets);
}

// ---- forms

#define PART(NAME, BODY)                                                                   \
    "--B\r\nContent-Type: a/b\r\ncontent-disposition: form-data; name=x; filename=\"" NAME \
    "\"\r\n\r\n" BODY "\r\n"

static glint_status read_form(struct glint_files *files, struct glint_arena *arena,
                              const char *text, struct glint_error *err)
{
    return glint_form_read(files, arena, "B", (const uint8_t *)text, strlen(text), err);
}

static void parts_become_files(void **state)
{
    (void)state;
    struct glint_arena arena = {0};
    struct glint_files files;
    static const char text[] = "preamble\r\n" PART(".\\tex\\a \\\"b\\\".png", "\r\n--A\r\n")
        PART("empty", "") PART("B", "-B") "--B--\r\nepilogue";
    assert_int_equal(read_form(&files, &arena, text, NULL), GLINT_OK);
    assert_int_equal(files.count, 3);
    assert_string_equal(files.file[0].name, "tex/a \"b\".png");
    assert_int_equal(files.file[0].size, 7);
    assert_memory_equal(files.file[0].bytes, "\r\n--A\r\n", 7);
    assert_int_equal(files.file[1].size, 0);
    assert_memory_equal(files.file[2].bytes, "-B", 2);
    assert_ptr_equal(glint_files_find(&files, "B"), &files.file[2]);
    assert_ptr_equal(glint_files_find_uri(&files, "x/../y/EMPTY"), &files.file[1]);
    assert_null(glint_files_find_uri(&files, "../empty"));
    assert_null(glint_files_find_uri(&files, "x/../../empty"));
    assert_null(glint_files_find_uri(&files, "%2e%2e/empty"));
    assert_null(glint_files_find_uri(&files, "file://empty"));
    assert_null(glint_files_find_uri(&files, "/empty"));
    assert_null(glint_files_find_uri(&files, "empty%00"));
    assert_null(glint_files_find_uri(&files, ""));
    glint_arena_finish(&arena);
}

static void every_cut_of_a_form_is_refused(void **state)
{
    (void)state;
    static const char text[] = PART("a", "1") PART("b", "2") "--B--";
    for (size_t n = 0; n < sizeof text - 1; n++) {
        struct glint_arena arena = {0};
        struct glint_files files;
        struct glint_error err = {0};
        uint8_t *cut = malloc(n + 1);
        memcpy(cut, text, n);
        assert_int_equal(glint_form_read(&files, &arena, "B", cut, n, &err), GLINT_E_SYNTAX);
        free(cut);
        glint_error_finish(&err);
        glint_arena_finish(&arena);
    }
}

static void parts_that_are_no_files_are_refused(void **state)
{
    (void)state;
    static const struct {
        const char *text, *words;
    } bad[] = {
        {"--B\r\n\r\nx\r\n--B--", "no filename"},
        {"--B\r\nContent-Disposition: form-data; name=\"filename=a\"\r\n\r\nx\r\n--B--",
         "no filename"},
        {PART("", "x") "--B--", "no filename"},
        {PART("a", "1") PART("./a", "2") "--B--", "part 2 of the form: a file of this name"},
        {"--Bx\r\n\r\n\r\n--B--", "does not end its line"},
        {"--B--", "part 1 of the form: there is none"},
        {"x", "is nowhere in the body"},
    };
    for (size_t i = 0; i < sizeof bad / sizeof *bad; i++) {
        struct glint_arena arena = {0};
        struct glint_files files;
        struct glint_error err = {0};
        assert_int_equal(read_form(&files, &arena, bad[i].text, &err), GLINT_E_SYNTAX);
        if (!strstr(err.fault[0].detail, bad[i].words))
            fail_msg("\"%s\" does not say \"%s\"", err.fault[0].detail, bad[i].words);
        glint_error_finish(&err);
        glint_arena_finish(&arena);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(equal_bytes_are_kept_once),
        cmocka_unit_test(what_a_client_puts_stays_without_a_scene),
        cmocka_unit_test(the_limit_is_told_with_figures),
        cmocka_unit_test(no_more_large_ones_are_held_than_there_are_mappings_for),
        cmocka_unit_test(a_text_names_its_assets_once_each),
        cmocka_unit_test(threads_add_and_release_at_once),
        cmocka_unit_test(parts_become_files),
        cmocka_unit_test(every_cut_of_a_form_is_refused),
        cmocka_unit_test(parts_that_are_no_files_are_refused),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
