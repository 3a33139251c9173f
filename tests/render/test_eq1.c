// Mattes through bounces against Eq. 1 worked out by brute force, with code of its own: glass and a
// diffuse wall as the whole tree of their paths, rough metal behind a pane by quadrature.
//
// Every claim is about the frame and about each pixel: |z| < 4.892 of n samples whose deviation is s
// = sqrt(c (1 - c)) at most, so that a matte that is d off is missed once in a thousand at
// n = ((4.892 + 3.09) s / d)^2: of a pixel 0.125 at n = 1024, of the frame 0.0064.
#include "kernels/gk_matte.h"
#include "tests/render/bounced.h"
#include "tests/stability/stable.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define SAMPLES 1024
#define YFOV 0.9

static void take(struct shot *s, const char *scene, const char *mattes)
{
    char *scene_text = stable_text("%s", scene);
    char *job_text = stable_text(
        "{'scene':'s','resolution':[24,16],'outputs':['beauty','crypto_object'],'stop':{"
        "'samples':%d},'filter':{'kind':'box'},'accuracy':{'microfacet':'single'},"
        "'mattes':{%s}}",
        SAMPLES, mattes);
    glint_resident *resident = offline_load_text(&things_crew, scene_text);
    shoot(s, resident, job_text);
    glint_resident_release(&resident);
    free(scene_text);
    free(job_text);
}

// The matte of a name against what Eq. 1 gives each pixel.
static void assert_matte(const char *test, const struct shot *s, const char *name,
                         const double *want)
{
    double sum = 0.0, wanted = 0.0;
    const double n = (double)pixels(s->frame);
    for (size_t p = 0; p < pixels(s->frame); p++) {
        const double got = coverage_of(s->frame, "CryptoGlossObject", name, p);
        const double deviation = sqrt(fmax(want[p] * (1.0 - want[p]), 1e-9) / SAMPLES);
        if (fabs(got - want[p]) > CHECK_Z * deviation + 1e-4)
            fail_msg("%s at pixel %zu: %.5f, by brute force %.5f", name, p, got, want[p]);
        sum += got / n;
        wanted += want[p] / n;
    }
    print_message("# %s: %.5f, by brute force %.5f\n", name, sum, wanted);
    const double deviation = sqrt(fmax(wanted * (1.0 - wanted), 1e-9) / (n * SAMPLES));
    odds_note(__FILE__, test, "bound", sum - wanted, deviation);
    assert_within(sum - wanted, CHECK_Z * deviation + 1e-4);
}

// ---- a slab of tinted glass between a wall of two objects and what is behind the camera

#define TINT 0.8
#define INDEX 1.5
#define NEAR_FACE (-1.0)
#define FAR_FACE (-1.5)
#define WALL (-3.0)

static const char slab[] =
    "{'cameras':{'c':{'yfov':0.9}},'environment':{'radiance':[1,1,1]},"
    "'meshes':{'quad':{'primitive':'quad'},'box':{'primitive':'box'}},"
    "'materials':{'glass':{'transmission':1,'roughness':0,'ior':1.5,'base_color':[0.8,0.8,0.8]},"
    "'paint':{'ior':1,'base_color':[0.8,0.8,0.8]}},"
    "'objects':{'slab':{},'left':{},'right':{},'behind':{}},'instances':{"
    "'slab':{'object':'slab','mesh':'box','material':'glass','transform':{'translation':"
    "[0,0,-1.25],'scale':[200,200,0.5]}},"
    "'left':{'object':'left','mesh':'quad','material':'paint','transform':{'translation':"
    "[-50,0,-3],'scale':[100,100,1]}},"
    "'right':{'object':'right','mesh':'quad','material':'paint','transform':{'translation':"
    "[50,0,-3],'scale':[100,100,1]}},"
    "'behind':{'object':'behind','mesh':'quad','material':'paint','transform':{'rotation':[0,1,0,0]"
    ","
    "'translation':[0,0,2],'scale':[200,200,1]}}}}";

enum { SLAB, LEFT, RIGHT, BEHIND, OBJECTS };
static const char *const slab_name[OBJECTS] = {"slab", "left", "right", "behind"};

// A ray in the plane of its incidence: x is all that tells left from right.
struct ray {
    double x, z;    // where it is
    double dx;      // sideways, of a unit direction; dy is as it was for good
    double dy;      //
    int up, inside; // towards the camera; in the glass
    int bounces;
};

