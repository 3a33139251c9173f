#include "scene/import.h"
#include "scene/import_jail.h"
#include "tests/unit/glb_maker.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>
#include <errno.h>
#include <fcntl.h>
#include <pthread.h>
#include <seccomp.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>
#include <zlib.h>

// Out of memory is something to be answered, under a sanitizer too.
const char *__asan_default_options(void);
const char *__asan_default_options(void)
{
    return "allocator_may_return_null=1";
}
const char *__tsan_default_options(void);
const char *__tsan_default_options(void)
{
    return "allocator_may_return_null=1";
}

#define NODE "'scenes':[{'nodes':[0]}],'nodes':[{'name':'n','mesh':0}]"

static glint_importer *importer; // one for all tests: each finds the helper alive

static int start(void **state)
{
    (void)state;
    return (int)glint_importer_create(&importer, NULL);
}

static int stop(void **state)
{
    (void)state;
    glint_importer_destroy(&importer);
    return importer != NULL;
}

static glint_status run(enum glint_scene_type type, const void *bytes, size_t size,
                        const struct glint_import_limits *limits, struct glint_import **out,
                        struct glint_error *err)
{
    const struct glint_import_source source = {.type = type, .bytes = bytes, .size = size};
    return glint_import_run(importer, &source, limits, out, err);
}

static void imports_a_square(void)
{
    size_t size;
    uint8_t *glb = glb_quad(GLB_QUAD_MESH "," NODE, &size);
    struct glint_import *im;
    struct glint_scene *scene;
    struct glint_error err = {0};
    if (run(GLINT_SCENE_GLB, glb, size, NULL, &im, &err))
        fail_msg("%s", glint_error_text(&err));
    assert_int_equal(glint_scene_parse(&scene, im->text, im->length, im->asset, im->assets, &err),
                     GLINT_OK);
    assert_int_equal(scene->instances, 1);
    assert_int_equal(scene->mesh[0].triangles, 2);
    assert_memory_equal(scene->mesh[0].position, glb_quad_data.position, 48);
    glint_scene_destroy(&scene);
    glint_import_destroy(&im);
    free(glb);
}

static void refused(enum glint_scene_type type, const void *bytes, size_t size,
                    const struct glint_import_limits *limits, glint_status status,
                    const char *pointer, const char *word)
{
    struct glint_import *im;
    struct glint_error err = {0};
    const glint_status st = run(type, bytes, size, limits, &im, &err);
    if (st != status)
        fail_msg("status %d: %s", st, glint_error_text(&err));
    assert_null(im);
    assert_string_equal(err.fault[0].pointer, pointer);
    if (!strstr(err.fault[0].detail, word))
        fail_msg("\"%s\" does not say \"%s\"", err.fault[0].detail, word);
    glint_error_finish(&err);
}

static void a_glb_comes_back_as_native_text_and_assets(void **state)
{
    (void)state;
    imports_a_square();
}

static void camera_and_emitter_are_added_with_warnings(void **state)
{
    (void)state;
    size_t size;
    uint8_t *glb = glb_quad(GLB_QUAD_MESH "," NODE, &size);
    struct glint_import *im;
    struct glint_scene *scene;
    assert_int_equal(run(GLINT_SCENE_GLB, glb, size, NULL, &im, NULL), GLINT_OK);
    assert_int_equal(im->warnings, 2);
    assert_int_equal(glint_scene_parse(&scene, im->text, im->length, im->asset, im->assets, NULL),
                     GLINT_OK);
    assert_int_equal(scene->cameras, 1);
    assert_true(scene->has_environment);
    assert_int_equal(scene->warnings, 0); // the text has them now
    glint_scene_destroy(&scene);
    glint_import_destroy(&im);
    free(glb);
}

static void equal_files_give_equal_text(void **state)
{
    (void)state;
    size_t size;
    uint8_t *glb = glb_quad(GLB_QUAD_MESH "," NODE, &size);
    struct glint_import *a, *b;
    assert_int_equal(run(GLINT_SCENE_GLB, glb, size, NULL, &a, NULL), GLINT_OK);
    assert_int_equal(run(GLINT_SCENE_GLB, glb, size, NULL, &b, NULL), GLINT_OK);
    assert_string_equal(a->text, b->text);
    assert_int_equal(a->assets, b->assets);
    glint_import_destroy(&a);
    glint_import_destroy(&b);
    free(glb);
}

