// A batch job in a large scene begins with a sketch through a structure that is soon built, and leaves
// the picture of one that waited for the scene's own.
#include "tests/render/filmed.h"

#include <stdlib.h>

// Of a scene of 66,048 triangles, from its load to its release.
struct large {
    struct glint_job *job;
    struct glint_posed rest, posed;
};

static void open_large(struct large *l, const char *members)
{
    struct glint_error err = {0};
    l->job = filmed_job(members);
    l->rest = filmed_scene_of(&offline_crew, 258);
    if (glint_posed_for(&l->posed, offline_crew.devices, &l->rest, l->job, &err))
        offline_die("pose", &err);
}

static void close_large(struct large *l)
{
    glint_resident_release(&l->posed.resident);
    glint_resident_release(&l->rest.resident);
    glint_job_destroy(&l->job);
}

static glint_render *sketch(const struct large *l)
{
    glint_render *render;
    struct glint_error err = {0};
    if (glint_render_sketch(&render, offline_crew.devices, l->posed.resident, l->posed.pose, l->job,
                            &err))
        offline_die("sketch", &err);
    return render;
}

static void finish(glint_render *render, const struct large *l)
{
    glint_view *view;
    struct glint_error err = {0};
    if (glint_render_move(&view, render, l->posed.resident, l->posed.pose, l->job, &err))
        offline_die("move", &err);
    glint_render_restart(render, &view);
    glint_view_release(&view);
}

static glint_render *whole(const struct large *l)
{
    glint_render *render;
    struct glint_error err = {0};
    if (glint_render_create(&render, offline_crew.devices, l->posed.resident, l->posed.pose, l->job,
                            &err))
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
        struct large l;
        open_large(&l, job[i].members);
        glint_render *render = sketch(&l);
        assert_true(glint_render_is_sketch(render));
        filmed_run(&offline_crew, render, job[i].slices);
        finish(render, &l);
        assert_false(glint_render_is_sketch(render));
        glint_render *twin = whole(&l);
        filmed_run(&offline_crew, render, UINT32_MAX);
        filmed_run(&offline_crew, twin, UINT32_MAX);
        filmed_assert_same(render, twin);
        glint_render_destroy(&render);
        glint_render_destroy(&twin);
        close_large(&l);
    }
}

static void a_sketch_shows_every_tile_and_has_no_sample(void **state)
{
    (void)state;
    struct large l;
    struct glint_render_state now;
    struct glint_slice slice;
    struct glint_frame *tile;
    uint32_t samples = 7;
    open_large(&l, "'stop':{'samples':20},");
    glint_render *render = sketch(&l);
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
    finish(render, &l);
    for (uint32_t t = 0; t < glint_render_tiles(render); t++)
        assert_int_equal(glint_render_tile_version(render, t), 0);
    glint_render_destroy(&render);
    close_large(&l);
}

// Of the pixels that it has, 95 in 100 are those of the first sample.
static void a_sketch_shows_the_scene_and_camera_of_the_job(void **state)
{
    (void)state;
    struct large l;
    open_large(&l, "'stop':{'samples':1},");
    glint_render *render = sketch(&l), *twin = whole(&l);
    filmed_run(&offline_crew, render, UINT32_MAX);
    filmed_run(&offline_crew, twin, UINT32_MAX);
    struct glint_frame *a, *b;
    assert_int_equal(glint_render_frame(render, l.job->outputs, &a, NULL, NULL), GLINT_OK);
    assert_int_equal(glint_render_frame(twin, l.job->outputs, &b, NULL, NULL), GLINT_OK);
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
    close_large(&l);
}

static bool wants(const struct glint_posed *posed, const char *members)
{
    struct glint_job *job = filmed_job(members);
    const bool wanted = glint_render_wants_sketch(posed->resident, job);
    glint_job_destroy(&job);
    return wanted;
}

static void what_moves_measures_is_small_or_has_its_structure_is_not_sketched(void **state)
{
    (void)state;
    struct large l;
    const struct glint_geometry *built;
    open_large(&l, "");
    assert_true(wants(&l.posed, ""));
    assert_false(wants(&l.posed, "'live':true,"));
    assert_false(wants(&l.posed, "'accuracy':{'precision':'float64'},"));
    assert_false(wants(&filmed, ""));
    assert_int_equal(
        glint_resident_geometry(l.posed.resident, GLINT_GEOMETRY_FLAT, false, &built, NULL),
        GLINT_OK);
    assert_false(wants(&l.posed, ""));
    assert_true(wants(&l.posed, "'accuracy':{'traversal':'robust'},"));
    close_large(&l);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(sketched_picture_is_that_of_a_job_that_waited),
        cmocka_unit_test(a_sketch_shows_every_tile_and_has_no_sample),
        cmocka_unit_test(a_sketch_shows_the_scene_and_camera_of_the_job),
        cmocka_unit_test(what_moves_measures_is_small_or_has_its_structure_is_not_sketched),
    };
    return cmocka_run_group_tests(tests, filmed_start, filmed_stop);
}
