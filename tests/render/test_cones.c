// The cone of a camera sample, whose width decides what rough lobes hand on: in a parallel view, bent by
// surfaces, refracted, of a frame of another size; and where what is handed on is written.
//
// Of each: n = 98 304 samples in 384 pixels, s = 0.5 at most, so that a mean that is d = 0.013 off is
// missed once in a thousand; the deviation that is used is the one seen, which is less.
#include "tests/odds.h"
#include "tests/render/bounced.h"
#include "tests/stability/stable.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define CEILING 30.0 // metres above the floor
#define TO_FLOOR 5.0 // metres from the camera, whose view meets the floor at a cosine of 0.6
#define HALF_PIXEL (0.0005 / 16)
#define ROUNDED 1e-4 // what rings and turns leave out of an integral
#define CURVED 4e-4  // where normals or ways differ within the view

#define ABOVE "'transform':{'translation':[0,3,4],'rotation':[-0.316227766,0,0,0.948683298]}"
#define NARROW "'yfov':0.001," ABOVE
#define PARALLEL "'projection':'orthographic','ymag':0.0025," ABOVE
#define UNDER(camera, meshes, material, floor, more, objects)                                      \
    "{'cameras':{'c':{" camera "}},'environment':{'radiance':[1,1,1]},"                            \
    "'meshes':{'quad':{'primitive':'quad'}," meshes "},"                                           \
    "'materials':{'floor':{" material "},'paint':{'ior':1,'base_color':[0,0,0]}," more "},"        \
    "'objects':{'floor':{},'ceiling':{},'glass':{}" objects "},'instances':{" floor ",'ceiling':{" \
    "'object':'ceiling','mesh':'quad','material':'paint','transform':{'translation':[0,30,0],"     \
    "'rotation':[-0.707106781,0,0,0.707106781],'scale':[1e5,1e5,1]}}}}"
#define METAL "'metallic':1,'roughness':0.3,'base_color':[0.7,0.7,0.7]"
#define FLAT                                                                    \
    "'floor':{'object':'floor','mesh':'quad','material':'floor','transform':{'" \
    "rotation':[0.707106781,0,0,0.707106781],'scale':[2,2,1]}}"
#define WITH_BOX "'box':{'primitive':'box'}"
#define NONE "'none':{}"
#define JOB(size, mattes, more)                                                          \
    "{'scene':'s','resolution':" size ",'outputs':['beauty','crypto_object'],'stop':{"   \
    "'samples':256},'accuracy':{'microfacet':'single'}," more "'filter':{'kind':'box'}," \
    "'mattes':{'through':'glossy'," mattes "}}"
#define SMALL "[24,16]"

static const struct ceiling flat_metal = {
    .material = {.name = "", .base = 0.7f, .metallic = 1, .roughness = 0.3f, .ior = 1.5f},
    .height = CEILING,
    .cosine = 0.6,
    .radius = HALF_PIXEL * TO_FLOOR,
    .slope = HALF_PIXEL,
    .alpha = 0.1,
    .cut = true};

// Of the matte of a name against what it should have.
#define assert_mean(scene, job, type, name, want, slack)                                        \
    do {                                                                                        \
        struct shot shot_of;                                                                    \
        double error_of;                                                                        \
        bounced_take(&shot_of, scene, job);                                                     \
        const double mean_of = bounced_mean(&shot_of, type, name, &error_of), want_of = (want); \
        print_message("# %.5f, by quadrature %.5f, error %.5f\n", mean_of, want_of, error_of);  \
        assert_odds(mean_of - want_of, error_of, slack);                                        \
        finish_shot(&shot_of);                                                                  \
    } while (0)

static void in_a_parallel_view_cones_stay_as_wide_as_a_pixel(void **state)
{
    (void)state;
    struct ceiling c = flat_metal;
    c.radius = 0.0025 / 16;
    c.slope = 0.0;
    assert_mean(UNDER(PARALLEL, WITH_BOX, METAL, FLAT, NONE, ""), JOB(SMALL, "'alpha':0.1", ""),
                "CryptoGlossObject", "ceiling", ceiling_share(&c), ROUNDED);
}