static void faults_come_back_with_their_pointers(void **state)
{
    (void)state;
    size_t size;
    uint8_t *glb = glb_quad("'materials':[{'pbrMetallicRoughness':{'metallicFactor':2}}]", &size);
    refused(GLINT_SCENE_GLB, glb, size, NULL, GLINT_E_RANGE,
            "/materials/0/pbrMetallicRoughness/metallicFactor", "2 is outside");
    refused(GLINT_SCENE_GLB, glb, size - 1, NULL, GLINT_E_SYNTAX, "", "header says");
    refused(GLINT_SCENE_GLB, "", 0, NULL, GLINT_E_SYNTAX, "", "0 of 12");
    refused(GLINT_SCENE_NATIVE, "{\"mesh\":{}}", 11, NULL, GLINT_E_RANGE, "/mesh", "mesh");
    refused(GLINT_SCENE_NATIVE, "{", 1, NULL, GLINT_E_SYNTAX, "", "line 1");
    refused(GLINT_SCENE_NATIVE, "", 0, NULL, GLINT_E_SYNTAX, "", "");
    free(glb);
    imports_a_square();
}

// --- native scenes

#define NATIVE(IMAGE)                                                                   \
    "{\"images\":{\"a/b\":{" IMAGE                                                      \
    "}},\"materials\":{\"m\":{\"base_color_texture\":{\"image\":\"a/b\"}}},"            \
    "\"meshes\":{\"q\":{\"primitive\":\"quad\"}},\"instances\":{\"i\":{\"mesh\":\"q\"," \
    "\"material\":\"m\"}}}"
#define RED                                                                                      \
    "\"data\":\"data:image/png;base64,iVBORw0KGgoAAAANSUhEUgAAAAEAAAABCAIAAACQd1PeAAAADElEQVR4n" \
    "GP4z8AAAAMBAQDJ/pLvAAAAAElFTkSuQmCC\""

static void pictures_in_native_text_become_assets(void **state)
{
    (void)state;
    static const char text[] = NATIVE(RED);
    struct glint_import *im;
    struct glint_scene *s;
    struct glint_error err = {0};
    if (run(GLINT_SCENE_NATIVE, text, strlen(text), NULL, &im, &err))
        fail_msg("%s", glint_error_text(&err));
    assert_null(strstr(im->text, "data:"));
    assert_int_equal(glint_scene_parse(&s, im->text, im->length, im->asset, im->assets, NULL),
                     GLINT_OK);
    assert_int_equal(s->image[0].width, 1);
    assert_memory_equal(s->image[0].pixels, "\xff\0\0\xff", 4);
    assert_int_equal(s->material[0].base_color_texture.image, 0);
    glint_scene_destroy(&s);
    glint_import_destroy(&im);
}

static void bad_pictures_are_refused_at_their_pointer(void **state)
{
    (void)state;
    static const char text[] = NATIVE("\"data\":\"data:,hello\"");
    static const char both[] = NATIVE("\"asset\":\"0\"," RED);
    static const char more[] = NATIVE("\"colour\":1," RED);
    refused(GLINT_SCENE_NATIVE, text, strlen(text), NULL, GLINT_E_RANGE, "/images/a~1b/data",
            "not PNG");
    refused(GLINT_SCENE_NATIVE, both, strlen(both), NULL, GLINT_E_RANGE, "/images/a~1b/data",
            "either");
    refused(GLINT_SCENE_NATIVE, more, strlen(more), NULL, GLINT_E_RANGE, "/images/a~1b/colour",
            "colour");
}

// --- limits

static void put_be(uint8_t *at, size_t value)
{
    for (int i = 0; i < 4; i++)
        at[i] = (uint8_t)(value >> (24 - 8 * i));
}

static size_t chunk(uint8_t *at, const char *type, const uint8_t *data, size_t bytes)
{
    put_be(at, bytes);
    memcpy(at + 4, type, 4);
    memcpy(at + 8, data, bytes);
    put_be(at + 8 + bytes, crc32(0, at + 4, (uInt)bytes + 4));
    return bytes + 12;
}

