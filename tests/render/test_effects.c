// The rules of the effects table, for every row: forcing a row that nothing calls for changes no bit
// of the image; the automatic plan is the smallest that a hand could make.
#include "device/program.h"
#include "tests/stability/stable.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static struct offline o;

#define COUNT(a) (sizeof(a) / sizeof *(a))

// ---- scenes: a ball before a wall

struct world {
    const char *light;  // top-level members
    const char *ball;   // members of the ball's material
    const char *camera; // members
    const char *more;   // instances
    int segments;       // of the ball
};

#define SKY "'environment':{'radiance':[1,0.9,0.8]},"
#define LAMP "'lamp':{'mesh':'down','material':'lamp','transform':{'translation':[0,2.9,0]}},"
#define BASE_TEXTURE "'ior':1,'base_color_texture':{'image':'i'}"

static const struct world sky = {SKY, "'ior':1", "", "", 24};
static const struct world lamp = {"", "'ior':1", "", LAMP, 24};
static const struct world textured = {SKY, BASE_TEXTURE, "", "", 24};
static const struct world glossy = {SKY, "'roughness':0.4", "", "", 24};
static const struct world polished = {SKY, "'roughness':0,'metallic':1", "", "", 24};
static const struct world glass = {SKY, "'roughness':0,'transmission':1", "", "", 24};
static const struct world image_sky = {"'environment':{'image':'i'},", "'ior':1", "", "", 24};

static char *picture;

// 12 x 9 texels of different colours.
static void paint(void)
{
    float rgb[12 * 9 * 3];
    for (int i = 0; i < 12 * 9 * 3; i++)
        rgb[i] = (float)(i * 37 % 64 + 1) / 64.0f;
    picture = stable_png(12, 9, rgb);
}

static glint_resident *load(const struct world *w)
{
    char *text = stable_text(
        "{%s'images':{'i':{'data':'%s'}},"
        "'materials':{'grey':{'base_color':[0.5,0.4,0.3],'ior':1},'ball':{%s},"
        "'lamp':{'base_color':[0,0,0],'ior':1,'emission':[8,8,8]}},"
        "'meshes':{'wall':{'primitive':'quad','size':[6,6]},'down':{'positions':[-0.5,0,-0.5,0.5,0,"
        "-0.5,0.5,0,0.5,-0.5,0,0.5],'indices':[0,1,2,0,2,3]},"
        "'ball':{'primitive':'sphere','segments':%d}},'instances':{%s"
        "'wall':{'mesh':'wall','material':'grey','transform':{'translation':[0,0,-1]}},"
        "'ball':{'mesh':'ball','material':'ball','transform':{'translation':[0.3,-1,0.2]}}},"
        "'cameras':{'eye':{'yfov':0.9%s,'transform':{'translation':[0,0,2.9]}}}}",
        w->light, picture, w->ball, w->segments, w->more, w->camera);
    glint_resident *scene = offline_load_text(&o, text);
    free(text);
    return scene;
}

// ---- jobs

struct order {
    const char *outputs, *filter, *more;
    int bounces;
};

static const struct order beauty = {"'beauty'", "box", "", 3};

static char *job_text(const struct order *of)
{
    return stable_text("{'scene':'s','resolution':[24,20],'outputs':[%s],"
                       "'filter':{'kind':'%s','width':1},%s'max_bounces':%d,'stop':{'samples':8}}",
                       of->outputs, of->filter, of->more, of->bounces);
}

static struct glint_frame *frame_of(const struct world *w, const struct order *of, uint64_t force)
{
    glint_resident *scene = load(w);
    char *job = job_text(of);
    struct glint_frame *frame = offline_frame(&o, scene, job, force);
    free(job);
    glint_resident_release(&scene);
    return frame;
}

// ---- plans

static struct glint_plan plan_of(const struct world *w, const struct order *of, uint64_t force)
{
    glint_resident *scene = load(w);
    char *text = job_text(of);
    struct glint_job *job = offline_job(text);
    const struct glint_effect_input in = {glint_resident_facts(scene), job,
                                          &glint_resident_scene(scene)->camera[0], false};
    struct glint_plan plan;
    glint_plan_make(&plan, &in, force);
    glint_job_destroy(&job);
    free(text);
    glint_resident_release(&scene);
    return plan;
}