// A square of two triangles on the floor whose normals lean outwards by `bend` a metre; its mesh is ten
// times as large.
static void print_bent(char *out, size_t size, double bend)
{
    const double lean = 0.1 * bend, k = 1.0 / sqrt(1.0 + 2.0 * lean * lean);
    snprintf(out, size,
             UNDER(NARROW,
                   "'bent':{'indices':[0,1,2,0,2,3],'positions':[-1,0,1,1,0,1,1,0,-1,-1,0,-1],'"
                   "normals':[%.9f,%.9f,%.9f,%.9f,%.9f,%.9f,%.9f,%.9f,%.9f,%.9f,%.9f,%.9f]}",
                   METAL,
                   "'floor':{'object':'floor','mesh':'bent','material':'floor','transform':{'scale'"
                   ":[0.1,0.1,0.1]}}",
                   NONE, ""),
             -lean * k, k, lean * k, lean * k, k, lean * k, lean * k, k, -lean * k, -lean * k, k,
             -lean * k);
}

// A mirror of curvature 0.06 would make the cone of its view parallel; Eq. 6 takes it for straight.
static void rough_mirrors_widen_and_narrow_cones_by_their_curvature(void **state)
{
    (void)state;
    static const struct {
        double bend;
        const char *job;
        bool clamped;
    } rule[] = {{1.0, JOB(SMALL, "'clamp':true", ""), false},
                {-0.06, JOB(SMALL, "'clamp':false", ""), false},
                {-0.06, JOB(SMALL, "'clamp':true", ""), true}};
    for (size_t i = 0; i < COUNT(rule); i++) {
        char scene[2048];
        struct ceiling c = flat_metal;
        print_bent(scene, sizeof scene, rule[i].bend);
        if (!rule[i].clamped)
            c.slope += 2.0 * rule[i].bend * c.radius / 0.6;
        assert_mean(scene, rule[i].job, "CryptoGlossObject", "ceiling", ceiling_share(&c), CURVED);
    }
}

// Under glass 30 m deep, which the path does not leave: metal keeps what the lobe does not hand on.
static void glass_narrows_the_cones_that_enter_it(void **state)
{
    (void)state;
    const double cosine = sqrt(1.0 - 0.64 / 2.25), slope = HALF_PIXEL / 1.5;
    struct ceiling c = flat_metal;
    c.cosine = cosine;
    c.radius = HALF_PIXEL * TO_FLOOR + slope * CEILING / cosine;
    c.slope = slope;
    const double enters = 1.0 - exact_fresnel(0.6, 1.5);
    assert_mean(UNDER(NARROW, WITH_BOX, METAL,
                      "'glass':{'object':'glass','mesh':'box','material':'glass','transform':{"
                      "'translation':[0,-50,0],'scale':[2e4,100,2e4]}},'floor':{'object':'floor',"
                      "'mesh':'quad','material':'floor','transform':{'translation':[0,-30,0],"
                      "'rotation':[0.707106781,0,0,0.707106781],'scale':[8e3,8e3,1]}}",
                      "'glass':{'transmission':1,'roughness':0,'ior':1.5}", ""),
                JOB(SMALL, "'clamp':false", "'max_bounces':2,"), "CryptoGlossObject", "floor",
                enters * (1.0 - ceiling_share(&c)), CURVED);
}

// Glass reflects a twentieth of what comes: its lobe is as narrow as if it reflected all.
static void what_a_surface_lets_through_does_not_widen_its_reflection(void **state)
{
    (void)state;
    struct ceiling c = flat_metal;
    c.material = (struct material){
        .name = "", .base = 1.0f, .transmission = 1, .roughness = 0.4f, .ior = 1.5f};
    c.shared = true;
    assert_mean(UNDER(NARROW, WITH_BOX, "'transmission':1,'roughness':0.4,'ior':1.5",
                      "'floor':{'object':'floor','mesh':'box','material':'floor','transform':{"
                      "'translation':[0,-50,0],'scale':[200,100,200]}}",
                      NONE, ""),
                JOB(SMALL, "'classes':true", "'max_bounces':1,"), "CryptoReflObject", "ceiling",
                ceiling_share(&c), ROUNDED);
}

