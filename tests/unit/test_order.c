// The first samples of a live job: from the middle outwards, and every block in its turn.
#include "render/order.h"
#include "tests/render/offline.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>

#include <cmocka.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static const uint32_t size[][2] = {{1, 1}, {2, 1}, {1, 7}, {8, 6}, {5, 5}, {30, 17}, {31, 16}};
#define SIZES (sizeof size / sizeof *size)

static uint32_t tile_of(const uint32_t wh[2], uint32_t block)
{
    uint32_t column, row;
    glint_order_place(wh[0], wh[1], block, &column, &row);
    assert_true(column < wh[0] && row < wh[1]);
    return row / 2 * ((wh[0] + 1) / 2) + column / 2;
}

static void every_block_is_named_once(void **state)
{
    (void)state;
    for (size_t s = 0; s < SIZES; s++) {
        const uint32_t blocks = size[s][0] * size[s][1];
        uint32_t *order = glint_order_create(size[s][0], size[s][1]);
        unsigned char *seen = calloc(blocks, 1);
        for (uint32_t b = 0; b < blocks; b++) {
            assert_true(order[b] < blocks);
            assert_int_equal(seen[order[b]]++, 0);
        }
        free(seen);
        free(order);
    }
}

static void the_blocks_of_a_tile_follow_one_another(void **state)
{
    (void)state;
    for (size_t s = 0; s < SIZES; s++) {
        const uint32_t blocks = size[s][0] * size[s][1];
        uint32_t *order = glint_order_create(size[s][0], size[s][1]);
        unsigned char *begun = calloc(blocks + 1, 1);
        for (uint32_t b = 0; b < blocks; b++) {
            const uint32_t tile = tile_of(size[s], order[b]);
            if (b == 0 || tile != tile_of(size[s], order[b - 1]))
                assert_int_equal(begun[tile]++, 0);
        }
        free(begun);
        free(order);
    }
}

static double distance(const uint32_t wh[2], uint32_t block)
{
    const uint32_t tile = tile_of(wh, block), wide = (wh[0] + 1) / 2;
    return hypot(2 * (tile % wide) + 1 - wh[0] / 2.0, 2.0 * (tile / wide) + 1 - wh[1] / 2.0);
}

static void it_goes_from_the_middle_outwards(void **state)
{
    (void)state;
    for (size_t s = 0; s < SIZES; s++) {
        const uint32_t blocks = size[s][0] * size[s][1];
        uint32_t *order = glint_order_create(size[s][0], size[s][1]);
        for (uint32_t b = 1; b < blocks; b++)
            assert_true(distance(size[s], order[b]) >= distance(size[s], order[b - 1]) - 1e-9);
        free(order);
    }
}

// Live renders. Where the coarsest pixels of 256 x 256 make a block, the wide one has 8 x 6.

static const char scene_text[] =
    "{\"meshes\": {\"q\": {\"primitive\": \"quad\"}}, \"materials\": {\"m\": {}},"
    " \"instances\": {\"i\": {\"mesh\": \"q\", \"material\": \"m\"}},"
    " \"environment\": {\"radiance\": [1, 1, 1]}}";
#define JOB_TEXT                                                                               \
    "{\"scene\": \"s\", \"live\": true, \"resolution\": [%u, %u], \"stop\": {\"samples\": 4}," \
    " \"camera\": {\"yfov\": 0.8, \"transform\": {\"translation\": [0, 0, 3]}}}"

struct fixture {
    glint_resident *scene;
    struct glint_job *job;
    glint_render *render;
};

static void open_render(struct fixture *f, uint32_t width, uint32_t height)
{
    struct glint_error err = {0};
    char text[512];
    snprintf(text, sizeof text, JOB_TEXT, width, height);
    f->scene = offline_load_text(&offline_crew, scene_text);
    f->job = offline_job(text);
    if (glint_render_create(&f->render, offline_crew.devices, f->scene, NULL, f->job, &err))
        offline_die("render", &err);
}

