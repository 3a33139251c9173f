// Motion vectors against differences of projected points, in pixels, y up.
#include "tests/render/moving.h"

#include <math.h>
#include <stdlib.h>

static struct offline o;

#define WIDTH 64
#define HEIGHT 48
#define YFOV 0.6
#define TOLERANCE 1e-3 // pixels

// ---- the camera on paper

// At (x, 0, z), turned by `yaw` about +y; at 0 it looks along -z.
struct eye {
    double x, z, yaw;
};

static const struct eye in_front = {0, 6, 0};

static double pixel_at_one(void)
{
    return 2 * tan(YFOV / 2) / HEIGHT;
}

// Pixels from the image's middle, y up.
static void project(const struct eye *e, const double p[3], double out[2])
{
    const double dx = p[0] - e->x, dz = p[2] - e->z, c = cos(e->yaw), s = sin(e->yaw);
    const double ahead = -(s * dx + c * dz);
    out[0] = (c * dx - s * dz) / (ahead * pixel_at_one());
    out[1] = p[1] / (ahead * pixel_at_one());
}

// The point of the plane z = `plane` that the middle of a pixel shows.
static void unproject(const struct eye *e, int x, int y, double plane, double out[3])
{
    const double r = (x + 0.5 - WIDTH / 2) * pixel_at_one();
    const double c = cos(e->yaw), s = sin(e->yaw);
    const double dx = r * c - s, dz = -r * s - c, t = (plane - e->z) / dz;
    out[0] = e->x + t * dx;
    out[1] = t * (HEIGHT / 2 - y - 0.5) * pixel_at_one();
    out[2] = plane;
}

// ---- frames

// Frame 1 of an animation of one key a second from 0 to 2. Enough samples that their mean lies in
// the middle of the pixel.
static struct glint_frame *frame_of(char *text, double open, double close)
{
    struct glint_posed scene = offline_load_posed_text(&o, text);
    char *job = stable_text("{'scene':'s','outputs':['beauty','motion'],'fps':1,'frame':1,"
                            "'shutter':[%g,%g],'resolution':[%d,%d],'max_bounces':0,"
                            "'filter':{'kind':'box','width':1},'stop':{'samples':1024}}",
                            open, close, WIDTH, HEIGHT);
    struct glint_frame *f = offline_frame_posed(&o, &scene, job, 0);
    free(job);
    free(text);
    glint_resident_release(&scene.resident);
    return f;
}

// Pixels that are looked at: around the middle of the image, well inside of what moves.
static const int look[9][2] = {{32, 24}, {28, 24}, {36, 24}, {32, 20}, {32, 28},
                               {29, 21}, {35, 27}, {35, 21}, {29, 27}};

static void expect(const struct glint_frame *f, int x, int y, const char *u, const char *v,
                   const double want[2])
{
    const size_t i = (size_t)y * WIDTH + x;
    const double got[2] = {glint_frame_find(f, u)[i], glint_frame_find(f, v)[i]};
    if (hypot(got[0] - want[0], got[1] - want[1]) > TOLERANCE)
        fail_msg("%s at %d %d is (%.5f %.5f), not (%.5f %.5f)", u, x, y, got[0], got[1], want[0],
                 want[1]);
}

// Where what is at p in frame 1 is a frame later (+1) or earlier (-1); user is the test's.
typedef void (*carry)(const double p[3], int frames, double out[3], struct eye *eye);

static void expect_flow(char *text, double plane, carry carry)
{
    struct glint_frame *f = frame_of(text, 0, 0);
    for (int i = 0; i < 9; i++) {
        double p[3], now[2], then[2][2];
        struct eye eye = in_front;
        carry((const double[3]){0}, 0, p, &eye);
        unproject(&eye, look[i][0], look[i][1], plane, p);
        project(&eye, p, now);
        for (int k = 0; k < 2; k++) {
            double to[3];
            carry(p, k ? -1 : 1, to, &eye);
            project(&eye, to, then[k]);
            then[k][0] -= now[0];
            then[k][1] -= now[1];
        }
        expect(f, look[i][0], look[i][1], "forward.u", "forward.v", then[0]);
        expect(f, look[i][0], look[i][1], "backward.u", "backward.v", then[1]);
    }
    glint_frame_destroy(&f);
}