// A GLB with three pictures of side x side grey pixels, one bit each, all black.
static uint8_t *large_pictures(uint32_t side, size_t *size)
{
    const size_t raw_bytes = (size_t)side * ((side + 7) / 8 + 1);
    uLongf packed_bytes = compressBound(raw_bytes);
    uint8_t *raw = calloc(1, raw_bytes), *packed = malloc(packed_bytes);
    assert_int_equal(compress(packed, &packed_bytes, raw, raw_bytes), Z_OK);
    uint8_t *png = calloc(1, packed_bytes + 64), header[13] = {0};
    put_be(header, side);
    put_be(header + 4, side);
    header[8] = 1;
    memcpy(png, "\x89PNG\r\n\x1a\n", 8);
    size_t n = 8 + chunk(png + 8, "IHDR", header, 13);
    n += chunk(png + n, "IDAT", packed, packed_bytes);
    n += chunk(png + n, "IEND", (const uint8_t *)"", 0);
    char json[800];
    snprintf(json, sizeof json,
             "{'asset':{'version':'2.0'},'buffers':[{'byteLength':%zu}],'bufferViews':[{'buffer':0,"
             "'byteLength':%zu}],'images':[{'bufferView':0},{'bufferView':0},{'bufferView':0}],"
             "'textures':[{'source':0},{'source':1},{'source':2}],'materials':[{'emissiveTexture':{"
             "'index':0}},{'emissiveTexture':{'index':1}},{'emissiveTexture':{'index':2}}]}",
             n, n);
    uint8_t *glb = glb_make(json, png, n, size);
    free(png);
    free(packed);
    free(raw);
    return glb;
}

static void too_little_memory_refuses_the_file_and_says_so(void **state)
{
    (void)state;
    size_t size;
    uint8_t *glb = large_pictures(4096, &size); // 64 MiB of pixels each
    const struct glint_import_limits limits = {.memory_bytes = (size_t)32 << 20};
    refused(GLINT_SCENE_GLB, glb, size, &limits, GLINT_E_RANGE, "", "32 MiB");
    free(glb);
    imports_a_square();
}

static void too_large_a_scene_from_a_small_file_is_refused(void **state)
{
    (void)state;
#ifdef __SANITIZE_THREAD__
    skip(); // its own allocator ends the process
#endif
    // A million vertices from a few bytes: text is small, the asset is not.
    static const char text[] =
        "{\"materials\":{\"m\":{}},\"meshes\":{\"s\":{\"primitive\":\"sphere\",\"segments\":1024}},"
        "\"instances\":{\"i\":{\"mesh\":\"s\",\"material\":\"m\"}}}";
    const struct glint_import_limits limits = {.memory_bytes = (size_t)16 << 20};
    refused(GLINT_SCENE_NATIVE, text, strlen(text), &limits, GLINT_E_RANGE, "", "16 MiB");
    imports_a_square();
}

static void too_much_processor_time_refuses_the_file_and_says_so(void **state)
{
    (void)state;
    size_t size;
    uint8_t *glb = large_pictures(11000, &size); // 1.4 GB of pixels; the limit is rounded to 1 s
    const struct glint_import_limits limits = {.cpu_seconds = 0.01};
    refused(GLINT_SCENE_GLB, glb, size, &limits, GLINT_E_RANGE, "", "took longer than the 0.01 s");
    free(glb);
    imports_a_square();
}

// --- ends that a file could bring about

// The first child of a process, or 0.
static pid_t child_of(pid_t pid)
{
    char path[80], text[64] = "";
    snprintf(path, sizeof path, "/proc/%d/task/%d/children", pid, pid);
    FILE *f = fopen(path, "r");
    if (f && !fgets(text, sizeof text, f))
        text[0] = '\0';
    if (f)
        fclose(f);
    return (pid_t)strtol(text, NULL, 10);
}

struct slow {
    pthread_t thread;
    uint8_t *glb;
    size_t size;
    glint_status status;
    struct glint_error err;
};

static void *import_slowly(void *user)
{
    struct slow *s = user;
    struct glint_import *im;
    s->status = run(GLINT_SCENE_GLB, s->glb, s->size, NULL, &im, &s->err);
    glint_import_destroy(&im);
    return NULL;
}

