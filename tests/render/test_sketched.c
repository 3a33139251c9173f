// A batch job in a large scene begins with a sketch through a structure that is soon built, and leaves
// the picture of one that waited for the scene's own.
#include "tests/render/filmed.h"

#include <stdlib.h>
#include <string.h>

// Two spheres, one in the other's way, of 66,048 triangles each; where they meet, ties are many.
static const char *const large =
    "{'materials':{'grey':{'base_color':[0.6,0.5,0.4],'roughness':0.3},"
    "'glass':{'transmission':1,'roughness':0.2}},"
    "'meshes':{'s':{'primitive':'sphere','segments':258}},"
    "'instances':{'a':{'mesh':'s','material':'grey'},'b':{'mesh':'s','material':'glass',"
    "'transform':{'translation':[0.5,0.25,0.5]}}},"
    "'environment':{'radiance':[1,1.5,2]},"
    "'cameras':{'eye':{'yfov':0.9,'transform':{'translation':[0,0,3.5]}}}}";

static struct glint_job *job_of(const char *members)
{
    char *text =
        stable_text("{'scene':'s','outputs':['beauty','variance','samples','crypto_object',"
                    "'depth'],%s'resolution':[75,50],'max_bounces':4}",
                    members);
    struct glint_job *job = offline_job(text);
    free(text);
    return job;
}

static glint_resident *load(const char *scene)
{
    char *text = stable_text("%s", scene);
    glint_resident *resident = offline_load_text(&offline_crew, text);
    free(text);
    return resident;
}

static glint_render *sketch(glint_resident *scene, const struct glint_job *job)
{
    glint_render *render;
    struct glint_error err = {0};
    if (glint_render_sketch(&render, offline_crew.devices, scene, NULL, job, &err))
        offline_die("sketch", &err);
    return render;
}

static void finish(glint_render *render, glint_resident *scene, const struct glint_job *job)
{
    glint_view *view;
    struct glint_error err = {0};
    if (glint_render_move(&view, render, scene, NULL, job, &err))
        offline_die("move", &err);
    glint_render_restart(render, &view);
    glint_view_release(&view);
}

static glint_render *whole(glint_resident *scene, const struct glint_job *job)
{
    glint_render *render;
    struct glint_error err = {0};
    if (glint_render_create(&render, offline_crew.devices, scene, NULL, job, &err))
        offline_die("render", &err);
    return render;
}

// Restarted after so many slices of the sketch, at most all.
static void sketched_picture_is_that_of_a_job_that_waited(void **state)
{
    (void)state;
    static const struct {
        const char *members;
        uint32_t slices;
    } job[] = {{"'stop':{'samples':20},", UINT32_MAX},
               {"'stop':{'samples':5},'region':[10,6,60,40],", 1},
               {"'sample_range':[16,40],", 2},
               {"'adaptive':true,'stop':{'samples':64},", UINT32_MAX},
               {"'stop':{'samples':18},'accuracy':{'traversal':'robust'},", 0}};
    for (size_t i = 0; i < sizeof job / sizeof *job; i++) {
        struct glint_job *parsed = job_of(job[i].members);
        glint_resident *scene = load(large);
        glint_render *render = sketch(scene, parsed);
        assert_true(glint_render_is_sketch(render));
        filmed_run(&offline_crew, render, job[i].slices);
        finish(render, scene, parsed);
        assert_false(glint_render_is_sketch(render));
        glint_render *twin = whole(scene, parsed);
        filmed_run(&offline_crew, render, UINT32_MAX);
        filmed_run(&offline_crew, twin, UINT32_MAX);
        filmed_assert_same(render, twin);
        glint_render_destroy(&render);
        glint_render_destroy(&twin);
        glint_resident_release(&scene);
        glint_job_destroy(&parsed);
    }
}