// Eq. 1: what the vertex that the ray comes to keeps, and what it hands on, times `share`.
static void follow(struct ray r, double share, double out[OBJECTS])
{
    const double to = r.inside ? (r.up ? NEAR_FACE : FAR_FACE)
                      : r.up   ? (r.z < FAR_FACE ? FAR_FACE : 2.0)
                               : (r.z > NEAR_FACE ? NEAR_FACE : WALL);
    const double cosine = sqrt(1.0 - r.dx * r.dx - r.dy * r.dy);
    r.x += r.dx / cosine * fabs(to - r.z);
    r.z = to;
    if (to == 2.0 || to == WALL) {
        out[to == 2.0 ? BEHIND : r.x < 0.0 ? LEFT : RIGHT] += share;
        return;
    }
    if (r.bounces == 8) {
        out[SLAB] += share;
        return;
    }
    const double eta = r.inside ? 1.0 / INDEX : INDEX, f = exact_fresnel(cosine, eta);
    struct ray mirrored = r, bent = r;
    mirrored.up = !r.up;
    bent.inside = !r.inside;
    bent.dx /= eta;
    bent.dy /= eta;
    bent.bounces = mirrored.bounces = r.bounces + 1;
    out[SLAB] += share * (1.0 - f - TINT * (1.0 - f));
    follow(mirrored, share * f, out);
    if (f < 1.0)
        follow(bent, share * TINT * (1.0 - f), out);
}

// The mean over a pixel.
static void slab_pixel(size_t pixel, double out[OBJECTS])
{
    enum { SIDE = 16 };
    const double half = tan(0.5 * YFOV), scale = 2.0 * half / HEIGHT;
    memset(out, 0, OBJECTS * sizeof *out);
    for (int i = 0; i < SIDE * SIDE; i++) {
        const double u = (double)(pixel % WIDTH) + (i % SIDE + 0.5) / SIDE;
        const double v = (double)(pixel / WIDTH) + (double)(i / SIDE) / SIDE + 0.5 / SIDE;
        const double x = (u - 0.5 * WIDTH) * scale, y = half - v * scale;
        const double length = sqrt(x * x + y * y + 1.0);
        const struct ray r = {.dx = x / length, .dy = y / length};
        follow(r, 1.0 / (SIDE * SIDE), out);
    }
}

static void assert_slab(const char *mattes)
{
    static double want[OBJECTS][WIDTH * HEIGHT];
    struct shot s;
    take(&s, slab, mattes);
    for (size_t p = 0; p < WIDTH * HEIGHT; p++) {
        double of[OBJECTS];
        slab_pixel(p, of);
        for (int k = 0; k < OBJECTS; k++)
            want[k][p] = of[k];
    }
    for (int k = 0; k < OBJECTS; k++)
        assert_matte("solid_glass_hands_on_what_it_lets_through", &s, slab_name[k], want[k]);
    assert_int_equal(s.render->stats.count[GLINT_COUNT_CLAMPED], 0);
    finish_shot(&s);
}

static void solid_glass_hands_on_what_it_lets_through(void **state)
{
    (void)state;
    assert_slab("'through':'delta'");
    assert_slab("'through':'glossy'");
    assert_slab("'through':'glossy','alpha':1,'clamp':false,'variance':'eq3'");
}

// ---- a pane before rough metal below stripes and the sky

#define CEILING 30.0
#define TO_FLOOR 5.0 // metres from the camera, whose view meets the floor at a cosine of 0.6
#define HALF_PIXEL (0.0005 / 16)
#define THROUGH_PANE 0.96

