// Features whose picture follows from geometry: normal maps, spot lights, an image at infinity, and
// textures in more pools than one.
#include "kernels/gk_scene.h"
#include "tests/stability/stable.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#define COUNT(a) (sizeof(a) / sizeof *(a))
#define SIDE 32

static struct glint_frame *render(char *scene)
{
    return stable_frame(&offline_crew, scene,
                        stable_job("'resolution':[32,32],'filter':{'kind':'box','width':1},"
                                   "'max_bounces':1,'stop':{'samples':64}"));
}

// Every pixel of a channel is `want`.
static void assert_uniform(struct glint_frame *f, const char *channel, double want)
{
    print_message("# %.5f..%.5f, expected %.5f\n", stable_least(f, channel),
                  stable_most(f, channel), want);
    assert_float_equal(stable_least(f, channel), want, 2e-5);
    assert_float_equal(stable_most(f, channel), want, 2e-5);
}

// ---- normal maps

static double linear_of(int byte)
{
    const double c = byte / 255.0;
    return c <= 0.04045 ? c / 12.92 : pow((c + 0.055) / 1.055, 2.4);
}

// A picture of one texel with these bytes.
static char *texel_uri(const int rgb[3])
{
    const float linear[3] = {(float)linear_of(rgb[0]), (float)linear_of(rgb[1]),
                             (float)linear_of(rgb[2])};
    return stable_png(1, 1, linear);
}

// The rotation that takes +z to the direction `polar` from it, `azimuth` from +x about it.
static char *rotation(double polar, double azimuth)
{
    return stable_text("%.9g,%.9g,0,%.9g", -sin(azimuth) * sin(polar / 2),
                       cos(azimuth) * sin(polar / 2), cos(polar / 2));
}

struct mapped {
    const char *mesh;      // further members
    const char *placement; // of the quad
    const char *copies;    // indices of the quad's two triangles, as often as they are stored
    const char *more;      // instances
    int rgb[3];            // the map's texel
    double tangent[3];     // where red points to in the world
    double bitangent[3];   // and green
    double normal[3];
    double polar, azimuth; // of the direction to the sun
};

// v grows downwards, as in the image: at the top edge it is 0.
#define UPRIGHT "'uvs':[0,1,1,1,1,0,0,0]"
#define MIRRORED "'uvs':[1,1,0,1,0,0,1,0]"
#define TURNED "'uvs':[0,0,0,1,1,1,1,0]" // u runs upwards, v to the right

static struct glint_frame *mapped_plane(const struct mapped *m)
{
    char *uri = texel_uri(m->rgb), *sun = rotation(m->polar, m->azimuth);
    struct glint_frame *f = render(stable_text(
        "{'images':{'n':{'data':'%s'}},'materials':{'m':{'ior':1,'normal_map':{'image':'n'}}},"
        "'meshes':{'q':{'positions':[-1,-1,0,1,-1,0,1,1,0,-1,1,0],'indices':[%s],%s}},"
        "'instances':{%s'q':{'mesh':'q','material':'m','transform':{%s}}},"
        "'lights':{'sun':{'type':'sun','intensity':3.14159265,'transform':{'rotation':[%s]}}},"
        "'cameras':{'eye':{'yfov':0.5,'transform':{'translation':[0,0,3]}}}}",
        uri, m->copies, m->mesh, m->more, m->placement, sun));
    free(uri);
    free(sun);
    return f;
}

// Cosine of the sun with the normal that the texel's bytes say; a white plane shows just that.
static double mapped_cosine(const struct mapped *m)
{
    const double sun[3] = {sin(m->polar) * cos(m->azimuth), sin(m->polar) * sin(m->azimuth),
                           cos(m->polar)};
    double cosine = 0, square = 0;
    for (int k = 0; k < 3; k++) {
        const double n = m->tangent[k] * (m->rgb[0] / 127.5 - 1) +
                         m->bitangent[k] * (m->rgb[1] / 127.5 - 1) +
                         m->normal[k] * (m->rgb[2] / 127.5 - 1);
        cosine += n * sun[k];
        square += n * n;
    }
    return fmax(cosine / sqrt(square), 0);
}

