// Mattes through bounces: what reflections and refractions show is covered as Eq. 1 says, and nothing
// else of a frame is different for it.
#include "kernels/gk_matte.h"
#include "tests/render/bounced.h"
#include "tests/stability/stable.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define JOB(outputs, mattes, more)                                             \
    "{'scene':'s','resolution':[24,16],'outputs':['beauty'," outputs "]," more \
    "'filter':{'kind':'box'},'mattes':{" mattes "}}"
#define OBJECTS "'crypto_object'"
#define SAMPLES(n) "'stop':{'samples':" #n "},"

// A camera at the origin that looks along -z; quads are 1x1 in xy and face -z unless turned.
#define CAMERA(yfov) "'cameras':{'c':{'yfov':" #yfov "}},"
#define TURNED "'rotation':[0,1,0,0],"
#define QUAD(name, material, turned, z, size)                                                      \
    "'" name "':{'object':'" name "','mesh':'quad','material':'" material "','transform':{" turned \
    "'translation':[0,0," #z "],'scale':[" #size "," #size ",1]}}"

// ---- a room with everything: rough and smooth, metal and glass

static const char room[] = "{" CAMERA(
    0.9) "'environment':{'radiance':[1,1,1]},"
         "'meshes':{'quad':{'primitive':'quad'},'ball':{'primitive':'sphere','segments':32}},"
         "'materials':{'rough':{'metallic':1,'roughness':0.3,'base_color':[0.9,0.8,0.7]},"
         "'mirror':{'metallic':1,'roughness':0,'base_color':[0.9,0.9,0.9]},"
         "'glass':{'transmission':1,'roughness':0.1},'paint':{'base_color':[0.6,0.2,0.1]}},"
         "'objects':{'back':{},'behind':{},'glass':{},'red':{},'mirror':{}},"
         "'instances':{" QUAD("back", "rough", TURNED, -4, 3) "," QUAD(
             "behind", "paint", "", 3,
             4) ","
                "'glass':{'object':'glass','mesh':'ball','material':'glass','transform':{'"
                "translation':"
                "[-0.5,0,-2.5],'scale':[0.5,0.5,0.5]}},"
                "'red':{'object':'red','mesh':'ball','material':'paint','transform':{'translation':"
                "[0.2,0.4,-3.3],'scale':[0.3,0.3,0.3]}},"
                "'mirror':{'object':'mirror','mesh':'ball','material':'mirror','transform':{'"
                "translation':"
                "[0.6,-0.2,-2.6],'scale':[0.4,0.4,0.4]}}}}";

static double sum_of_ranks(const struct glint_frame *f, const char *type, size_t pixel)
{
    double sum = 0.0;
    for (uint32_t rank = 0; rank < 16; rank++)
        sum += rank_coverage(f, type, rank, pixel);
    return sum;
}

#define ALL "'levels':16,'slots':32,"

static void every_sample_is_given_away_whole(void **state)
{
    (void)state;
    static const char *const settings[] = {
        JOB(OBJECTS, ALL "'through':'glossy'", SAMPLES(16)),
        JOB(OBJECTS, ALL "'through':'delta'", SAMPLES(16)),
        JOB(OBJECTS, ALL "'through':'glossy','alpha':0", SAMPLES(16)),
        JOB(OBJECTS, ALL "'through':'glossy','diffuse_cut':false,'clamp':false,'variance':'eq3'",
            SAMPLES(16))};
    for (size_t i = 0; i < COUNT(settings); i++) {
        struct shot s;
        bounced_take(&s, room, settings[i]);
        for (size_t p = 0; p < pixels(s.frame); p++)
            assert_within(sum_of_ranks(s.frame, "CryptoGlossObject", p) - 1.0, 1e-6);
        assert_true(lost_in(&s) == 0.0);
        finish_shot(&s);
    }
}

