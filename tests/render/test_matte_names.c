// Mattes by name: unions, totals, and the names that a frame's manifest lists.
#include "tests/render/things.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>

#include <cmocka.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static void assert_matte(const struct shot *s, enum glint_matte_layer layer,
                         const char *const *names, size_t count)
{
    struct glint_frame *matte = NULL;
    struct glint_error err = {0};
    if (glint_render_matte(s->render, layer, 1u, names, count, &matte, &err))
        offline_die("matte", &err);
    const float *plane = glint_frame_find(matte, "A");
    for (size_t i = 0; i < pixels(s->frame); i++) {
        double sum = 0.0;
        for (size_t n = 0; n < count; n++)
            sum += coverage_of(s->frame, glint_matte_layer_type(layer), names[n], i);
        assert_float_equal(plane[i], sum, 1e-6);
    }
    glint_frame_destroy(&matte);
}

static void union_matte_is_the_sum_over_the_written_layers(void **state)
{
    (void)state;
    static const char *const objects[] = {"a", "g", "twin"}, *const materials[] = {"red", "blue"};
    static const char *const assets[] = {"set"};
    struct shot s;
    shoot_things(&s, crowd, CROWD, LENS, ALL_RANKS, 96);
    assert_matte(&s, GLINT_MATTE_OBJECT, objects, 3);
    assert_matte(&s, GLINT_MATTE_OBJECT, objects, 1);
    assert_matte(&s, GLINT_MATTE_MATERIAL, materials, 2);
    assert_matte(&s, GLINT_MATTE_ASSET, assets, 1);
    finish_shot(&s);
}

static void unknown_name_is_refused_by_name(void **state)
{
    (void)state;
    static const char *const names[] = {"a", "nobody"};
    struct glint_frame *matte = NULL;
    struct glint_error err = {0};
    struct shot s;
    shoot_things(&s, crowd, CROWD, "", "", 1);
    assert_int_equal(glint_render_matte(s.render, GLINT_MATTE_OBJECT, 1u, names, 2, &matte, &err),
                     GLINT_E_NOT_FOUND);
    assert_null(matte);
    assert_string_equal(err.fault[0].pointer, "/name");
    assert_non_null(strstr(err.fault[0].detail, "nobody"));
    glint_error_finish(&err);
    finish_shot(&s);
}

static void totals_are_sums_over_the_frame(void **state)
{
    (void)state;
    struct shot s;
    shoot_things(&s, crowd, CROWD, LENS, ALL_RANKS, 96);
    struct glint_matte_totals totals;
    assert_int_equal(glint_render_mattes(s.render, 7u, &totals, NULL), GLINT_OK);
    for (int layer = 0; layer < GLINT_MATTE_LAYERS; layer++) {
        const struct glint_matte_total *total = totals.of[layer];
        const size_t count = totals.count[layer];
        assert_int_equal(count, layer == GLINT_MATTE_OBJECT     ? 9
                                : layer == GLINT_MATTE_MATERIAL ? 3
                                                                : 1);
        for (size_t n = 0; n < count; n++) {
            double sum = 0.0;
            for (size_t i = 0; i < pixels(s.frame); i++)
                sum += coverage_of(s.frame, glint_matte_layer_type(layer), total[n].name, i);
            assert_float_equal(total[n].coverage[0], sum, 1e-4);
            assert_int_equal(total[n].id, glint_cryptomatte_id(total[n].name));
        }
    }
    glint_matte_totals_finish(&totals);
    finish_shot(&s);
}

// ---- manifests

static const char names_scene[] =
    "{\"materials\":{\"m\":{\"name\":\"seen m\"},\"n\":{\"name\":\"hidden "
    "m\"},\"k\":{\"name\":\"unused m\"}},"
    "\"meshes\":{\"q\":{\"primitive\":\"quad\"}},"
    "\"objects\":{\"1\":{\"name\":\"seen\",\"asset\":\"seen "
    "a\"},\"2\":{\"name\":\"hidden\",\"asset\":\"hidden a\"},"
    "\"3\":{\"name\":\"unused\",\"asset\":\"unused a\"},\"4\":{\"name\":\"behind "
    "\\\"you\\\"\"},\"5\":{\"name\":\"\"}},"
    "\"lights\":{\"lamp\":{\"type\":\"area\",\"transform\":{\"translation\":[0,5,0]}}},"
    "\"instances\":{\"1\":{\"mesh\":\"q\",\"material\":\"m\",\"object\":\"1\"},"
    "\"2\":{\"mesh\":\"q\",\"material\":\"n\",\"object\":\"2\",\"visible\":false},"
    "\"4\":{\"mesh\":\"q\",\"material\":\"m\",\"object\":\"4\",\"transform\":{\"translation\":[0,0,"
    "99]}},"
    "\"5\":{\"mesh\":\"q\",\"material\":\"m\",\"object\":\"5\",\"transform\":{\"translation\":[2,0,"
    "0]}}},"
    "\"cameras\":{\"eye\":{\"yfov\":0.9,\"transform\":{\"translation\":[0,0,4]}}}}";

