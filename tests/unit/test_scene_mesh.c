// Attributes of meshes, morph targets and skins.
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

#define POINTS "'positions':[0,0,0, 1,0,0, 0,1,0]"

static void inline_attributes_arrive(void **state)
{
    (void)state;
    struct glint_scene *s =
        parse("{'meshes':{'t':{" POINTS ",'uvs1':[0,1, 2,3, 4,5],'colors':[0,0.25,0.5,1, 1,1,1,0, "
              "0,0,0,0.5],'joints':[0,1,2,3, 65535,0,0,0, 7,0,0,0],'weights':[0.25,0.25,0.25,0.25, "
              "1,0,0,0, 0.5,0.5,0,0]}}}");
    const struct glint_mesh *m = &s->mesh[0];
    assert_true(m->uv1[5] == 5 && !m->uv && m->color[1] == 0.25f && m->color[7] == 0);
    assert_true(m->joint[3] == 3 && m->joint[4] == 65535 && m->joint_end == 65536);
    assert_true(m->weight[8] == 0.5f && m->targets == 0 && m->reach == 1);
    assert_int_equal(glint_mesh_attributes(m),
                     GLINT_MESH_UV1 | GLINT_MESH_COLOR | GLINT_MESH_JOINTS | GLINT_MESH_WEIGHTS);
    glint_scene_destroy(&s);
}

static void colors_are_cut_at_one_and_never_negative(void **state)
{
    (void)state;
    struct glint_scene *s =
        parse("{'meshes':{'t':{" POINTS ",'colors':[2,0.5,0,1, 0,0,0,9, 1,1,1,1]}}}");
    const float want[12] = {1, 0.5f, 0, 1, 0, 0, 0, 1, 1, 1, 1, 1};
    assert_memory_equal(s->mesh[0].color, want, sizeof want);
    glint_scene_destroy(&s);
    refuse("{'meshes':{'t':{" POINTS ",'colors':[1,1,1,1, 1,-0.5,1,1, 1,1,1,1]}}}",
           "/meshes/t=color 1 has -0.5");
    refuse("{'meshes':{'t':{" POINTS ",'colors':[1,1,1]}}}", "/meshes/t/colors=12 numbers");
}

static void weights_sum_to_one_and_go_with_joints(void **state)
{
    (void)state;
    struct glint_scene *s = parse("{'meshes':{'t':{" POINTS ",'joints':[0,1,0,0, 0,0,0,0, 0,0,0,0],"
                                  "'weights':[3,1,0,0, 1,0,0,0, 0,0,0.5,0]}}}");
    const float want[12] = {0.75f, 0.25f, 0, 0, 1, 0, 0, 0, 0, 0, 1, 0};
    assert_memory_equal(s->mesh[0].weight, want, sizeof want);
    glint_scene_destroy(&s);
    refuse("{'meshes':{'a':{" POINTS ",'joints':[0,0,0,0, 0,0,0,0, 0,0,0,0]},"
           "'b':{" POINTS ",'weights':[1,0,0,0, 1,0,0,0, 1,0,0,0]},"
           "'c':{" POINTS ",'joints':[0,0,0,0, 0,0,0,0, 0,0,0,0],'weights':[1,0,0,0, 0,0,0,0, "
           "1,0,0,0]},"
           "'d':{" POINTS ",'joints':[0,0,0,0, 0,0,0,0, 0,0,0,0],'weights':[1,0,0,0, 2,-1,0,0, "
           "1,0,0,0]},"
           "'e':{" POINTS ",'joints':[0,0,65536,0, 0,0.5,0,0, 0,0,0,0],'weights':[1,0]}}}",
           "/meshes/a=joints only|/meshes/b=weights only|/meshes/c=vertex 1 are zero|"
           "/meshes/d=negative|/meshes/e/joints/2|/meshes/e/joints/5=integer|"
           "/meshes/e/weights=12 numbers");
}

// ---- morph targets

