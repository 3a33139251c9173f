// A live job's first sample comes coarsely, and leaves the film of one that comes at once.
#include "tests/render/filmed.h"

#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#define LIVE "'live':true,'stop':{'samples':20},"
#define REGION "'region':[10,6,75,50],"
#define GLOSSY "'mattes':{'levels':4,'slots':12,'through':'glossy','classes':true},"

static glint_render *begin(const char *members)
{
    return filmed_render(&offline_crew, &filmed, members);
}

// Goes on from a film without a sample: films know whole samples, so this one takes such.
static glint_render *begin_at_once(const char *members)
{
    glint_render *before = begin(members), *render = begin(members);
    const int fd = filmed_write(before);
    assert_int_equal(glint_render_restore(render, fd, NULL), GLINT_OK);
    close(fd);
    glint_render_destroy(&before);
    return render;
}

// One slice; the distance between its pixels, 0 for all.
static uint32_t run_one(glint_render *render)
{
    struct glint_slice slice;
    assert_true(glint_render_take(render, &slice));
    assert_int_equal(
        glint_render_run(render, glint_devices_worker(offline_crew.devices, 0), &slice, NULL),
        GLINT_OK);
    glint_render_give_back(render, &slice, true);
    return slice.step;
}

static uint32_t next_step(glint_render *render)
{
    struct glint_slice slice;
    assert_true(glint_render_take(render, &slice));
    glint_render_give_back(render, &slice, false);
    return slice.step;
}

static void whole_film_is_that_of_samples_taken_at_once(void **state)
{
    (void)state;
    static const char *const job[] = {LIVE, LIVE REGION, LIVE "'region':[3,5,1,1],",
                                      LIVE "'region':[0,0,17,9],", LIVE REGION GLOSSY};
    for (size_t i = 0; i < sizeof job / sizeof *job; i++) {
        glint_render *coarse = begin(job[i]), *twin = begin_at_once(job[i]);
        assert_int_equal(next_step(coarse), 8);
        assert_int_equal(next_step(twin), 0);
        filmed_run(&offline_crew, coarse, UINT32_MAX);
        filmed_run(&offline_crew, twin, UINT32_MAX);
        filmed_assert_same(coarse, twin); // the number of rays too: none was traced twice
        glint_render_destroy(&coarse);
        glint_render_destroy(&twin);
    }
}

static struct glint_frame *show(glint_render *render, uint32_t *samples)
{
    struct glint_frame *frame;
    assert_int_equal(glint_render_frame(render, render->job.outputs, &frame, samples, NULL),
                     GLINT_OK);
    return frame;
}

// Pixel (x, y) of `a` is pixel (u, v) of `b` in all channels but the samples.
static void same_pixel(const struct glint_frame *a, uint32_t x, uint32_t y,
                       const struct glint_frame *b, uint32_t u, uint32_t v)
{
    for (uint32_t c = 0; c < a->channels; c++) {
        const float *p = glint_frame_find(a, a->channel[c].name);
        const float *q = glint_frame_find(b, a->channel[c].name);
        if (strcmp(a->channel[c].name, "samples.Y") != 0)
            assert_memory_equal(&p[y * a->width + x], &q[v * b->width + u], sizeof *p);
    }
}

static void check_blocks(const struct glint_frame *f, const struct glint_frame *whole,
                         uint32_t step)
{
    const float *samples = glint_frame_find(f, "samples.Y");
    for (uint32_t y = 0; y < f->height; y++)
        for (uint32_t x = 0; x < f->width; x++) {
            const uint32_t u = x - x % step, v = y - y % step;
            assert_true(samples[y * f->width + x] == (u == x && v == y ? 1.0f : 0.0f));
            same_pixel(f, x, y, whole, u, v);
        }
}

static void check_tile(glint_render *render, const struct glint_frame *frame)
{
    struct glint_frame *tile;
    uint32_t samples = 7;
    uint64_t version = 0;
    assert_int_equal(glint_render_tile(render, 0, &tile, &samples, &version, NULL, NULL), GLINT_OK);
    assert_int_equal(samples, 0);
    assert_true(version > 0);
    const float *a = glint_frame_find(tile, "G"), *b = glint_frame_find(frame, "G");
    for (uint32_t y = 0; y < tile->height; y++)
        assert_memory_equal(a + y * tile->width, b + y * frame->width, tile->width * sizeof *a);
    glint_frame_destroy(&tile);
}

