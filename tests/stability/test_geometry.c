// Hard geometry in pictures: closed balls, dropped triangles, coincident surfaces, decimal scales and
// far places.
#include "tests/stability/stable.h"

#include <math.h>
#include <stdlib.h>

// ---- closed and degenerate

// Random rays inside a ball of many triangles under a strong sky: 4 million from the camera.
static double light_in_closed_ball(const char *traversal)
{
    struct glint_frame *f = stable_frame(
        &offline_crew,
        stable_text("{'environment':{'radiance':[1e6,1e6,1e6]},'materials':{'m':{'ior':1}},"
                    "'meshes':{'s':{'primitive':'sphere','segments':256}},"
                    "'instances':{'s':{'mesh':'s','material':'m'}},"
                    "'cameras':{'eye':{'yfov':2,'transform':{'translation':[0.2,0.1,0.3]}}}}"),
        stable_text("{'scene':'s','outputs':['beauty'],'resolution':[128,128],'max_bounces':1,"
                    "'accuracy':{'traversal':'%s'},'stop':{'samples':256}}",
                    traversal));
    const double mean = stable_mean(f, "G").mean;
    glint_frame_destroy(&f);
    return mean;
}

static void closed_ball_is_dark_inside(void **state)
{
    (void)state;
    assert_float_equal(light_in_closed_ball("robust"), 0.0, 0.0);
    const double fast = light_in_closed_ball("fast") / 1e6; // share of samples that leaked
    print_message("# fast traversal: %.3g of the samples leak\n", fast);
    assert_true(fast < 1e-5);
}

static void placed_balls_far_from_their_own_origin_are_dark_inside(void **state)
{
    (void)state;
    struct glint_frame *f = stable_frame(
        &offline_crew,
        stable_text("{'environment':{'radiance':[1e6,1e6,1e6]},'materials':{'m':{'ior':1}},"
                    "'meshes':{'s':{'primitive':'sphere','segments':128}},"
                    "'instances':{'s':{'mesh':'s','material':'m','transform':{"
                    "'translation':[1e5,-1e5,1e5],'rotation':[0.3,0.1,0.2,0.9]}}},"
                    "'cameras':{'eye':{'yfov':2,'transform':{'translation':[1e5,-1e5,1e5]}}}}"),
        stable_text("{'scene':'s','live':true,'outputs':['beauty'],'resolution':[96,96],"
                    "'max_bounces':1,'accuracy':{'traversal':'robust'},'stop':{'samples':64}}"));
    assert_float_equal(stable_mean(f, "G").mean, 0.0, 0.0);
    glint_frame_destroy(&f);
}

static char *wall_with(const char *extra_positions)
{
    return stable_text(
        "{'environment':{'radiance':[1,2,3]},'materials':{'m':{'base_color':[0.5,0.6,0.7]}},"
        "'meshes':{'t':{'positions':[-1,-1,0,1,-1,0,1,1,0,-1,-1,0,1,1,0,-1,1,0%s]}},"
        "'instances':{'t':{'mesh':'t','material':'m'}},"
        "'cameras':{'eye':{'yfov':0.9,'transform':{'translation':[0,0,3]}}}}",
        extra_positions);
}

static void degenerate_triangles_are_dropped_counted_and_unseen(void **state)
{
    (void)state;
    // A point, two equal corners, three on a line, and 1:2e7; then 1:1e6, which is a surface.
    char *text = wall_with(",0,0,0,0,0,0,0,0,0, 0,0,0.5,1,0,0.5,1,0,0.5, -1,-1,0.5,0,0,0.5,1,1,0.5,"
                           "-0.5,0,0,0.5,0,0,0,5e-8,0, -0.5,0,-0.5,0.5,0,-0.5,0,1e-6,-0.5");
    glint_resident *scene = offline_load_text(&offline_crew, text);
    struct glint_resident_stats stats;
    glint_resident_stats(scene, &stats);
    assert_int_equal(stats.dropped, 4);
    assert_int_equal(stats.triangles, 3);
    const char *const job = "'resolution':[40,40],'stop':{'samples':8}";
    struct glint_frame *with = stable_frame_of(&offline_crew, scene, stable_job(job));
    struct glint_frame *without = stable_frame(
        &offline_crew, wall_with(", -0.5,0,-0.5,0.5,0,-0.5,0,1e-6,-0.5"), stable_job(job));
    stable_assert_same(with, without);
    glint_frame_destroy(&with);
    glint_frame_destroy(&without);
    glint_resident_release(&scene);
    free(text);
}

// ---- coincident surfaces

