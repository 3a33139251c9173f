// Assets that an earlier parse has checked, and how long parsing takes.
#include "scene_text.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

static double now_ms(void)
{
    struct timespec t;
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
    return 1e3 * (double)t.tv_sec + 1e-6 * (double)t.tv_nsec;
}

// ---- trust

struct mesh_bytes {
    float position[9], normal[9], color[12];
    uint16_t joint[12];
    float weight[12], target[9];
    uint32_t index[3];
};

// Normals that are not unit, colours above 1 and weights that do not sum to 1: all are replaced.
static struct mesh_bytes make_mesh(void)
{
    return (struct mesh_bytes){.position = {0, 0, 0, 7, 0, 0, 0, 1, 0},
                               .normal = {0, 0, 2, 0, 3, 4, 1, 0, 0},
                               .color = {2, 1, 0, 1},
                               .joint = {0, 1, 2, 3},
                               .weight = {1, 1, 1, 1, 1, 0, 0, 0, 2, 0, 0, 0},
                               .target = {0, 0, -3},
                               .index = {0, 1, 2}};
}

#define SHAPE \
    "'vertices':3,'triangles':1,'targets':1,'attributes':['normal','color','joints','weights']"

static char *mesh_text(const char *hash, const char *shape)
{
    char *quoted = NULL;
    assert_true(asprintf(&quoted, "{'meshes':{'t':{'asset':'%s',%s}}}", hash, shape) > 0);
    char *text = json(quoted);
    free(quoted);
    return text;
}

static void arrays_that_the_check_replaced_are_replaced_again(void **state)
{
    (void)state;
    const struct mesh_bytes bytes = make_mesh();
    const struct glint_asset asset = name_asset(&bytes, sizeof bytes);
    char *text = mesh_text(asset.sha256, SHAPE);
    struct glint_scene *first = reparse(text, strlen(text), &asset, 1, NULL);
    struct glint_scene *second = reparse(text, strlen(text), &asset, 1, first);
    const struct glint_mesh *a = &first->mesh[0], *b = &second->mesh[0];
    assert_ptr_equal(b->position, bytes.position);
    assert_ptr_equal(b->index, bytes.index);
    assert_ptr_equal(b->target_position, bytes.target);
    assert_true(a->normal != b->normal && a->color != b->color && a->weight != b->weight);
    glint_scene_destroy(&first); // the second has nothing of it
    assert_true(b->normal[2] == 1 && b->normal[4] == 0.6f && b->color[0] == 1);
    assert_true(b->weight[3] == 0.25f && b->weight[8] == 1 && b->reach == 7);
    assert_true(b->target_reach == 3 && b->joint_end == 4);
    struct glint_scene *third = reparse(text, strlen(text), &asset, 1, second);
    glint_scene_destroy(&second);
    assert_true(third->mesh[0].normal[5] == 0.8f && third->mesh[0].weight[0] == 0.25f);
    glint_scene_destroy(&third);
    free(text);
}

// Bytes that have become wrong show whether they were walked.
static void what_was_checked_is_not_walked_again(void **state)
{
    (void)state;
    struct mesh_bytes bytes = make_mesh();
    const struct glint_asset asset = name_asset(&bytes, sizeof bytes);
    char *text = mesh_text(asset.sha256, SHAPE);
    struct glint_scene *first = reparse(text, strlen(text), &asset, 1, NULL), *second;
    bytes.position[3] = NAN;
    bytes.index[2] = 3;
    second = reparse(text, strlen(text), &asset, 1, first);
    glint_scene_destroy(&second);
    assert_int_equal(glint_scene_parse(&second, text, strlen(text), &asset, 1, NULL),
                     GLINT_E_RANGE);
    free(text);
    // Of another shape it is another mesh, whatever its bytes are called.
    text = mesh_text(asset.sha256, "'vertices':3,'triangles':10,'attributes':['color','joints',"
                                   "'weights']");
    assert_int_equal(glint_scene_parse_from(&second, text, strlen(text), &asset, 1, first, NULL),
                     GLINT_E_RANGE);
    glint_scene_destroy(&first);
    free(text);
}

static void a_checked_image_is_not_walked_again(void **state)
{
    (void)state;
    uint16_t half[8] = {0x3c00};
    const struct glint_asset asset = name_asset(half, sizeof half);
    char *quoted = NULL;
    assert_true(asprintf(&quoted,
                         "{'images':{'a':{'asset':'%s','width':2,'height':1,'format':'rgba16f'}}}",
                         asset.sha256) > 0);
    char *text = json(quoted), *tall = strdup(text);
    memcpy(strstr(tall, "2,"), "1,", 2);
    memcpy(strstr(tall, "1,\"format"), "2,\"format", 9);
    struct glint_scene *first = reparse(text, strlen(text), &asset, 1, NULL), *second;
    half[7] = 0xffff;
    second = reparse(text, strlen(text), &asset, 1, first);
    assert_ptr_equal(second->image[0].pixels, half);
    glint_scene_destroy(&second);
    assert_int_equal(glint_scene_parse_from(&second, tall, strlen(tall), &asset, 1, first, NULL),
                     GLINT_E_RANGE);
    glint_scene_destroy(&first);
    free(tall);
    free(text);
    free(quoted);
}

