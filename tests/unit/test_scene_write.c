// The canonical text.
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

// ---- writing

// Without the padding that structures may have.
#define SAME(A, B, FIELD) assert_memory_equal(&(A)->FIELD, &(B)->FIELD, sizeof(A)->FIELD)

static void assert_same_array(const void *a, const void *b, size_t bytes)
{
    assert_int_equal(!a, !b);
    if (a)
        assert_memory_equal(a, b, bytes);
}

static void assert_same_mesh(const struct glint_mesh *a, const struct glint_mesh *b)
{
    assert_string_equal(a->id, b->id);
    SAME(a, b, vertices);
    SAME(a, b, triangles);
    assert_same_array(a->position, b->position, 12ull * a->vertices);
    assert_same_array(a->normal, b->normal, 12ull * a->vertices);
    assert_same_array(a->uv, b->uv, 8ull * a->vertices);
    assert_same_array(a->tangent, b->tangent, 16ull * a->vertices);
    assert_same_array(a->index, b->index, 12ull * a->triangles);
    SAME(a, b, targets);
    SAME(a, b, reach);
    SAME(a, b, low);
    SAME(a, b, high);
    SAME(a, b, target_reach);
    SAME(a, b, joint_end);
    const uint64_t displacements = 12ull * a->vertices * a->targets;
    assert_same_array(a->uv1, b->uv1, 8ull * a->vertices);
    assert_same_array(a->color, b->color, 16ull * a->vertices);
    assert_same_array(a->joint, b->joint, 8ull * a->vertices);
    assert_same_array(a->weight, b->weight, 16ull * a->vertices);
    assert_same_array(a->target_position, b->target_position, displacements);
    assert_same_array(a->target_normal, b->target_normal, displacements);
    assert_same_array(a->target_tangent, b->target_tangent, displacements);
    assert_same_array(a->target_weight, b->target_weight, 4ull * a->targets);
}

static void assert_same_node(const struct glint_node *a, const struct glint_node *b)
{
    assert_string_equal(a->id, b->id);
    assert_string_equal(a->name, b->name);
    assert_true(a->parent == b->parent && a->matrix == b->matrix);
    SAME(a, b, transform);
    SAME(a, b, translation);
    SAME(a, b, rotation);
    SAME(a, b, scale);
}

static void assert_same_skin(const struct glint_skin *a, const struct glint_skin *b)
{
    assert_string_equal(a->id, b->id);
    assert_int_equal(a->joints, b->joints);
    assert_memory_equal(a->joint, b->joint, 4ull * a->joints);
    assert_memory_equal(a->inverse_bind, b->inverse_bind, 64ull * a->joints);
}

static void assert_same_channel(const struct glint_animation_channel *a,
                                const struct glint_animation_channel *b)
{
    assert_string_equal(a->id, b->id);
    assert_true(a->node == b->node && a->path == b->path && a->interpolation == b->interpolation);
    assert_true(a->keys == b->keys && a->width == b->width);
    assert_memory_equal(a->time, b->time, 4ull * a->keys);
    assert_memory_equal(a->value, b->value, 4 * glint_channel_values(a));
}

static void assert_same_animation(const struct glint_animation *a, const struct glint_animation *b)
{
    assert_string_equal(a->id, b->id);
    assert_string_equal(a->name, b->name);
    assert_int_equal(a->channels, b->channels);
    for (uint32_t i = 0; i < a->channels; i++)
        assert_same_channel(&a->channel[i], &b->channel[i]);
}

static void assert_same_medium(const struct glint_medium *a, const struct glint_medium *b)
{
    assert_string_equal(a->id, b->id);
    assert_true(a->density == b->density && a->g == b->g && a->bounded == b->bounded);
    SAME(a, b, albedo);
    SAME(a, b, box);
}

