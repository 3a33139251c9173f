// What a revision shares with the one before it.
#include "scene/curvature.h"
#include "scene/internal.h"
#include "tests/render/revised.h"
#include "tests/stability/stable.h"

// The revision after an edit, of one that live and batch jobs trace; before is released first.
static void assert_edit(const struct revised_edit *to, float first_texel, unsigned parts,
                        uint32_t new_meshes, uint32_t new_bodies)
{
    struct glint_error err = {0};
    const struct glint_geometry *g;
    glint_resident *before = revised_load(revised_text(&revised_base, 0.5f), NULL);
    assert_int_equal(glint_resident_geometry(before, GLINT_GEOMETRY_PLACED, false, &g, &err),
                     GLINT_OK);
    glint_resident *after = revised_load(revised_text(to, first_texel), before);
    const struct glint_resident_change *c = glint_resident_change(after);
    for (int p = 0; p < GLINT_PARTS; p++)
        print_message("# %-12s %d, %u made, %.2f ms\n", glint_part_name[p], c->fate[p], c->items[p],
                      1e3 * c->seconds[p]);
    assert_int_equal(revised_made(after), parts);
    // That of batch jobs waits until one asks.
    assert_int_equal(c->fate[GLINT_PART_BVH] == GLINT_KEPT, !(parts & REVISED_PART(PLACEMENT)));
    assert_int_not_equal(c->fate[GLINT_PART_PLACEMENT], GLINT_LATER);
    assert_int_equal(c->items[GLINT_PART_MESHES], new_meshes);
    assert_int_equal(c->items[GLINT_PART_BVH], new_bodies);
    for (int t = 0; t < GLINT_TABLES; t++)
        if (!(parts & REVISED_PART(MESHES)) &&
            t <= GLINT_TABLE_COLOURS) // once in memory, not only equal
            assert_ptr_equal(glint_resident_table(after, t), glint_resident_table(before, t));
    glint_resident_release(&before);

    // What is shared is the same as what a scene has that was made alone.
    glint_resident *alone = revised_load(revised_text(to, first_texel), NULL);
    struct glint_frame *f[4] = {revised_show(after, true), revised_show(alone, true),
                                revised_show(after, false), revised_show(alone, false)};
    stable_assert_same(f[0], f[1]);
    stable_assert_same(f[2], f[3]);
    for (int i = 0; i < 4; i++)
        glint_frame_destroy(&f[i]);
    glint_resident_release(&after);
    glint_resident_release(&alone);
}

static void equal_scenes_share_everything(void **state)
{
    (void)state;
    assert_edit(&revised_base, 0.5f, 0, 0, 0);
}

static void a_colour_makes_material_records_only(void **state)
{
    (void)state;
    struct revised_edit e = revised_base;
    e.red = "[0.1,0.8,0.1]";
    assert_edit(&e, 0.5f, REVISED_PART(MATERIALS), 0, 0);
}

static void a_lamp_makes_the_light_table_only(void **state)
{
    (void)state;
    struct revised_edit e = revised_base;
    e.lamp = "7";
    assert_edit(&e, 0.5f, REVISED_PART(LIGHTS), 0, 0);
}

static void a_moved_ball_makes_rows_and_the_placement_only(void **state)
{
    (void)state;
    struct revised_edit e = revised_base;
    e.place = "[1.25,0.5,0.5]";
    assert_edit(&e, 0.5f, REVISED_PART(INSTANCES) | REVISED_PART(PLACEMENT), 0, 0);
}

static void a_hidden_cube_makes_rows_and_the_placement_only(void **state)
{
    (void)state;
    struct revised_edit e = revised_base;
    e.cube = ",'visible':false";
    assert_edit(&e, 0.5f, REVISED_PART(INSTANCES) | REVISED_PART(PLACEMENT), 0, 0);
}

static void an_edited_mesh_makes_its_own_structure_only(void **state)
{
    (void)state;
    struct revised_edit e = revised_base;
    e.box = "'primitive':'box','size':[0.5,0.5,0.5]";
    assert_edit(&e, 0.5f, REVISED_PART(MESHES) | REVISED_PART(BVH) | REVISED_PART(PLACEMENT), 1, 1);
}

// More triangles than a core takes at a time.
static void every_triangle_of_a_large_mesh_has_its_record(void **state)
{
    (void)state;
    glint_resident *r =
        revised_load(stable_text("{'materials':{'m':{}},'meshes':{'ball':{'primitive':"
                                 "'sphere','segments':300}},'instances':{'ball':{'mesh':"
                                 "'ball','material':'m'}}}"),
                     NULL);
    const struct glint_kept *k = &r->kept[0];
    const struct gk_triangle *record =
        (const struct gk_triangle *)glint_table_host(r, GLINT_TABLE_TRIANGLES) + k->first;
    assert_true(k->triangles > 5 * 16384);
    for (uint32_t i = 0; i < k->triangles; i++) {
        const uint32_t *t = k->index + 3 * (size_t)i;
        for (int c = 0; c < 3; c++)
            assert_memory_equal(record[i].normal + 3 * c, k->mesh->normal + 3 * (size_t)t[c], 12);
        assert_int_equal(record[i].flags,
                         glint_curvature_bits(glint_curvature(k->position, k->mesh->normal, t)));
    }
    glint_resident_release(&r);
}

static void a_mesh_that_nothing_draws_makes_nothing(void **state)
{
    (void)state;
    struct revised_edit e = revised_base;
    e.more = ",'extra':{'primitive':'disk'}";
    assert_edit(&e, 0.5f, 0, 0, 0);
}

static void a_texel_makes_textures_only(void **state)
{
    (void)state;
    assert_edit(&revised_base, 0.75f, REVISED_PART(TEXTURES), 0, 0);
}

static void the_sky_is_numbers_of_frames(void **state)
{
    (void)state;
    struct revised_edit e = revised_base;
    e.sky = "'radiance':[1,0.3,0.4]";
    assert_edit(&e, 0.5f, REVISED_PART(ENVIRONMENT), 0, 0);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(equal_scenes_share_everything),
        cmocka_unit_test(a_colour_makes_material_records_only),
        cmocka_unit_test(a_lamp_makes_the_light_table_only),
        cmocka_unit_test(a_moved_ball_makes_rows_and_the_placement_only),
        cmocka_unit_test(a_hidden_cube_makes_rows_and_the_placement_only),
        cmocka_unit_test(an_edited_mesh_makes_its_own_structure_only),
        cmocka_unit_test(every_triangle_of_a_large_mesh_has_its_record),
        cmocka_unit_test(a_mesh_that_nothing_draws_makes_nothing),
        cmocka_unit_test(a_texel_makes_textures_only),
        cmocka_unit_test(the_sky_is_numbers_of_frames),
    };
    return cmocka_run_group_tests(tests, offline_crew_start, offline_crew_finish);
}