static void assert_mapped(const struct mapped *m)
{
    struct glint_frame *f = mapped_plane(m);
    assert_uniform(f, "G", mapped_cosine(m));
    glint_frame_destroy(&f);
}

#define ONCE "0,1,2,0,2,3"
#define X       \
    {           \
        1, 0, 0 \
    }
#define Y       \
    {           \
        0, 1, 0 \
    }
#define Z       \
    {           \
        0, 0, 1 \
    }

static void normal_map_turns_a_plane_to_the_sun(void **state)
{
    (void)state;
    static const struct mapped flat = {UPRIGHT, "", ONCE, "", {204, 128, 230}, X, Y, Z, 0, 0};
    for (int i = 0; i < 4; i++) { // the sun on the right, above, on the left and below
        struct mapped m = flat;
        m.polar = 0.6;
        m.azimuth = i * M_PI / 2;
        assert_mapped(&m);
    }
}

static void green_of_a_normal_map_points_up_in_the_image(void **state)
{
    (void)state;
    static const struct mapped map[] = {
        {UPRIGHT, "", ONCE, "", {128, 204, 230}, X, Y, Z, 0.6, M_PI / 2},
        {UPRIGHT, "", ONCE, "", {128, 204, 230}, X, Y, Z, 0.6, -M_PI / 2},
        {MIRRORED, "", ONCE, "", {204, 180, 230}, {-1, 0, 0}, Y, Z, 0.6, 1},
        {TURNED, "", ONCE, "", {204, 180, 230}, Y, {-1, 0, 0}, Z, 0.6, 1},
        // A mirroring placement takes the tangents with it.
        {UPRIGHT, "'scale':[-1,1,1]", ONCE, "", {204, 180, 230}, {-1, 0, 0}, Y, Z, 0.6, 1},
    };
    for (size_t i = 0; i < COUNT(map); i++)
        assert_mapped(&map[i]);
}

static void tangents_of_the_file_are_used(void **state)
{
    (void)state;
    static const struct mapped map[] = {
        {UPRIGHT ",'normals':[0,0,1,0,0,1,0,0,1,0,0,1],"
                 "'tangents':[0,1,0,1,0,1,0,1,0,1,0,1,0,1,0,1]",
         "",
         ONCE,
         "",
         {204, 180, 230},
         Y,
         {-1, 0, 0},
         Z,
         0.6,
         1},
        {UPRIGHT ",'normals':[0,0,1,0,0,1,0,0,1,0,0,1],"
                 "'tangents':[0,1,0,-1,0,1,0,-1,0,1,0,-1,0,1,0,-1]",
         "",
         ONCE,
         "",
         {204, 180, 230},
         Y,
         X,
         Z,
         0.6,
         1},
    };
    for (size_t i = 0; i < COUNT(map); i++)
        assert_mapped(&map[i]);
}

// `n` copies of a text, one after the other; malloc'd.
static char *repeated(const char *text, int n)
{
    const size_t length = strlen(text);
    char *all = malloc(length * (size_t)n + 1);
    assert_non_null(all);
    for (int i = 0; i < n; i++)
        memcpy(all + length * (size_t)i, text, length + 1);
    return all;
}

// Instances of the quad, out of sight.
static char *others(int n)
{
    char *all = stable_text("%s", "");
    for (int i = 0; i < n; i++) {
        char *longer = stable_text(
            "%s'o%d':{'mesh':'q','material':'m','transform':{'translation':[90,0,-5]}},", all, i);
        free(all);
        all = longer;
    }
    return all;
}

