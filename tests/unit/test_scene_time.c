// Nodes, animations, and the bounds of the world at all times.
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

#define THING "'meshes':{'q':{'primitive':'quad','size':[2,2]}},'materials':{'m':{}}"

// ---- nodes

static void a_node_remembers_how_its_transform_was_said(void **state)
{
    (void)state;
    struct glint_scene *s =
        parse("{'nodes':{'child':{'parent':'top','name':'C','transform':{'translation':[1,2,3],"
              "'rotation':[0,0,3,3],'scale':[1,2,4]}},'top':{'transform':[0,2,0,0, -1,0,0,0, "
              "0,0,1,0, 5,6,7,1]},'rest':{}}}");
    const struct glint_node *n = s->node;
    assert_true(n[0].parent == 1 && n[1].parent == GLINT_NONE && !n[0].matrix && n[1].matrix);
    assert_string_equal(n[0].name, "C");
    assert_string_equal(n[1].name, "top");
    assert_true(fabsf(n[0].rotation[2] - sqrtf(0.5f)) < 1e-7f && n[0].scale[2] == 4);
    assert_true(fabsf(n[0].transform[1] - 1) < 1e-7f && fabsf(n[0].transform[4] + 2) < 1e-7f);
    assert_true(n[0].transform[14] == 3 && n[1].transform[1] == 2);
    assert_true(n[2].scale[1] == 1 && n[2].rotation[3] == 1 && n[2].transform[5] == 1);
    struct glint_arena scratch = {0};
    double(*world)[16] = glint_nodes_world(s, &scratch);
    // (1, 2, 3) through the parent: x to 2 y, y to -x, then moved.
    assert_true(world[0][12] == 5 - 2 && world[0][13] == 6 + 2 && world[0][14] == 7 + 3);
    glint_arena_finish(&scratch);
    glint_scene_destroy(&s);
}

static void every_fault_of_nodes_is_named(void **state)
{
    (void)state;
    refuse("{'nodes':{'a':{'parent':'x'},'b':{'parent':7},'c':{'transform':[1,0,0]},"
           "'d':{'transform':{'scale':[0,1,1]}},'e':{'transform':{'rotation':[0,0,0,0]}},"
           "'f':{'transform':[1,0,0,0.5, 0,1,0,0, 0,0,1,0, 0,0,0,1]},'g':{'visible':true},'h':1},"
           "'instances':{'i':{'node':'nobody'}}}",
           "/nodes/a/parent=no node|/nodes/b/parent=string|/nodes/c/transform|"
           "/nodes/d/transform=singular|/nodes/e/transform/rotation=zero|"
           "/nodes/f/transform=not affine|/nodes/g/visible|/nodes/h|/instances/i/node=no node|"
           "/instances/i/mesh|/instances/i/material");
    refuse("{'nodes':[]}", "/nodes");
}

static void every_circle_of_parents_is_named_once(void **state)
{
    (void)state;
    refuse("{'nodes':{'self':{'parent':'self'},'fine':{},'a':{'parent':'b'},'b':{'parent':'c'},"
           "'c':{'parent':'b'},'tail':{'parent':'a'},'leaf':{'parent':'fine'}}}",
           "/nodes/self/parent=above itself|/nodes/b/parent=above itself");
}

// A chain of 100000 nodes, the deepest first.
static void a_deep_chain_takes_linear_time(void **state)
{
    (void)state;
    const int depth = 100000;
    struct glint_text t = {0};
    glint_text_add(&t, "{" THING ",'instances':{'i':{'mesh':'q','material':'m','node':'n0'}},"
                       "'nodes':{");
    for (int i = 0; i + 1 < depth; i++)
        glint_text_print(&t, "'n%d':{'parent':'n%d','transform':{'translation':[1,0,0]}},", i,
                         i + 1);
    glint_text_print(&t, "'n%d':{}}}", depth - 1);
    char *text = glint_text_take(&t, NULL);
    struct glint_scene *s = parse(text);
    assert_int_equal(s->nodes, depth);
    // The camera that was added looks at where the chain leads.
    const float *c = s->camera[0].transform;
    assert_true(fabsf(c[12] - (float)(depth - 1)) < 20);
    glint_scene_destroy(&s);
    free(text);
}

