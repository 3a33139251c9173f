// Placed meshes are where baked ones are, whatever places them and when.
#include "kernels/gk_wave.h"
#include "scene/internal.h"
#include "tests/render/revised.h"
#include "tests/stability/stable.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

// ---- placed and baked

#define RAYS 4096u

struct beam {
    float wave[GK_COLUMNS][RAYS];
};

static void aim(struct beam *b, uint64_t *seed)
{
    memset(b->wave, 0, sizeof b->wave);
    memset(b->wave[GK_COL_MASK], 0xff, sizeof b->wave[GK_COL_MASK]);
    memset(b->wave[GK_COL_GEOMETRY], 0xff, sizeof b->wave[GK_COL_GEOMETRY]);
    memset(b->wave[GK_COL_INSTANCE], 0xff, sizeof b->wave[GK_COL_INSTANCE]);
    for (uint32_t i = 0; i < RAYS; i++) {
        double d[3], square = 0.0;
        for (int k = 0; k < 3; k++) {
            b->wave[GK_COL_OX + k][i] = (float)(6.0 * stable_random(seed) - 3.0);
            d[k] = 4.0 * stable_random(seed) - 2.0 - b->wave[GK_COL_OX + k][i];
            square += d[k] * d[k];
        }
        for (int k = 0; k < 3; k++)
            b->wave[GK_COL_DX + k][i] = (float)(d[k] / sqrt(square));
        b->wave[GK_COL_T][i] = INFINITY;
    }
}

static uint32_t word(const struct beam *b, int column, uint32_t i)
{
    uint32_t w;
    memcpy(&w, &b->wave[column][i], 4);
    return w;
}

static uint32_t row_of(const struct beam *b, uint32_t i)
{
    const uint32_t instance = word(b, GK_COL_INSTANCE, i);
    return instance != GK_NONE ? instance : word(b, GK_COL_GEOMETRY, i);
}

static bool same_hit(const struct beam *a, const struct beam *b, uint32_t i)
{
    return row_of(a, i) == row_of(b, i) &&
           word(a, GK_COL_PRIMITIVE, i) == word(b, GK_COL_PRIMITIVE, i);
}

static void placed_meshes_are_hit_where_baked_ones_are(void **state)
{
    (void)state;
    static struct beam a, b;
    struct glint_error err = {0};
    const struct glint_geometry *flat, *placed;
    uint64_t seed = 5;
    unsigned others = 0, hits = 0;
    double worst = 0.0;
    glint_resident *r = revised_load(revised_text(&revised_base, 0.5f), NULL);
    assert_int_equal(glint_resident_geometry(r, GLINT_GEOMETRY_FLAT, false, &flat, &err), GLINT_OK);
    assert_int_equal(glint_resident_geometry(r, GLINT_GEOMETRY_PLACED, false, &placed, &err),
                     GLINT_OK);
    for (int wave = 0; wave < 25; wave++) {
        aim(&a, &seed);
        b = a;
        glint_geometry_trace_wave(flat, &a.wave[0][0], RAYS, RAYS);
        glint_geometry_trace_wave(placed, &b.wave[0][0], RAYS, RAYS);
        for (uint32_t i = 0; i < RAYS; i++) {
            const double t = a.wave[GK_COL_T][i], u = b.wave[GK_COL_T][i];
            hits += t < INFINITY;
            others += !same_hit(&a, &b, i);
            if (same_hit(&a, &b, i) && t < INFINITY)
                worst = fmax(worst, fabs(t - u));
        }
    }
    print_message("# %u hits of %u rays, %u on another triangle, distances within %.2g\n", hits,
                  25 * RAYS, others, worst);
    assert_true(hits > RAYS);
    assert_true(others <= 25 * RAYS / 10000); // along shared edges either is right
    assert_true(worst < 1e-4);                // 4096 u of the coordinates: grazing ones are worst
    glint_resident_release(&r);
}

static double apart(const struct glint_frame *f, const struct glint_frame *g, const char *channel,
                    double bound)
{
    const float *p = glint_frame_find(f, channel), *q = glint_frame_find(g, channel);
    size_t n = 0;
    for (size_t i = 0; i < stable_pixels(f); i++)
        n += !(fabs((double)p[i] - q[i]) <= bound);
    return (double)n / (double)stable_pixels(f);
}

static void assert_alike(const struct glint_frame *f, const struct glint_frame *g)
{
    static const char *const channel[] = {"R", "G", "B", "Z", "N.X", "N.Y", "N.Z"};
    for (size_t c = 0; c < sizeof channel / sizeof *channel; c++) {
        const double share = apart(f, g, channel[c], 2e-3);
        if (share > 0.01)
            fail_msg("%s differs in %.2f %% of the pixels", channel[c], 100 * share);
    }
}