// Whether a mesh is stored once and placed or baked where it stands is not to be seen. The tangent
// (1,1,0) of a plane twice as wide becomes (2,1,0), and green is at right angles to it. Without
// texture coordinates there is no tangent: the map does nothing.
static void stretched_instance_turns_its_tangents(void **state)
{
    (void)state;
    enum { TWICE = 350, PLACES = 100 }; // 70,000 triangles: above the limit for baking
    const double c = 2 / sqrt(5), s = 1 / sqrt(5);
    struct mapped m[] = {
        {UPRIGHT ",'normals':[0,0,1,0,0,1,0,0,1,0,0,1],'tangents':"
                 "[0.70710678,0.70710678,0,1,0.70710678,0.70710678,0,1,"
                 "0.70710678,0.70710678,0,1,0.70710678,0.70710678,0,1]",
         "'scale':[2,1,1]",
         ONCE,
         "",
         {204, 180, 230},
         {c, s, 0},
         {-s, c, 0},
         Z,
         0.6,
         0.2},
        {"'normals':[0,0,1,0,0,1,0,0,1,0,0,1]",
         "'scale':[2,1,1]",
         ONCE,
         "",
         {204, 180, 230},
         {0},
         {0},
         Z,
         0.6,
         0.2},
    };
    char *more = others(PLACES), *many = repeated(ONCE ",", TWICE);
    many[strlen(many) - 1] = 0;
    for (size_t i = 0; i < COUNT(m); i++) {
        assert_mapped(&m[i]);
        m[i].copies = many;
        m[i].more = more;
        assert_mapped(&m[i]);
    }
    free(many);
    free(more);
}

// ---- spot lights

#define VIEW 3.0  // the eye above a white plane
#define REACH 1.5 // half the side of what it sees
#define CANDELA 7.0

struct spot {
    double at[3], polar, azimuth; // azimuth and polar angle of +z, from which the beam runs away
    double inner, outer;
};

// KHR_lights_punctual: saturate((cos a - cos outer) / (cos inner - cos outer))^2 / d^2, times the
// cosine on the plane.
static double spot_radiance(const struct spot *s, double x, double y)
{
    const double to[3] = {x - s->at[0], y - s->at[1], -s->at[2]};
    const double d = sqrt(to[0] * to[0] + to[1] * to[1] + to[2] * to[2]);
    const double axis[3] = {-sin(s->polar) * cos(s->azimuth), -sin(s->polar) * sin(s->azimuth),
                            -cos(s->polar)};
    const double cosine = (to[0] * axis[0] + to[1] * axis[1] + to[2] * axis[2]) / d;
    const double fall = (cosine - cos(s->outer)) / fmax(1e-3, cos(s->inner) - cos(s->outer));
    const double cone = fmin(fmax(fall, 0), 1);
    return CANDELA * cone * cone * (s->at[2] / d) / (d * d) / M_PI;
}

static double place(int i, double fraction)
{
    return ((i + fraction) / SIDE * 2 - 1) * REACH;
}

struct range {
    double mean, least, most;
};

static struct range spot_pixel(const struct spot *s, int column, int row)
{
    enum { FINE = 17 };
    struct range r = {0, INFINITY, 0};
    for (int j = 0; j < FINE; j++)
        for (int i = 0; i < FINE; i++) { // to the very corners
            const double L =
                spot_radiance(s, place(column, i / (FINE - 1.0)), -place(row, j / (FINE - 1.0)));
            r.mean += L / (FINE * FINE);
            r.least = fmin(r.least, L);
            r.most = fmax(r.most, L);
        }
    return r;
}

static struct glint_frame *spot_picture(const struct spot *s)
{
    char *turn = rotation(s->polar, s->azimuth);
    struct glint_frame *f = render(stable_text(
        "{'materials':{'m':{'ior':1}},'meshes':{'q':{'primitive':'quad','size':[9,9]}},"
        "'instances':{'q':{'mesh':'q','material':'m'}},"
        "'lights':{'spot':{'type':'spot','intensity':%g,'inner_cone':%.9g,'outer_cone':%.9g,"
        "'transform':{'translation':[%g,%g,%g],'rotation':[%s]}}},"
        "'cameras':{'eye':{'yfov':%.9g,'transform':{'translation':[0,0,%g]}}}}",
        CANDELA, s->inner, s->outer, s->at[0], s->at[1], s->at[2], turn, 2 * atan(REACH / VIEW),
        VIEW));
    free(turn);
    return f;
}