static void what_is_singular_together_with_its_parents_is_refused(void **state)
{
    (void)state;
    refuse("{" THING ",'nodes':{'small':{'transform':{'scale':[1e-7,1,1]}},'smaller':{'parent':"
           "'small','transform':{'scale':[1e-7,1,1]}},'skew':{'transform':{'rotation':[0,0,"
           "0.38268343,0.92387953],'scale':[1e-4,1e4,1]}}},"
           "'instances':{'i':{'mesh':'q','material':'m','node':'small','transform':{'scale':[1e-6,"
           "1,1]}},'j':{'mesh':'q','material':'m','node':'skew','transform':{'rotation':[0,0,"
           "0.38268343,0.92387953],'scale':[1,1,1]}},'k':{'mesh':'q','material':'m','node':"
           "'small'}},'cameras':{'c':{'yfov':1,'node':'skew','transform':{'rotation':[0,0,"
           "0.38268343,0.92387953]}}},'lights':{'l':{'type':'sun','node':'small','transform':{"
           "'scale':[1e-6,1,1]}}}}",
           "/nodes/smaller=singular|/instances/i=singular|/instances/j=singular|"
           "/cameras/c=singular|/lights/l=singular");
}

// ---- the bounds of the world

static void the_world_ends_where_it_ends_for_what_stands_on_nodes(void **state)
{
    (void)state;
    refuse("{" THING ",'nodes':{'far':{'transform':{'translation':[9e11,0,0]}},'farther':{'parent':"
           "'far','transform':{'translation':[9e11,0,0]}},'big':{'transform':{'scale':[1e6,1,1]}}},"
           "'instances':{'i':{'mesh':'q','material':'m','node':'far','transform':{'translation':"
           "[2e11,0,0]}},'j':{'mesh':'q','material':'m','node':'big','transform':{'scale':[1e7,1,1]"
           "}},'k':{'mesh':'q','material':'m','node':'far'}},'lights':{'l':{'type':'point','node':"
           "'far','transform':{'translation':[2e11,0,0]}}},'cameras':{'c':{'yfov':1,'node':'big',"
           "'transform':{'translation':[2e6,0,0]}}}}",
           "/nodes/farther=node reaches|/instances/i=instance reaches|/instances/j=reaches|"
           "/lights/l=light reaches|/cameras/c=camera reaches");
}

static void an_animation_cannot_lead_out_of_the_world(void **state)
{
    (void)state;
    static const struct {
        const char *channel, *faults;
    } cases[] = {
        {"'path':'translation','times':[0,1],'values':[0,0,0, 1e12,1e12,0]",
         "/nodes/n=reaches|/instances/i=reaches"},
        {"'path':'scale','times':[0,1],'values':[1,1,1, 1,1,1e12]", "/instances/i=reaches"},
        // Between two keys at rest the tangents throw it far out: 4/27 10 2e12.
        {"'path':'translation','interpolation':'cubicspline','times':[0,10],"
         "'values':[0,0,0, 0,0,0, 1e12,0,0, -1e12,0,0, 0,0,0, 0,0,0]",
         "/nodes/n=reaches|/instances/i=reaches"},
        {"'path':'weights','times':[0],'values':[1e6]", "/instances/i=deformed mesh reaches"},
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        char *text = NULL;
        assert_true(asprintf(&text,
                             "{'meshes':{'t':{'positions':[0,0,0, 1,0,0, 0,1,0],'targets':[{"
                             "'positions':[0,0,0, 0,0,0, 2e6,0,0]}]}},'materials':{'m':{}},"
                             "'nodes':{'n':{}},'instances':{'i':{'mesh':'t','material':'m','node':"
                             "'n'}},'animations':{'a':{'channels':{'c':{'node':'n',%s}}}}}",
                             cases[i].channel) > 0);
        refuse(text, cases[i].faults);
        free(text);
    }
}