static void live_jobs_show_what_batch_jobs_show(void **state)
{
    (void)state;
    glint_resident *r = revised_load(revised_text(&revised_base, 0.5f), NULL);
    struct glint_frame *batch = revised_show(r, false), *live = revised_show(r, true);
    assert_alike(batch, live);
    glint_frame_destroy(&batch);
    glint_frame_destroy(&live);
    glint_resident_release(&r);
}

// ---- poses

#define KEYS 3u

// The ball turns and travels, the cube is bent; everything else stands still.
struct moves {
    struct glint_pose pose;
    struct glint_pose_instance instance[4];
    struct glint_pose_placement light[1], camera[1];
    double ball[KEYS][16];
    float *cube; // [KEYS][vertices][3]
};

static uint32_t instance_of(const struct glint_scene *s, const char *id)
{
    uint32_t i = 0;
    while (strcmp(s->instance[i].id, id) != 0)
        i++;
    return i;
}

static void init_moves(struct moves *m, const struct glint_scene *s, uint32_t keys)
{
    const uint32_t ball = instance_of(s, "ball"), cube = instance_of(s, "cube");
    const struct glint_mesh *mesh = &s->mesh[s->instance[cube].mesh];
    memset(m, 0, sizeof *m);
    atomic_init(&m->pose.references, 8); // never freed by those who let go
    m->pose.request = glint_pose_rest();
    m->pose.keys = keys;
    m->pose.instances = s->instances;
    m->pose.instance = m->instance;
    m->pose.light = m->light;
    m->pose.camera = m->camera;
    m->cube = calloc((size_t)KEYS * mesh->vertices, 12);
    assert_true(s->instances == 4 && m->cube);
    for (uint32_t k = 0; k < KEYS; k++) {
        glint_pose_instance_at(NULL, s, ball, 0, m->ball[k]);
        const double c = cos(0.2 * k), w = sin(0.2 * k);
        const double turn[12] = {1.5 * c, w, 0, 0, -w, c, 0, 0, 0, 0, 1, 0};
        memcpy(m->ball[k], turn, sizeof turn);
        m->ball[k][12] += 0.3 * k;
        for (uint32_t v = 0; v < mesh->vertices; v++)
            for (int i = 0; i < 3; i++) {
                const float *p = mesh->position + 3 * (size_t)v;
                m->cube[3 * ((size_t)k * mesh->vertices + v) + i] =
                    p[i] + (i == 0 ? 0.4f * (float)(k * k) * p[1] : 0.0f);
            }
    }
    m->instance[ball] =
        (struct glint_pose_instance){.moves = keys > 1, .transform = &m->ball[0][0]};
    m->instance[cube] = (struct glint_pose_instance){
        .deforms = true, .bends = keys > 1, .position = m->cube, .normal = (float *)mesh->normal};
}

// What is at time t becomes the first key.
static void stop_at(struct moves *m, const struct glint_scene *s, double t)
{
    const struct glint_mesh *mesh = &s->mesh[s->instance[instance_of(s, "cube")].mesh];
    const uint32_t k = t < 0.5 ? 0 : 1;
    const double along = 2.0 * t - k;
    const size_t n = 3 * (size_t)mesh->vertices;
    for (int i = 0; i < 16; i++)
        m->ball[0][i] = m->ball[k][i] * (1 - along) + m->ball[k + 1][i] * along;
    for (size_t i = 0; i < n; i++)
        m->cube[i] = (float)(m->cube[k * n + i] * (1 - along) + m->cube[(k + 1) * n + i] * along);
}

static glint_resident *posed(const struct moves *m, const glint_resident *rest)
{
    struct glint_error err = {0};
    glint_resident *r = NULL;
    struct glint_scene *scene = (struct glint_scene *)glint_resident_scene(rest);
    if (glint_resident_create(
            &r, offline_crew.devices,
            &(struct glint_resident_order){.scene = scene, .pose = &m->pose, .from = rest}, &err))
        offline_die("pose", &err);
    return r;
}

// Rays that meet something else, or elsewhere.
static unsigned compare_at(const glint_resident *moving, const glint_resident *still,
                           enum glint_geometry_kind kind, double time)
{
    static struct beam a, b;
    struct glint_error err = {0};
    const struct glint_geometry *g, *h;
    uint64_t seed = 11;
    unsigned others = 0;
    assert_int_equal(glint_resident_geometry((glint_resident *)moving, kind, false, &g, &err),
                     GLINT_OK);
    assert_int_equal(
        glint_resident_geometry((glint_resident *)still, GLINT_GEOMETRY_FLAT, false, &h, &err),
        GLINT_OK);
    for (int wave = 0; wave < 5; wave++) {
        aim(&a, &seed);
        for (uint32_t i = 0; i < RAYS; i++)
            a.wave[GK_COL_TIME][i] = (float)time;
        b = a;
        glint_geometry_trace_wave(g, &a.wave[0][0], RAYS, RAYS);
        glint_geometry_trace_wave(h, &b.wave[0][0], RAYS, RAYS);
        for (uint32_t i = 0; i < RAYS; i++)
            others +=
                !same_hit(&a, &b, i) || (a.wave[GK_COL_T][i] < INFINITY &&
                                         fabsf(a.wave[GK_COL_T][i] - b.wave[GK_COL_T][i]) > 1e-4f);
    }
    return others;
}