static void what_a_target_leaves_out_is_zero(void **state)
{
    (void)state;
    struct glint_scene *s =
        parse("{'meshes':{'t':{" POINTS
              ",'targets':[{},{'positions':[1,2,3, 4,5,6, 7,8,-9],'tangents':[1,"
              "0,0, 0,0,0, 0,0,0]},{'normals':[0,0,0, 0,0,0, 0,0,2]}],'target_weights':[0,0.5,-1]},"
              "'u':{" POINTS ",'targets':[{}]}}}");
    const struct glint_mesh *m = &s->mesh[0];
    assert_true(m->targets == 3 && m->target_weight[2] == -1 && m->target_reach == 9);
    for (int i = 0; i < 27; i++)
        assert_true(m->target_position[i] == (i == 17 ? -9 : i / 9 == 1 ? i - 8 : 0));
    assert_true(m->target_normal[26] == 2 && m->target_normal[0] == 0);
    assert_true(m->target_tangent[9] == 1 && m->target_tangent[18] == 0);
    m = &s->mesh[1];
    assert_true(m->targets == 1 && !m->target_weight && !m->target_normal);
    assert_true(m->target_position && m->target_position[8] == 0);
    glint_scene_destroy(&s);
}

static void every_fault_of_targets_is_named(void **state)
{
    (void)state;
    refuse("{'meshes':{'t':{" POINTS ",'targets':[{'positions':[1]},{'normal':1},7,{'positions':[0,"
           "0,0, 0,2e12,0, 0,0,0]}],'target_weights':[1,2]}}}",
           "/meshes/t/targets/0/positions=9 numbers|/meshes/t/targets/1/normal|/meshes/t/targets/2|"
           "/meshes/t/targets/3/positions/4|/meshes/t/target_weights=4 targets; 2 weights");
    refuse("{'meshes':{'t':{" POINTS ",'targets':{},'target_weights':[]}}}", "/meshes/t/targets");
    refuse("{'meshes':{'t':{" POINTS ",'target_weights':[1]}}}",
           "/meshes/t/target_weights=0 targets; 1 weights");
    struct glint_text text = {0};
    glint_text_add(&text, "{'meshes':{'t':{" POINTS ",'targets':[{}");
    for (int i = 0; i < 256; i++)
        glint_text_add(&text, ",{}");
    glint_text_add(&text, "]}}}");
    char *many = glint_text_take(&text, NULL);
    refuse(many, "/meshes/t/targets=257 targets; the limit is 256");
    free(many);
}

static void weights_of_an_instance_are_as_many_as_the_targets(void **state)
{
    (void)state;
    struct glint_scene *s = parse(
        "{'meshes':{'t':{" POINTS ",'targets':[{},{}]}},'materials':{'m':{}},'instances':{"
        "'i':{'mesh':'t','material':'m','weights':[1,0.5]},'j':{'mesh':'t','material':'m'}}}");
    assert_true(s->instance[0].weight[1] == 0.5f && !s->instance[1].weight);
    glint_scene_destroy(&s);
    refuse("{'meshes':{'t':{" POINTS ",'targets':[{},{}]}},'materials':{'m':{}},'instances':{"
           "'i':{'mesh':'t','material':'m','weights':[1]},"
           "'j':{'mesh':'t','material':'m','weights':[1,1e7]}}}",
           "/instances/i/weights=2 targets; 1 weights|/instances/j/weights/1");
}

// ---- assets

// The order of the bytes as the contract has it.
struct whole {
    float position[9], normal[9], uv[6], tangent[12], uv1[6], color[12];
    uint16_t joint[12];
    float weight[12], target_position[2][9], target_normal[2][9], target_tangent[2][9];
    uint32_t index[3];
};

static struct whole make_whole(void)
{
    struct whole w = {.position = {0, 0, 0, 1, 0, 0, 0, 1, 0},
                      .normal = {0, 0, 1, 0, 0, 1, 0, 0, 1},
                      .uv = {0, 0, 1, 0, 0, 1},
                      .tangent = {1, 0, 0, 1, 1, 0, 0, -1, 1, 0, 0, 1},
                      .uv1 = {5, 6},
                      .color = {1, 0.5f},
                      .joint = {3, 2, 1, 0},
                      .weight = {0.5f, 0.5f, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0},
                      .target_position = {{1}, {2, -3}},
                      .target_normal = {{4}},
                      .target_tangent = {{5}},
                      .index = {0, 1, 2}};
    return w;
}

#define WHOLE                                                                                  \
    "'vertices':3,'triangles':1,'attributes':['normal','uv','tangent','uv1','color','joints'," \
    "'weights'],'targets':2,'target_attributes':['normal','tangent'],'target_weights':[0,1]"