static void a_skin_cannot_lead_out_of_the_world(void **state)
{
    (void)state;
    refuse(
        "{'meshes':{'t':{'positions':[0,0,0, 1,0,0, 0,1,0],'joints':[0,0,0,0, 0,0,0,0, 0,0,0,0],"
        "'weights':[1,0,0,0, 1,0,0,0, 1,0,0,0]}},'materials':{'m':{}},'nodes':{'n':{},'big':{"
        "'transform':{'scale':[1e8,1e8,1e8]}}},'skins':{'s':{'joints':['n','big'],'inverse_bind':"
        "[1,0,0,0, 0,1,0,0, 0,0,1,0, 0,0,0,1, 1e5,0,0,0, 0,1,0,0, 0,0,1,0, 0,0,0,1]}},"
        "'instances':{'i':{'mesh':'t','material':'m','skin':'s'}}}",
        "/instances/i=reaches");
}

// Rotations stretch nothing: 300 joints in a row, each turned about an axis of its own.
static void a_long_limb_stays_in_the_world(void **state)
{
    (void)state;
    struct glint_text t = {0};
    glint_text_add(&t, "{" THING ",'nodes':{'n0':{}");
    for (int i = 1; i < 300; i++)
        glint_text_print(&t, ",'n%d':{'parent':'n%d','transform':%s}", i, i - 1,
                         i % 2 ? "{'translation':[0,1,0],'rotation':[1,2,3,4]}"
                               : "[0,1,0,0, 0,0,1,0, 1,0,0,0, 0,1,0,1]");
    glint_text_add(&t, "},'instances':{'i':{'mesh':'q','material':'m','node':'n299'}}}");
    char *text = glint_text_take(&t, NULL);
    struct glint_scene *s = parse(text);
    glint_scene_destroy(&s);
    free(text);
}

static void a_matrix_stretches_by_its_largest_singular_value(void **state)
{
    (void)state;
    static const float all[][16] = {{3, 0, 0, 0, 0, -5, 0, 0, 0, 0, 2, 0, 0, 0, 0, 1},
                                    {0, 2, 0, 0, -2, 0, 0, 0, 0, 0, 2, 0, 0, 0, 0, 1},
                                    {1, 0, 0, 0, 1, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1},
                                    {0}};
    const double want[] = {5, 2, 0.5 * (1 + sqrt(5)), 0}; // of a shear by 1: the golden ratio
    for (int i = 0; i < 4; i++)
        assert_true(fabs(glint_transform_stretch(all[i]) - want[i]) < 1e-7);
}

static void the_added_camera_frames_what_stands_on_nodes_and_skins(void **state)
{
    (void)state;
    struct glint_scene *s = parse(
        "{'meshes':{'t':{'positions':[0,0,0, 1,0,0, 0,1,0],'joints':[0,0,0,0, 0,0,0,0, 0,0,0,0],"
        "'weights':[1,0,0,0, 1,0,0,0, 1,0,0,0]}},'materials':{'m':{}},'nodes':{'n':{'transform':{"
        "'translation':[1000,0,0]}}},'skins':{'s':{'joints':['n']}},"
        "'instances':{'i':{'mesh':'t','material':'m','skin':'s','transform':{'translation':"
        "[0,500,0]}},'j':{'mesh':'t','material':'m','node':'n','transform':{'translation':"
        "[0,500,0]}}}}");
    const float *c = s->camera[0].transform;
    assert_true(fabsf(c[12] - 1000) < 5 && fabsf(c[13] - 500) < 5);
    glint_scene_destroy(&s);
}

// ---- animations