// Where all names have a slot, as the scene's few have among 32.
static void exact_eviction_is_what_slots_enough_give(void **state)
{
    (void)state;
    struct shot exact, slots;
    bounced_take(&exact, room,
                 JOB(OBJECTS ",'crypto_material','matte_sums'",
                     "'through':'glossy','classes':true,'eviction':'exact'", SAMPLES(16)));
    bounced_take(&slots, room,
                 JOB(OBJECTS ",'crypto_material','matte_sums'",
                     "'through':'glossy','classes':true,'slots':32", SAMPLES(16)));
    stable_assert_same(exact.frame, slots.frame);
    const float *kept = glint_frame_find(exact.frame, "sums.primary");
    for (size_t p = 0; p < pixels(exact.frame); p++)
        assert_true(kept[p] == 1.0f);
    finish_shot(&exact);
    finish_shot(&slots);
}

// The form for many work-items, on a device that runs them one after the other: full tables are the
// same, too.
static void tables_shared_by_work_items_are_those_of_an_owner(void **state)
{
    (void)state;
    static const char *const settings[] = {
        JOB(OBJECTS ",'matte_sums'", "'through':'glossy','eviction':'exact'", SAMPLES(16)),
        JOB(OBJECTS ",'matte_sums'", ALL "'through':'glossy','classes':true", SAMPLES(16)),
        JOB(OBJECTS ",'matte_sums'", "'through':'delta','levels':1,'slots':4,'eviction':'drop'",
            SAMPLES(16))};
    const uint64_t shared = glint_effect_bit(GLINT_EFFECT_SHARED_TABLES);
    char *text = stable_text("%s", room);
    glint_resident *scene = offline_load_text(&things_crew, text);
    for (size_t i = 0; i < COUNT(settings); i++) {
        char *job = stable_text("%s", settings[i]);
        struct glint_frame *owner = offline_frame(&things_crew, scene, job, 0),
                           *many = offline_frame(&things_crew, scene, job, shared);
        stable_assert_same(many, owner);
        glint_frame_destroy(&owner);
        glint_frame_destroy(&many);
        free(job);
    }
    glint_resident_release(&scene);
    free(text);
}

static void the_picture_and_what_is_seen_directly_are_the_same_without(void **state)
{
    (void)state;
    struct shot with, without;
    bounced_take(&with, room, JOB(OBJECTS, "'through':'glossy'", SAMPLES(16)));
    bounced_take(&without, room, JOB(OBJECTS, "'through':'none'", SAMPLES(16)));
    for (uint32_t c = 0; c < without.frame->channels; c++) {
        const char *name = without.frame->channel[c].name;
        assert_int_equal(stable_equal(with.frame, without.frame, name), pixels(with.frame));
    }
    assert_true(with.frame->channels > without.frame->channels);
    finish_shot(&with);
    finish_shot(&without);
}

static void reflection_and_refraction_make_what_is_seen_by_bounces(void **state)
{
    (void)state;
    struct shot whole, parts, bins;
    bounced_take(&whole, room, JOB(OBJECTS, ALL "'through':'glossy'", SAMPLES(16)));
    bounced_take(&parts, room, JOB(OBJECTS, ALL "'through':'glossy','classes':true", SAMPLES(16)));
    bounced_take(&bins, room, JOB(OBJECTS, ALL "'through':'glossy','depth_bins':4", SAMPLES(16)));
    double reflected = 0.0, refracted = 0.0;
    for (size_t p = 0; p < pixels(whole.frame); p++) {
        const double r = coverage_of(parts.frame, "CryptoReflObject", "behind", p);
        const double t = coverage_of(parts.frame, "CryptoRefrObject", "behind", p);
        double of_bins = 0.0;
        for (int b = 0; b < 4; b++) {
            char type[24];
            snprintf(type, sizeof type, "CryptoD%dObject", b);
            of_bins += coverage_of(bins.frame, type, "behind", p);
        }
        const double all = coverage_of(whole.frame, "CryptoGlossObject", "behind", p);
        assert_within(r + t - all, 1e-6); // it is not seen directly
        assert_within(of_bins - all, 1e-6);
        reflected += r;
        refracted += t;
    }
    assert_true(reflected > 1.0 && refracted > 0.1);
    finish_shot(&whole);
    finish_shot(&parts);
    finish_shot(&bins);
}