#define CAMERA "'cameras':{'eye':{'yfov':0.6,'transform':{'translation':[0,0,6]}}}"
#define QUAD "'meshes':{'quad':{'primitive':'quad','size':[2,2]}}"
#define NEAR_ONE "'positions':[-1,-1,0,1,-1,0,1,1,0,-1,1,0],'indices':[0,1,2,0,2,3]"
#define SKY "'materials':{'m':{}},'environment':{'radiance':[1,1,1]}"

// A quad on node n, with channels.
static char *quad_scene(const char *channels)
{
    return stable_text("{" SKY "," QUAD ",'nodes':{'n':{}},'instances':{'q':{'mesh':'quad',"
                       "'material':'m','node':'n'}},'animations':{'a':{'channels':{%s}}}," CAMERA
                       "}",
                       channels);
}

// ---- what moves

static void still(const double p[3], int frames, double out[3], struct eye *eye)
{
    (void)frames;
    (void)eye;
    for (int k = 0; k < 3; k++)
        out[k] = p[k];
}

static void what_stands_still_does_not_flow(void **state)
{
    (void)state;
    expect_flow(quad_scene("'c':{'node':'n','path':'translation','times':[0,3],"
                           "'values':[0,0,0,0,0,0]}"),
                0, still);
}

static void across(const double p[3], int frames, double out[3], struct eye *eye)
{
    still(p, frames, out, eye);
    out[0] += frames > 0 ? 0.4 : frames < 0 ? -0.2 : 0;
    out[1] += frames > 0 ? 0.1 : frames < 0 ? 0.3 : 0;
}

static void what_goes_across_flows_by_its_steps(void **state)
{
    (void)state;
    expect_flow(quad_scene("'c':{'node':'n','path':'translation','times':[0,1,2],"
                           "'values':[-0.2,0.3,0,0,0,0,0.4,0.1,0]}"),
                0, across);
}

static void towards(const double p[3], int frames, double out[3], struct eye *eye)
{
    still(p, frames, out, eye);
    out[2] += frames;
}

static void what_comes_nearer_flows_outwards(void **state)
{
    (void)state;
    expect_flow(quad_scene("'c':{'node':'n','path':'translation','times':[0,2],"
                           "'values':[0,0,-1,0,0,1]}"),
                0, towards);
}

static void turned(const double p[3], int frames, double out[3], struct eye *eye)
{
    (void)eye;
    const double a = frames * 0.5, x = p[0] * cos(a) - p[1] * sin(a);
    out[1] = p[0] * sin(a) + p[1] * cos(a);
    out[0] = x;
    out[2] = p[2];
}

static void what_turns_flows_about_its_axis(void **state)
{
    (void)state;
    expect_flow(quad_scene("'c':{'node':'n','path':'rotation','times':[0,2],'values':"
                           "[0,0,-0.247403959,0.968912422,0,0,0.247403959,0.968912422]}"),
                0, turned);
}

// Half of every vertex follows a joint that goes by (0.6, -0.4) a frame.
static void half(const double p[3], int frames, double out[3], struct eye *eye)
{
    still(p, frames, out, eye);
    out[0] += 0.3 * frames;
    out[1] -= 0.2 * frames;
}

static void what_a_skin_moves_flows_with_its_vertices(void **state)
{
    (void)state;
    expect_flow(stable_text("{" SKY ",'meshes':{'q':{" NEAR_ONE
                            ",'joints':[0,1,0,0,0,1,0,0,0,1,0,0,0,1,0,0],"
                            "'weights':[0.5,0.5,0,0,0.5,0.5,0,0,0.5,0.5,0,0,0.5,0.5,0,0]}},"
                            "'nodes':{'i':{},'j':{}},'skins':{'s':{'joints':['i','j']}},"
                            "'instances':{'q':{'mesh':'q','material':'m','skin':'s'}},"
                            "'animations':{'a':{'channels':{'c':{'node':'j','path':'translation',"
                            "'times':[0,2],'values':[-0.6,0.4,0,0.6,-0.4,0]}}}}," CAMERA "}"),
                0, half);
}