// A varnish without roughness reflects by a delta, which is handed on whole; what is below it has the
// density that it has without the varnish.
static void a_delta_lobe_does_not_widen_those_beside_it(void **state)
{
    (void)state;
    struct ceiling c = flat_metal;
    c.material = (struct material){.name = "", .base = 0.7f, .ior = 1.5f};
    c.shared = true;
    c.cut = false;
    assert_mean(UNDER(NARROW, WITH_BOX, "'roughness':0,'ior':1.5,'base_color':[0.7,0.7,0.7]", FLAT,
                      NONE, ""),
                JOB(SMALL, "'diffuse_cut':false", "'max_bounces':1,"), "CryptoGlossObject",
                "ceiling", exact_fresnel(0.6, 1.5) + ceiling_share(&c), CURVED);
}

static void frames_of_any_size_weigh_as_the_one_that_is_named(void **state)
{
    (void)state;
    static const struct {
        const char *job;
        double pixel;
    } rule[] = {{JOB(SMALL, "'alpha':0.1", ""), 1.0},
                {JOB(SMALL, "'cone_width':480", ""), 0.05},
                {JOB("[48,32]", "'cone_width':24", ""), 1.0},
                {JOB("[48,32]", "'cone_width':0", ""), 0.5}};
    for (size_t i = 0; i < COUNT(rule); i++) {
        struct ceiling c = flat_metal;
        c.radius *= rule[i].pixel;
        c.slope *= rule[i].pixel;
        assert_mean(UNDER(NARROW, WITH_BOX, METAL, FLAT, NONE, ""), rule[i].job,
                    "CryptoGlossObject", "ceiling", ceiling_share(&c), ROUNDED);
    }
}

// All weights are 1 then: the program without cones makes the same bits.
static void at_alpha_0_no_cone_is_kept_and_none_is_missed(void **state)
{
    (void)state;
    const uint64_t cones = glint_effect_bit("mattes through glossy lobes");
    struct shot s;
    bounced_take(&s, UNDER(NARROW, WITH_BOX, METAL, FLAT, NONE, ""), JOB(SMALL, "'alpha':0", ""));
    assert_true(cones != 0 && (s.render->view->plan.called & cones) == 0);
    char *scene = stable_text(UNDER(NARROW, WITH_BOX, METAL, FLAT, NONE, ""));
    char *job = stable_text(JOB(SMALL, "'alpha':0", ""));
    glint_resident *resident = offline_load_text(&things_crew, scene);
    struct glint_frame *forced = offline_frame(&things_crew, resident, job, cones);
    stable_assert_same(forced, s.frame);
    assert_true(coverage_of(forced, "CryptoGlossObject", "ceiling", 0) > 0.4);
    glint_frame_destroy(&forced);
    glint_resident_release(&resident);
    free(scene);
    free(job);
    finish_shot(&s);
}

// ---- where it is written

// A grey mirror 0.25 m away, whose view is of a wall %g m behind the camera or of the sky.
static const char behind[] =
    "{'cameras':{'c':{'yfov':0.001}},'environment':{'radiance':[1,1,1]},"
    "'meshes':{'quad':{'primitive':'quad'}},"
    "'materials':{'m':{'metallic':1,'roughness':0,'base_color':[0.5,0.5,0.5]},"
    "'paint':{'ior':1,'base_color':[0,0,0]}},'objects':{'mirror':{},'wall':{}},'instances':{"
    "'mirror':{'object':'mirror','mesh':'quad','material':'m','transform':{'rotation':[0,1,0,0],"
    "'translation':[0,0,-0.25]}},'wall':{'object':'wall','mesh':'quad','material':'paint',"
    "'transform':{'translation':[%g,0,%g],'scale':[10,10,1]}}}}";

static void each_octave_of_the_way_has_its_bin(void **state)
{
    (void)state;
    static const double way[] = {0.95, 1.05, 1.95, 2.05, 3.95, 4.05, 100.0};
    static const int bin[] = {0, 1, 1, 2, 2, 3, 3};
    for (size_t i = 0; i < COUNT(way); i++) {
        char scene[1024];
        struct shot s;
        snprintf(scene, sizeof scene, behind, 0.0, way[i] - 0.5);
        bounced_take(&s, scene, JOB(SMALL, "'depth_bins':4", ""));
        for (int b = 0; b < 4; b++) {
            char type[24];
            snprintf(type, sizeof type, "CryptoD%dObject", b);
            assert_within(coverage_of(s.frame, type, "wall", 0) - (b == bin[i] ? 0.5 : 0.0), 2e-5);
            assert_within(coverage_of(s.frame, type, "mirror", 0) - (b == 0 ? 0.5 : 0.0), 2e-5);
        }
        finish_shot(&s);
    }
}