// A mirror shows what is behind the camera through a pane: that is a reflection.
static void the_first_bounce_says_of_which_class_a_path_is(void **state)
{
    (void)state;
    static const char scene[] =
        "{" CAMERA(0.001) "'environment':{'radiance':[1,1,1]},"
                          "'meshes':{'quad':{'primitive':'quad'}},"
                          "'materials':{'m':{'metallic':1,'roughness':0,'base_color':[1,1,1]},"
                          "'g':{'transmission':1,'roughness':0,'thin':true},"
                          "'p':{'ior':1,'base_color':[0.8,0.8,0.8]}},'objects':{'mirror':{},'pane':"
                          "{},'wall':{}},"
                          "'instances':{" QUAD("mirror", "m", TURNED, -1, 100) "," QUAD(
                              "pane", "g", "", 1, 100) "," QUAD("wall", "p", "", 2, 100) "}}";
    struct shot s;
    double error;
    bounced_take(&s, scene, JOB(OBJECTS, "'through':'glossy','classes':true", SAMPLES(64)));
    assert_true(bounced_mean(&s, "CryptoReflObject", "wall", &error) > 0.9);
    assert_within(bounced_mean(&s, "CryptoRefrObject", "wall", &error), 1e-6);
    finish_shot(&s);
}

// The back of a single-sided sheet, which the camera does not see: the wall behind it is seen directly.
static void what_is_passed_unseen_is_no_bounce(void **state)
{
    (void)state;
    static const char scene[] = "{" CAMERA(
        0.001) "'environment':{'radiance':[1,1,1]},"
               "'meshes':{'quad':{'primitive':'quad'}},"
               "'materials':{'b':{'ior':1,'double_sided':false},'p':{'ior':1}},"
               "'objects':{'sheet':{},'wall':{}},'instances':{" QUAD(
                   "sheet", "b", TURNED, -1, 100) "," QUAD("wall", "p", "", -2, 100) "}}";
    struct shot s;
    double error;
    bounced_take(&s, scene, JOB(OBJECTS, "'through':'glossy','classes':true", SAMPLES(16)));
    assert_within(bounced_mean(&s, "CryptoObject", "wall", &error) - 1.0, 1e-6);
    assert_within(bounced_mean(&s, "CryptoReflObject", "wall", &error), 1e-6);
    assert_within(bounced_mean(&s, "CryptoRefrObject", "wall", &error), 1e-6);
    finish_shot(&s);
}

// ---- closed forms

// The camera between two mirrors that keep half of the light: vertex k is given 2^-k, the ninth all
// that is left.
static const char facing[] =
    "{" CAMERA(0.001) "'environment':{'radiance':[1,1,1]},'meshes':{'quad':{'primitive':'quad'}},"
                      "'materials':{'m':{'metallic':1,'roughness':0,'base_color':[0.5,0.5,0.5]}},"
                      "'objects':{'ahead':{},'behind':{}},"
                      "'instances':{" QUAD("ahead", "m", TURNED, -1, 100) "," QUAD("behind", "m",
                                                                                   "", 1, 100) "}}";