#define MORPHS                                                                                  \
    "'meshes':{'two':{'positions':[0,0,0, 1,0,0, 0,1,0],'targets':[{},{}]},'one':{'positions':" \
    "[0,0,0, 1,0,0, 0,1,0],'targets':[{}]},'none':{'primitive':'quad'}},'materials':{'m':{}}"

static void channels_have_keys_of_their_paths_width(void **state)
{
    (void)state;
    const float keys[2 + 2 * 3 * 2] = {0, 0.5f, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12};
    const struct glint_asset asset = name_asset(keys, sizeof keys);
    char *text = NULL;
    assert_true(
        asprintf(&text,
                 "{" MORPHS
                 ",'nodes':{'n':{}},'instances':{'i':{'mesh':'two','material':'m','node':"
                 "'n'},'j':{'mesh':'none','material':'m','node':'n'}},'animations':{'a':{'name':"
                 "'Walk','channels':{'t':{'node':'n','path':'translation','interpolation':'step',"
                 "'times':[0,2],'values':[1,2,3, 4,5,6]},'r':{'node':'n','path':'rotation','times':"
                 "[1],'values':[0,0,0,1]},'w':{'node':'n','path':'weights','interpolation':"
                 "'cubicspline','asset':'%s','keys':2}}},'b':{}}}",
                 asset.sha256) > 0);
    struct glint_scene *s = parse_with(text, &asset, 1);
    assert_true(s->animations == 2 && s->animation[0].channels == 3 && !s->animation[1].channels);
    assert_string_equal(s->animation[0].name, "Walk");
    assert_string_equal(s->animation[1].name, "b");
    const struct glint_animation_channel *c = s->animation[0].channel;
    assert_true(c[0].width == 3 && c[0].keys == 2 && c[0].value[5] == 6 && c[0].time[1] == 2);
    assert_int_equal(c[0].interpolation, GLINT_INTERPOLATION_STEP);
    assert_true(c[1].width == 4 && c[1].path == GLINT_PATH_ROTATION && c[1].asset[0] == 0);
    assert_true(c[2].width == 2 && c[2].value[11] == 12 && c[2].time[1] == 0.5f);
    assert_string_equal(c[2].asset, asset.sha256);
    glint_scene_destroy(&s);
    free(text);
}

static void every_fault_of_channels_is_named(void **state)
{
    (void)state;
    refuse("{'nodes':{'n':{},'m':{'transform':[1,0,0,0, 0,1,0,0, 0,0,1,0, 0,0,0,1]}},'animations':"
           "{'x':{'speed':2,'channels':{'a':{},'b':{'node':'z','path':'scale'},'c':{'node':'n',"
           "'path':'colour'},'d':{'node':'m','path':'scale','times':[0],'values':[1,1,1]},"
           "'e':{'node':'n','path':'scale'},'f':{'node':'n','path':'rotation','interpolation':"
           "'bezier'},'g':{'node':'n','path':'translation','times':[],'values':[],'keys':1}}},"
           "'y':{'channels':[]}}}",
           "/animations/x/speed|/animations/x/channels/a/node=required|"
           "/animations/x/channels/a/path=required|/animations/x/channels/b/node=no node|"
           "/animations/x/channels/c/path=weights|/animations/x/channels/d/node=matrix|"
           "/animations/x/channels/e/times=required|/animations/x/channels/e/values=required|"
           "/animations/x/channels/f/interpolation=cubicspline|"
           "/animations/x/channels/g/keys|/animations/y/channels");
}

// One channel of translations, else as given.
static char *channel(const char *members)
{
    char *text = NULL;
    assert_true(asprintf(&text,
                         "{'nodes':{'n':{}},'animations':{'x':{'channels':{'c':{'node':'n',"
                         "%s}}}}}",
                         members) > 0);
    return text;
}

#define AT "/animations/x/channels/c"

