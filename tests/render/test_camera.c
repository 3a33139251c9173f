// Where the camera puts things: the matrices in a frame's header against the picture, and what the
// first-hit channels say of known surfaces.
#include "tests/render/offline.h"
#include "tests/render/picture.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>

#include <cmocka.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define WIDTH 192
#define HEIGHT 128
#define YFOV 0.6
#define COUNT(a) (sizeof(a) / sizeof *(a))

// A camera that looks along no axis.
static const double eye[3] = {3.0, -2.0, 5.0};
static const double turn[4] = {0.1, 0.7, -0.2, 0.67823299831252681}; // unit

#define EYE                                                                                       \
    "\"environment\":{},\"cameras\":{\"eye\":{\"yfov\":0.6,\"transform\":{\"translation\":[3,-2," \
    "5],"                                                                                         \
    "\"rotation\":[0.1,0.7,-0.2,0.67823299831252681]}}}"

static void rotate(const double q[4], const double v[3], double out[3])
{
    for (int k = 0; k < 3; k++) { // v + 2 w (q x v) + 2 q x (q x v)
        const int a = (k + 1) % 3, b = (k + 2) % 3;
        const double c[3] = {q[1] * v[2] - q[2] * v[1], q[2] * v[0] - q[0] * v[2],
                             q[0] * v[1] - q[1] * v[0]};
        out[k] = v[k] + 2 * q[3] * c[k] + 2 * (q[a] * c[b] - q[b] * c[a]);
    }
}

// World position of what the eye has x to the right, y upwards, z ahead.
static void seen_at(double x, double y, double z, double world[3])
{
    rotate(turn, (const double[]){x, y, -z}, world);
    for (int k = 0; k < 3; k++)
        world[k] += eye[k];
}

static struct glint_frame *render_text(const char *scene, const char *job)
{
    glint_resident *resident = offline_load_text(&offline_crew, scene);
    struct glint_frame *frame = offline_frame(&offline_crew, resident, job, 0);
    glint_resident_release(&resident);
    return frame;
}

// p M, row vectors; returns w.
static double transform(const struct glint_frame *f, const char *name, const double p[3],
                        double out[3])
{
    const float *m = glint_frame_attribute(f, name)->number;
    for (int j = 0; j < 3; j++)
        out[j] = p[0] * m[j] + p[1] * m[4 + j] + p[2] * m[8 + j] + m[12 + j];
    return p[0] * m[3] + p[1] * m[7] + p[2] * m[11] + m[15];
}

static void centroid(const struct glint_frame *f, double at[2])
{
    const float *alpha = glint_frame_find(f, "A");
    double sum = 0.0;
    at[0] = at[1] = 0.0;
    for (uint32_t i = 0; i < f->width * f->height; i++) {
        sum += alpha[i];
        at[0] += alpha[i] * (f->x + i % f->width + 0.5);
        at[1] += alpha[i] * (f->y + i / f->width + 0.5);
    }
    assert_true(sum > 0.0);
    at[0] /= sum;
    at[1] /= sum;
}

// A ball of 1.5 pixels' radius around a point; of the frame only the 16x16 pixels around `pixel`.
static struct glint_frame *render_ball(const double p[3], double radius, const double pixel[2])
{
    char scene[1024], job[256];
    snprintf(
        scene, sizeof scene,
        "{\"materials\":{\"m\":{}},\"meshes\":{\"s\":{\"primitive\":\"sphere\",\"radius\":%.17g}},"
        "\"instances\":{\"s\":{\"mesh\":\"s\",\"material\":\"m\",\"transform\":{\"translation\":[%."
        "17g,%.17g,%.17g]}}}," EYE "}",
        radius, p[0], p[1], p[2]);
    snprintf(job, sizeof job,
             "{\"scene\":\"s\",\"resolution\":[%d,%d],\"region\":[%d,%d,16,16],\"outputs\":["
             "\"beauty\"],\"max_bounces\":0,"
             "\"filter\":{\"kind\":\"box\",\"width\":1},\"stop\":{\"samples\":4096}}",
             WIDTH, HEIGHT, (int)pixel[0] - 8, (int)pixel[1] - 8);
    return render_text(scene, job);
}