static void facing_mirrors_share_as_a_geometric_series(void **state)
{
    (void)state;
    const double ahead = 0.5 * (1.0 - pow(0.25, 4)) / 0.75 + 1.0 / 256;
    static const char *const settings[] = {
        JOB(OBJECTS, "'through':'delta'", SAMPLES(16) "'accuracy':{'roulette':'none'},"),
        JOB(OBJECTS, "'through':'glossy'", SAMPLES(16) "'accuracy':{'roulette':'none'},"),
        JOB(OBJECTS, "'through':'glossy'", SAMPLES(256))};
    for (size_t i = 0; i < COUNT(settings); i++) {
        struct shot s;
        double error;
        bounced_take(&s, facing, settings[i]);
        const double mean = bounced_mean(&s, "CryptoGlossObject", "ahead", &error);
        assert_odds(mean - ahead, error, 8.0 / GK_MATTE_ONE);
        finish_shot(&s);
    }
}

static void in_a_scene_of_deltas_lobes_change_no_bit(void **state)
{
    (void)state;
    struct shot delta, glossy;
    bounced_take(&delta, facing, JOB(OBJECTS, "'through':'delta'", SAMPLES(64)));
    bounced_take(&glossy, facing, JOB(OBJECTS, "'through':'glossy'", SAMPLES(64)));
    stable_assert_same(delta.frame, glossy.frame);
    assert_true(coverage_of(delta.frame, "CryptoGlossObject", "behind", 0) > 0.1);
    finish_shot(&delta);
    finish_shot(&glossy);
}

static const char walls[] =
    "{" CAMERA(0.9) "'environment':{'radiance':[1,1,1]},'meshes':{'quad':{'primitive':'quad'}},"
                    "'materials':{'m':{'ior':1,'base_color':[0.8,0.8,0.8]}},"
                    "'objects':{'a':{},'b':{},'c':{}},"
                    "'instances':{" QUAD("a", "m", TURNED, -4, 3) "," QUAD(
                        "b", "m", TURNED, -3, 1) "," QUAD("c", "m", "", 2, 9) "}}";

static void diffuse_surfaces_keep_all_of_theirs(void **state)
{
    (void)state;
    struct shot s;
    bounced_take(&s, walls, JOB(OBJECTS, "'through':'glossy'", SAMPLES(64)));
    for (size_t p = 0; p < pixels(s.frame); p++)
        for (const char *name = "abc"; *name; name++) {
            const char one[2] = {*name, 0};
            assert_within(coverage_of(s.frame, "CryptoGlossObject", one, p) -
                              coverage_of(s.frame, "CryptoObject", one, p),
                          1.0 / 255);
        }
    finish_shot(&s);
}

static void without_the_cut_they_lose_some(void **state)
{
    (void)state;
    struct shot s;
    double error;
    bounced_take(&s, walls, JOB(OBJECTS, "'through':'glossy','diffuse_cut':false", SAMPLES(64)));
    assert_true(bounced_mean(&s, "CryptoGlossObject", "c", &error) > 0.02);
    finish_shot(&s);
}

// A pane of clear glass, thin, before a wall.
static const char pane[] =
    "{" CAMERA(0.001) "'environment':{'radiance':[1,1,1]},'meshes':{'quad':{'primitive':'quad'}},"
                      "'materials':{'g':{'transmission':1,'roughness':0,'thin':true},"
                      "'m':{'ior':1,'base_color':[0.8,0.8,0.8]}},"
                      "'objects':{'pane':{},'wall':{}},"
                      "'instances':{" QUAD("pane", "g", TURNED, -1,
                                           100) "," QUAD("wall", "m", TURNED, -2, 100) "}}";

static void clear_glass_gives_its_place_to_what_is_behind(void **state)
{
    (void)state;
    struct shot s;
    double error;
    bounced_take(&s, pane, JOB(OBJECTS, "'through':'delta'", SAMPLES(256)));
    const double wall = bounced_mean(&s, "CryptoGlossObject", "wall", &error);
    assert_odds(wall - 0.96, error, 0);
    assert_within(bounced_mean(&s, "CryptoGlossObject", "pane", &error), 1e-6);
    assert_within(bounced_mean(&s, "CryptoObject", "pane", &error) - 1.0, 0.0);
    finish_shot(&s);
}