static char *mesh_text(const char *hash, const char *rest)
{
    char *text = NULL;
    assert_true(asprintf(&text, "{'meshes':{'t':{'asset':'%s',%s}}}", hash, rest) > 0);
    return text;
}

static void an_asset_has_its_arrays_in_the_order_of_the_contract(void **state)
{
    (void)state;
    const struct whole w = make_whole();
    const struct glint_asset asset = name_asset(&w, sizeof w);
    char *text = mesh_text(asset.sha256, WHOLE);
    struct glint_scene *s = parse_with(text, &asset, 1);
    const struct glint_mesh *m = &s->mesh[0];
    assert_ptr_equal(m->position, w.position);
    assert_ptr_equal(m->normal, w.normal);
    assert_ptr_equal(m->uv, w.uv);
    assert_ptr_equal(m->tangent, w.tangent);
    assert_ptr_equal(m->uv1, w.uv1);
    assert_ptr_equal(m->color, w.color);
    assert_ptr_equal(m->joint, w.joint);
    assert_ptr_equal(m->weight, w.weight);
    assert_ptr_equal(m->target_position, w.target_position);
    assert_ptr_equal(m->target_normal, w.target_normal);
    assert_ptr_equal(m->target_tangent, w.target_tangent);
    assert_ptr_equal(m->index, w.index);
    assert_true(m->target_weight[1] == 1 && m->joint_end == 4 && m->target_reach == 3);
    glint_scene_destroy(&s);
    free(text);
}

static void what_an_asset_holds_of_each_array_is_checked(void **state)
{
    (void)state;
    struct whole bad[9];
    for (int i = 0; i < 9; i++)
        bad[i] = make_whole();
    bad[0].uv1[3] = NAN;
    bad[1].color[2] = -1;
    bad[2].color[11] = INFINITY;
    bad[3].weight[4] = -1;
    memset(bad[4].weight + 8, 0, 16);
    bad[5].weight[0] = NAN;
    bad[6].target_position[1][8] = 2e12f;
    bad[7].target_normal[0][0] = NAN;
    bad[8].target_tangent[1][8] = -INFINITY;
    for (int i = 0; i < 9; i++) {
        const struct glint_asset asset = name_asset(&bad[i], sizeof bad[i]);
        char *text = mesh_text(asset.sha256, WHOLE);
        refuse_with(text, &asset, 1, "/meshes/t/asset");
        free(text);
    }
}

static void what_is_said_of_an_asset_must_be_sound(void **state)
{
    (void)state;
    const struct whole w = make_whole();
    const struct glint_asset asset = name_asset(&w, sizeof w);
    static const struct {
        const char *text, *faults;
    } wrong[] = {
        {"'vertices':3,'triangles':1,'attributes':['color','colour','color'],'targets':257,"
         "'target_attributes':['uv','normal','normal']",
         "/meshes/t/attributes/1|/meshes/t/attributes/2=twice|/meshes/t/targets|"
         "/meshes/t/target_attributes/0|/meshes/t/target_attributes/2=twice"},
        {"'vertices':3,'triangles':1,'targets':2,'target_weights':[1]",
         "/meshes/t/target_weights=2 targets; 1 weights"},
        {"'vertices':2147483647,'triangles':2147483647,'attributes':['normal','uv','tangent','uv1',"
         "'color','joints','weights'],'targets':256,'target_attributes':['normal','tangent']",
         "/meshes/t/asset=bytes"},
        {"'vertices':3,'triangles':1,'targets':[]", "/meshes/t/targets"},
    };
    for (size_t i = 0; i < sizeof wrong / sizeof *wrong; i++) {
        char *text = mesh_text(asset.sha256, wrong[i].text);
        refuse_with(text, &asset, 1, wrong[i].faults);
        free(text);
    }
}

// ---- skins

#define SKINNED                                                                                   \
    "'meshes':{'t':{" POINTS ",'joints':[0,1,0,0, 0,0,0,0, 0,0,0,0],'weights':[1,0,0,0, 1,0,0,0," \
    " 1,0,0,0]},'r':{" POINTS "}},'materials':{'m':{}},'nodes':{'a':{},'b':{'parent':'a'}}"

