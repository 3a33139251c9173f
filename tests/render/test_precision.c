// Exact twins of a precision: the same samples, so that what differs is rounding alone.
#include "tests/stability/stable.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

// Closed surfaces of many triangles that touch each other, a lamp, a sky.
static const char scene[] =
    "{'environment':{'radiance':[0.5,0.6,0.8]},'materials':{'grey':{'base_color':[0.6,0.5,0.4]},"
    "'metal':{'metallic':1,'roughness':0.2},'glass':{'transmission':1,'roughness':0},"
    "'lamp':{'base_color':[0,0,0],'ior':1,'emission':[9,8,7]}},"
    "'meshes':{'floor':{'primitive':'quad','size':[8,8]},'ball':{'primitive':'sphere','segments':"
    "48},"
    "'box':{'primitive':'box'}},'instances':{"
    "'floor':{'mesh':'floor','material':'grey','transform':{'translation':[0,-1,0],'rotation':[-0."
    "70710678,0,0,0.70710678]}},"
    "'ball':{'mesh':'ball','material':'metal','transform':{'translation':[-1.1,0,0]}},"
    "'glass':{'mesh':'ball','material':'glass','transform':{'translation':[1.1,0,0]}},"
    "'box':{'mesh':'box','material':'grey','transform':{'translation':[0,-0.5,-1.5]}},"
    "'lamp':{'mesh':'box','material':'lamp','transform':{'translation':[0,3,0],'scale':[1,0.1,1]}}}"
    ","
    "'cameras':{'eye':{'yfov':0.9,'transform':{'translation':[0,0.3,4]}}}}";

enum { BOUNCES = 6 };

static struct glint_frame *frame_with(const char *dial)
{
    char *members = stable_text("'resolution':[64,48],'max_bounces':%d,'stop':{'samples':16},"
                                "'accuracy':{%s}",
                                BOUNCES, dial);
    struct glint_frame *frame =
        stable_frame(&offline_crew, stable_text("%s", scene), stable_job(members));
    free(members);
    return frame;
}

// Relative differences of a channel: the largest, and how many pixels have none and one over 1e-4.
struct difference {
    double largest;
    size_t none, some;
};

static struct difference compare(const struct glint_frame *a, const struct glint_frame *b)
{
    struct difference d = {0};
    const float *p = glint_frame_find(a, "G"), *q = glint_frame_find(b, "G");
    for (size_t i = 0; i < stable_pixels(a); i++) {
        const double relative = p[i] == q[i] ? 0.0 : fabs((double)p[i] / q[i] - 1.0);
        d.largest = fmax(d.largest, relative);
        d.none += p[i] == q[i];
        d.some += relative > 1e-4;
    }
    print_message("# largest %.3g, %zu of %zu pixels equal, %zu differ by over 1e-4\n", d.largest,
                  d.none, stable_pixels(a), d.some);
    return d;
}

// A path adds what it finds and what a light sample brings at each vertex: so many roundings, and
// one for the frame. The film's own sums are exact, or nearly so in double.
static void sums_in_floats_are_sums_in_double_to_a_unit_a_term(void **state)
{
    (void)state;
    struct glint_frame *narrow = frame_with("'precision':'float32'");
    struct glint_frame *wide = frame_with("'precision':'float64'");
    const struct difference d = compare(narrow, wide);
    assert_true(d.largest <= (2 * (BOUNCES + 1) + 1) * 0x1p-24);
    assert_true(d.none < stable_pixels(wide));
    glint_frame_destroy(&narrow);
    glint_frame_destroy(&wide);
}

// Both find the same triangles but where a ray meets an edge to within rounding; paths that part
// there are others of the same light.
static void robust_and_fast_traversal_part_at_edges_alone(void **state)
{
    (void)state;
    struct glint_frame *fast = frame_with("'traversal':'fast'");
    struct glint_frame *robust = frame_with("'traversal':'robust'");
    const struct difference d = compare(fast, robust);
    assert_true(d.some <= stable_pixels(fast) / 500 && d.none >= stable_pixels(fast) / 2);
    const double ratio = stable_mean(fast, "G").mean / stable_mean(robust, "G").mean;
    print_message("# means: ratio %.6f\n", ratio);
    assert_float_equal(ratio, 1.0, 1e-3);
    glint_frame_destroy(&fast);
    glint_frame_destroy(&robust);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(sums_in_floats_are_sums_in_double_to_a_unit_a_term),
        cmocka_unit_test(robust_and_fast_traversal_part_at_edges_alone),
    };
    return cmocka_run_group_tests(tests, offline_crew_start, offline_crew_finish);
}