// Eq. 8: the pane covers what it does not let through, 0.04, and hands on all.
static void full_mattes_of_opaque_surfaces_take_nothing_from_what_follows(void **state)
{
    (void)state;
    struct shot s;
    double error;
    bounced_take(&s, pane,
                 JOB(OBJECTS, "'through':'delta','coverage':'opaque_full'", SAMPLES(256)));
    assert_within(bounced_mean(&s, "CryptoGlossObject", "pane", &error) - 0.04, 2e-5);
    const double wall = bounced_mean(&s, "CryptoGlossObject", "wall", &error);
    assert_odds(wall - 0.96, error, 0);
    finish_shot(&s);
}

// What a stained pane lets through is its mean over the colours, of the half that is transmitted; what it
// scatters goes no further.
static void what_is_let_through_has_the_colour_of_the_pane(void **state)
{
    (void)state;
    static const char stained[] = "{" CAMERA(
        0.001) "'environment':{'radiance':[1,1,1]},'meshes':{'quad':{'primitive':'quad'}},"
               "'materials':{'g':{'transmission':0.5,'roughness':0,'thin':true,'base_color':"
               "[0.9,0.5,0.1]},'m':{'ior':1,'base_color':[0.8,0.8,0.8]}},"
               "'objects':{'pane':{},'wall':{}},'instances':{" QUAD(
                   "pane", "g", TURNED, -1, 100) "," QUAD("wall", "m", TURNED, -2, 100) "}}";
    struct shot s;
    double error;
    bounced_take(&s, stained,
                 JOB(OBJECTS, "'through':'delta','coverage':'opaque_full'", SAMPLES(256)));
    const double pane_covers = bounced_mean(&s, "CryptoGlossObject", "pane", &error);
    assert_within(pane_covers - (1.0 - 0.96 * 0.5 * 0.5), 2e-5);
    const double wall = bounced_mean(&s, "CryptoGlossObject", "wall", &error);
    assert_odds(wall - 0.96 * 0.5 * 0.5, error, 0);
    finish_shot(&s);
}

// A block of glass is met at its front, at its back and, by what that reflects, again and again: by both
// rules it is covered at its front alone.
static void what_a_path_meets_twice_in_a_row_is_covered_once(void **state)
{
    (void)state;
    static const char block[] = "{" CAMERA(
        0.001) "'environment':{'radiance':[1,1,1]},'meshes':{'quad':{'primitive':'quad'},"
               "'box':{'primitive':'box'}},'materials':{'g':{'transmission':1,'roughness':0,"
               "'ior':1.5},'m':{'ior':1,'base_color':[0.8,0.8,0.8]}},"
               "'objects':{'block':{},'wall':{}},'instances':{'block':{'object':'block','mesh':'"
               "box',"
               "'material':'g','transform':{'translation':[0,0,-2],'scale':[9,9,1]}}," QUAD(
                   "wall", "m", TURNED, -4, 100) "}}";
    static const char *const rule[] = {
        JOB(OBJECTS, "'through':'delta','coverage':'opaque_full','path_ids':'previous'",
            SAMPLES(16)),
        JOB(OBJECTS, "'through':'delta','coverage':'opaque_full','path_ids':'list'", SAMPLES(16))};
    for (size_t i = 0; i < COUNT(rule); i++) {
        struct shot s;
        bounced_take(&s, block, rule[i]);
        for (size_t p = 0; p < pixels(s.frame); p++)
            assert_within(coverage_of(s.frame, "CryptoGlossObject", "block", p) - 0.04, 2e-5);
        finish_shot(&s);
    }
}