// Three meshes of which one is new, in another order.
static void meshes_are_found_wherever_they_stand(void **state)
{
    (void)state;
    float all[3][9 + 3] = {{0}};
    struct glint_asset asset[3];
    char *quoted = NULL;
    for (int i = 0; i < 3; i++) {
        const uint32_t index[3] = {0, 1, 2};
        all[i][0] = (float)i + 1;
        memcpy(all[i] + 9, index, sizeof index);
        asset[i] = name_asset(all[i], sizeof all[i]);
    }
    assert_true(asprintf(&quoted,
                         "{'meshes':{'a':{'asset':'%s','vertices':3,'triangles':1},'b':{'asset':"
                         "'%s','vertices':3,'triangles':1}}}",
                         asset[0].sha256, asset[1].sha256) > 0);
    struct glint_scene *first = parse_with(quoted, asset, 3);
    free(quoted);
    all[0][0] = all[1][0] = INFINITY;
    assert_true(asprintf(&quoted,
                         "{'meshes':{'b':{'asset':'%s','vertices':3,'triangles':1},'c':{'asset':"
                         "'%s','vertices':3,'triangles':1},'a':{'asset':'%s','vertices':3,"
                         "'triangles':1}}}",
                         asset[1].sha256, asset[2].sha256, asset[0].sha256) > 0);
    char *text = json(quoted);
    struct glint_scene *second = reparse(text, strlen(text), asset, 3, first);
    assert_true(second->mesh[0].reach == 2 && second->mesh[1].reach == 3);
    assert_true(second->mesh[2].reach == 1);
    glint_scene_destroy(&first);
    glint_scene_destroy(&second);
    free(text);
    free(quoted);
}

// Naming one asset again and again costs neither its bytes nor its time.
static void an_asset_named_by_many_is_checked_once(void **state)
{
    (void)state;
    const struct glint_mesh shape = {.vertices = 450000, .triangles = 900000};
    const struct glint_mesh_layout at = glint_mesh_layout(&shape, GLINT_MESH_NORMAL);
    uint8_t *bytes = calloc(1, at.bytes);
    const struct glint_asset asset = name_asset(bytes, at.bytes);
    struct glint_text t = {0};
    glint_text_add(&t, "{\"meshes\":{");
    for (int i = 0; i < 2000; i++)
        glint_text_print(&t,
                         "%s\"m%d\":{\"asset\":\"%s\",\"vertices\":450000,\"triangles\":900000,"
                         "\"attributes\":[\"normal\"]}",
                         i ? "," : "", i, asset.sha256);
    glint_text_add(&t, "}}");
    size_t length;
    char *text = glint_text_take(&t, &length);
    const double from = now_ms();
    struct glint_scene *s = reparse(text, length, &asset, 1, NULL);
    assert_true(now_ms() - from < 2000);
    assert_ptr_equal(s->mesh[1999].normal, s->mesh[0].normal);
    assert_true(s->arena.bytes < (64u << 20));
    glint_scene_destroy(&s);
    free(text);
    free(bytes);
}

static void assets_cannot_be_named_without_bound_in_other_shapes(void **state)
{
    (void)state;
    const uint32_t thirds = 3000000; // of 12 bytes: vertices and triangles share them out
    uint8_t *bytes = calloc(thirds, 12);
    const struct glint_asset asset = name_asset(bytes, 12ull * thirds);
    struct glint_text t = {0};
    glint_text_add(&t, "{\"meshes\":{");
    for (uint32_t i = 0; i < 100; i++)
        glint_text_print(&t, "%s\"m%u\":{\"asset\":\"%s\",\"vertices\":%u,\"triangles\":%u}",
                         i ? "," : "", i, asset.sha256, 1000 + i, thirds - 1000 - i);
    glint_text_add(&t, "}}");
    size_t length;
    char *text = glint_text_take(&t, &length);
    struct glint_error err = {0};
    struct glint_scene *s;
    assert_int_equal(glint_scene_parse(&s, text, length, &asset, 1, &err), GLINT_E_RANGE);
    // (2^30 + 4 * 36e6) / 36e6 fit.
    assert_string_equal(err.fault[0].pointer, "/meshes/m33/asset");
    glint_error_finish(&err);
    free(text);
    free(bytes);
}

// ---- size

