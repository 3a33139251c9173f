// Rays at closed meshes and slivers, through the traversal that renders use.
#include "tests/stability/stable.h"

#include "kernels/gk_wave.h"
#include "protocol/dials.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static struct offline o;

#define LANES 4096u

struct ray_bench {
    glint_geometry *geometry;
    float wave[GK_COLUMNS][LANES];
};

static glint_status add_mesh(glint_world *world, void *mesh, struct glint_error *err)
{
    return glint_world_add_mesh(world, 0, mesh, err);
}

static void bench_open(struct ray_bench *b, bool robust, const struct glint_geometry_mesh *mesh)
{
    struct glint_error err = {0};
    memset(b->wave, 0, sizeof b->wave);
    memset(b->wave[GK_COL_MASK], 0xff, sizeof b->wave[GK_COL_MASK]);
    const struct glint_geometry_build build = {.robust = robust};
    glint_tracer *tracer = NULL;
    glint_world *world = NULL;
    if (glint_tracer_create(&tracer, &err) ||
        glint_world_create(&world, tracer, &build, add_mesh, (void *)mesh, &err))
        offline_die("geometry", &err);
    b->geometry = glint_geometry_create(world, NULL, NULL);
    glint_world_release(&world);
    glint_tracer_release(&tracer);
}

static void set_ray(struct ray_bench *b, uint32_t i, const double origin[3], const double target[3])
{
    double d[3], square = 0.0;
    for (int k = 0; k < 3; k++) {
        d[k] = target[k] - (float)origin[k];
        square += d[k] * d[k];
    }
    for (int k = 0; k < 3; k++) {
        b->wave[GK_COL_OX + k][i] = (float)origin[k];
        b->wave[GK_COL_DX + k][i] = (float)(d[k] / sqrt(square));
    }
    b->wave[GK_COL_T][i] = INFINITY;
    memset(&b->wave[GK_COL_GEOMETRY][i], 0xff, 4);
    memset(&b->wave[GK_COL_INSTANCE][i], 0xff, 4);
}

static bool hit(const struct ray_bench *b, uint32_t i)
{
    return b->wave[GK_COL_T][i] < INFINITY;
}

static void trace(struct ray_bench *b)
{
    glint_geometry_trace_wave(b->geometry, &b->wave[0][0], LANES, LANES);
}

// The same rays for shadow rays.
static void trace_shadows(struct ray_bench *b)
{
    memcpy(b->wave[GK_COL_SOX], b->wave[GK_COL_OX], sizeof b->wave[0] * 7);
    glint_geometry_shadow_wave(b->geometry, &b->wave[0][0], LANES, LANES);
}

// ---- cracks

#define ROWS 24
#define COLUMNS 48

// A closed ball with dents: poles, then rings.
struct ball {
    float position[(ROWS - 1) * COLUMNS + 2][3];
    uint32_t index[2 * (ROWS - 1) * COLUMNS][3], triangles;
};

static uint32_t ring(int row, int column)
{
    if (row == 0 || row == ROWS)
        return row == 0 ? 0 : 1;
    return 2 + (uint32_t)((row - 1) * COLUMNS + column % COLUMNS);
}

static void make_ball(struct ball *b)
{
    uint64_t seed = 3;
    memset(b, 0, sizeof *b);
    for (int r = 0; r <= ROWS; r++)
        for (int c = 0; c < COLUMNS; c++) {
            const double theta = M_PI * r / ROWS, phi = 2 * M_PI * c / COLUMNS;
            const double radius = 1.0 + 0.2 * stable_random(&seed);
            float *p = b->position[ring(r, c)];
            p[0] = (float)(radius * sin(theta) * cos(phi));
            p[1] = (float)(radius * cos(theta));
            p[2] = (float)(radius * sin(theta) * sin(phi));
        }
    for (int r = 0; r < ROWS; r++)
        for (int c = 0; c < COLUMNS; c++) {
            const uint32_t quad[4] = {ring(r, c), ring(r + 1, c), ring(r + 1, c + 1),
                                      ring(r, c + 1)};
            if (r + 1 < ROWS)
                memcpy(b->index[b->triangles++], quad, 12);
            if (r > 0)
                memcpy(b->index[b->triangles++], (uint32_t[3]){quad[0], quad[2], quad[3]}, 12);
        }
}

struct leaks {
    unsigned seen, shadows;
};