// Nine vertices between mirrors that lose nothing: by Eq. 8 as it is printed the first is covered
// five times, the second four times; with a list of what the path has met, once each.
static void a_list_of_what_was_met_covers_each_once(void **state)
{
    (void)state;
    static const char white[] = "{" CAMERA(
        0.001) "'environment':{'radiance':[1,1,1]},'meshes':{'quad':{'primitive':'quad'}},"
               "'materials':{'m':{'metallic':1,'roughness':0,'base_color':[1,1,1]}},"
               "'objects':{'ahead':{},'behind':{}},'instances':{" QUAD(
                   "ahead", "m", TURNED, -1, 100) "," QUAD("behind", "m", "", 1, 100) "}}";
    static const struct {
        const char *job;
        double ahead, behind;
    } rule[] = {
        {JOB(OBJECTS ",'matte_sums'",
             "'through':'delta','coverage':'opaque_full','path_ids':'previous'", SAMPLES(16)),
         5, 4},
        {JOB(OBJECTS ",'matte_sums'",
             "'through':'glossy','coverage':'opaque_full','path_ids':'list'", SAMPLES(16)),
         1, 1},
        {JOB(OBJECTS ",'matte_sums'", "'through':'delta','coverage':'opaque_full','classes':true",
             SAMPLES(16)),
         0, 1}};
    for (size_t i = 0; i < COUNT(rule); i++) {
        struct shot s;
        bounced_take(&s, white, rule[i].job);
        const char *type = i == 2 ? "CryptoReflObject" : "CryptoGlossObject";
        const float *sum = glint_frame_find(s.frame, "sums.bounced");
        for (size_t p = 0; p < pixels(s.frame); p++) {
            assert_within(coverage_of(s.frame, type, "ahead", p) - rule[i].ahead, 1e-3);
            assert_within(coverage_of(s.frame, type, "behind", p) - rule[i].behind, 1e-3);
            assert_within(sum[p] - rule[i].ahead - rule[i].behind, 2e-3);
        }
        finish_shot(&s);
    }
}

#define SIDE(name, x, z, half_turn)                                              \
    "'" name "':{'object':'" name "','mesh':'quad','material':'m','transform':{" \
    "'rotation':[0," half_turn "],'translation':[" x ",0," z "],'scale':[3.4,3.4,1]}}"

// The way round between three mirrors, three times: nine vertices on the middles of the sides.
static void a_list_goes_on_after_its_first_entries(void **state)
{
    (void)state;
    static const char prism[] = "{" CAMERA(
        0.001) "'environment':{'radiance':[1,1,1]},'meshes':{'quad':{'primitive':'quad'}"
               "},'materials':{'m':{'metallic':1,'roughness':0,'base_color':[1,1,1]}},"
               "'objects':{'a':{},'b':{},'c':{}},'instances':{" SIDE(
                   "a", "0", "-0.866025404",
                   "0.258819045,0,0.965925826") "," SIDE("b", "0", "0.866025404",
                                                         "0.965925826,0,0.258819045") "," SIDE("c",
                                                                                               "1."
                                                                                               "5",
                                                                                               "0",
                                                                                               "-0."
                                                                                               "707"
                                                                                               "106"
                                                                                               "781"
                                                                                               ",0,"
                                                                                               "0."
                                                                                               "707"
                                                                                               "106"
                                                                                               "78"
                                                                                               "1") "}}";
    static const struct {
        const char *job;
        double each;
    } rule[] = {
        {JOB(OBJECTS, "'through':'delta','coverage':'opaque_full','path_ids':'previous'",
             SAMPLES(16)),
         3},
        {JOB(OBJECTS, "'through':'delta','coverage':'opaque_full','path_ids':'list'", SAMPLES(16)),
         1}};
    for (size_t i = 0; i < COUNT(rule); i++) {
        struct shot s;
        bounced_take(&s, prism, rule[i].job);
        for (size_t p = 0; p < pixels(s.frame); p++)
            for (const char *name = "abc"; *name; name++)
                assert_within(
                    coverage_of(s.frame, "CryptoGlossObject", (const char[]){*name, 0}, p) -
                        rule[i].each,
                    1e-3);
        finish_shot(&s);
    }
}

// ---- one bounce off rough metal under a ceiling without end, by quadrature