static void assert_same_motion(const struct glint_scene *a, const struct glint_scene *b)
{
    assert_true(a->nodes == b->nodes && a->skins == b->skins && a->media == b->media);
    assert_true(a->animations == b->animations && a->fps == b->fps);
    for (uint32_t i = 0; i < a->nodes; i++)
        assert_same_node(&a->node[i], &b->node[i]);
    for (uint32_t i = 0; i < a->skins; i++)
        assert_same_skin(&a->skin[i], &b->skin[i]);
    for (uint32_t i = 0; i < a->animations; i++)
        assert_same_animation(&a->animation[i], &b->animation[i]);
    for (uint32_t i = 0; i < a->media; i++)
        assert_same_medium(&a->medium[i], &b->medium[i]);
}

static void assert_same_material(const struct glint_material *a, const struct glint_material *b)
{
    assert_string_equal(a->id, b->id);
    assert_string_equal(a->name, b->name);
    const size_t from = offsetof(struct glint_material, base_color);
    struct glint_material x = *a, y = *b; // bools leave padding between them
    assert_memory_equal((char *)&x + from, (char *)&y + from,
                        offsetof(struct glint_material, thin) - from);
    assert_true(a->thin == b->thin && a->double_sided == b->double_sided);
    const size_t more = offsetof(struct glint_material, emission);
    assert_memory_equal((char *)&x + more, (char *)&y + more,
                        offsetof(struct glint_material, base_color_texture) - more);
    for (size_t i = 0; i < GLINT_TEXTURE_SLOTS; i++)
        assert_memory_equal(glint_texture_of(&x, i), glint_texture_of(&y, i),
                            sizeof(struct glint_texture));
}

static void assert_same_scene(const struct glint_scene *a, const struct glint_scene *b)
{
    assert_true(a->images == b->images && a->materials == b->materials && a->meshes == b->meshes);
    assert_true(a->objects == b->objects && a->instances == b->instances && a->lights == b->lights);
    assert_true(a->cameras == b->cameras && a->has_environment == b->has_environment);
    for (uint32_t i = 0; i < a->images; i++)
        assert_memory_equal(a->image[i].pixels, b->image[i].pixels, 8);
    for (uint32_t i = 0; i < a->materials; i++)
        assert_same_material(&a->material[i], &b->material[i]);
    for (uint32_t i = 0; i < a->meshes; i++)
        assert_same_mesh(&a->mesh[i], &b->mesh[i]);
    for (uint32_t i = 0; i < a->objects; i++) {
        assert_string_equal(a->object[i].name, b->object[i].name);
        assert_string_equal(a->object[i].asset, b->object[i].asset);
    }
    for (uint32_t i = 0; i < a->instances; i++) {
        const struct glint_instance *x = &a->instance[i], *y = &b->instance[i];
        assert_string_equal(x->id, y->id);
        assert_true(x->object == y->object && x->mesh == y->mesh && x->material == y->material);
        assert_true(x->node == y->node && x->skin == y->skin && x->visible == y->visible);
        SAME(x, y, transform);
        assert_same_array(x->weight, y->weight, 4ull * a->mesh[x->mesh].targets);
    }
    assert_same_motion(a, b);
    for (uint32_t i = 0; i < a->lights; i++)
        assert_memory_equal(&a->light[i].kind, &b->light[i].kind,
                            offsetof(struct glint_light, size) -
                                offsetof(struct glint_light, kind));
    for (uint32_t i = 0; i < a->cameras; i++) {
        const struct glint_camera *x = &a->camera[i], *y = &b->camera[i];
        assert_true(x->projection == y->projection && x->node == y->node && x->yfov == y->yfov);
        assert_true(x->ymag == y->ymag && x->lens_radius == y->lens_radius);
        assert_true(x->focus_distance == y->focus_distance);
        SAME(x, y, transform);
    }
    if (a->has_environment)
        assert_memory_equal(&a->environment, &b->environment, sizeof a->environment);
}