// A grid of 1000 x 500 quads. Loose bound: only something quadratic could exceed it.
static void a_million_triangles_in_an_asset_parse_without_being_copied(void **state)
{
    (void)state;
    const uint32_t w = 1001, h = 501, vertices = w * h, triangles = 2 * (w - 1) * (h - 1);
    const struct glint_mesh shape = {.vertices = vertices, .triangles = triangles};
    const struct glint_mesh_layout at = glint_mesh_layout(&shape, GLINT_MESH_NORMAL);
    uint8_t *bytes = calloc(1, at.bytes);
    float *normal = (float *)(bytes + at.at[1]);
    uint32_t *index = (uint32_t *)(bytes + at.at[GLINT_MESH_ARRAYS - 1]);
    for (uint32_t i = 0; i < vertices; i++)
        normal[3 * i + i % 3] = 1;
    for (uint32_t i = 0; i < 3 * triangles; i++)
        index[i] = i % vertices;
    const struct glint_asset asset = name_asset(bytes, at.bytes);
    char *text = NULL;
    assert_true(asprintf(&text,
                         "{'cameras':{'c':{'yfov':1}},'meshes':{'t':{'asset':'%s','vertices':%u,"
                         "'triangles':%u,'attributes':['normal']}}}",
                         asset.sha256, vertices, triangles) > 0);
    struct timespec from, to;
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &from);
    struct glint_scene *s = parse_with(text, &asset, 1);
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &to);
    const double ms =
        1e3 * (double)(to.tv_sec - from.tv_sec) + 1e-6 * (double)(to.tv_nsec - from.tv_nsec);
    print_message("# %.2f ms of CPU for %u triangles\n", ms, triangles);
    assert_true(ms < 1000);
    assert_ptr_equal(s->mesh[0].normal, normal);
    assert_true(s->arena.bytes < 10000);
    glint_scene_destroy(&s);
    free(text);
    free(bytes);
}

// An edit of a scene of 900000 triangles must not cost what they cost.
static void a_large_scene_is_parsed_again_in_a_moment(void **state)
{
    (void)state;
    const struct glint_mesh shape = {.vertices = 450000, .triangles = 900000};
    const struct glint_mesh_layout at = glint_mesh_layout(&shape, GLINT_MESH_NORMAL);
    uint8_t *bytes = calloc(1, at.bytes);
    float *normal = (float *)(bytes + at.at[1]);
    for (uint32_t i = 0; i < shape.vertices; i++)
        normal[3 * i] = i % 2 ? 1 : 2; // replaced: the slower way
    const struct glint_asset asset = name_asset(bytes, at.bytes);
    char *text =
        mesh_text(asset.sha256, "'vertices':450000,'triangles':900000,'attributes':['normal']");
    struct glint_scene *first = reparse(text, strlen(text), &asset, 1, NULL);
    const double from = now_ms();
    struct glint_scene *second = reparse(text, strlen(text), &asset, 1, first);
    const double ms = now_ms() - from;
    print_message("# %.2f ms of CPU\n", ms);
    glint_scene_destroy(&first);
    glint_scene_destroy(&second);
    free(text);
    free(bytes);
}

// Loose bound: looking through all assets for each would take minutes.
static void many_meshes_are_written_and_read_in_linear_time(void **state)
{
    (void)state;
    const int count = 50000;
    struct glint_text t = {0};
    glint_text_add(&t, "{\"meshes\":{");
    for (int i = 0; i < count; i++)
        glint_text_print(&t, "%s\"m%d\":{\"positions\":[0,0,%d,1,0,0,0,1,0]}", i ? "," : "", i, i);
    glint_text_add(&t, "}}");
    size_t length, assets = 0, again = 0;
    char *text = glint_text_take(&t, &length);
    struct glint_scene *s = reparse(text, length, NULL, 0, NULL);
    free(text);
    struct glint_asset *asset = NULL;
    const double from = now_ms();
    assert_int_equal(glint_scene_write(s, &text, &length, &asset, &assets, NULL), GLINT_OK);
    const double written = now_ms();
    assert_int_equal(assets, count);
    glint_scene_destroy(&s);
    s = reparse(text, length, asset, assets, NULL);
    const double read = now_ms();
    struct glint_scene *edited = reparse(text, length, asset, assets, s);
    print_message("# %.0f ms to write, %.0f to read, %.0f to read again\n", written - from,
                  read - written, now_ms() - read);
    assert_true(now_ms() - from < 10000);
    again = assets;
    free(text);
    assert_int_equal(glint_scene_write(edited, &text, &length, &asset, &again, NULL), GLINT_OK);
    assert_int_equal(again, count);
    glint_scene_destroy(&s);
    glint_scene_destroy(&edited);
    for (size_t i = 0; i < assets; i++)
        free((void *)asset[i].bytes);
    free(asset);
    free(text);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(arrays_that_the_check_replaced_are_replaced_again),
        cmocka_unit_test(what_was_checked_is_not_walked_again),
        cmocka_unit_test(a_checked_image_is_not_walked_again),
        cmocka_unit_test(meshes_are_found_wherever_they_stand),
        cmocka_unit_test(an_asset_named_by_many_is_checked_once),
        cmocka_unit_test(assets_cannot_be_named_without_bound_in_other_shapes),
        cmocka_unit_test(a_million_triangles_in_an_asset_parse_without_being_copied),
        cmocka_unit_test(a_large_scene_is_parsed_again_in_a_moment),
        cmocka_unit_test(many_meshes_are_written_and_read_in_linear_time),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