#define CEILING 30.0 // metres above the floor
#define TO_FLOOR 5.0 // metres from the camera, whose view meets the floor at a cosine of 0.6
#define HALF_PIXEL (0.0005 / 16)

static const char under_a_ceiling[] =
    "{'cameras':{'c':{'yfov':0.001,'transform':{'translation':[0,3,4],'rotation':"
    "[-0.316227766,0,0,0.948683298]}}},'environment':{'radiance':[1,1,1]},"
    "'meshes':{'quad':{'primitive':'quad'}},"
    "'materials':{'floor':{'metallic':1,'roughness':%g,'base_color':[0.7,0.7,0.7]},"
    "'paint':{'ior':1,'base_color':[0,0,0]}},'objects':{'floor':{},'ceiling':{}},"
    "'instances':{'floor':{'object':'floor','mesh':'quad','material':'floor','transform':{"
    "'rotation':[0.707106781,0,0,0.707106781],'scale':[2,2,1]}},"
    "'ceiling':{'object':'ceiling','mesh':'quad','material':'paint','transform':{'translation':"
    "[0,30,0],'rotation':[-0.707106781,0,0,0.707106781],'scale':[1e5,1e5,1]}}}}";

static void rough_metal_hands_on_the_integral_of_eq_1(void **state)
{
    (void)state;
    static const struct {
        double roughness, alpha;
        bool cut;
    } setting[] = {{0.3, 0.1, true},  {0.3, 0.1, false}, {0.5, 0.1, true},
                   {0.5, 1.0, false}, {0.7, 0.05, true}, {0.2, 2.0, false}};
    for (size_t i = 0; i < COUNT(setting); i++) {
        struct shot s;
        double error;
        char scene[2048], job[512];
        snprintf(scene, sizeof scene, under_a_ceiling, setting[i].roughness);
        snprintf(job, sizeof job,
                 JOB(OBJECTS, "'through':'glossy','alpha':%g,'diffuse_cut':%s",
                     SAMPLES(256) "'accuracy':{'microfacet':'single'},"),
                 setting[i].alpha, setting[i].cut ? "true" : "false");
        bounced_take(&s, scene, job);
        const double mean = bounced_mean(&s, "CryptoGlossObject", "ceiling", &error);
        const double want =
            ceiling_share(&(struct ceiling){.material = {.name = "",
                                                         .base = 0.7f,
                                                         .metallic = 1,
                                                         .roughness = (float)setting[i].roughness,
                                                         .ior = 1.5f},
                                            .height = CEILING,
                                            .cosine = 0.6,
                                            .radius = HALF_PIXEL * TO_FLOOR,
                                            .slope = HALF_PIXEL,
                                            .alpha = setting[i].alpha,
                                            .cut = setting[i].cut});
        print_message("# roughness %g alpha %g: %.5f, by quadrature %.5f, error %.5f\n",
                      setting[i].roughness, setting[i].alpha, mean, want, error);
        assert_odds(mean - want, error, 2e-4);
        finish_shot(&s);
    }
}

static const char under_a_mirror[] =
    "{'cameras':{'c':{'yfov':0.001,'transform':{'translation':[0,3,4],'rotation':"
    "[-0.316227766,0,0,0.948683298]}}},'environment':{'radiance':[1,1,1]},"
    "'meshes':{'quad':{'primitive':'quad'}},"
    "'materials':{'floor':{'metallic':1,'roughness':0.5,'base_color':[1,1,1]},"
    "'grey':{'metallic':1,'roughness':0,'base_color':[0.2,0.2,0.2]},"
    "'paint':{'ior':1,'base_color':[0,0,0]}},'objects':{'floor':{},'mirror':{},'ground':{}},"
    "'instances':{'floor':{'object':'floor','mesh':'quad','material':'floor','transform':{"
    "'rotation':[0.707106781,0,0,0.707106781],'scale':[0.1,0.1,1]}},"
    "'mirror':{'object':'mirror','mesh':'quad','material':'grey','transform':{'translation':"
    "[0,30,0],'rotation':[-0.707106781,0,0,0.707106781],'scale':[1e5,1e5,1]}},"
    "'ground':{'object':'ground','mesh':'quad','material':'paint','transform':{'translation':"
    "[0,-30,0],'rotation':[0.707106781,0,0,0.707106781],'scale':[1e5,1e5,1]}}}}";