static void what_moves_is_hit_where_it_is_at_the_ray_s_time(void **state)
{
    (void)state;
    static const double time[] = {0.0, 0.2, 0.5, 0.85, 1.0};
    struct moves moving, stopped;
    glint_resident *rest = revised_load(revised_text(&revised_base, 0.5f), NULL);
    const struct glint_scene *s = glint_resident_scene(rest);
    init_moves(&moving, s, KEYS);
    glint_resident *r = posed(&moving, rest);
    assert_int_equal(glint_resident_segments(r), KEYS - 1);
    assert_true(glint_resident_facts(r)->motion);
    for (size_t i = 0; i < sizeof time / sizeof *time; i++) {
        init_moves(&stopped, s, 1);
        stop_at(&stopped, s, time[i]);
        glint_resident *still = posed(&stopped, rest);
        const unsigned flat = compare_at(r, still, GLINT_GEOMETRY_FLAT, time[i]);
        const unsigned placed = compare_at(r, still, GLINT_GEOMETRY_PLACED, time[i]);
        print_message("# at %.2f: %u and %u of %u rays differ\n", time[i], flat, placed, 5 * RAYS);
        assert_true(flat <= 5 * RAYS / 2000 && placed <= 5 * RAYS / 2000);
        glint_resident_release(&still);
        free(stopped.cube);
    }
    glint_resident_release(&r);
    glint_resident_release(&rest);
    free(moving.cube);
}

static void a_rigid_pose_shares_all_records_of_triangles(void **state)
{
    (void)state;
    struct moves m;
    glint_resident *rest = revised_load(revised_text(&revised_base, 0.5f), NULL);
    const struct glint_scene *s = glint_resident_scene(rest);
    init_moves(&m, s, KEYS);
    m.instance[instance_of(s, "cube")] = (struct glint_pose_instance){0};
    glint_resident *r = posed(&m, rest);
    assert_int_equal(revised_made(r), REVISED_PART(INSTANCES));
    for (int t = 0; t < GLINT_TABLES; t++)
        if (t < GLINT_TABLE_INSTANCES || t > GLINT_TABLE_FLOWS)
            assert_ptr_equal(glint_resident_table(r, t), glint_resident_table(rest, t));
    const uint32_t ball = instance_of(s, "ball");
    const struct gk_instance *row =
        glint_buffer_host(glint_resident_table(r, GLINT_TABLE_INSTANCES));
    const struct gk_mover *mover = glint_buffer_host(glint_resident_table(r, GLINT_TABLE_MOVERS));
    for (uint32_t i = 0; i < s->instances; i++)
        assert_int_equal(row[i].mover, i == ball ? 0 : GK_NONE);
    assert_int_equal(mover[0].turn, 0);
    assert_int_equal(mover[0].stride, 0);
    glint_resident_release(&rest);
    glint_resident_release(&r);
    free(m.cube);
}

// ---- transforms that are no rotations