static const char names_job[] =
    "{\"scene\":\"s\",\"resolution\":[16,16],\"max_bounces\":0,\"stop\":{\"samples\":4}}";

static void assert_manifest(const struct glint_frame *f, const char *type, const char *want)
{
    char key[8], name[40];
    glint_cryptomatte_key(type, key);
    snprintf(name, sizeof name, "cryptomatte/%s/manifest", key);
    cJSON *tree = cJSON_Parse(glint_frame_attribute(f, name)->text);
    char names[512] = "";
    for (const cJSON *entry = tree->child; entry; entry = entry->next) {
        char id[9];
        snprintf(id, sizeof id, "%08x", glint_cryptomatte_id(entry->string));
        assert_string_equal(entry->valuestring, id);
        strcat(strcat(names, entry->string), ";");
    }
    assert_string_equal(names, want);
    cJSON_Delete(tree);
}

static void manifests_have_all_names_of_the_scene_seen_or_not(void **state)
{
    (void)state;
    glint_resident *scene = offline_load_text(&things_crew, names_scene);
    struct shot s;
    shoot(&s, scene, names_job);
    assert_manifest(s.frame, "CryptoObject", "behind \"you\";default;hidden;lamp;seen;unused;");
    assert_manifest(s.frame, "CryptoMaterial", "hidden m;lamp;seen m;unused m;");
    assert_manifest(s.frame, "CryptoAsset", "hidden a;seen a;unused a;");
    finish_shot(&s);
    glint_resident_release(&scene);
}

static void name_that_is_not_seen_has_an_empty_matte(void **state)
{
    (void)state;
    static const char *const unseen[] = {"hidden", "unused", "behind \"you\""};
    glint_resident *scene = offline_load_text(&things_crew, names_scene);
    struct shot s;
    shoot(&s, scene, names_job);
    for (size_t i = 0; i < COUNT(unseen); i++) {
        struct glint_frame *matte = NULL;
        assert_int_equal(
            glint_render_matte(s.render, GLINT_MATTE_OBJECT, 1u, &unseen[i], 1, &matte, NULL),
            GLINT_OK);
        for (size_t p = 0; p < pixels(matte); p++)
            assert_true(glint_frame_find(matte, "A")[p] == 0.0f);
        glint_frame_destroy(&matte);
    }
    assert_matte(&s, GLINT_MATTE_OBJECT, (const char *const[]){"default"}, 1);
    finish_shot(&s);
    glint_resident_release(&scene);
}

static void a_pick_is_what_the_frame_ranks_there(void **state)
{
    (void)state;
    struct shot s;
    shoot_things(&s, crowd, CROWD, LENS, ALL_RANKS, 96);
    size_t ranks = 0;
    for (size_t i = 0; i < pixels(s.frame); i++) {
        struct glint_matte_found *found;
        size_t count, of_type = 0;
        assert_int_equal(
            glint_render_pick(s.render, i % WIDTH, (uint32_t)(i / WIDTH), &found, &count, NULL),
            GLINT_OK);
        ranks += count;
        for (size_t k = 0; k < count; k++) {
            const char *type = found[k].type.name;
            of_type = k && strcmp(type, found[k - 1].type.name) == 0 ? of_type : 0;
            while (rank_id(s.frame, type, (uint32_t)of_type, i) == 0)
                of_type++; // of nothing
            assert_int_equal(found[k].id, rank_id(s.frame, type, (uint32_t)of_type, i));
            assert_true(found[k].coverage == rank_coverage(s.frame, type, (uint32_t)of_type, i));
            assert_int_equal(found[k].id, glint_cryptomatte_id(found[k].name));
            of_type++;
        }
        free(found);
    }
    assert_true(ranks > pixels(s.frame));
    struct glint_error err = {0};
    struct glint_matte_found *found;
    size_t count;
    assert_int_equal(glint_render_pick(s.render, WIDTH, 0, &found, &count, &err), GLINT_E_RANGE);
    assert_null(found);
    glint_error_finish(&err);
    finish_shot(&s);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(union_matte_is_the_sum_over_the_written_layers),
        cmocka_unit_test(unknown_name_is_refused_by_name),
        cmocka_unit_test(totals_are_sums_over_the_frame),
        cmocka_unit_test(a_pick_is_what_the_frame_ranks_there),
        cmocka_unit_test(manifests_have_all_names_of_the_scene_seen_or_not),
        cmocka_unit_test(name_that_is_not_seen_has_an_empty_matte),
    };
    return cmocka_run_group_tests(tests, things_start, things_finish);
}