// The rays of a wave that leave the closed ball.
static void count(struct ray_bench *b, bool watertight, struct leaks *lost)
{
    float *wave = &b->wave[0][0];
    trace_shadows(b);
    if (watertight)
        glint_geometry_close_shadows(b->geometry, wave, LANES, LANES);
    trace(b);
    if (watertight)
        glint_geometry_close_wave(b->geometry, wave, LANES, LANES);
    for (uint32_t i = 0; i < LANES; i++) {
        lost->seen += !hit(b, i);
        lost->shadows += b->wave[GK_COL_ST][i] > 0.0f;
    }
}

// From around the centre at points of edges, or at vertices: of 2^20 rays of either kind.
static struct leaks leaks(const struct ball *ball, unsigned char traversal, bool vertices)
{
    static struct ray_bench b;
    const struct glint_geometry_mesh mesh = {.position = &ball->position[0][0],
                                             .vertices = (ROWS - 1) * COLUMNS + 2,
                                             .index = &ball->index[0][0],
                                             .triangles = ball->triangles,
                                             .keys = 1};
    uint64_t seed = 17;
    struct leaks lost = {0};
    bench_open(&b, traversal != GLINT_TRAVERSAL_FAST, &mesh);
    for (int wave = 0; wave < 256; wave++) {
        for (uint32_t i = 0; i < LANES; i++) {
            const uint32_t *t = ball->index[(uint32_t)(stable_random(&seed) * ball->triangles)];
            const double along = vertices ? 0.0 : stable_random(&seed);
            double origin[3], target[3];
            for (int k = 0; k < 3; k++) {
                origin[k] = 0.5 * stable_random(&seed) - 0.25;
                target[k] =
                    ball->position[t[0]][k] * (1.0 - along) + ball->position[t[1]][k] * along;
            }
            set_ray(&b, i, origin, target);
        }
        count(&b, traversal == GLINT_TRAVERSAL_WATERTIGHT, &lost);
    }
    glint_geometry_destroy(&b.geometry);
    return lost;
}

static void rays_at_edges_do_not_leak_in_robust_traversal(void **state)
{
    (void)state;
    static struct ball ball;
    make_ball(&ball);
    const struct leaks fast = leaks(&ball, GLINT_TRAVERSAL_FAST, false),
                       robust = leaks(&ball, GLINT_TRAVERSAL_ROBUST, false);
    print_message("# of 2^20 rays leak: fast %u, robust %u\n", fast.seen, robust.seen);
    assert_int_equal(robust.seen, 0);
    assert_int_equal(robust.shadows, 0);
    assert_true(fast.seen > 0);
}

static void rays_at_vertices_do_not_leak_in_watertight_traversal(void **state)
{
    (void)state;
    static struct ball ball;
    make_ball(&ball);
    const struct leaks robust = leaks(&ball, GLINT_TRAVERSAL_ROBUST, true),
                       closed = leaks(&ball, GLINT_TRAVERSAL_WATERTIGHT, true);
    print_message("# of 2^20 rays leak: robust %u, watertight %u\n", robust.seen, closed.seen);
    assert_int_equal(closed.seen, 0);
    assert_int_equal(closed.shadows, 0);
    assert_in_range(robust.seen, 1, (1u << 20) / 1000);
}

// All rays of these renders go by this vertex, by which many slip in robust traversal.
#define SLIPPERY 860

static void print_ball(FILE *text, const struct ball *ball)
{
    fputs("'meshes':{'t':{'positions':[0,0.3,0,-0.3,-0.3,0,0.3,-0.3,0]},'s':{'positions':[", text);
    for (uint32_t v = 0; v < (ROWS - 1) * COLUMNS + 2; v++) {
        const float *p = ball->position[v];
        fprintf(text, "%s%.9g,%.9g,%.9g", v ? "," : "", p[0], p[1], p[2]);
    }
    fputs("],'indices':[", text);
    for (uint32_t t = 0; t < ball->triangles; t++) {
        const uint32_t *i = ball->index[t];
        fprintf(text, "%s%u,%u,%u", t ? "," : "", i[0], i[1], i[2]);
    }
    fputs("]}},'materials':{'m':{'ior':1},'white':{'base_color':[1,1,1]}}", text);
}