static void a_killed_child_is_explained(int signal, const char *word)
{
    struct slow s = {0};
    s.glb = large_pictures(8000, &s.size);
    pid_t child = 0;
    assert_int_equal(pthread_create(&s.thread, NULL, import_slowly, &s), 0);
    while (!child)
        child = child_of(child_of(getpid()));
    kill(child, signal);
    pthread_join(s.thread, NULL);
    assert_int_equal(s.status, GLINT_E_RANGE);
    assert_string_equal(s.err.fault[0].pointer, "");
    if (!strstr(s.err.fault[0].detail, word))
        fail_msg("\"%s\" does not say \"%s\"", s.err.fault[0].detail, word);
    glint_error_finish(&s.err);
    free(s.glb);
    imports_a_square();
}

static void a_crash_is_the_fault_of_the_file(void **state)
{
    (void)state;
    a_killed_child_is_explained(SIGSEGV, "crashed on this file (Segmentation fault)");
}

static void a_kill_is_told_from_a_crash(void **state)
{
    (void)state;
    a_killed_child_is_explained(SIGKILL, "want of memory");
}

static void many_threads_import_at_once(void **state)
{
    (void)state;
    struct slow s[20] = {0}; // more than the helper has children
    for (int i = 0; i < 20; i++) {
        s[i].glb = glb_quad(GLB_QUAD_MESH "," NODE, &s[i].size);
        assert_int_equal(pthread_create(&s[i].thread, NULL, import_slowly, &s[i]), 0);
    }
    for (int i = 0; i < 20; i++) {
        pthread_join(s[i].thread, NULL);
        assert_int_equal(s[i].status, GLINT_OK);
        free(s[i].glb);
    }
}

static void without_its_helper_an_import_fails_and_does_not_wait(void **state)
{
    (void)state;
    glint_importer *lost;
    struct glint_import *im;
    struct glint_error err = {0};
    const pid_t first = child_of(getpid());
    assert_int_equal(glint_importer_create(&lost, NULL), GLINT_OK);
    assert_true(glint_importer_lives(lost));
    pid_t pids[2] = {0};
    char path[80];
    snprintf(path, sizeof path, "/proc/self/task/%d/children", getpid());
    FILE *f = fopen(path, "r");
    assert_int_equal(fscanf(f, "%d %d", &pids[0], &pids[1]), 2);
    fclose(f);
    kill(pids[0] == first ? pids[1] : pids[0], SIGKILL);
    assert_int_equal(glint_import_run(lost,
                                      &(struct glint_import_source){.type = GLINT_SCENE_GLB,
                                                                    .bytes = (const uint8_t *)"x",
                                                                    .size = 1},
                                      NULL, &im, &err),
                     GLINT_E_INTERNAL);
    assert_string_equal(err.fault[0].detail, "the import helper is gone");
    assert_false(glint_importer_lives(lost));
    glint_error_finish(&err);
    glint_importer_destroy(&lost);
}

// --- the jail

static const struct glint_import_limits jail = {.memory_bytes = (size_t)64 << 20, .cpu_seconds = 1};

// Runs in a jailed child; returns its wait status.
static int jailed(int (*body)(void))
{
    const pid_t parent = getpid(), pid = fork();
    if (pid == 0)
        _exit(glint_jail_enter(&jail, parent) ? body() : 99);
    int status;
    assert_int_equal(waitpid(pid, &status, 0), pid);
    return status;
}

static int opens_a_file(void)
{
    return open("/dev/null", O_RDONLY) < 0 && errno == EACCES ? 0 : 1;
}

static int opens_a_socket(void)
{
    return socket(AF_INET, SOCK_STREAM, 0) >= 0;
}

static int forks(void)
{
    return fork() < 0;
}

static int signals_its_parent(void)
{
    return kill(getppid(), 0);
}

static int makes_executable_memory(void)
{
    return mmap(NULL, 4096, PROT_READ | PROT_EXEC, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0) ==
           MAP_FAILED;
}

static int takes_too_much(void)
{
    const size_t part = (size_t)48 << 20; // the first fits, two do not
    const bool first =
        mmap(NULL, part, PROT_READ, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0) != MAP_FAILED;
    const bool second =
        mmap(NULL, part, PROT_READ, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0) != MAP_FAILED;
    return first && !second ? 0 : 1;
}

static int loops(void)
{
    for (volatile unsigned i = 0;; i++) {
    }
    return 0;
}

static int aborts(void)
{
    abort();
}