// A target stretches x by a quarter of the weight, which is 1 in frame 1 and 2 in frame 2.
static void stretched(const double p[3], int frames, double out[3], struct eye *eye)
{
    still(p, frames, out, eye);
    out[0] *= (1 + 0.25 * (1 + frames)) / 1.25;
}

static void what_a_target_moves_flows_with_its_vertices(void **state)
{
    (void)state;
    expect_flow(stable_text("{" SKY ",'meshes':{'q':{" NEAR_ONE ",'targets':[{'positions':"
                            "[-0.25,0,0,0.25,0,0,0.25,0,0,-0.25,0,0]}]}},'nodes':{'n':{}},"
                            "'instances':{'q':{'mesh':'q','material':'m','node':'n'}},"
                            "'animations':{'a':{'channels':{'c':{'node':'n','path':'weights',"
                            "'times':[0,2],'values':[0,2]}}}}," CAMERA "}"),
                0, stretched);
}

static void passing(const double p[3], int frames, double out[3], struct eye *eye)
{
    still(p, frames, out, eye);
    *eye = (struct eye){0.2 * frames, 6 - 0.3 * frames, 0.05 * frames};
}

static void a_camera_that_moves_makes_all_flow(void **state)
{
    (void)state;
    expect_flow(stable_text("{" SKY "," QUAD ",'nodes':{'n':{}},'instances':{'q':{'mesh':'quad',"
                            "'material':'m'}},'animations':{'a':{'channels':{"
                            "'c':{'node':'n','path':'translation','times':[0,2],"
                            "'values':[-0.2,0,6.3,0.2,0,5.7]},"
                            "'d':{'node':'n','path':'rotation','times':[0,2],"
                            "'values':[0,-0.0249973959,0,0.999687516,0,0.0249973959,0,"
                            "0.999687516]}}}},'cameras':{'eye':{'yfov':0.6,'node':'n'}}}"),
                0, passing);
}

static void yawing(const double p[3], int frames, double out[3], struct eye *eye)
{
    still(p, frames, out, eye);
    *eye = (struct eye){0, 6, 0.05 * frames};
}

static void the_sky_flows_as_the_camera_turns(void **state)
{
    (void)state;
    // Nothing is in sight: any plane far off will do.
    expect_flow(stable_text("{" SKY "," QUAD ",'nodes':{'n':{}},'instances':{'q':{'mesh':'quad',"
                            "'material':'m','transform':{'translation':[0,0,20]}}},"
                            "'animations':{'a':{'channels':{'d':{'node':'n','path':'rotation',"
                            "'times':[0,2],'values':[0,-0.0249973959,0,0.999687516,0,0.0249973959,"
                            "0,0.999687516]}}}},'cameras':{'eye':{'yfov':0.6,'node':'n',"
                            "'transform':{'translation':[0,0,6]}}}}"),
                -1e9, yawing);
}

static void a_shutter_leaves_vectors_a_frame_long(void **state)
{
    (void)state;
    struct glint_frame *f = frame_of(quad_scene("'c':{'node':'n','path':'translation',"
                                                "'times':[0,3],'values':[-0.6,0,0,0.6,0,0]}"),
                                     0, 0.5);
    const double frame = 0.4 / (6 * pixel_at_one());
    for (int i = 0; i < 9; i++) {
        expect(f, look[i][0], look[i][1], "forward.u", "forward.v", (const double[2]){frame, 0});
        expect(f, look[i][0], look[i][1], "backward.u", "backward.v", (const double[2]){-frame, 0});
    }
    glint_frame_destroy(&f);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(what_stands_still_does_not_flow),
        cmocka_unit_test(what_goes_across_flows_by_its_steps),
        cmocka_unit_test(what_comes_nearer_flows_outwards),
        cmocka_unit_test(what_turns_flows_about_its_axis),
        cmocka_unit_test(what_a_skin_moves_flows_with_its_vertices),
        cmocka_unit_test(what_a_target_moves_flows_with_its_vertices),
        cmocka_unit_test(a_camera_that_moves_makes_all_flow),
        cmocka_unit_test(the_sky_flows_as_the_camera_turns),
        cmocka_unit_test(a_shutter_leaves_vectors_a_frame_long),
    };
    offline_start(&o, offline_workers());
    const int failed = cmocka_run_group_tests(tests, NULL, NULL);
    offline_finish(&o);
    return failed;
}