// Balls of these materials in one place, in this order in the file; NULL: none. live: traced as live
// jobs are, who place what others bake.
static struct glint_frame *balls(const struct offline *with, const char *first, const char *second,
                                 bool live)
{
    static const char ball[] = "{'mesh':'s','object':'ball','transform':{'rotation':[0.3,0.1,0.2,"
                               "0.9]},'material'";
    char *other = second ? stable_text(",'b':%s:'%s'}", ball, second) : stable_text("%s", "");
    struct glint_frame *f = stable_frame(
        with,
        stable_text(
            "{'environment':{'radiance':[1,1,1]},'objects':{'ball':{}},"
            "'materials':{'red':{'base_color':[0.8,0.1,0.1]},'blue':{'base_color':[0.1,0.1,0.8]},"
            "'gone':{'alpha_mode':'mask','opacity':0}},"
            "'meshes':{'s':{'primitive':'sphere','segments':120}},'instances':{'a':%s:'%s'}%s},"
            "'cameras':{'eye':{'yfov':0.6,'transform':{'translation':[0,0,4]}}}}",
            ball, first, other),
        stable_text(
            "{'scene':'s','outputs':['beauty','crypto_object','crypto_material','depth','normal'],"
            "'live':%s,'resolution':[48,48],'max_bounces':3,'stop':{'samples':8}}",
            live ? "true" : "false"));
    free(other);
    return f;
}

static void assert_same_and_destroy(struct glint_frame *f, struct glint_frame *g)
{
    stable_assert_same(f, g);
    glint_frame_destroy(&f);
    glint_frame_destroy(&g);
}

static void coincident_surfaces_show_the_same_for_any_number_of_workers(void **state)
{
    (void)state;
    static const uint32_t workers[] = {1, 2, 15}; // PoCL has 16 devices, one of them spare
    struct glint_frame *frame[3];
    for (uint32_t n = 0; n < 3; n++) {
        struct offline crew;
        offline_start(&crew, workers[n]);
        frame[n] = balls(&crew, "red", "blue", false);
        offline_finish(&crew);
    }
    stable_assert_same(frame[0], frame[1]);
    stable_assert_same(frame[0], frame[2]);
    for (int n = 0; n < 3; n++)
        glint_frame_destroy(&frame[n]);
}

static void order_of_equal_coincident_instances_does_not_matter(void **state)
{
    (void)state;
    assert_same_and_destroy(balls(&offline_crew, "red", "red", false),
                            balls(&offline_crew, "red", NULL, false));
}

static void of_placements_in_one_place_the_first_in_the_file_is_seen(void **state)
{
    (void)state;
    for (int live = 0; live < 2; live++) {
        assert_same_and_destroy(balls(&offline_crew, "red", "blue", live),
                                balls(&offline_crew, "red", NULL, live));
        assert_same_and_destroy(balls(&offline_crew, "blue", "red", live),
                                balls(&offline_crew, "blue", NULL, live));
    }
}

static void where_the_first_of_them_has_a_hole_the_next_is_seen(void **state)
{
    (void)state;
    for (int live = 0; live < 2; live++)
        assert_same_and_destroy(balls(&offline_crew, "gone", "blue", live),
                                balls(&offline_crew, "blue", NULL, live));
}

// ---- scale and place

// A floor, two balls and a lamp: every length times `scale`, everything moved by `place`.
static struct glint_frame *still_life(double scale, double place)
{
    const double s = scale, x = place;
    return stable_frame(
        &offline_crew,
        stable_text(
            "{'environment':{'radiance':[0.2,0.3,0.4]},'materials':{'floor':{'base_color':[0.6,0.5,"
            "0.4]},"
            "'gold':{'base_color':[1,0.8,0.3],'metallic':1,'roughness':0.3},"
            "'glass':{'transmission':1,'roughness':0.1},'lamp':{'emission':[9,9,9]}},"
            "'meshes':{'q':{'primitive':'quad','size':[%.9g,%.9g]},'l':{'primitive':'quad','size':["
            "%.9g,%.9g]},"
            "'s':{'primitive':'sphere','radius':%.9g,'segments':32}},"
            "'instances':{'f':{'mesh':'q','material':'floor','transform':{'translation':[%.9g,%.9g,"
            "%.9g],'rotation':[-1,0,0,1]}},"
            "'g':{'mesh':'s','material':'gold','transform':{'translation':[%.9g,%.9g,%.9g]}},"
            "'h':{'mesh':'s','material':'glass','transform':{'translation':[%.9g,%.9g,%.9g]}},"
            "'l':{'mesh':'l','material':'lamp','transform':{'translation':[%.9g,%.9g,%.9g],'"
            "rotation':[1,0,0,1]}}},"
            "'cameras':{'eye':{'yfov':0.7,'transform':{'translation':[%.9g,%.9g,%.9g]}}}}",
            8 * s, 8 * s, 2 * s, 2 * s, s, x, x - s, x, x - 1.25 * s, x, x, x + 1.25 * s, x,
            x + 0.5 * s, x, x + 4 * s, x, x, x, x + 8 * s),
        stable_job("'resolution':[48,32],'accuracy':{'roulette':'none'},'max_bounces':5,'stop':{'"
                   "samples':32}"));
}