static void the_jail_lets_nothing_in_or_out(void **state)
{
    (void)state;
    assert_int_equal(jailed(opens_a_file), 0);
    assert_int_equal(WTERMSIG(jailed(opens_a_socket)), SIGSYS);
    assert_int_equal(WTERMSIG(jailed(forks)), SIGSYS);
    assert_int_equal(WTERMSIG(jailed(signals_its_parent)), SIGSYS);
    assert_int_equal(WTERMSIG(jailed(makes_executable_memory)), SIGSYS);
}

static void the_jail_bounds_memory_and_time(void **state)
{
    (void)state;
    assert_int_equal(jailed(takes_too_much), 0);
    assert_int_equal(WTERMSIG(jailed(loops)), SIGXCPU);
}

static void an_abort_in_the_jail_is_an_abort(void **state)
{
    (void)state;
    assert_int_equal(WTERMSIG(jailed(aborts)), SIGABRT);
}

// As under a unit with SystemCallFilter=@system-service and SystemCallErrorNumber=EPERM.
static bool deny_seccomp(void)
{
    scmp_filter_ctx filter = seccomp_init(SCMP_ACT_ALLOW);
    return prctl(PR_SET_NO_NEW_PRIVS, 1, 0, 0, 0) == 0 &&
           seccomp_rule_add(filter, SCMP_ACT_ERRNO(EPERM), SCMP_SYS(seccomp), 0) == 0 &&
           seccomp_rule_add(filter, SCMP_ACT_ERRNO(EPERM), SCMP_SYS(setrlimit), 0) == 0 &&
           seccomp_load(filter) == 0;
}

// In a process of its own: libseccomp asks the kernel only once what it offers.
static int denied_main(void)
{
    const int socket = jailed(opens_a_socket), file = jailed(opens_a_file);
    return WIFSIGNALED(socket) && WTERMSIG(socket) == SIGSYS && file == 0 ? 0 : 1;
}

static void the_jail_holds_under_a_service_manager_that_denies_seccomp(void **state)
{
    (void)state;
    const pid_t pid = fork();
    if (pid == 0) {
        if (deny_seccomp())
            execl("/proc/self/exe", "test_import", "--denied", NULL);
        _exit(2);
    }
    int status;
    waitpid(pid, &status, 0);
    assert_int_equal(status, 0);
}

static void only_listed_descriptors_stay_open(void **state)
{
    (void)state;
    const pid_t pid = fork();
    if (pid == 0) {
        int fd[6];
        for (int i = 0; i < 6; i++)
            fd[i] = dup(2);
        const int keep[2] = {fd[1], fd[4]};
        bool fine = glint_jail_close_others(keep, 2);
        for (int i = 0; i < 6; i++)
            fine &= (fcntl(fd[i], F_GETFD) >= 0) == (i == 1 || i == 4);
        _exit(fine && fcntl(2, F_GETFD) >= 0 ? 0 : 1);
    }
    int status;
    waitpid(pid, &status, 0);
    assert_int_equal(status, 0);
}

int main(int argc, char **argv)
{
    if (argc == 2 && strcmp(argv[1], "--denied") == 0)
        return denied_main();
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_glb_comes_back_as_native_text_and_assets),
        cmocka_unit_test(camera_and_emitter_are_added_with_warnings),
        cmocka_unit_test(equal_files_give_equal_text),
        cmocka_unit_test(faults_come_back_with_their_pointers),
        cmocka_unit_test(pictures_in_native_text_become_assets),
        cmocka_unit_test(bad_pictures_are_refused_at_their_pointer),
        cmocka_unit_test(too_little_memory_refuses_the_file_and_says_so),
        cmocka_unit_test(too_large_a_scene_from_a_small_file_is_refused),
        cmocka_unit_test(too_much_processor_time_refuses_the_file_and_says_so),
        cmocka_unit_test(a_crash_is_the_fault_of_the_file),
        cmocka_unit_test(a_kill_is_told_from_a_crash),
        cmocka_unit_test(many_threads_import_at_once),
        cmocka_unit_test(without_its_helper_an_import_fails_and_does_not_wait),
        cmocka_unit_test(the_jail_lets_nothing_in_or_out),
        cmocka_unit_test(the_jail_bounds_memory_and_time),
        cmocka_unit_test(an_abort_in_the_jail_is_an_abort),
        cmocka_unit_test(the_jail_holds_under_a_service_manager_that_denies_seccomp),
        cmocka_unit_test(only_listed_descriptors_stay_open),
    };
    return cmocka_run_group_tests(tests, start, stop);
}