// Each pixel lies between the extremes of its area, and the mean is that of the law.
static void assert_spot(const struct spot *s)
{
    struct glint_frame *f = spot_picture(s);
    const float *p = glint_frame_find(f, "G");
    double sum = 0, want = 0;
    int dark = 0, bright = 0;
    for (int i = 0; i < SIDE * SIDE; i++) {
        const struct range r = spot_pixel(s, i % SIDE, i / SIDE);
        if (p[i] < r.least * (1 - 1e-5) || p[i] > r.most * (1 + 1e-5))
            fail_msg("pixel %d,%d is %g, not in %g..%g", i % SIDE, i / SIDE, p[i], r.least, r.most);
        dark += r.most == 0;
        bright += r.least > 0;
        sum += p[i];
        want += r.mean;
    }
    print_message("# %d dark, %d bright; sum %.4f, expected %.4f\n", dark, bright, sum, want);
    assert_true(dark > 100 && bright > 100);
    assert_float_equal(sum, want, 0.01 * want);
    glint_frame_destroy(&f);
}

static void spot_light_falls_off_as_its_cone_says(void **state)
{
    (void)state;
    static const struct spot spot[] = {
        {{0, 0, 2}, 0, 0, 0, 0.5},           // soft from the axis on
        {{0, 0, 2}, 0, 0, 0.3, 0.5},         // a bright middle
        {{0, 0, 2}, 0, 0, 0.4999, 0.5},      // a hard edge
        {{1, -0.5, 2}, 0.5, -0.4, 0.2, 0.4}, // from the side
    };
    for (size_t i = 0; i < COUNT(spot); i++)
        assert_spot(&spot[i]);
}

// ---- the image at infinity

#define SKY_ROWS 8
#define SKY_COLUMNS 16

// A picture whose second row from the top has radiance 1.
static char *bright_band(void)
{
    static float rgb[SKY_ROWS * SKY_COLUMNS * 3];
    for (int i = 0; i < SKY_COLUMNS * 3; i++)
        rgb[SKY_COLUMNS * 3 + i] = 1.0f;
    return stable_hdr(SKY_COLUMNS, SKY_ROWS, rgb);
}

// Irradiance from above: the band is a tent over v with its peak in the middle of its row.
static double band_irradiance(void)
{
    enum { STEPS = 100000 };
    double sum = 0;
    for (int i = 0; i < STEPS; i++) {
        const double v = (i + 0.5) / (2 * STEPS), theta = M_PI * v;
        const double L = fmax(1 - fabs(v * SKY_ROWS - 1.5), 0);
        sum += L * cos(theta) * sin(theta);
    }
    return 2 * M_PI * sum * M_PI / (2 * STEPS);
}

// A white plane across y, seen from the end of the y axis that `side` says.
static struct glint_frame *floor_under_band(int side)
{
    char *uri = bright_band();
    struct glint_frame *f = render(
        stable_text("{'images':{'sky':{'data':'%s'}},'environment':{'image':'sky'},"
                    "'materials':{'m':{'ior':1}},'meshes':{'q':{'primitive':'quad','size':[9,9]}},"
                    "'instances':{'q':{'mesh':'q','material':'m','transform':{'rotation':"
                    "[0.70710678,0,0,0.70710678]}}},"
                    "'cameras':{'eye':{'yfov':0.8,'transform':{'translation':[0,%d,0],"
                    "'rotation':[%.9g,0,0,0.70710678]}}}}",
                    uri, 3 * side, -0.70710678 * side));
    free(uri);
    return f;
}

static void upper_rows_of_the_sky_are_above(void **state)
{
    (void)state;
    struct glint_frame *above = floor_under_band(1), *below = floor_under_band(-1);
    const struct stable_mean mean = stable_mean(above, "G");
    const double want = band_irradiance() / M_PI;
    print_message("# %.5f, expected %.5f, standard error %.5f\n", mean.mean, want, mean.error);
    assert_odds(mean.mean - want, mean.error, 2e-4 * want);
    assert_true(mean.error < 0.01 * want);
    assert_float_equal(stable_most(below, "G"), 0, 0);
    glint_frame_destroy(&above);
    glint_frame_destroy(&below);
}

// ---- texture pools

#define POOLS 4

