// Light from an image at infinity: its integral, its direction and what a matched body does to it.
// Statistical bounds are 4.9 standard errors.
#include "tests/stability/stable.h"

#include <math.h>
#include <stdlib.h>

static struct offline o;

#define WIDTH 64
#define HEIGHT 32
#define HOT_X 38 // one texel that gives two thirds of all light
#define HOT_Y 9
#define HOT 57344.0f

static float sky[HEIGHT * WIDTH * 3];
static char *sky_uri;

// ---- the integral, by a fine grid over the same bilinear picture

static double texel(int x, int y)
{
    x = (x + WIDTH) % WIDTH;
    y = y < 0 ? 0 : y > HEIGHT - 1 ? HEIGHT - 1 : y;
    return sky[3 * (y * WIDTH + x) + 1];
}

static double sky_at(double u, double v)
{
    const double x = u * WIDTH - 0.5, y = v * HEIGHT - 0.5;
    const int x0 = (int)floor(x), y0 = (int)floor(y);
    const double wx = x - x0, wy = y - y0;
    return (texel(x0, y0) * (1 - wx) + texel(x0 + 1, y0) * wx) * (1 - wy) +
           (texel(x0, y0 + 1) * (1 - wx) + texel(x0 + 1, y0 + 1) * wx) * wy;
}

// The picture's middle looks along -z, its right is +x; turning about +y takes -z to -x.
static void direction(double u, double v, double turn, double d[3])
{
    const double phi = 2 * M_PI * (u - 0.5), x = sin(phi) * sin(M_PI * v),
                 z = -cos(phi) * sin(M_PI * v);
    d[0] = x * cos(turn) + z * sin(turn);
    d[1] = cos(M_PI * v);
    d[2] = -x * sin(turn) + z * cos(turn);
}

// Irradiance of a plane whose normal is +z.
static double irradiance(double turn)
{
    enum { FINE = 16 };
    double sum = 0;
    for (int j = 0; j < HEIGHT * FINE; j++)
        for (int i = 0; i < WIDTH * FINE; i++) {
            const double u = (i + 0.5) / (WIDTH * FINE), v = (j + 0.5) / (HEIGHT * FINE);
            double d[3];
            direction(u, v, turn, d);
            sum += sky_at(u, v) * fmax(d[2], 0.0) * sin(M_PI * v);
        }
    return sum * 2 * M_PI * M_PI / (WIDTH * FINE * HEIGHT * FINE);
}

// ---- renders

// A white diffuse plane that fills the picture, under `extra` lights too.
static struct stable_mean plane_under_sky(double turn, const char *extra, const char *dial)
{
    struct glint_frame *f = stable_frame(
        &o,
        stable_text(
            "{'images':{'sky':{'data':'%s'}},'environment':{'image':'sky','rotation':%.9g},%s"
            "'materials':{'m':{'ior':1}},'meshes':{'q':{'primitive':'quad','size':[9,9]}},"
            "'instances':{'q':{'mesh':'q','material':'m'}},"
            "'cameras':{'eye':{'yfov':0.8,'transform':{'translation':[0,0,3]}}}}",
            sky_uri, turn, extra),
        stable_text("{'scene':'s','outputs':['beauty'],'resolution':[64,64],'accuracy':{%s},"
                    "'max_bounces':1,'stop':{'samples':64}}",
                    dial));

    const struct stable_mean mean = stable_mean(f, "G");
    glint_frame_destroy(&f);
    return mean;
}

static void assert_radiance(const char *test, struct stable_mean seen, double want)
{
    print_message("# %.4f, expected %.4f, standard error %.4f\n", seen.mean, want, seen.error);
    assert_odds_of(test, seen.mean - want, seen.error, 2e-4 * want);
    assert_true(seen.error < 0.01 * want); // importance sampling: a hundredth after 64 samples
}

static void plane_under_one_bright_texel_shows_the_integral(void **state)
{
    (void)state;
    static const double turn[] = {M_PI, M_PI + 0.7, M_PI - 0.7, 2.2};
    for (int t = 0; t < 4; t++)
        assert_radiance(__func__, plane_under_sky(turn[t], "", ""), irradiance(turn[t]) / M_PI);
}

static void sky_and_lamps_add_up(void **state)
{
    (void)state;
    // A sun of 30 W/m^2 straight onto the plane, and none from behind.
    const char *const lights =
        "'lights':{'a':{'type':'sun','intensity':30},'b':{'type':'sun','intensity':41,"
        "'transform':{'rotation':[0,1,0,0]}}},";
    const double want = (irradiance(2.9) + 30.0) / M_PI;
    assert_radiance(__func__, plane_under_sky(2.9, lights, ""), want);
    assert_radiance(__func__, plane_under_sky(2.9, lights, "'lights':'uniform'"), want);
}