// The bits of rows named "a|b"; no name for none.
static uint64_t bits_of(const char *names)
{
    uint64_t bits = 0;
    char copy[256], *rest = NULL;
    snprintf(copy, sizeof copy, "%s", names);
    for (char *name = strtok_r(copy, "|", &rest); name; name = strtok_r(NULL, "|", &rest)) {
        const uint64_t bit = glint_effect_bit(name);
        if (!bit)
            fail_msg("there is no row \"%s\"", name);
        bits |= bit;
    }
    return bits;
}

static uint64_t all_rows(void)
{
    return ~0ull >> (64 - glint_effect_count);
}

// ---- forcing

// A row, a picture that does not call for it, and what else its code needs to run.
struct forcing {
    const char *effect;
    const struct world *world;
    const char *with;
};

static const struct forcing forcing[] = {
    {"microfacet", &sky, ""},
    {"transmission", &glossy, ""},
    {"textures", &lamp, ""}, // reads emission textures as well
    {"texture pools", &textured, ""},
    {"normal maps", &textured, ""},
    {"instances", &sky, ""},
    {"alpha cut-outs", &sky, ""}, // has neither define nor pass: the tracer's own
    {"emission", &sky, ""},
    {"light table", &sky, "next-event estimation"},
    {"next-event estimation", &sky, ""},
    {"constant environment", &lamp, ""},
    {"environment image", &sky, "next-event estimation"},
    {"depth of field", &sky, ""},
    {"Blackman-Harris filter", &sky, ""},
    {"multiple scattering", &polished, ""},
    {"specular", &glossy, ""},
    {"clearcoat", &glossy, ""},
    {"collimation", &glass, ""},
    {"second texture coordinates", &textured, ""},
    {"texture transforms", &textured, ""},
    {"nearest texels", &textured, ""},
    {"layer textures", &textured, ""},
    {"vertex colours", &sky, ""},
    {"inside of solids", &glass, ""},
    {"nested dielectrics", &glass, ""},
    {"medium", &lamp, ""},
    {"single-sided surfaces", &sky, ""},
    {"alpha blending", &sky, ""},
    {"motion", &lamp, ""},
    {"camera motion", &sky, ""},
    {"light grid", &lamp, ""},
    {"orthographic view", &sky, ""},
    {"motion vectors", &sky, "first-hit AOVs"},
    {"first-hit AOVs", &sky, ""},
    {"ID coverage", &sky, ""},
    {"mattes through bounces", &glass, "ID coverage"},
    {"mattes through glossy lobes", &glass, "mattes through bounces|ID coverage"},
    {"full mattes of opaque surfaces", &glass,
     "mattes through glossy lobes|mattes through bounces|ID coverage"},
};

// Settings of a dial whose other setting is another image: to force one is to ask for that image.
static const char twins[] = "float64 film|uniform light choice";

static void every_row_is_forced_but_twins_of_a_dial(void **state)
{
    (void)state;
    uint64_t covered = bits_of(twins);
    for (size_t i = 0; i < COUNT(forcing); i++)
        covered |= bits_of(forcing[i].effect);
    assert_int_equal(covered, all_rows());
    assert_int_equal(COUNT(forcing) + 2, glint_effect_count);
}

static void assert_forcing_changes_nothing(const struct world *w, uint64_t force)
{
    const struct glint_plan plan = plan_of(w, &beauty, force);
    assert_int_equal(plan.called & force, 0);
    assert_int_equal(plan.on, plan.called | force);
    struct glint_frame *plain = frame_of(w, &beauty, 0), *forced = frame_of(w, &beauty, force);
    assert_true(stable_most(plain, "G") > 0.1);
    stable_assert_same(plain, forced);
    glint_frame_destroy(&plain);
    glint_frame_destroy(&forced);
}

static void forcing_an_uncalled_effect_changes_no_bit(void **state)
{
    (void)state;
    for (size_t i = 0; i < COUNT(forcing); i++) {
        print_message("# forcing %s\n", forcing[i].effect);
        assert_forcing_changes_nothing(forcing[i].world,
                                       bits_of(forcing[i].effect) | bits_of(forcing[i].with));
    }
}