static const char striped[] =
    "{'cameras':{'c':{'yfov':0.001,'transform':{'translation':[0,3,4],'rotation':"
    "[-0.316227766,0,0,0.948683298]}}},'environment':{'radiance':[1,1,1]},"
    "'meshes':{'quad':{'primitive':'quad'}},"
    "'materials':{'floor':{'metallic':1,'roughness':0.4,'base_color':[0.7,0.7,0.7]},"
    "'glass':{'transmission':1,'roughness':0,'thin':true},'paint':{'ior':1,'base_color':[0,0,0]}},"
    "'objects':{'floor':{},'pane':{},'far':{},'middle':{},'near':{}},'instances':{"
    "'floor':{'object':'floor','mesh':'quad','material':'floor','transform':{"
    "'rotation':[-0.707106781,0,0,0.707106781],'scale':[2,2,1]}},"
    "'pane':{'object':'pane','mesh':'quad','material':'glass','transform':{'translation':"
    "[0,2.7,3.6],'rotation':[-0.316227766,0,0,0.948683298],'scale':[0.002,0.002,1]}},"
    "'far':{'object':'far','mesh':'quad','material':'paint','transform':{'translation':"
    "[0,30,-5050],'rotation':[0.707106781,0,0,0.707106781],'scale':[1e5,1e4,1]}},"
    "'middle':{'object':'middle','mesh':'quad','material':'paint','transform':{'translation':"
    "[0,30,-40],'rotation':[0.707106781,0,0,0.707106781],'scale':[1e5,20,1]}},"
    "'near':{'object':'near','mesh':'quad','material':'paint','transform':{'translation':"
    "[0,30,-20],'rotation':[0.707106781,0,0,0.707106781],'scale':[1e5,20,1]}}}}";

// Of the quads above, along z; between and beyond them is the sky.
static const struct {
    const char *name;
    double from, to;
} stripe[] = {{"far", -10050, -50}, {"middle", -50, -30}, {"near", -30, -10}};
#define STRIPES COUNT(stripe)

// Eq. 4 to 7 with diffuse_cut, of the metal's lobe alone: the pane before it adds no variance.
static double weight_of(double pdf, double way, double alpha)
{
    const double r = HALF_PIXEL * (TO_FLOOR + way);
    const double spread = isinf(way) ? 1.0 / HALF_PIXEL : way / r;
    return plain_weight(plain_variance(pdf), spread, alpha, true);
}

// The integral of W f cos over the directions that see each stripe, and the sky last.
static void by_quadrature(float roughness, double alpha, double out[STRIPES + 1])
{
    enum { RINGS = 2000, TURNS = 720 };
    const struct material metal = {
        .name = "", .base = 0.7f, .metallic = 1, .roughness = roughness, .ior = 1.5f};
    const struct gk_vec wo = gk_vec(0.8f, 0.0f, 0.6f); // x along the world's z
    const struct gk_surface surface = make_surface_at(&metal, wo);
    memset(out, 0, (STRIPES + 1) * sizeof *out);
    for (int i = 0; i < RINGS; i++)
        for (int j = 0; j < TURNS; j++) {
            const double z = (i + 0.5) / RINGS;
            const struct gk_vec wi = direction(z, (j + 0.5) / TURNS);
            const struct gk_bsdf_value f = gk_bsdf_eval(&surface, wo, wi);
            const double at = wi.x * CEILING / z;
            size_t k = 0;
            while (k < STRIPES && !(at >= stripe[k].from && at < stripe[k].to))
                k++;
            const double way = k < STRIPES ? CEILING / z : INFINITY;
            if (f.pdf > 0.0f)
                out[k] += gk_mean3(f.f) * weight_of(f.pdf, way, alpha) * 2.0 * M_PI /
                          ((double)RINGS * TURNS);
        }
}

#define RUNS "rough_metal_behind_a_pane_is_shared_by_all_that_it_shows"

static void assert_stripes(double alpha)
{
    static double want[WIDTH * HEIGHT];
    double share[STRIPES + 1], left = 1.0;
    char mattes[64];
    struct shot s;
    snprintf(mattes, sizeof mattes, "'through':'glossy','alpha':%g", alpha);
    take(&s, striped, mattes);
    by_quadrature(0.4f, alpha, share);
    for (size_t k = 0; k <= STRIPES; k++)
        left -= share[k];
    for (size_t k = 0; k < STRIPES; k++) {
        for (size_t p = 0; p < WIDTH * HEIGHT; p++)
            want[p] = THROUGH_PANE * share[k];
        assert_matte(RUNS, &s, stripe[k].name, want);
    }
    for (size_t p = 0; p < WIDTH * HEIGHT; p++)
        want[p] = THROUGH_PANE * left;
    assert_matte(RUNS, &s, "floor", want);
    finish_shot(&s);
}

static void rough_metal_behind_a_pane_is_shared_by_all_that_it_shows(void **state)
{
    (void)state;
    assert_stripes(0.1);
    assert_stripes(0.5);
}