// Light in the closed ball. more: what lights it, what else is in it, and the members of its camera.
static double light_in_ball(const char *more, const char *camera, const char *traversal)
{
    static struct ball ball;
    char *scene = NULL;
    size_t size = 0;
    FILE *text = open_memstream(&scene, &size);
    make_ball(&ball);
    assert_non_null(text);
    fprintf(text, "{%s,'cameras':{'eye':{%s}},", more, camera);
    print_ball(text, &ball);
    fputs("}", text);
    fclose(text);
    for (char *c = scene; *c; c++)
        *c = *c == '\'' ? '"' : *c;
    struct glint_frame *f =
        stable_frame(&o, scene,
                     stable_text("{'scene':'s','outputs':['beauty'],'resolution':[64,64],"
                                 "'max_bounces':1,'accuracy':{'traversal':'%s'},"
                                 "'stop':{'samples':128}}",
                                 traversal));
    const double mean = stable_mean(f, "G").mean;
    glint_frame_destroy(&f);
    return mean;
}

// A strong sky outside, through a wide lens at the centre that is focused on the vertex.
static double seen_past_the_vertex(const char *traversal)
{
    static struct ball ball;
    make_ball(&ball);
    const float *v = ball.position[SLIPPERY];
    const double far = hypot(hypot(v[0], v[1]), v[2]); // the camera looks along (0, 0, -1)
    const double w = far - v[2], length = hypot(hypot(v[0], v[1]), w);
    char *camera = stable_text("'yfov':1e-6,'lens_radius':0.2,'focus_distance':%.9g,"
                               "'transform':{'rotation':[%.9g,%.9g,0,%.9g]}",
                               far, v[1] / length, -v[0] / length, w / length);
    const double light = light_in_ball("'environment':{'radiance':[1e6,1e6,1e6]},"
                                       "'instances':{'s':{'mesh':'s','material':'m'}}",
                                       camera, traversal);
    free(camera);
    return light;
}

// A strong lamp outside, two millionths from the vertex, and a sheet inside.
static double lit_past_the_vertex(const char *traversal)
{
    static struct ball ball;
    make_ball(&ball);
    const float *v = ball.position[SLIPPERY];
    char *more = stable_text("'lights':{'p':{'type':'point','intensity':1e6,'transform':{"
                             "'translation':[%.9g,%.9g,%.9g]}}},'instances':{"
                             "'s':{'mesh':'s','material':'m'},'t':{'mesh':'t','material':'white'}}",
                             v[0] * 1.000002, v[1] * 1.000002, v[2] * 1.000002);
    const double light = light_in_ball(
        more, "'yfov':1,'transform':{'translation':[0,0,-0.5],'rotation':[0,1,0,0]}", traversal);
    free(more);
    return light;
}

static void no_light_slips_by_a_vertex_in_watertight_traversal(void **state)
{
    (void)state;
    const double seen = seen_past_the_vertex("robust"), lit = lit_past_the_vertex("robust");
    print_message("# robust traversal: %g is seen, %g is lit\n", seen, lit);
    assert_true(seen > 0.0 && lit > 0.0);
    assert_float_equal(seen_past_the_vertex("watertight"), 0.0, 0.0);
    assert_float_equal(lit_past_the_vertex("watertight"), 0.0, 0.0);
}

// ---- slivers

static void rotate_into_place(double p[3], const double axis[3][3])
{
    const double q[3] = {p[0], p[1], p[2]};
    for (int k = 0; k < 3; k++)
        p[k] = axis[0][k] * q[0] + axis[1][k] * q[1] + axis[2][k] * q[2];
}

#define BOUND 0x1p-19 // of what is near a hit, by which rays are lifted off it

// What a hit's distance may be off: 8 error bounds, and the rounding of the plane, which grows as the
// needle gets thin and the view flat.
static double allowed_error(const struct ray_bench *b, uint32_t i, double height, double size)
{
    double square = 0.0, along = 0.0;
    for (int k = 0; k < 3; k++) {
        square += (double)b->wave[GK_COL_NX + k][i] * b->wave[GK_COL_NX + k][i];
        along += (double)b->wave[GK_COL_NX + k][i] * b->wave[GK_COL_DX + k][i];
    }
    const double cosine = fabs(along) / sqrt(square);
    return size * (8 * BOUND + 0x1p-24 * (4.0 + 1.0 / height) / cosine);
}

struct slivers {
    unsigned hits, far, outside; // far: by their distance; outside: as points of the triangle
};