static void times_are_finite_and_grow(void **state)
{
    (void)state;
    static const struct {
        const char *channel, *faults;
    } cases[] = {
        {"'path':'scale','times':[0,1,1],'values':[1,1,1, 1,1,1, 1,1,1]", AT "/times/2=come after"},
        {"'path':'scale','times':[2,1],'values':[1,1,1, 1,1,1]", AT "/times/1=come after"},
        {"'path':'scale','times':[-1],'values':[1,1,1]", AT "/times/0=outside"},
        {"'path':'scale','times':[1e10],'values':[1,1,1]", AT "/times/0"},
        {"'path':'scale','times':['now'],'values':[1,1,1]", AT "/times/0"},
        {"'path':'scale','times':[],'values':[]", AT "/times=at least one"},
        {"'path':'scale','times':[0],'values':[1,1]", AT "/values=3 numbers are expected for 1"},
        {"'path':'scale','interpolation':'cubicspline','times':[0],'values':[1,1,1]",
         AT "/values=9 numbers"},
        {"'path':'scale','times':[0],'values':[1,1e13,1]", AT "/values/1"},
        {"'path':'rotation','times':[0],'values':[0,0,0,0.9]", AT "/values/0=length 0.9"},
        {"'path':'rotation','times':[0,1],'values':[0,0,0,1, 0,0,0,0]", AT "/values/4=length 0"},
        {"'path':'rotation','interpolation':'cubicspline','times':[0],'values':[0,0,0,0, "
         "0,0,0,2, 0,0,0,0]",
         AT "/values/4=length 2"},
        {"'path':'weights','times':[0],'values':[1]", AT "/node=no instance"},
        {"'path':'scale','times':{},'values':7", AT "/times|" AT "/values"},
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        char *text = channel(cases[i].channel);
        refuse(text, cases[i].faults);
        free(text);
    }
}

static void keys_of_an_asset_are_checked_as_well(void **state)
{
    (void)state;
    static const float good[8] = {0, 1, 1, 1, 1, 2, 2, 2}, same[8] = {1, 1}, nan[8] = {NAN, 1},
                       late[8] = {0, 2e9f}, far[8] = {0, 1, 0, 0, INFINITY};
    const float *const all[] = {good, same, nan, late, far};
    for (size_t i = 0; i < 5; i++) {
        const struct glint_asset asset = name_asset(all[i], sizeof good);
        char members[256];
        snprintf(members, sizeof members, "'path':'scale','asset':'%s','keys':2", asset.sha256);
        char *text = channel(members);
        if (i) {
            refuse_with(text, &asset, 1, AT "/asset");
        } else {
            struct glint_scene *s = parse_with(text, &asset, 1);
            assert_ptr_equal(s->animation[0].channel[0].time, good);
            assert_ptr_equal(s->animation[0].channel[0].value, good + 2);
            glint_scene_destroy(&s);
        }
        free(text);
    }
    const struct glint_asset asset = name_asset(good, sizeof good);
    static const struct {
        const char *rest, *faults;
    } wrong[] = {{"'keys':3", AT "/asset=bytes"},
                 {"'keys':0", AT "/keys"},
                 {"'keys':2147483647", AT "/asset=bytes"},
                 {"'times':[0]", AT "/asset=either"},
                 {"'interpolation':'linear'", AT "/keys=required"}};
    for (size_t i = 0; i < sizeof wrong / sizeof *wrong; i++) {
        char members[256];
        snprintf(members, sizeof members, "'path':'scale','asset':'%s',%s", asset.sha256,
                 wrong[i].rest);
        char *text = channel(members);
        refuse_with(text, &asset, 1, wrong[i].faults);
        free(text);
    }
}