// ---- a rough pane before a wall: the lobe that is left by is that of one side

#define TO_PANE 1.0
#define TO_WALL 2.0

static const char frosted[] =
    "{'cameras':{'c':{'yfov':0.001}},'environment':{'radiance':[1,1,1]},"
    "'meshes':{'quad':{'primitive':'quad'}},"
    "'materials':{'pane':{'transmission':1,'roughness':0.4,'thin':true,'base_color':[0.8,0.8,0.8]},"
    "'paint':{'ior':1,'base_color':[0,0,0]}},'objects':{'pane':{},'wall':{}},'instances':{"
    "'pane':{'object':'pane','mesh':'quad','material':'pane','transform':{'translation':[0,0,-1]}},"
    "'wall':{'object':'wall','mesh':'quad','material':'paint','transform':{'translation':[0,0,-3],"
    "'scale':[1e5,1e5,1]}}}}";

// The integral of W f cos over the directions behind the pane. The probability of that side is the
// integral of the density over it.
static double through_frosted(double alpha)
{
    enum { RINGS = 2000 }; // what is seen straight on is the same all around
    const struct material glass = {
        .name = "", .base = 0.8f, .transmission = 1, .roughness = 0.4f, .ior = 1.5f, .thin = 1};
    const struct gk_vec wo = gk_vec(0.0f, 0.0f, 1.0f);
    const struct gk_surface surface = make_surface_at(&glass, wo);
    double side = 0.0, sum = 0.0;
    for (int i = 0; i < RINGS; i++)
        side += gk_bsdf_eval(&surface, wo, direction(-(i + 0.5) / RINGS, 0.25)).pdf * 2.0 * M_PI /
                RINGS;
    for (int i = 0; i < RINGS; i++) {
        const double z = (i + 0.5) / RINGS, way = TO_WALL / z;
        const struct gk_bsdf_value f = gk_bsdf_eval(&surface, wo, direction(-z, 0.25));
        const double spread = way / (HALF_PIXEL * (TO_PANE + way));
        if (f.pdf > 0.0f)
            sum += gk_mean3(f.f) * plain_weight(plain_variance(f.pdf / side), spread, alpha, true) *
                   2.0 * M_PI / RINGS;
    }
    return sum;
}

static void a_rough_pane_hands_on_by_the_lobe_of_the_side_it_is_left_by(void **state)
{
    (void)state;
    static double want[WIDTH * HEIGHT];
    struct shot s;
    take(&s, frosted, "'through':'glossy','alpha':0.1");
    const double share = through_frosted(0.1);
    for (size_t p = 0; p < WIDTH * HEIGHT; p++)
        want[p] = share;
    assert_matte(__func__, &s, "wall", want);
    finish_shot(&s);
}

// ---- nothing is clamped

static glint_resident *demo_scene(const char *name)
{
    char command[4096];
    const char *build = getenv("GLINT_BUILD");
    snprintf(command, sizeof command, "'%s/glint-demo-scene' %s", build ? build : ".", name);
    FILE *pipe = popen(command, "r");
    size_t capacity = (size_t)1 << 24, size = 0, n;
    char *text = malloc(capacity + 1);
    assert_true(pipe && text);
    while ((n = fread(text + size, 1, capacity - size, pipe)) > 0)
        size += n;
    text[size] = 0;
    assert_int_equal(pclose(pipe), 0);
    glint_resident *scene = offline_load_text(&things_crew, text);
    free(text);
    return scene;
}

static void weights_above_one_cut_a_ten_thousandth_at_most(void **state)
{
    (void)state;
    static const char *const scenes[] = {"shelves", "strips", "plant", "water", "forty", "cluster"};
    for (size_t i = 0; i < COUNT(scenes); i++) {
        struct shot s;
        glint_resident *scene = demo_scene(scenes[i]);
        char *job =
            stable_text("{'scene':'s','resolution':[64,36],'stop':{'samples':32},'outputs':["
                        "'beauty','crypto_object'],'mattes':{'through':'glossy'}}");
        shoot(&s, scene, job);
        const double samples = 32.0 * (double)pixels(s.frame);
        const double share =
            (double)s.render->stats.count[GLINT_COUNT_CLAMPED] / (samples * GK_MATTE_ONE);
        print_message("# %s: %.2e of the coverage cut\n", scenes[i], share);
        assert_true(share < 1e-4);
        finish_shot(&s);
        glint_resident_release(&scene);
        free(job);
    }
}