// What the grey mirror reflects of all that white metal hands on: of the mean over its lobe.
static double ground_by_quadrature(void)
{
    enum { RINGS = 2000, TURNS = 720 };
    const struct material metal = {
        .name = "", .base = 1.0f, .metallic = 1, .roughness = 0.5f, .ior = 1.5f};
    const struct gk_vec wo = gk_vec(0.8f, 0.0f, 0.6f);
    const struct gk_surface surface = make_surface_at(&metal, wo);
    double all = 0.0, reflected = 0.0;
    for (int i = 0; i < RINGS; i++)
        for (int j = 0; j < TURNS; j++) {
            const double z = (i + 0.5) / RINGS;
            const double f =
                gk_mean3(gk_bsdf_eval(&surface, wo, direction(z, (j + 0.5) / TURNS)).f);
            all += f;
            reflected += f * (0.2 + 0.8 * pow(1.0 - z, 5.0));
        }
    return reflected / all;
}

// Compensated lobes give single directions weights above one. The mirror cannot have more of a sample
// than all; the ground, which has a fifth of most, gets its share of the excess.
static void what_a_vertex_hands_on_over_what_it_has_reaches_those_beyond(void **state)
{
    (void)state;
    struct shot s;
    double error;
    bounced_take(&s, under_a_mirror,
                 JOB(OBJECTS, "'through':'glossy','alpha':0,'diffuse_cut':false", SAMPLES(256)));
    const double mean = bounced_mean(&s, "CryptoGlossObject", "ground", &error);
    const double want = ground_by_quadrature();
    print_message("# %.5f, by quadrature %.5f, error %.5f\n", mean, want, error);
    assert_odds(mean - want, error, 2e-3); // of tables of energy, of rays that miss the planes
    finish_shot(&s);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_sample_is_given_away_whole),
        cmocka_unit_test(exact_eviction_is_what_slots_enough_give),
        cmocka_unit_test(tables_shared_by_work_items_are_those_of_an_owner),
        cmocka_unit_test(the_picture_and_what_is_seen_directly_are_the_same_without),
        cmocka_unit_test(reflection_and_refraction_make_what_is_seen_by_bounces),
        cmocka_unit_test(the_first_bounce_says_of_which_class_a_path_is),
        cmocka_unit_test(what_is_passed_unseen_is_no_bounce),
        cmocka_unit_test(facing_mirrors_share_as_a_geometric_series),
        cmocka_unit_test(in_a_scene_of_deltas_lobes_change_no_bit),
        cmocka_unit_test(diffuse_surfaces_keep_all_of_theirs),
        cmocka_unit_test(without_the_cut_they_lose_some),
        cmocka_unit_test(clear_glass_gives_its_place_to_what_is_behind),
        cmocka_unit_test(full_mattes_of_opaque_surfaces_take_nothing_from_what_follows),
        cmocka_unit_test(what_is_let_through_has_the_colour_of_the_pane),
        cmocka_unit_test(what_a_path_meets_twice_in_a_row_is_covered_once),
        cmocka_unit_test(a_list_of_what_was_met_covers_each_once),
        cmocka_unit_test(a_list_goes_on_after_its_first_entries),
        cmocka_unit_test(rough_metal_hands_on_the_integral_of_eq_1),
        cmocka_unit_test(what_a_vertex_hands_on_over_what_it_has_reaches_those_beyond),
    };
    return cmocka_run_group_tests(tests, things_start, things_finish);
}