static void parsing_what_was_written_gives_an_equal_scene(void **state)
{
    (void)state;
    static const uint8_t pixels[8] = {1, 2, 3, 4, 5, 6, 7, 8};
    struct glint_asset *asset = malloc(sizeof *asset);
    uint8_t *own = malloc(8);
    memcpy(own, pixels, 8);
    *asset = name_asset(own, 8);
    size_t assets = 1, length, again_length;
    char *quoted = NULL, *text, *again;
    assert_true(asprintf(&quoted, scene_rich, asset->sha256) > 0);
    struct glint_scene *a = parse_with(quoted, asset, 1);
    assert_int_equal(glint_scene_write(a, &text, &length, &asset, &assets, NULL), GLINT_OK);
    // The image, the sphere, q and q2 as one, what moves, two skins, three channels.
    assert_int_equal(assets, 9);
    for (size_t i = 0; i < assets; i++)
        assert_string_equal(asset[i].sha256, name_asset(asset[i].bytes, asset[i].size).sha256);
    struct glint_scene *b = reparse(text, length, asset, assets, NULL);
    assert_same_scene(a, b);
    assert_int_equal(glint_scene_write(b, &again, &again_length, &asset, &assets, NULL), GLINT_OK);
    assert_int_equal(assets, 9);
    assert_string_equal(again, text);
    assert_int_equal(again_length, strlen(text));
    glint_scene_destroy(&a);
    glint_scene_destroy(&b);
    for (size_t i = 0; i < assets; i++)
        free((void *)asset[i].bytes);
    free(asset);
    free(quoted);
    free(text);
    free(again);
}

static void different_words_for_one_scene_are_written_as_equal_bytes(void **state)
{
    (void)state;
    struct glint_scene *s[2] = {parse("{'cameras':{'c':{'yfov':0.50,'name':'c'}},'lights':{'l':{'"
                                      "type':'sun','intensity':1}}}"),
                                parse("{'lights':{'l':{'type':'sun','transform':{'scale':[1,1,1]}}}"
                                      ",'cameras':{'c':{'yfov':5e-1}}}")};
    char *text[2];
    size_t length, assets = 0;
    struct glint_asset *asset = NULL;
    for (int i = 0; i < 2; i++) {
        assert_int_equal(glint_scene_write(s[i], &text[i], &length, &asset, &assets, NULL),
                         GLINT_OK);
        glint_scene_destroy(&s[i]);
    }
    assert_string_equal(text[0], text[1]);
    assert_null(asset);
    free(text[0]);
    free(text[1]);
}

// An importer sets what its file speaks of.
static void what_an_importer_leaves_unset_is_written_as_its_default(void **state)
{
    (void)state;
    struct glint_camera camera[2] = {{.id = "o", .name = "o", .node = GLINT_NONE},
                                     {.id = "p", .name = "p", .node = GLINT_NONE}};
    camera[0].projection = GLINT_ORTHOGRAPHIC;
    camera[0].ymag = 2;
    camera[1].yfov = 0.5f;
    for (int i = 0; i < 2; i++) {
        memcpy(camera[i].transform, glint_identity, sizeof glint_identity);
        camera[i].focus_distance = 1;
    }
    const struct glint_scene made = {.cameras = 2, .camera = camera};
    struct glint_asset *asset = NULL;
    size_t assets = 0, length;
    char *text;
    assert_int_equal(glint_scene_write(&made, &text, &length, &asset, &assets, NULL), GLINT_OK);
    struct glint_scene *s = reparse(text, length, NULL, 0, NULL);
    assert_true(s->fps == 24 && s->camera[0].ymag == 2 && s->camera[1].yfov == 0.5f);
    glint_scene_destroy(&s);
    free(text);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(parsing_what_was_written_gives_an_equal_scene),
        cmocka_unit_test(what_an_importer_leaves_unset_is_written_as_its_default),
        cmocka_unit_test(different_words_for_one_scene_are_written_as_equal_bytes),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