// Where the hot texel stands in a picture that looks along -z with the given turn; -1: not in it.
static int column_of_hot_texel(double turn)
{
    struct glint_frame *f = stable_frame(
        &o,
        stable_text("{'images':{'sky':{'data':'%s'}},'environment':{'image':'sky','rotation':%.9g},"
                    "'cameras':{'eye':{'yfov':2.4}}}",
                    sky_uri, turn),
        stable_job("'resolution':[32,32],'max_bounces':0,'filter':{'kind':'box','width':1},"
                   "'stop':{'samples':16}"));
    const float *p = glint_frame_find(f, "G");
    int best = 0;
    for (int i = 0; i < 32 * 32; i++)
        best = p[i] > p[best] ? i : best;
    const int column = p[best] > 100.0f ? best % 32 : -1;
    glint_frame_destroy(&f);
    return column;
}

static void rotation_turns_the_sky_about_y(void **state)
{
    (void)state;
    const double u = (HOT_X + 0.5) / WIDTH, angle = 2 * M_PI * (u - 0.5); // towards +x
    for (int t = -1; t <= 1; t++) {
        const double turn = 0.4 * t, seen = angle - turn; // the picture turns left
        const int want = (int)(16.0 + 16.0 * tan(seen) / tan(1.2));
        const int column = column_of_hot_texel(turn);
        if (abs(column - want) > 1)
            fail_msg("turned by %g: column %d, expected %d", turn, column, want);
    }
    assert_int_equal(column_of_hot_texel(M_PI), -1);
}

// A body of the surroundings' index changes no ray.
static struct glint_frame *with_body(const char *sky_image, const char *material, bool visible)
{
    return stable_frame(
        &o,
        stable_text(
            "{'images':{'sky':{'data':'%s'}},'environment':{'image':'sky'},'materials':{'m':{%s}},"
            "'meshes':{'s':{'primitive':'sphere','segments':32}},"
            "'instances':{'s':{'mesh':'s','material':'m','visible':%s}},"
            "'cameras':{'eye':{'yfov':0.6,'transform':{'translation':[0,0,4]}}}}",
            sky_image, material, visible ? "true" : "false"),
        stable_job("'resolution':[32,32],'stop':{'samples':16}"));
}

static void matched_body_is_invisible_before_any_sky(void **state)
{
    (void)state;
    // An index of 1 + 10^-6 bends what grazes the rim by 10^-3.
    static const struct {
        const char *material;
        double error;
    } body[] = {{"'transmission':1,'roughness':0,'ior':1", 2e-6},
                {"'transmission':1,'roughness':0.5,'ior':1", 2e-6},
                {"'transmission':1,'roughness':0,'ior':1.000001", 1e-3}};
    float smooth[16 * 8 * 3];
    for (int i = 0; i < 16 * 8 * 3; i++)
        smooth[i] = 0.25f + 0.125f * (float)abs(8 - i / 3 % 16);
    char *uri = stable_hdr(16, 8, smooth);
    for (int m = 0; m < 3; m++) {
        struct glint_frame *with = with_body(uri, body[m].material, true),
                           *without = with_body(uri, body[m].material, false);
        const float *p = glint_frame_find(with, "G"), *q = glint_frame_find(without, "G");
        double worst = 0.0;
        for (size_t i = 0; i < stable_pixels(with); i++)
            worst = fmax(worst, fabs(p[i] - q[i]));
        print_message("# %s: %.2g\n", body[m].material, worst);
        assert_true(worst <= body[m].error);
        glint_frame_destroy(&with);
        glint_frame_destroy(&without);
    }
    free(uri);
}

static int start(void **state)
{
    (void)state;
    offline_start(&o, offline_workers());
    for (int i = 0; i < HEIGHT * WIDTH * 3; i++)
        sky[i] = 0.5f * (float)(1 + i / 3 % 3);
    for (int k = 0; k < 3; k++)
        sky[3 * (HOT_Y * WIDTH + HOT_X) + k] = HOT;
    sky_uri = stable_hdr(WIDTH, HEIGHT, sky);
    return 0;
}

static int finish(void **state)
{
    (void)state;
    offline_finish(&o);
    free(sky_uri);
    return 0;
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(plane_under_one_bright_texel_shows_the_integral),
        cmocka_unit_test(sky_and_lamps_add_up),
        cmocka_unit_test(rotation_turns_the_sky_about_y),
        cmocka_unit_test(matched_body_is_invisible_before_any_sky),
    };
    return cmocka_run_group_tests(tests, start, finish);
}