// The same samples meet the same surfaces but for roundings: pixels differ by little, most not at all.
static void assert_same_picture(const struct glint_frame *a, const struct glint_frame *b)
{
    const float *p = glint_frame_find(a, "G"), *q = glint_frame_find(b, "G");
    size_t close = 0;
    for (size_t i = 0; i < stable_pixels(a); i++)
        close += fabsf(p[i] - q[i]) <= 0.01f * p[i];
    const double ratio = stable_mean(b, "G").mean / stable_mean(a, "G").mean;
    print_message("# %zu of %zu pixels within 1 %%, mean ratio %.6f\n", close, stable_pixels(a),
                  ratio);
    assert_true(close >= stable_pixels(a) * 95 / 100);
    assert_float_equal(ratio, 1.0, 0.005);
}

static void decimal_scales_keep_the_picture(void **state)
{
    (void)state;
    struct glint_frame *unit = still_life(1.0, 0.0);
    static const double scale[] = {1e-6, 1e6};
    for (int i = 0; i < 2; i++) {
        struct glint_frame *f = still_life(scale[i], 0.0);
        assert_same_picture(unit, f);
        glint_frame_destroy(&f);
    }
    glint_frame_destroy(&unit);
}

// The faces of a white box in white light, seen from outside: who leaves one meets none, so that one
// bounce shows all of the light, and a face that met itself would be darker. 10 million rays, a third
// of them at least to it.
static void faces_do_not_meet_themselves_wherever_they_are(void **state)
{
    (void)state;
    static const double place[] = {0, 1e5, -1e6};
    for (int i = 0; i < 3; i++) {
        struct glint_frame *f = stable_frame(
            &offline_crew,
            stable_text("{'environment':{'radiance':[1,1,1]},'materials':{'m':{'ior':1}},"
                        "'meshes':{'b':{'primitive':'box','size':[2,3,2.5]}},"
                        "'instances':{'b':{'mesh':'b','material':'m','transform':{'translation':"
                        "[%.17g,0,%.17g],'rotation':[0.1830127,0.1830127,0.6830127,0.6830127]}}},"
                        "'cameras':{'eye':{'yfov':0.5,'transform':{'translation':[%.17g,0,%.17g]}"
                        "}}}",
                        place[i], -place[i], place[i], 6 - place[i]),
            stable_job("'resolution':[128,128],'max_bounces':1,'stop':{'samples':208}"));
        assert_true(stable_mean(f, "A").mean > 0.3);
        assert_float_equal(stable_least(f, "G"), 1.0, 1e-5); // one ray would be a 208th
        assert_float_equal(stable_most(f, "G"), 1.0, 1e-5);
        glint_frame_destroy(&f);
    }
}

// The places are multiples of what single precision resolves there, so nothing is lost before load.
static void far_places_keep_the_picture(void **state)
{
    (void)state;
    struct glint_frame *here = still_life(1.0, 0.0);
    static const double place[] = {1e5, -1e6};
    for (int i = 0; i < 2; i++) {
        struct glint_frame *f = still_life(1.0, place[i]);
        assert_same_picture(here, f);
        print_message("# at %g: %zu pixels have the same bits\n", place[i],
                      stable_equal(here, f, "G"));
        glint_frame_destroy(&f);
    }
    glint_frame_destroy(&here);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(closed_ball_is_dark_inside),
        cmocka_unit_test(placed_balls_far_from_their_own_origin_are_dark_inside),
        cmocka_unit_test(degenerate_triangles_are_dropped_counted_and_unseen),
        cmocka_unit_test(coincident_surfaces_show_the_same_for_any_number_of_workers),
        cmocka_unit_test(order_of_equal_coincident_instances_does_not_matter),
        cmocka_unit_test(of_placements_in_one_place_the_first_in_the_file_is_seen),
        cmocka_unit_test(where_the_first_of_them_has_a_hole_the_next_is_seen),
        cmocka_unit_test(decimal_scales_keep_the_picture),
        cmocka_unit_test(far_places_keep_the_picture),
        cmocka_unit_test(faces_do_not_meet_themselves_wherever_they_are),
    };
    return cmocka_run_group_tests(tests, offline_crew_start, offline_crew_finish);
}