static void a_sketch_shows_every_tile_and_has_no_sample(void **state)
{
    (void)state;
    struct glint_job *job = job_of("'stop':{'samples':20},");
    glint_resident *scene = load(large);
    glint_render *render = sketch(scene, job);
    struct glint_render_state now;
    struct glint_slice slice;
    struct glint_frame *tile;
    uint32_t samples = 7;
    assert_true(filmed_run(&offline_crew, render, UINT32_MAX) > 1);
    assert_false(glint_render_take(render, &slice));
    assert_false(glint_render_complete(render));
    glint_render_state(render, &now);
    assert_int_equal(now.samples, 0);
    assert_true(now.progress == 0);
    for (uint32_t t = 0; t < glint_render_tiles(render); t++)
        assert_true(glint_render_tile_version(render, t) > 0);
    assert_int_equal(glint_render_tile(render, 0, &tile, &samples, NULL, NULL, NULL), GLINT_OK);
    assert_int_equal(samples, 0);
    glint_frame_destroy(&tile);
    finish(render, scene, job);
    for (uint32_t t = 0; t < glint_render_tiles(render); t++)
        assert_int_equal(glint_render_tile_version(render, t), 0);
    glint_render_destroy(&render);
    glint_resident_release(&scene);
    glint_job_destroy(&job);
}

// Share of the pixels of the sketch that the first sample has too.
static void a_sketch_shows_the_job_s_scene_and_camera(void **state)
{
    (void)state;
    struct glint_job *job = job_of("'stop':{'samples':1},");
    glint_resident *scene = load(large);
    glint_render *render = sketch(scene, job);
    filmed_run(&offline_crew, render, UINT32_MAX);
    glint_render *twin = whole(scene, job);
    filmed_run(&offline_crew, twin, UINT32_MAX);
    struct glint_frame *a, *b;
    assert_int_equal(glint_render_frame(render, job->outputs, &a, NULL, NULL), GLINT_OK);
    assert_int_equal(glint_render_frame(twin, job->outputs, &b, NULL, NULL), GLINT_OK);
    const float *x = glint_frame_find(a, "G"), *y = glint_frame_find(b, "G");
    uint32_t all = 0, same = 0;
    for (uint32_t v = 0; v < a->height; v += 4)
        for (uint32_t u = 0; u < a->width; u += 4, all++)
            same += x[v * a->width + u] == y[v * a->width + u];
    assert_true(same * 100 >= all * 95);
    glint_frame_destroy(&a);
    glint_frame_destroy(&b);
    glint_render_destroy(&render);
    glint_render_destroy(&twin);
    glint_resident_release(&scene);
    glint_job_destroy(&job);
}

static void what_moves_measures_or_has_its_structure_is_not_sketched(void **state)
{
    (void)state;
    static const char *const members[] = {
        "'stop':{'samples':4},'live':true,",
        "'stop':{'samples':4},'accuracy':{'precision':'float64'},",
        "'stop':{'samples':4}," // through the structure of the one before
    };
    glint_resident *scene = load(large);
    for (size_t i = 0; i < sizeof members / sizeof *members; i++) {
        struct glint_job *job = job_of(members[i]);
        glint_render *render = sketch(scene, job);
        assert_false(glint_render_is_sketch(render));
        glint_render_destroy(&render);
        glint_job_destroy(&job);
    }
    glint_resident_release(&scene);
    struct glint_job *job = job_of("'stop':{'samples':4},");
    glint_render *small = sketch(filmed.resident, job);
    assert_false(glint_render_is_sketch(small));
    glint_render_destroy(&small);
    glint_job_destroy(&job);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(sketched_picture_is_that_of_a_job_that_waited),
        cmocka_unit_test(a_sketch_shows_every_tile_and_has_no_sample),
        cmocka_unit_test(a_sketch_shows_the_job_s_scene_and_camera),
        cmocka_unit_test(what_moves_measures_or_has_its_structure_is_not_sketched),
    };
    return cmocka_run_group_tests(tests, filmed_start, filmed_stop);
}