// mattes: a member of the job's.
static void shoot_part(struct shot *s, glint_resident *scene, const char *mattes)
{
    char *job = stable_text("{'scene':'s','resolution':[160,90],'region':[56,28,48,32],'stop':{"
                            "'samples':32},'outputs':['beauty','crypto_object'],'mattes':{"
                            "'through':'glossy',%s}}",
                            mattes);
    shoot(s, scene, job);
    free(job);
}

// Share of the pixels of a part of a demo scene, 160 x 90 as a whole, with coverages that are not those
// of exact eviction to 1/255.
static double inexact(glint_resident *scene, const struct shot *exact, const char *mattes)
{
    struct shot s;
    size_t off = 0;
    shoot_part(&s, scene, mattes);
    for (size_t i = 0; i < pixels(s.frame); i++) {
        bool same = true;
        for (uint32_t k = 0; k < 6; k++) {
            const uint32_t id = rank_id(exact->frame, "CryptoGlossObject", k, i);
            const double truth = coverage_of_id(exact->frame, "CryptoGlossObject", id, i);
            const double ours = coverage_of_id(s.frame, "CryptoGlossObject", id, i);
            same &= fabs(truth - ours) <= 1.0 / 255;
        }
        off += !same;
    }
    const double share = (double)off / (double)pixels(s.frame);
    finish_shot(&s);
    return share;
}

static void twelve_slots_and_places_give_the_mattes_of_exact_eviction(void **state)
{
    (void)state;
    static const char *const scenes[] = {"shelves", "plant", "cluster"};
    for (size_t i = 0; i < COUNT(scenes); i++) {
        struct shot exact;
        glint_resident *scene = demo_scene(scenes[i]);
        shoot_part(&exact, scene, "'eviction':'exact'");
        const double off = inexact(scene, &exact, "'eviction':'spill'");
        const double before = inexact(scene, &exact, "'eviction':'uss_direct_first'");
        print_message("# %s: %.5f of the pixels are off, %.5f with slots alone\n", scenes[i], off,
                      before);
        assert_true(off <= 0.001 && before > 0.001);
        finish_shot(&exact);
        glint_resident_release(&scene);
    }
}

// The least that a pixel's ranks of a type have together.
static double least_sum(const struct glint_frame *f, const char *type)
{
    double least = 1.0;
    for (size_t i = 0; i < pixels(f); i++) {
        double sum = 0.0;
        for (uint32_t k = 0; layer_plane(f, type, k, true); k++)
            sum += rank_coverage(f, type, k, i);
        least = fmin(least, sum);
    }
    return least;
}

static double left_out(const struct glint_frame *f)
{
    return 1.0 - fmin(least_sum(f, "CryptoObject"), least_sum(f, "CryptoGlossObject"));
}

static struct glint_matte_excess excess_of(const struct shot *s)
{
    struct glint_render_state state;
    glint_render_state(s->render, &state);
    return state.excess;
}

static uint32_t levels_in(const struct glint_frame *f, const char *type)
{
    uint32_t k = 0;
    while (layer_plane(f, type, k, true))
        k++;
    return k;
}

// Samples give their coverage away whole: what a file's ranks have less than 1 is what it leaves out.
static void files_with_as_many_levels_as_it_takes_leave_out_two_hundredths_at_most(void **state)
{
    (void)state;
    struct shot six, whole, all;
    glint_resident *scene = demo_scene("cluster");
    shoot_part(&six, scene, "'levels':6");
    shoot_part(&whole, scene, "'levels':'auto'");
    shoot_part(&all, scene, "'levels':16");
    const struct glint_matte_excess said = excess_of(&six);
    const uint32_t levels = levels_in(whole.frame, "CryptoObject");
    print_message("# 6 levels leave out %.4f, %u leave out %.4f; %.0f pixels have more than 6\n",
                  left_out(six.frame), levels, left_out(whole.frame), (double)said.pixels);
    assert_true(left_out(six.frame) > 0.1 && left_out(whole.frame) <= 0.02 + 1e-6);
    assert_true(fabs(said.left_out - left_out(six.frame)) < 1e-5 && said.pixels > 0);
    assert_true(levels == said.needed && levels == levels_in(whole.frame, "CryptoGlossObject"));
    assert_true(excess_of(&whole).left_out == 0.0 && excess_of(&whole).needed == levels);
    for (uint32_t k = 0; k < levels; k++)
        for (size_t i = 0; i < pixels(all.frame); i++)
            assert_true(rank_coverage(whole.frame, "CryptoGlossObject", k, i) ==
                            rank_coverage(all.frame, "CryptoGlossObject", k, i) &&
                        rank_id(whole.frame, "CryptoGlossObject", k, i) ==
                            rank_id(all.frame, "CryptoGlossObject", k, i));
    finish_shot(&six);
    finish_shot(&whole);
    finish_shot(&all);
    glint_resident_release(&scene);
}