// How far a point is outside of a triangle's box.
static double outside_box(const float corner[9], const double p[3])
{
    double outside = 0.0;
    for (int k = 0; k < 3; k++) {
        const double lo = fmin(corner[k], fmin(corner[3 + k], corner[6 + k]));
        const double hi = fmax(corner[k], fmax(corner[3 + k], corner[6 + k]));
        outside = fmax(outside, fmax(lo - p[k], p[k] - hi));
    }
    return outside;
}

static void count_hit(const struct ray_bench *b, uint32_t i, const float corner[9], double height,
                      struct slivers *n)
{
    const double u = b->wave[GK_COL_U][i], v = b->wave[GK_COL_V][i], t = b->wave[GK_COL_T][i];
    double along[3], shaded[3], size = t;
    for (int k = 0; k < 3; k++) {
        along[k] = b->wave[GK_COL_OX + k][i] + t * b->wave[GK_COL_DX + k][i];
        shaded[k] = corner[k] * (1 - u - v) + corner[3 + k] * u + corner[6 + k] * v;
        size += fabs(shaded[k]);
    }
    n->hits++;
    n->far += !(outside_box(corner, along) <= allowed_error(b, i, height, size));
    n->outside += !(outside_box(corner, shaded) <= size * 8 * BOUND);
}

// Rays at a needle of length 1 and the given height, turned at random; many run nearly in its plane.
static struct slivers sliver_hits(double height, bool robust)
{
    static struct ray_bench b;
    static const double axis[3][3] = {{0.36, 0.48, -0.8}, {-0.8, 0.6, 0}, {0.48, 0.64, 0.6}};
    static const uint32_t index[3] = {0, 1, 2};
    double corner[3][3] = {{0, 0, 0}, {1, 0, 0}, {0.4, height, 0}};
    float position[9];
    uint64_t seed = 23;
    struct slivers n = {0};
    for (int v = 0; v < 3; v++) {
        rotate_into_place(corner[v], axis);
        for (int k = 0; k < 3; k++)
            position[3 * v + k] = (float)corner[v][k];
    }
    const struct glint_geometry_mesh mesh = {
        .position = position, .vertices = 3, .index = index, .triangles = 1, .keys = 1};
    bench_open(&b, robust, &mesh);
    for (int wave = 0; wave < 64; wave++) {
        for (uint32_t i = 0; i < LANES; i++) {
            double origin[3], target[3], u = stable_random(&seed),
                                         v = stable_random(&seed) * (1 - u);
            const double steep = pow(10.0, -7.0 * stable_random(&seed));
            for (int k = 0; k < 3; k++) {
                target[k] = position[k] * (1 - u - v) + position[3 + k] * u + position[6 + k] * v;
                origin[k] = 4 * stable_random(&seed) - 2;
            }
            origin[2] *= steep; // in the needle's own space, towards its plane
            rotate_into_place(origin, axis);
            set_ray(&b, i, origin, target);
        }
        trace(&b);
        for (uint32_t i = 0; i < LANES; i++)
            if (hit(&b, i))
                count_hit(&b, i, position, height, &n);
    }
    glint_geometry_destroy(&b.geometry);
    return n;
}

static void slivers_are_hit_in_their_box_at_the_distance_of_their_plane(void **state)
{
    (void)state;
    for (double height = 1.0; height > 1e-7; height *= 0.1)
        for (int robust = 0; robust < 2; robust++) {
            const struct slivers n = sliver_hits(height, robust);
            if (n.far > 0 || n.outside > 0 || n.hits < 1000)
                fail_msg("1:%.0e, %s: of %u hits %u are elsewhere, %u outside of the box",
                         1 / height, robust ? "robust" : "fast", n.hits, n.far, n.outside);
        }
}

static int start(void **state)
{
    (void)state;
    offline_start(&o, 1);
    glint_worker_enter(glint_devices_spare(o.devices)); // its rounding
    return 0;
}

static int finish(void **state)
{
    (void)state;
    offline_finish(&o);
    return 0;
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(rays_at_edges_do_not_leak_in_robust_traversal),
        cmocka_unit_test(rays_at_vertices_do_not_leak_in_watertight_traversal),
        cmocka_unit_test(no_light_slips_by_a_vertex_in_watertight_traversal),
        cmocka_unit_test(slivers_are_hit_in_their_box_at_the_distance_of_their_plane),
    };
    return cmocka_run_group_tests(tests, start, finish);
}