static void forcing_all_that_is_uncalled_changes_no_bit(void **state)
{
    (void)state;
    const uint64_t called = plan_of(&sky, &beauty, 0).called;
    assert_forcing_changes_nothing(&sky, all_rows() & ~called & ~bits_of(twins));
}

// ---- the smallest plan

#define LIGHTS "-DGK_LIGHT_TABLE -DGK_LIGHTS"
#define BASE_PASSES                                                                \
    (1u << GLINT_PASS_GENERATE | 1u << GLINT_PASS_TRACE | 1u << GLINT_PASS_SHADE | \
     1u << GLINT_PASS_COMPACT | 1u << GLINT_PASS_COLOUR)
#define LIGHT_PASSES (1u << GLINT_PASS_SHADOW | 1u << GLINT_PASS_UNOCCLUDED)

// Planes of 4 bytes: two halves of three colour sums of two words, hits and rejections make 14;
// AOVs add depth and six sums of two words, mattes 8 bytes for each slot and for what found none.
static const struct order with_aovs = {"'beauty','depth'", "box", "", 3};
static const struct order with_mattes = {"'beauty','crypto_object'", "box",
                                         "'mattes':{'slots':14},", 3};

static const struct smallest {
    const struct world *world;
    const struct order *order;
    const char *options;
    uint32_t passes;
    size_t film_bytes;
} smallest[] = {
    {&sky, &beauty, "-DGK_ENVIRONMENT_CONSTANT", BASE_PASSES, 80},
    {&lamp, &beauty, "-DGK_EMISSION " LIGHTS, BASE_PASSES | LIGHT_PASSES, 80},
    {&textured, &beauty, "-DGK_TEXTURES -DGK_ENVIRONMENT_CONSTANT", BASE_PASSES, 80},
    {&image_sky, &beauty, "-DGK_LIGHTS -DGK_ENVIRONMENT_IMAGE", BASE_PASSES | LIGHT_PASSES, 80},
    {&glass, &beauty, "-DGK_MICROFACET -DGK_TRANSMISSION -DGK_ENVIRONMENT_CONSTANT", BASE_PASSES,
     80},
    {&sky, &with_aovs, "-DGK_ENVIRONMENT_CONSTANT -DGK_AOVS", BASE_PASSES | 1u << GLINT_PASS_AOVS,
     80 + 13 * 4},
    {&sky, &with_mattes, "-DGK_ENVIRONMENT_CONSTANT", BASE_PASSES | 1u << GLINT_PASS_COVERAGE,
     80 + 15 * 8},
};

static void automatic_plan_is_the_smallest(void **state)
{
    (void)state;
    for (size_t i = 0; i < COUNT(smallest); i++) {
        const struct smallest *s = &smallest[i];
        const struct glint_plan plan = plan_of(s->world, s->order, 0);
        assert_string_equal(plan.options, s->options);
        assert_int_equal(plan.passes, s->passes);
        assert_int_equal(plan.film_bytes, s->film_bytes);
    }
}

// What a render really runs is the program that the options written by hand select.
static void assert_runs(const struct world *w, const char *options)
{
    struct glint_error err = {0};
    glint_resident *scene = load(w);
    char *text = job_text(&beauty);
    struct glint_job *job = offline_job(text);
    glint_render *render = NULL;
    glint_program *by_hand = NULL;
    if (glint_render_create(&render, o.devices, scene, NULL, job, &err) ||
        glint_program_get(&by_hand, o.devices, options, &err))
        offline_die("program", &err);
    assert_string_equal(glint_program_key(render->view->program), glint_program_key(by_hand));
    glint_program_release(&by_hand);
    glint_render_destroy(&render);
    glint_job_destroy(&job);
    free(text);
    glint_resident_release(&scene);
}

static void renders_run_the_program_that_a_hand_would_choose(void **state)
{
    (void)state;
    for (size_t i = 0; i < 3; i++)
        assert_runs(smallest[i].world, smallest[i].options);
}

// ---- causes

// Each cause switches on its own row, and no other than those that go with it.
struct cause {
    const char *effect;
    struct world world;
    struct order order;
    const char *calls; // every row
};

#define CONSTANT "constant environment"
#define TABLE "light table|next-event estimation"
#define TURNED "'two':{'mesh':'ball','material':'ball','transform':{'scale':[0.5,0.5,0.5]}},"
#define BEAUTY                   \
    {                            \
        "'beauty'", "box", "", 3 \
    }