static void shoot_classes(struct shot *s, glint_resident *scene, const char *classes)
{
    char *job = stable_text("{'scene':'s','resolution':[160,90],'region':[56,28,48,32],'stop':{"
                            "'samples':16},'outputs':['beauty','crypto_object'],'mattes':{"
                            "'through':'glossy','levels':'auto','slots':12,'classes':%s}}",
                            classes);
    shoot(s, scene, job);
    free(job);
}

// Whether a pixel may have names that have no rank.
static bool is_full(const struct shot *s, const char *type, size_t pixel)
{
    return rank_coverage(s->frame, type, levels_in(s->frame, type) - 1, pixel) > 0.0f;
}

// What the classes have less of a name that is not seen directly, whose share x_1 keeps none of.
static double missing(const struct shot *one, const struct shot *both, uint32_t rank, size_t pixel)
{
    const uint32_t id = rank_id(one->frame, "CryptoGlossObject", rank, pixel);
    const double all = rank_coverage(one->frame, "CryptoGlossObject", rank, pixel);
    if (all == 0.0 || coverage_of_id(one->frame, "CryptoObject", id, pixel) > 0.0)
        return 0.0; // no rank has the ID of the background
    return all - coverage_of_id(both->frame, "CryptoReflObject", id, pixel) -
           coverage_of_id(both->frame, "CryptoRefrObject", id, pixel);
}

static double most_missing(const struct shot *one, const struct shot *both)
{
    double worst = 0.0;
    for (size_t i = 0; i < pixels(one->frame); i++) {
        if (is_full(both, "CryptoReflObject", i) || is_full(both, "CryptoRefrObject", i))
            continue;
        for (uint32_t k = 0; k < levels_in(one->frame, "CryptoGlossObject"); k++)
            worst = fmax(worst, fabs(missing(one, both, k, i)));
    }
    return worst;
}

// A name that is both reflected and refracted takes two slots of the same table.
static void classes_lose_no_more_than_a_single_type(void **state)
{
    (void)state;
    static const char *const scenes[] = {"shelves", "plant"};
    for (size_t n = 0; n < COUNT(scenes); n++) {
        struct shot one, both;
        glint_resident *scene = demo_scene(scenes[n]);
        shoot_classes(&one, scene, "false");
        shoot_classes(&both, scene, "true");
        assert_true(both.render->stats.count[GLINT_COUNT_LOST] <=
                    one.render->stats.count[GLINT_COUNT_LOST]);
        const double worst = most_missing(&one, &both);
        print_message("# %s: mattes of the classes are off by %.2e at worst\n", scenes[n], worst);
        assert_true(worst < 1e-6);
        finish_shot(&one);
        finish_shot(&both);
        glint_resident_release(&scene);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(solid_glass_hands_on_what_it_lets_through),
        cmocka_unit_test(rough_metal_behind_a_pane_is_shared_by_all_that_it_shows),
        cmocka_unit_test(a_rough_pane_hands_on_by_the_lobe_of_the_side_it_is_left_by),
        cmocka_unit_test(weights_above_one_cut_a_ten_thousandth_at_most),
        cmocka_unit_test(twelve_slots_and_places_give_the_mattes_of_exact_eviction),
        cmocka_unit_test(files_with_as_many_levels_as_it_takes_leave_out_two_hundredths_at_most),
        cmocka_unit_test(classes_lose_no_more_than_a_single_type),
    };
    return cmocka_run_group_tests(tests, things_start, things_finish);
}