static void close_render(struct fixture *f)
{
    glint_render_destroy(&f->render);
    glint_job_destroy(&f->job);
    glint_resident_release(&f->scene);
}

static void look_again(struct fixture *f)
{
    struct glint_error err = {0};
    glint_view *view;
    if (glint_render_move(&view, f->render, f->scene, NULL, f->job, &err))
        offline_die("move", &err);
    glint_render_restart(f->render, &view);
    glint_view_release(&view);
}

// Takes `taken` slices, and gives back all but the last `left` of them as done.
static void run(struct fixture *f, uint32_t taken, uint32_t left, unsigned *runs)
{
    struct glint_slice slice[8];
    struct glint_error err = {0};
    glint_worker *worker = glint_devices_worker(offline_crew.devices, 0);
    for (uint32_t i = 0; i < taken; i++)
        assert_true(glint_render_take(f->render, &slice[i]));
    for (uint32_t i = 0; i < taken; i++) {
        const bool done = i + left < taken;
        if (done && glint_render_run(f->render, worker, &slice[i], &err))
            offline_die("slice", &err);
        if (done && slice[i].step == 8)
            runs[slice[i].block]++;
        glint_render_give_back(f->render, &slice[i], done);
    }
}

static void every_block_has_its_turn_however_often_the_view_changes(void **state)
{
    (void)state;
    enum { BLOCKS = 48, DONE = 3 };
    struct fixture f;
    unsigned runs[BLOCKS] = {0};
    open_render(&f, 2048, 1536);
    for (int round = 0; round < 2 * BLOCKS / DONE; round++) {
        run(&f, DONE + 2, 2, runs);
        look_again(&f);
    }
    for (int b = 0; b < BLOCKS; b++)
        assert_int_equal(runs[b], 2);
    close_render(&f);
}

static void a_view_that_was_covered_is_followed_from_the_middle(void **state)
{
    (void)state;
    struct fixture f;
    struct glint_slice first, again;
    unsigned runs[48] = {0};
    open_render(&f, 2048, 1536);
    assert_true(glint_render_take(f.render, &first));
    glint_render_give_back(f.render, &first, false);
    assert_true(first.x >= 512 && first.x < 1536 && first.y >= 512 && first.y < 1024);
    for (int i = 0; i < 50; i++)
        run(&f, 1, 0, runs);
    look_again(&f);
    assert_true(glint_render_take(f.render, &again));
    assert_int_equal(again.block, first.block);
    glint_render_give_back(f.render, &again, false);
    close_render(&f);
}

static void the_order_does_not_show_in_the_picture(void **state)
{
    (void)state;
    struct fixture f;
    struct glint_error err = {0};
    unsigned runs[48] = {0};
    struct glint_frame *frame[2];
    for (int i = 0; i < 2; i++) {
        open_render(&f, 640, 480);
        for (int round = 0; round < 5 * i; round++) {
            run(&f, 4, 2, runs);
            look_again(&f);
        }
        offline_render(&offline_crew, f.render);
        if (glint_render_frame(f.render, GLINT_OUT_BEAUTY, &frame[i], NULL, &err))
            offline_die("frame", &err);
        close_render(&f);
    }
    static const char *const channel[] = {"R", "G", "B", "A"};
    for (int c = 0; c < 4; c++)
        assert_memory_equal(glint_frame_find(frame[0], channel[c]),
                            glint_frame_find(frame[1], channel[c]), 640 * 480 * sizeof(float));
    glint_frame_destroy(&frame[0]);
    glint_frame_destroy(&frame[1]);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_block_is_named_once),
        cmocka_unit_test(the_blocks_of_a_tile_follow_one_another),
        cmocka_unit_test(it_goes_from_the_middle_outwards),
        cmocka_unit_test(every_block_has_its_turn_however_often_the_view_changes),
        cmocka_unit_test(a_view_that_was_covered_is_followed_from_the_middle),
        cmocka_unit_test(the_order_does_not_show_in_the_picture),
    };
    return cmocka_run_group_tests(tests, offline_crew_start, offline_crew_finish);
}