#define POINT "'lights':{'p':{'type':'point'}},"

// Rows whose cause is no member of these scenes are asked with facts alone, below.
static const char by_facts[] =
    "texture pools|second texture coordinates|vertex colours|motion|camera motion";

static const struct cause cause[] = {
    {"microfacet", {SKY, "'roughness':0", "", "", 24}, BEAUTY, "microfacet|" CONSTANT},
    {"microfacet",
     {SKY, "'ior':1,'metallic':1", "", "", 24},
     {"'beauty'", "box", "'accuracy':{'microfacet':'single'},", 3},
     "microfacet|" CONSTANT},
    {"transmission",
     {SKY, "'ior':1,'transmission':1", "", "", 24},
     BEAUTY,
     "transmission|microfacet|" CONSTANT},
    {"textures", {SKY, BASE_TEXTURE, "", "", 24}, BEAUTY, "textures|" CONSTANT},
    {"normal maps",
     {SKY, "'ior':1,'normal_map':{'image':'i'}", "", "", 24},
     BEAUTY,
     "normal maps|textures|" CONSTANT},
    {"instances", {SKY, "'ior':1", "", TURNED, 24}, BEAUTY, "instances|" CONSTANT},
    {"multiple scattering",
     {SKY, "'ior':1,'metallic':1", "", "", 24},
     BEAUTY,
     "multiple scattering|microfacet|" CONSTANT},
    {"multiple scattering",
     {SKY, "'transmission':1", "", "", 24},
     BEAUTY,
     "multiple scattering|transmission|microfacet|" CONSTANT},
    {"specular",
     {SKY, "'roughness':0,'specular':0.5", "", "", 24},
     BEAUTY,
     "specular|microfacet|" CONSTANT},
    {"clearcoat",
     {SKY, "'ior':1,'clearcoat':0.5", "", "", 24},
     BEAUTY,
     "clearcoat|microfacet|" CONSTANT},
    {"collimation",
     {SKY, "'ior':1,'transmission':1,'collimation':0.5", "", "", 24},
     BEAUTY,
     "multiple scattering|collimation|transmission|microfacet|" CONSTANT},
    {"texture transforms",
     {SKY, "'ior':1,'base_color_texture':{'image':'i','offset':[0.5,0]}", "", "", 24},
     BEAUTY,
     "texture transforms|textures|" CONSTANT},
    {"nearest texels",
     {SKY, "'ior':1,'base_color_texture':{'image':'i','filter':'nearest'}", "", "", 24},
     BEAUTY,
     "nearest texels|textures|" CONSTANT},
    {"layer textures",
     {SKY, "'ior':1,'transmission':1,'transmission_texture':{'image':'i'}", "", "", 24},
     BEAUTY,
     "layer textures|textures|transmission|microfacet|" CONSTANT},
    {"inside of solids",
     {SKY, "'ior':1,'transmission':1,'attenuation_color':[0.5,1,1],'attenuation_distance':1", "",
      "", 24},
     BEAUTY,
     "inside of solids|transmission|microfacet|" CONSTANT},
    {"nested dielectrics",
     {SKY, "'ior':1,'transmission':1,'priority':1", "", "", 24},
     BEAUTY,
     "nested dielectrics|transmission|microfacet|" CONSTANT},
    {"medium",
     {SKY "'media':{'fog':{'density':0.1,'albedo':[1,1,1],'box':[-1,-1,-1,1,1,1]}},", "'ior':1", "",
      "", 24},
     BEAUTY,
     "medium|" CONSTANT},
    {"single-sided surfaces",
     {SKY, "'ior':1,'double_sided':false", "", "", 24},
     BEAUTY,
     "single-sided surfaces|" CONSTANT},
    {"alpha blending",
     {SKY, "'ior':1,'alpha_mode':'blend'", "", "", 24},
     BEAUTY,
     "alpha blending|" CONSTANT},
    {"light grid",
     {"", "'ior':1,'emission':[1,1,1]", "", "", 24},
     {"'beauty'", "box", "", 0},
     "emission|light grid|light table"},
    {"orthographic view",
     {SKY, "'ior':1", ",'projection':'orthographic','ymag':2", "", 24},
     BEAUTY,
     "orthographic view|" CONSTANT},
    {"motion vectors",
     {SKY, "'ior':1", "", "", 24},
     {"'beauty','motion'", "box", "", 3},
     "motion vectors|first-hit AOVs|" CONSTANT},
    {"alpha cut-outs",
     {SKY, "'ior':1,'alpha_mode':'mask'", "", "", 24},
     BEAUTY,
     "alpha cut-outs|" CONSTANT},
    {"emission", {"", "'ior':1", "", LAMP, 24}, {"'beauty'", "box", "", 0}, "emission|light table"},
    {"light table", {POINT, "'ior':1", "", "", 24}, {"'beauty'", "box", "", 0}, "light table"},
    {"next-event estimation", {POINT, "'ior':1", "", "", 24}, BEAUTY, TABLE},
    {"uniform light choice",
     {POINT, "'ior':1", "", "", 24},
     {"'beauty'", "box", "'accuracy':{'lights':'uniform'},", 3},
     TABLE "|uniform light choice"},
    {CONSTANT, {SKY, "'ior':1", "", "", 24}, BEAUTY, CONSTANT},
    {"environment image",
     {"'environment':{'image':'i'},", "'ior':1", "", "", 24},
     BEAUTY,
     "environment image|next-event estimation"},
    {"depth of field",
     {SKY, "'ior':1", ",'lens_radius':0.1,'focus_distance':3", "", 24},
     BEAUTY,
     "depth of field|" CONSTANT},
    {"Blackman-Harris filter",
     {SKY, "'ior':1", "", "", 24},
     {"'beauty'", "blackman_harris", "", 3},
     "Blackman-Harris filter|" CONSTANT},
    {"float64 film",
     {SKY, "'ior':1", "", "", 24},
     {"'beauty'", "box", "'accuracy':{'precision':'float64'},", 3},
     "float64 film|" CONSTANT},
    {"first-hit AOVs",
     {SKY, "'ior':1", "", "", 24},
     {"'beauty','depth'", "box", "", 3},
     "first-hit AOVs|" CONSTANT},
    {"ID coverage",
     {SKY, "'ior':1", "", "", 24},
     {"'beauty','crypto_object'", "box", "", 3},
     "ID coverage|" CONSTANT},
    {"mattes through bounces",
     {SKY, "'ior':1", "", "", 24},
     {"'beauty','crypto_object'", "box", "'mattes':{'through':'delta'},", 3},
     "mattes through bounces|ID coverage|" CONSTANT},
    {"mattes through glossy lobes",
     {SKY, "'ior':1", "", "", 24},
     {"'beauty','crypto_object'", "box", "'mattes':{'through':'glossy'},", 3},
     "mattes through glossy lobes|mattes through bounces|ID coverage|" CONSTANT},
    {"full mattes of opaque surfaces",
     {SKY, "'ior':1", "", "", 24},
     {"'beauty','crypto_object'", "box", "'mattes':{'through':'delta','coverage':'opaque_full'},",
      3},
     "full mattes of opaque surfaces|mattes through bounces|ID coverage|" CONSTANT},
};