// A leaf, as it is or as another would be under m (row-major 3x3), with the inverse transpose of m
// for its normals. Flat, with one normal and one direction of the texture: what is interpolated
// does not depend on whether it is transformed before or after.
static char *leaf(const double m[9], const char *transform)
{
    static const double corner[4][3] = {
        {-1, -1, -0.15}, {1, -0.8, 0.06}, {0.9, 1, 0.14}, {-1, 0.7, -0.065}};
    static const double normal[3] = {-0.3, -0.2, 0.9};
    char *position = NULL, *normals = NULL;
    size_t length;
    FILE *p = open_memstream(&position, &length), *n = open_memstream(&normals, &length);
    for (int v = 0; v < 4; v++) {
        double q[3], w[3], square = 0.0;
        for (int i = 0; i < 3; i++) {
            q[i] = w[i] = 0.0;
            for (int j = 0; j < 3; j++) {
                const int a = (i + 1) % 3, b = (i + 2) % 3, c = (j + 1) % 3, d = (j + 2) % 3;
                q[i] += m[3 * i + j] * corner[v][j];
                w[i] += (m[3 * a + c] * m[3 * b + d] - m[3 * a + d] * m[3 * b + c]) * normal[j];
            }
            square += w[i] * w[i];
        }
        double determinant = 0.0;
        for (int j = 0; j < 3; j++)
            determinant += m[j] * (m[3 + (j + 1) % 3] * m[6 + (j + 2) % 3] -
                                   m[3 + (j + 2) % 3] * m[6 + (j + 1) % 3]);
        const double unit = (determinant < 0.0 ? -1.0 : 1.0) / sqrt(square);
        for (int i = 0; i < 3; i++) {
            fprintf(p, "%s%.9g", v + i ? "," : "", q[i]);
            fprintf(n, "%s%.9g", v + i ? "," : "", w[i] * unit);
        }
    }
    fclose(p);
    fclose(n);
    const bool mirrored = m[0] * (m[4] * m[8] - m[5] * m[7]) - m[1] * (m[3] * m[8] - m[5] * m[6]) +
                              m[2] * (m[3] * m[7] - m[4] * m[6]) <
                          0.0;
    const float bump[12] = {0.9f, 0.6f, 0.9f, 0.2f, 0.7f, 0.9f, 0.5f, 0.2f, 0.9f, 0.7f, 0.7f, 0.9f};
    char *png = stable_png(2, 2, bump);
    char *text = stable_text(
        "{'environment':{'radiance':[0.2,0.3,0.4]},'images':{'p':{'data':'%s'}},"
        "'materials':{'m':{'base_color':[0.6,0.5,0.4],'roughness':0.4,'double_sided':false,"
        "'normal_map':{'image':'p'},'emission':[0.1,0,0]}},"
        "'meshes':{'l':{'positions':[%s],'normals':[%s],'uvs':[0.05,0.05,0.86,0.23,0.91,0.945,0."
        "135,0.73],"
        "'indices':[%s]}},"
        "'instances':{'l':{'mesh':'l','material':'m'%s}},"
        "'lights':{'lamp':{'type':'point','intensity':30,'transform':{'translation':[2,3,4]}}},"
        "'cameras':{'eye':{'yfov':0.8,'transform':{'translation':[0,0,5]}}}}",
        png, position, normals, mirrored ? "0,2,1,0,3,2" : "0,1,2,0,2,3", transform);
    free(png);
    free(position);
    free(normals);
    return text;
}

static void transforms_do_what_transformed_meshes_do(void **state)
{
    (void)state;
    static const double identity[9] = {1, 0, 0, 0, 1, 0, 0, 0, 1};
    static const double cases[][9] = {
        {0.6, -0.8, 0, 0.8, 0.6, 0, 0, 0, 1},     // turned
        {1.5, 0, 0, 0, 0.4, 0, 0, 0, 2},          // scaled
        {1, 0.7, 0, 0, 1, 0, 0.3, 0, 1},          // sheared
        {-1, 0, 0, 0, 1, 0, 0, 0, 1},             // mirrored
        {-0.9, 0.3, 0.1, 0.4, 1.2, 0, 0.2, 0, 1}, // sheared and mirrored
        {1, 0, 0, 0, 1, 0, 0, 0, -1},             // mirrored away: its back is seen
    };
    for (size_t c = 0; c < sizeof cases / sizeof *cases; c++) {
        const double *m = cases[c];
        char *transform =
            stable_text(",'transform':[%.9g,%.9g,%.9g,0,%.9g,%.9g,%.9g,0,%.9g,%.9g,%.9g,0,0,0,0,1]",
                        m[0], m[3], m[6], m[1], m[4], m[7], m[2], m[5], m[8]);
        glint_resident *given = revised_load(leaf(m, ""), NULL);
        glint_resident *turned = revised_load(leaf(identity, transform), NULL);
        struct glint_frame *want = revised_show(given, false), *baked = revised_show(turned, false),
                           *placed = revised_show(turned, true);
        print_message("# case %zu: N.X differs in %.2f %% and %.2f %% of the pixels\n", c,
                      100 * apart(want, baked, "N.X", 2e-3),
                      100 * apart(want, placed, "N.X", 2e-3));
        assert_alike(want, baked);
        assert_alike(want, placed);
        glint_frame_destroy(&want);
        glint_frame_destroy(&baked);
        glint_frame_destroy(&placed);
        glint_resident_release(&given);
        glint_resident_release(&turned);
        free(transform);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(placed_meshes_are_hit_where_baked_ones_are),
        cmocka_unit_test(live_jobs_show_what_batch_jobs_show),
        cmocka_unit_test(what_moves_is_hit_where_it_is_at_the_ray_s_time),
        cmocka_unit_test(a_rigid_pose_shares_all_records_of_triangles),
        cmocka_unit_test(transforms_do_what_transformed_meshes_do),
    };
    return cmocka_run_group_tests(tests, offline_crew_start, offline_crew_finish);
}