static void a_skin_has_joints_and_identities_unless_it_says_so(void **state)
{
    (void)state;
    float bind[32];
    for (int j = 0; j < 2; j++)
        memcpy(bind + 16 * j, glint_identity, sizeof glint_identity);
    bind[12] = 5;
    const struct glint_asset asset = name_asset(bind, sizeof bind);
    char *text = NULL;
    assert_true(asprintf(&text,
                         "{" SKINNED ",'skins':{'s':{'joints':['b','a']},'k':{'joints':['a','b'],"
                         "'asset':'%s'},'l':{'joints':['a'],'inverse_bind':[1,0,0,0, 0,1,0,0, "
                         "0,0,1,0, 7,8,9,1]}},'instances':{'i':{'mesh':'t','material':'m','skin':"
                         "'k','node':'a'}}}",
                         asset.sha256) > 0);
    struct glint_scene *s = parse_with(text, &asset, 1);
    assert_true(s->skins == 3 && s->skin[0].joints == 2 && s->skin[0].joint[0] == 1);
    assert_memory_equal(s->skin[0].inverse_bind + 16, glint_identity, sizeof glint_identity);
    assert_memory_equal(s->skin[1].inverse_bind, bind, sizeof bind);
    assert_string_equal(s->skin[1].asset, asset.sha256);
    assert_true(s->skin[2].inverse_bind[13] == 8);
    assert_true(s->instance[0].skin == 1 && s->instance[0].node == 0);
    glint_scene_destroy(&s);
    free(text);
}

static void every_fault_of_skins_is_named(void **state)
{
    (void)state;
    const float bind[16] = {1, 0, 0, 0.5f}, none[16] = {NAN};
    const struct glint_asset asset[2] = {name_asset(bind, 64), name_asset(none, 64)};
    char *text = NULL;
    assert_true(
        asprintf(&text,
                 "{" SKINNED ",'skins':{'a':{},'b':{'joints':[]},'c':{'joints':['a','x',7]},"
                 "'d':{'joints':['a'],'inverse_bind':[1]},'e':{'joints':['a'],'asset':'%s'},"
                 "'f':{'joints':['a'],'asset':'%s'},'g':{'joints':['a','b'],'asset':'%s'},"
                 "'h':{'joints':['a'],'inverse_bind':[],'asset':'%s'}}}",
                 asset[0].sha256, asset[1].sha256, asset[0].sha256, asset[0].sha256) > 0);
    refuse_with(text, asset, 2,
                "/skins/a/joints=required|/skins/b/joints=not 0|/skins/c/joints/1=no node|"
                "/skins/c/joints/2|/skins/d/inverse_bind|/skins/e/asset=not affine|"
                "/skins/f/asset=not finite|/skins/g/asset=64 bytes|/skins/h/asset=either");
    free(text);
}

static void a_skinned_mesh_names_joints_that_the_skin_has(void **state)
{
    (void)state;
    refuse("{" SKINNED ",'skins':{'one':{'joints':['a']},'two':{'joints':['a','b']}},'instances':{"
           "'i':{'mesh':'t','material':'m','skin':'one'},'j':{'mesh':'r','material':'m','skin':"
           "'two'},'k':{'mesh':'t','material':'m','skin':'three'},'l':{'mesh':'t','material':'m',"
           "'skin':'two'}}}",
           "/instances/i/skin=names joint 1; the skin has 1|/instances/j/skin=no joints|"
           "/instances/k/skin=no skin");
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(inline_attributes_arrive),
        cmocka_unit_test(colors_are_cut_at_one_and_never_negative),
        cmocka_unit_test(weights_sum_to_one_and_go_with_joints),
        cmocka_unit_test(what_a_target_leaves_out_is_zero),
        cmocka_unit_test(every_fault_of_targets_is_named),
        cmocka_unit_test(weights_of_an_instance_are_as_many_as_the_targets),
        cmocka_unit_test(an_asset_has_its_arrays_in_the_order_of_the_contract),
        cmocka_unit_test(what_an_asset_holds_of_each_array_is_checked),
        cmocka_unit_test(what_is_said_of_an_asset_must_be_sound),
        cmocka_unit_test(a_skin_has_joints_and_identities_unless_it_says_so),
        cmocka_unit_test(every_fault_of_skins_is_named),
        cmocka_unit_test(a_skinned_mesh_names_joints_that_the_skin_has),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