static void each_cause_calls_for_its_own_row(void **state)
{
    (void)state;
    uint64_t covered = bits_of(by_facts);
    for (size_t i = 0; i < COUNT(cause); i++) {
        print_message("# %s\n", cause[i].effect);
        const uint64_t called = plan_of(&cause[i].world, &cause[i].order, 0).called;
        assert_int_equal(called, bits_of(cause[i].calls));
        assert_true(called & bits_of(cause[i].effect));
        covered |= bits_of(cause[i].effect);
    }
    assert_int_equal(covered, all_rows());
}

static void each_fact_calls_for_its_own_row(void **state)
{
    (void)state;
    static const struct {
        struct glint_scene_facts facts;
        const char *calls;
    } fact[] = {
        {{.texture_pools = 0}, ""},
        {{.texture_pools = 1}, ""},
        {{.texture_pools = 2}, "texture pools"},
        {{.texture_pools = 4}, "texture pools"},
        {{.microfacet = true}, "microfacet"},
        {{.uv1 = true}, "second texture coordinates"},
        {{.vertex_colours = true}, "vertex colours"},
        {{.motion = true}, "motion"},
        {{.transmission = true}, "transmission"},
        {{.textures = true}, "textures"},
        {{.normal_maps = true}, "normal maps"},
        {{.instances = true}, "instances"},
        {{.cutout = true}, "alpha cut-outs"},
        {{.emission = true}, "emission"},
        {{.light_table = true}, TABLE},
        {{.environment_constant = true}, CONSTANT},
        {{.environment_image = true}, "environment image|next-event estimation"},
    };
    char *text = job_text(&beauty);
    struct glint_job *job = offline_job(text);
    const struct glint_camera camera = {.yfov = 1.0f};
    for (size_t i = 0; i < COUNT(fact); i++) {
        const struct glint_effect_input in = {&fact[i].facts, job, &camera, false};
        assert_int_equal(glint_effects_called(&in), bits_of(fact[i].calls));
    }
    const struct glint_scene_facts none = {0};
    const struct glint_effect_input moves = {&none, job, &camera, true};
    assert_int_equal(glint_effects_called(&moves), bits_of("camera motion"));
    glint_job_destroy(&job);
    free(text);
}