// Off the axis a ball's picture is an ellipse, whose middle is 0.005 pixels beyond; the centroid's
// standard deviation is below 0.005.
static void header_matrices_project_points_to_where_they_are_seen(void **state)
{
    (void)state;
    static const double point[][3] = {
        {0, 0, 4}, {1.6, 1.0, 4}, {-2.4, 1.2, 6}, {-0.35, -0.24, 1}, {25, -20, 90}};
    const double pixel_size = 2 * tan(YFOV / 2) / HEIGHT;
    for (size_t i = 0; i < COUNT(point); i++) {
        const double *c = point[i];
        double world[3], camera[3], ndc[3], at[2];
        seen_at(c[0], c[1], c[2], world);
        const double want[2] = {WIDTH / 2 + c[0] / c[2] / pixel_size,
                                HEIGHT / 2 - c[1] / c[2] / pixel_size};
        struct glint_frame *f = render_ball(world, 1.5 * pixel_size * c[2], want);
        assert_float_equal(transform(f, "worldToCamera", world, camera), 1.0, 1e-6);
        for (int k = 0; k < 3; k++)
            assert_float_equal(camera[k], c[k], 1e-5 * c[2]);
        const double w = transform(f, "worldToNDC", world, ndc);
        centroid(f, at);
        assert_float_equal(at[0], ndc[0] / w * WIDTH, 0.02);
        assert_float_equal(at[1], ndc[1] / w * HEIGHT, 0.02);
        glint_frame_destroy(&f);
    }
}

static void region_is_the_data_window_of_the_whole_display(void **state)
{
    (void)state;
    struct glint_frame *f = render_ball((const double[]){0, 0, 0}, 1, (const double[]){20, 31});
    assert_int_equal(f->display_width, WIDTH);
    assert_int_equal(f->display_height, HEIGHT);
    assert_int_equal(f->x, 12);
    assert_int_equal(f->y, 23);
    assert_int_equal(f->width, 16);
    assert_int_equal(f->height, 16);
    glint_frame_destroy(&f);
}

#define CHANNELS_JOB                                                                          \
    "{\"scene\":\"s\",\"resolution\":[192,128],\"outputs\":[\"beauty\",\"depth\",\"normal\"," \
    "\"albedo\"],"                                                                            \
    "\"max_bounces\":0,\"filter\":{\"kind\":\"box\",\"width\":1},\"stop\":{\"samples\":16}}"

// A wall across the view at distance 7 that hides the left half, seen along rays of every length.
static void depth_is_the_distance_along_the_view_axis(void **state)
{
    (void)state;
    char scene[1024];
    double p[3];
    seen_at(-50, 0, 7, p);
    snprintf(
        scene, sizeof scene,
        "{\"materials\":{\"m\":{}},\"meshes\":{\"q\":{\"primitive\":\"quad\",\"size\":[100,100]}},"
        "\"instances\":{\"q\":{\"mesh\":\"q\",\"material\":\"m\",\"transform\":{\"translation\":[%."
        "17g,%.17g,%.17g],"
        "\"rotation\":[0.1,0.7,-0.2,0.67823299831252681]}}}," EYE "}",
        p[0], p[1], p[2]);
    struct glint_frame *f = render_text(scene, CHANNELS_JOB);
    const float *z = glint_frame_find(f, "Z");
    for (int i = 0; i < WIDTH * HEIGHT; i++) {
        const int x = i % WIDTH;
        if (x < WIDTH / 2 - 1)
            assert_float_equal(z[i], 7.0, 7e-5);
        else if (x > WIDTH / 2)
            assert_true(z[i] == 1e30f);
    }
    glint_frame_destroy(&f);
}

// ---- normals: an ellipsoid at `centre` with these half axes, turned by `tilt`

static const double axes[3] = {0.9, 1.5, 0.6};
static const double tilt[4] = {0.3, -0.2, 0.5, 0.78740078740118110}; // unit
#define TILT "\"rotation\":[0.3,-0.2,0.5,0.78740078740118110],\"scale\":[0.9,1.5,0.6]"

static void into_ellipsoid(const double v[3], double out[3])
{
    rotate((const double[]){-tilt[0], -tilt[1], -tilt[2], tilt[3]}, v, out);
    for (int k = 0; k < 3; k++)
        out[k] /= axes[k];
}

// Normal at the first point of the ray from the eye through a pixel's middle, or false.
static bool ellipsoid_normal(int x, int y, const double centre[3], double n[3])
{
    const double size = 2 * tan(YFOV / 2) / HEIGHT;
    double target[3], from[3], d[3], world[3];
    seen_at((x + 0.5 - WIDTH / 2) * size, (HEIGHT / 2 - y - 0.5) * size, 1, target);
    for (int k = 0; k < 3; k++) {
        world[k] = target[k] - eye[k];
        target[k] = eye[k] - centre[k];
    }
    into_ellipsoid(target, from);
    into_ellipsoid(world, d);
    const double a = d[0] * d[0] + d[1] * d[1] + d[2] * d[2],
                 b = from[0] * d[0] + from[1] * d[1] + from[2] * d[2];
    const double c = from[0] * from[0] + from[1] * from[1] + from[2] * from[2] - 1;
    if (b * b - a * c < 0.1 * a) // a margin: beyond it the normal turns quickly
        return false;
    const double t = (-b - sqrt(b * b - a * c)) / a;
    double gradient[3], length = 0.0;
    for (int k = 0; k < 3; k++)
        gradient[k] = (from[k] + t * d[k]) / axes[k];
    rotate(tilt, gradient, n);
    for (int k = 0; k < 3; k++)
        length += n[k] * n[k];
    for (int k = 0; k < 3; k++)
        n[k] /= sqrt(length);
    return true;
}