static void pixels_without_a_sample_are_shown_as_one_that_has_it(void **state)
{
    (void)state;
    glint_render *render = begin(LIVE REGION GLOSSY), *whole = begin(LIVE REGION GLOSSY);
    while (next_step(whole))
        run_one(whole);
    struct glint_frame *wanted = show(whole, NULL);
    uint64_t before = 0;
    assert_int_equal(glint_render_tile_version(render, 0), 0);
    for (uint32_t step = 8; step > 1; step /= 2) {
        while (next_step(render) == step)
            run_one(render);
        uint32_t fewest = 7;
        struct glint_frame *f = show(render, &fewest);
        assert_int_equal(fewest, 0);
        check_blocks(f, wanted, step);
        check_tile(render, f);
        assert_true(glint_render_tile_version(render, 0) > before);
        before = glint_render_tile_version(render, 0);
        glint_frame_destroy(&f);
    }
    run_one(render); // a quarter of the tile: it is not sent before the others
    assert_true(glint_render_tile_version(render, 0) == before);
    glint_frame_destroy(&wanted);
    glint_render_destroy(&render);
    glint_render_destroy(&whole);
}

static void progress_of_the_first_sample_grows_and_ends_at_its_share(void **state)
{
    (void)state;
    glint_render *render = begin(LIVE);
    struct glint_render_state now;
    double before = -1;
    while (next_step(render)) {
        glint_render_state(render, &now);
        assert_int_equal(now.samples, 0);
        assert_true(now.progress > before && now.progress < 1 / 20.0);
        before = now.progress;
        run_one(render);
    }
    glint_render_state(render, &now);
    assert_int_equal(now.samples, 1);
    assert_true(now.progress == 1 / 20.0);
    glint_render_destroy(&render);
}

// Cut off after any number of slices, with slices that come back undone: it begins coarsely again.
static void move_begins_with_the_coarsest_pixels_again(void **state)
{
    (void)state;
    glint_render *twin = begin_at_once(LIVE);
    filmed_run(&offline_crew, twin, UINT32_MAX);
    for (uint32_t slices = 0; slices < 14; slices++) {
        glint_render *render = begin(LIVE);
        filmed_run(&offline_crew, render, slices);
        glint_view *view = glint_view_hold(render);
        glint_render_restart(render, &view);
        glint_view_release(&view);
        assert_int_equal(glint_render_tile_version(render, 0), 0);
        assert_int_equal(next_step(render), 8);
        filmed_run(&offline_crew, render, UINT32_MAX);
        struct glint_frame *a = show(render, NULL), *b = show(twin, NULL);
        stable_assert_same(a, b);
        glint_frame_destroy(&a);
        glint_frame_destroy(&b);
        glint_render_destroy(&render);
    }
    glint_render_destroy(&twin);
}

// Films hold whole samples: one that is written meanwhile goes on with the whole sample.
static void film_of_a_coarse_moment_goes_on_to_the_same_picture(void **state)
{
    (void)state;
    glint_render *twin = begin_at_once(LIVE);
    filmed_run(&offline_crew, twin, UINT32_MAX);
    for (uint32_t slices = 0; slices < 14; slices++) {
        glint_render *before = begin(LIVE), *after = begin(LIVE);
        filmed_run(&offline_crew, before, slices);
        const int fd = filmed_write(before);
        assert_int_equal(glint_render_restore(after, fd, NULL), GLINT_OK);
        close(fd);
        filmed_run(&offline_crew, after, UINT32_MAX);
        struct glint_frame *a = show(after, NULL), *b = show(twin, NULL);
        stable_assert_same(a, b);
        glint_frame_destroy(&a);
        glint_frame_destroy(&b);
        glint_render_destroy(&before);
        glint_render_destroy(&after);
    }
    glint_render_destroy(&twin);
}

static void films_of_doubles_and_batch_jobs_come_at_once(void **state)
{
    (void)state;
    static const struct {
        const char *members;
        bool coarsens;
    } job[] = {{LIVE, true},
               {"'stop':{'samples':20},", false},
               {LIVE "'accuracy':{'precision':'float64'},", false}};
    for (size_t i = 0; i < sizeof job / sizeof *job; i++) {
        char *text = stable_text("{'scene':'s',%s'outputs':['beauty']}", job[i].members);
        struct glint_job *parsed = offline_job(text);
        assert_int_equal(glint_pass_coarsens(parsed), job[i].coarsens);
        glint_job_destroy(&parsed);
        free(text);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(whole_film_is_that_of_samples_taken_at_once),
        cmocka_unit_test(pixels_without_a_sample_are_shown_as_one_that_has_it),
        cmocka_unit_test(progress_of_the_first_sample_grows_and_ends_at_its_share),
        cmocka_unit_test(move_begins_with_the_coarsest_pixels_again),
        cmocka_unit_test(film_of_a_coarse_moment_goes_on_to_the_same_picture),
        cmocka_unit_test(films_of_doubles_and_batch_jobs_come_at_once),
    };
    return cmocka_run_group_tests(tests, filmed_start, filmed_stop);
}