// Four quads side by side, each with its own texture of one tile of texels.
static glint_resident *four_textures(void)
{
    char *uri[POOLS];
    for (int p = 0; p < POOLS; p++) {
        float rgb[8 * 8 * 3];
        for (int i = 0; i < 8 * 8 * 3; i++)
            rgb[i] = (float)((i * (7 + 2 * p) + 11 * p) % 32 + 1) / 32.0f;
        uri[p] = stable_png(8, 8, rgb);
    }
    char *text = stable_text(
        "{'images':{'a':{'data':'%s'},'b':{'data':'%s'},'c':{'data':'%s'},'d':{'data':'%s'}},"
        "'environment':{'radiance':[1,1,1]},'materials':{"
        "'a':{'ior':1,'base_color_texture':{'image':'a'}},"
        "'b':{'ior':1,'base_color_texture':{'image':'b'}},"
        "'c':{'ior':1,'base_color_texture':{'image':'c'}},"
        "'d':{'ior':1,'base_color_texture':{'image':'d'}}},"
        "'meshes':{'q':{'primitive':'quad'}},'instances':{"
        "'a':{'mesh':'q','material':'a','transform':{'translation':[-0.5,-0.5,0]}},"
        "'b':{'mesh':'q','material':'b','transform':{'translation':[0.5,-0.5,0]}},"
        "'c':{'mesh':'q','material':'c','transform':{'translation':[-0.5,0.5,0]}},"
        "'d':{'mesh':'q','material':'d','transform':{'translation':[0.5,0.5,0]}}},"
        "'cameras':{'eye':{'yfov':0.6,'transform':{'translation':[0,0,3]}}}}",
        uri[0], uri[1], uri[2], uri[3]);
    glint_resident *scene = offline_load_text(&offline_crew, text);
    for (int p = 0; p < POOLS; p++)
        free(uri[p]);
    free(text);
    return scene;
}

// Moves the texels of texture p to the start of pool p, as if each image had filled its own, and
// leaves no copy in the first pool.
static void spread(glint_resident *scene)
{
    struct gk_texture *t = glint_buffer_host(glint_resident_table(scene, GLINT_TABLE_TEXTURES));
    for (uint32_t p = 1; p < POOLS; p++) {
        glint_buffer *pool = glint_resident_table(scene, GLINT_TABLE_POOL0 + p);
        uint32_t *from =
            (uint32_t *)glint_buffer_host(glint_resident_table(scene, GLINT_TABLE_POOL0)) +
            t[p].offset;
        assert_int_equal(t[p].pool, 0);
        assert_true(glint_buffer_bytes(pool) >= 64 * sizeof *from);
        memcpy(glint_buffer_host(pool), from, 64 * sizeof *from);
        memset(from, 0, 64 * sizeof *from);
        t[p].pool = p;
        t[p].offset = 0;
    }
}

static void four_texture_pools_give_the_picture_of_one(void **state)
{
    (void)state;
    static const char job[] = "{\"scene\":\"s\",\"outputs\":[\"beauty\"],\"resolution\":[32,32],"
                              "\"max_bounces\":1,\"stop\":{\"samples\":16}}";
    glint_resident *scene = four_textures();
    struct glint_frame *one = offline_frame(&offline_crew, scene, job, 0);
    assert_true(stable_most(one, "G") > 0.8 && stable_least(one, "G") < 0.3);
    spread(scene);
    struct glint_frame *four =
        offline_frame(&offline_crew, scene, job, glint_effect_bit("texture pools"));
    stable_assert_same(one, four);
    glint_frame_destroy(&one);
    glint_frame_destroy(&four);
    glint_resident_release(&scene);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(normal_map_turns_a_plane_to_the_sun),
        cmocka_unit_test(green_of_a_normal_map_points_up_in_the_image),
        cmocka_unit_test(tangents_of_the_file_are_used),
        cmocka_unit_test(stretched_instance_turns_its_tangents),
        cmocka_unit_test(spot_light_falls_off_as_its_cone_says),
        cmocka_unit_test(upper_rows_of_the_sky_are_above),
        cmocka_unit_test(four_texture_pools_give_the_picture_of_one),
    };
    return cmocka_run_group_tests(tests, offline_crew_start, offline_crew_finish);
}