// copies: of a mesh of many triangles; more than one are instances of one structure.
static void check_normals(int copies, int segments)
{
    char scene[2048];
    double p[3];
    int seen = 0;
    seen_at(0.3, -0.2, 8, p);
    int n = snprintf(scene, sizeof scene,
                     "{\"materials\":{\"m\":{}},\"meshes\":{\"s\":{\"primitive\":\"sphere\","
                     "\"segments\":%d}},\"instances\":{",
                     segments);
    for (int i = 0; i < copies; i++)
        n += snprintf(scene + n, sizeof scene - n,
                      "%s\"s%d\":{\"mesh\":\"s\",\"material\":\"m\",\"transform\":{\"translation\":"
                      "[%.17g,%.17g,%.17g]," TILT "}}",
                      i ? "," : "", i, p[0], p[1] + 40 * i, p[2]);
    snprintf(scene + n, sizeof scene - n, "}," EYE "}");
    struct glint_frame *f = render_text(scene, CHANNELS_JOB);
    const float *const plane[3] = {glint_frame_find(f, "N.X"), glint_frame_find(f, "N.Y"),
                                   glint_frame_find(f, "N.Z")};
    for (int i = 0; i < WIDTH * HEIGHT; i++) {
        double want[3], square = 0.0;
        if (!ellipsoid_normal(i % WIDTH, i / WIDTH, p, want))
            continue;
        for (int k = 0; k < 3; k++) {
            assert_float_equal(plane[k][i], want[k], 0.02);
            square += (double)plane[k][i] * plane[k][i];
        }
        assert_float_equal(sqrt(square), 1.0, 0.002); // a mean over the pixel
        seen++;
    }
    assert_true(seen > 300);
    glint_frame_destroy(&f);
}

static void normals_are_unit_in_the_world_and_face_the_eye(void **state)
{
    (void)state;
    check_normals(1, 64);
    check_normals(2, 256);
}

// ---- albedo

// Red green above blue white.
static char *quarters(void)
{
    float plane[3][64];
    static const float colour[4][3] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {1, 1, 1}};
    for (int i = 0; i < 64; i++)
        for (int c = 0; c < 3; c++)
            plane[c][i] = colour[i / 32 * 2 + i % 8 / 4][c];
    return picture_uri(&(struct glint_png_image){8, 8, plane[0], plane[1], plane[2], NULL});
}

static void assert_albedo(const struct glint_frame *f, int x, int y, float r, float g, float b)
{
    const size_t i = (size_t)y * WIDTH + x;
    assert_float_equal(glint_frame_find(f, "albedo.R")[i], r, 1e-6);
    assert_float_equal(glint_frame_find(f, "albedo.G")[i], g, 1e-6);
    assert_float_equal(glint_frame_find(f, "albedo.B")[i], b, 1e-6);
}

static void textures_are_upright_and_not_mirrored(void **state)
{
    (void)state;
    char scene[4096], *image = quarters();
    snprintf(scene, sizeof scene,
             "{\"images\":{\"p\":{\"data\":\"%s\"}},\"materials\":{\"m\":{\"base_color_texture\":{"
             "\"image\":\"p\"}}},"
             "\"meshes\":{\"q\":{\"primitive\":\"quad\",\"size\":[2,2]}},\"instances\":{\"q\":{"
             "\"mesh\":\"q\",\"material\":\"m\"}},"
             "\"cameras\":{\"eye\":{\"yfov\":0.6,\"transform\":{\"translation\":[0,0,4]}}}}",
             image);
    struct glint_frame *f = render_text(scene, CHANNELS_JOB);
    assert_albedo(f, WIDTH / 2 - 25, HEIGHT / 2 - 25, 1, 0, 0);
    assert_albedo(f, WIDTH / 2 + 25, HEIGHT / 2 - 25, 0, 1, 0);
    assert_albedo(f, WIDTH / 2 - 25, HEIGHT / 2 + 25, 0, 0, 1);
    assert_albedo(f, WIDTH / 2 + 25, HEIGHT / 2 + 25, 1, 1, 1);
    assert_albedo(f, 2, 2, 0, 0, 0); // nothing there
    glint_frame_destroy(&f);
    free(image);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(header_matrices_project_points_to_where_they_are_seen),
        cmocka_unit_test(region_is_the_data_window_of_the_whole_display),
        cmocka_unit_test(depth_is_the_distance_along_the_view_axis),
        cmocka_unit_test(normals_are_unit_in_the_world_and_face_the_eye),
        cmocka_unit_test(textures_are_upright_and_not_mirrored),
    };
    return cmocka_run_group_tests(tests, offline_crew_start, offline_crew_finish);
}