static void what_leaves_the_scene_covers_the_background_or_nothing(void **state)
{
    (void)state;
    char scene[1024];
    snprintf(scene, sizeof scene, behind, 1e3, 1.0);
    for (int env = 0; env < 2; env++) {
        struct shot s;
        bounced_take(&s, scene,
                     env ? JOB(SMALL, "'env_id':true", "") : JOB(SMALL, "'env_id':false", ""));
        assert_within(coverage_of(s.frame, "CryptoGlossObject", "mirror", 0) - 0.5, 2e-5);
        assert_within(coverage_of_id(s.frame, "CryptoGlossObject", 0, 0) - (env ? 0.5 : 0.0), 2e-5);
        finish_shot(&s);
    }
}

#define STRIPE(name, z)                                                               \
    ",'" name "':{'object':'" name "','mesh':'quad','material':'paint','transform':{" \
    "'translation':[0,29," #z "],'rotation':[0.707106781,0,0,0.707106781],'scale':[1e4,3,1]}}"

// One pixel of rough metal below stripes that fill its slots, with a tiny mirror that shows what is behind
// the camera: one sample in 64.
static void what_deltas_alone_have_led_to_has_the_right_of_what_is_seen(void **state)
{
    (void)state;
    static const char scene[] = UNDER(
        NARROW, WITH_BOX, METAL,
        FLAT ",'mirror':{'object':'mirror','mesh':'quad','material':'mirror','transform':{"
             "'translation':[0,2.7,3.6],'rotation':[-0.316227766,0,0,0.948683298],'scale':[6.25e-5,"
             "6.25e-5,1]}},'rare':{'object':'rare','mesh':'quad','material':'paint','transform':{"
             "'translation':[0,6,8],'rotation':[-0.316227766,0,0,0.948683298]}}" STRIPE("a", -25)
                 STRIPE("b", -30) STRIPE("d", -35) STRIPE("e", -40) STRIPE("f", -45)
                     STRIPE("g", -50) STRIPE("h", -60) STRIPE("i", -70),
        "'mirror':{'metallic':1,'roughness':0,'base_color':[1,1,1]}",
        ",'mirror':{},'rare':{},'a':{},'b':{},'d':{},'e':{},'f':{},'g':{},'h':{},'i':{}");
    static const char *const job[] = {
        JOB("[1,1]", "'slots':6,'levels':3,'eviction':'direct_first'", "'seed':1,"),
        JOB("[1,1]", "'slots':6,'levels':3,'eviction':'direct_first'", "'seed':2,"),
        JOB("[1,1]", "'slots':6,'levels':3,'eviction':'direct_first'", "'seed':3,"),
        JOB("[1,1]", "'slots':6,'levels':3,'eviction':'direct_first'", "'seed':4,")};
    for (size_t i = 0; i < COUNT(job); i++) {
        struct shot s;
        bounced_take(&s, scene, job[i]);
        const double rare = coverage_of(s.frame, "CryptoGlossObject", "rare", 0);
        print_message("# %.5f, without a slot %.5f\n", rare, lost_in(&s));
        assert_true(lost_in(&s) > 0.0);
        assert_within(rare - coverage_of(s.frame, "CryptoObject", "mirror", 0), 1e-6);
        assert_true(rare > 0.0);
        finish_shot(&s);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(in_a_parallel_view_cones_stay_as_wide_as_a_pixel),
        cmocka_unit_test(rough_mirrors_widen_and_narrow_cones_by_their_curvature),
        cmocka_unit_test(glass_narrows_the_cones_that_enter_it),
        cmocka_unit_test(what_a_surface_lets_through_does_not_widen_its_reflection),
        cmocka_unit_test(a_delta_lobe_does_not_widen_those_beside_it),
        cmocka_unit_test(at_alpha_0_no_cone_is_kept_and_none_is_missed),
        cmocka_unit_test(frames_of_any_size_weigh_as_the_one_that_is_named),
        cmocka_unit_test(each_octave_of_the_way_has_its_bin),
        cmocka_unit_test(what_leaves_the_scene_covers_the_background_or_nothing),
        cmocka_unit_test(what_deltas_alone_have_led_to_has_the_right_of_what_is_seen),
    };
    return cmocka_run_group_tests(tests, things_start, things_finish);
}