// ---- defines

// The value of kernel_options in kernels/local.mk on one line, a blank before and after each word.
static char *checked_options(const char *top)
{
    char path[4096];
    size_t size;
    snprintf(path, sizeof path, "%s/kernels/local.mk", top);
    char *text = (char *)offline_read_file(path, &size);
    static const char name[] = "\nkernel_options =";
    char *value = strstr(text, name);
    assert_non_null(value);
    value += strlen(name);
    char *c = value;
    for (; *c && *c != '\n'; c++)
        if (*c == '\\' && c[1] == '\n')
            *c = c[1] = c[2] = ' '; // the third is a tab
    *c = 0;
    value = stable_text("%s ", value);
    free(text);
    return value;
}

// A row that is not in the makefile's copy would be built without ever having been checked.
static void kernels_are_checked_with_every_define(void **state)
{
    (void)state;
    const char *top = getenv("top_srcdir");
    if (!top)
        skip();
    char *options = checked_options(top);
    size_t defines = 0, written = 0;
    for (size_t i = 0; i < glint_effect_count; i++) {
        char wanted[128];
        if (!glint_effect_table[i].define)
            continue;
        snprintf(wanted, sizeof wanted, " -D%s ", glint_effect_table[i].define);
        if (!strstr(options, wanted))
            fail_msg("kernels/local.mk does not check%s", wanted);
        defines++;
    }
    for (const char *c = options; (c = strstr(c, "-D")); c += 2)
        written++;
    assert_int_equal(written, defines);
    free(options);
}

// ---- outputs

static void the_image_does_not_depend_on_mattes_or_aovs(void **state)
{
    (void)state;
    static const struct order all = {"'beauty','crypto_object','crypto_material','depth','normal'",
                                     "box", "", 3};
    struct glint_frame *plain = frame_of(&sky, &beauty, 0), *full = frame_of(&sky, &all, 0);
    for (int c = 0; c < 4; c++) {
        const char name[2] = {"RGBA"[c], 0};
        assert_int_equal(stable_equal(plain, full, name), stable_pixels(plain));
    }
    glint_frame_destroy(&plain);
    glint_frame_destroy(&full);
}

static int start(void **state)
{
    (void)state;
    offline_start(&o, 2);
    paint();
    return 0;
}

static int finish(void **state)
{
    (void)state;
    free(picture);
    offline_finish(&o);
    return 0;
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(kernels_are_checked_with_every_define),
        cmocka_unit_test(automatic_plan_is_the_smallest),
        cmocka_unit_test(renders_run_the_program_that_a_hand_would_choose),
        cmocka_unit_test(each_fact_calls_for_its_own_row),
        cmocka_unit_test(each_cause_calls_for_its_own_row),
        cmocka_unit_test(every_row_is_forced_but_twins_of_a_dial),
        cmocka_unit_test(forcing_an_uncalled_effect_changes_no_bit),
        cmocka_unit_test(forcing_all_that_is_uncalled_changes_no_bit),
        cmocka_unit_test(the_image_does_not_depend_on_mattes_or_aovs),
    };
    return cmocka_run_group_tests(tests, start, finish);
}