static void rotations_are_made_unit_where_they_are_nearly(void **state)
{
    (void)state;
    struct glint_scene *s =
        parse("{'nodes':{'n':{}},'animations':{'x':{'channels':{'c':{'node':'n','path':'rotation',"
              "'times':[0,1],'values':[0,0,0,1.01, 0.6,0,0,0.8]}}},'y':{'channels':{'c':{'node':"
              "'n','path':'rotation','interpolation':'cubicspline','times':[0],'values':[9,9,9,9, "
              "0,0,0,1.01, -9,0,0,0]}}}}}");
    const float *v = s->animation[0].channel[0].value;
    assert_true(v[3] == 1 && v[4] == 0.6f && v[7] == 0.8f);
    assert_true(s->animation[1].channel[0].value[7] == 1.01f);
    glint_scene_destroy(&s);
}

static void two_channels_of_one_node_and_path_are_a_fault(void **state)
{
    (void)state;
    const char *const one = "'times':[0],'values':[1,1,1]";
    char *text = NULL;
    assert_true(
        asprintf(&text,
                 "{'nodes':{'n':{},'o':{}},'animations':{'x':{'channels':{'a':{'node':'n','path':"
                 "'scale',%s},'b':{'node':'n','path':'translation',%s},'c':{'node':'o','path':"
                 "'scale',%s},'d':{'node':'n','path':'scale',%s}}},'y':{'channels':{'a':{'node':"
                 "'n','path':'scale',%s}}}}}",
                 one, one, one, one, one) > 0);
    refuse(text, "/animations/x/channels/d=another channel");
    free(text);
}

static void weights_are_as_wide_as_the_meshes_on_the_node(void **state)
{
    (void)state;
    static const char format[] =
        "{" MORPHS ",'nodes':{'n':{},'o':{'transform':[1,0,0,0, 0,1,0,0, 0,0,1,0, 0,0,0,1]}},"
        "'instances':{'i':{'mesh':'two','material':'m','node':'%s'},'j':{'mesh':'one','material':"
        "'m','node':'%s'}},'animations':{'x':{'channels':{'c':{'node':'o','path':'weights',"
        "'times':[0],'values':[1]}}}}}";
    static const struct {
        const char *of_two, *of_one, *faults;
    } cases[] = {{"o", "n", AT "/values=2 numbers"},
                 {"o", "o", AT "/node=different numbers"},
                 {"n", "n", AT "/node=no instance"},
                 {"n", "o", NULL}}; // the node's matrix does not matter to weights
    for (size_t i = 0; i < 4; i++) {
        char *text = NULL;
        assert_true(asprintf(&text, format, cases[i].of_two, cases[i].of_one) > 0);
        if (cases[i].faults) {
            refuse(text, cases[i].faults);
        } else {
            struct glint_scene *s = parse(text);
            assert_int_equal(s->animation[0].channel[0].width, 1);
            glint_scene_destroy(&s);
        }
        free(text);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_node_remembers_how_its_transform_was_said),
        cmocka_unit_test(every_fault_of_nodes_is_named),
        cmocka_unit_test(every_circle_of_parents_is_named_once),
        cmocka_unit_test(a_deep_chain_takes_linear_time),
        cmocka_unit_test(what_is_singular_together_with_its_parents_is_refused),
        cmocka_unit_test(the_world_ends_where_it_ends_for_what_stands_on_nodes),
        cmocka_unit_test(an_animation_cannot_lead_out_of_the_world),
        cmocka_unit_test(a_skin_cannot_lead_out_of_the_world),
        cmocka_unit_test(a_long_limb_stays_in_the_world),
        cmocka_unit_test(a_matrix_stretches_by_its_largest_singular_value),
        cmocka_unit_test(the_added_camera_frames_what_stands_on_nodes_and_skins),
        cmocka_unit_test(channels_have_keys_of_their_paths_width),
        cmocka_unit_test(every_fault_of_channels_is_named),
        cmocka_unit_test(times_are_finite_and_grow),
        cmocka_unit_test(keys_of_an_asset_are_checked_as_well),
        cmocka_unit_test(rotations_are_made_unit_where_they_are_nearly),
        cmocka_unit_test(two_channels_of_one_node_and_path_are_a_fault),
        cmocka_unit_test(weights_are_as_wide_as_the_meshes_on_the_node),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
