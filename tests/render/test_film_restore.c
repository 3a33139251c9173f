// A render that is written to a file goes on from there as if nothing had happened, and a file of
// one that has ended answers for it.
#include "tests/render/filmed.h"

#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#define REGION "'region':[10,6,75,50],"
#define STOP "'stop':{'samples':24},"

static glint_render *begin(const char *members)
{
    return filmed_render(&offline_crew, &filmed, members);
}

static void finish(glint_render *render)
{
    filmed_run(&offline_crew, render, UINT32_MAX);
    assert_true(glint_render_complete(render));
}

static glint_render *whole(const char *members)
{
    glint_render *render = begin(members);
    finish(render);
    return render;
}

// The slices: 2 of one sample, 2 of one, 6 of two, three times 6 of four, 20 of eight.
static void film_of_any_moment_goes_on_to_the_same_bytes(void **state)
{
    (void)state;
    static const uint32_t slices[] = {0, 1, 2, 3, 4, 9, 10, 19, 28, 29, 47, 48};
    glint_render *twin = whole(REGION STOP);
    for (size_t i = 0; i < sizeof slices / sizeof *slices; i++) {
        glint_render *before = begin(REGION STOP), *after = begin(REGION STOP);
        assert_int_equal(filmed_run(&offline_crew, before, slices[i]), slices[i]);
        const int fd = filmed_write(before);
        assert_int_equal(glint_render_restore(after, fd, NULL), GLINT_OK);
        filmed_assert_same(before, after);
        assert_int_equal(filmed_run(&offline_crew, after, UINT32_MAX), 48 - slices[i]);
        filmed_assert_same(after, twin);
        close(fd);
        glint_render_destroy(&before);
        glint_render_destroy(&after);
    }
    glint_render_destroy(&twin);
}

static void restore(glint_render *render, int fd)
{
    struct glint_error err = {0};
    if (glint_render_restore(render, fd, &err))
        offline_die("restore", &err);
    close(fd);
}

static void goes_on_to_the_same_bytes(const char *job)
{
    glint_render *twin = whole(job), *before = begin(job), *after = begin(job), *opened;
    filmed_run(&offline_crew, before, 20);
    restore(after, filmed_write(before));
    finish(after);
    filmed_assert_same(after, twin);
    const int fd = filmed_write(twin);
    assert_int_equal(glint_render_open(&opened, fd, NULL), GLINT_OK);
    close(fd);
    filmed_assert_same(opened, twin);
    glint_render_destroy(&before);
    glint_render_destroy(&after);
    glint_render_destroy(&opened);
    glint_render_destroy(&twin);
}

// Coverage that bounces bring, in full tables that share without bias: keys have classes.
static void coverage_through_bounces_goes_on_to_the_same_bytes(void **state)
{
    (void)state;
    goes_on_to_the_same_bytes("'stop':{'samples':20},'mattes':{'levels':2,'slots':4,'through':"
                              "'glossy','classes':true,'eviction':'uss_direct_first'},");
}

static void exact_coverage_goes_on_to_the_same_bytes(void **state)
{
    (void)state;
    goes_on_to_the_same_bytes("'stop':{'samples':20},'mattes':{'levels':2,'slots':4,'through':"
                              "'glossy','depth_bins':3,'eviction':'exact'},");
}

// Through several files, one after the other, with slices that come back without having been run.
static void render_may_be_restored_again_and_again(void **state)
{
    (void)state;
    glint_render *twin = whole(STOP), *render = begin(STOP);
    while (!glint_render_complete(render)) {
        struct glint_slice slice;
        filmed_run(&offline_crew, render, 13);
        if (glint_render_take(render, &slice))
            glint_render_give_back(render, &slice, false);
        const int fd = filmed_write(render);
        glint_render_destroy(&render);
        render = begin(STOP);
        restore(render, fd);
    }
    filmed_assert_same(render, twin);
    glint_render_destroy(&render);
    glint_render_destroy(&twin);
}

static void decision_to_stop_by_error_is_the_same(void **state)
{
    (void)state;
    static const char job[] = REGION "'stop':{'samples':512,'error':0.12},";
    glint_render *twin = whole(job);
    struct glint_render_state end;
    glint_render_state(twin, &end);
    assert_in_range(end.samples, 17, 511);
    for (uint32_t slices = 8; slices < 110; slices += 50) {
        glint_render *before = begin(job), *after = begin(job);
        filmed_run(&offline_crew, before, slices);
        const int fd = filmed_write(before);
        assert_int_equal(glint_render_restore(after, fd, NULL), GLINT_OK);
        finish(after);
        filmed_assert_same(after, twin);
        close(fd);
        glint_render_destroy(&before);
        glint_render_destroy(&after);
    }
    const int fd = filmed_write(twin);
    glint_render *ended = begin(job);
    assert_int_equal(glint_render_restore(ended, fd, NULL), GLINT_OK);
    filmed_assert_same(ended, twin);
    close(fd);
    glint_render_destroy(&ended);
    glint_render_destroy(&twin);
}

static void same_tiles(glint_render *a, glint_render *b)
{
    assert_int_equal(glint_render_tiles(a), glint_render_tiles(b));
    for (uint32_t t = 0; t < glint_render_tiles(a); t++) {
        struct glint_frame *x, *y;
        uint32_t n, m;
        char r[65], s[65];
        assert_int_equal(glint_render_tile(a, t, &x, &n, NULL, r, NULL), GLINT_OK);
        assert_int_equal(glint_render_tile(b, t, &y, &m, NULL, s, NULL), GLINT_OK);
        assert_int_equal(n, m);
        assert_string_equal(r, s);
        stable_assert_same(x, y);
        assert_int_equal(glint_render_tile_version(a, t) > 0, glint_render_tile_version(b, t) > 0);
        glint_frame_destroy(&x);
        glint_frame_destroy(&y);
    }
}

static void same_mattes(glint_render *a, glint_render *b)
{
    struct glint_matte_totals of_a, of_b;
    assert_int_equal(glint_render_mattes(a, 7u, &of_a, NULL), GLINT_OK);
    assert_int_equal(glint_render_mattes(b, 7u, &of_b, NULL), GLINT_OK);
    assert_memory_equal(of_a.lost, of_b.lost, sizeof of_a.lost);
    for (int l = 0; l < GLINT_MATTE_LAYERS; l++) {
        const struct glint_matte_total *p = of_a.of[l], *q = of_b.of[l];
        assert_int_equal(of_a.count[l], of_b.count[l]);
        for (size_t i = 0; i < of_a.count[l]; i++) {
            assert_string_equal(p[i].name, q[i].name);
            assert_true(p[i].id == q[i].id);
            assert_memory_equal(p[i].coverage, q[i].coverage, sizeof p[i].coverage);
        }
    }
    glint_matte_totals_finish(&of_a);
    glint_matte_totals_finish(&of_b);
    struct glint_frame *x, *y;
    const char *const names[] = {"s", "m"};
    assert_int_equal(glint_render_matte(a, 0, 1u, names, 2, &x, NULL), GLINT_OK);
    assert_int_equal(glint_render_matte(b, 0, 1u, names, 2, &y, NULL), GLINT_OK);
    stable_assert_same(x, y);
    glint_frame_destroy(&x);
    glint_frame_destroy(&y);
}

static void same_plans(glint_render *a, glint_render *b)
{
    cJSON *x = glint_render_plan(a), *y = glint_render_plan(b);
    assert_true(cJSON_Compare(x, y, true));
    cJSON_Delete(x);
    cJSON_Delete(y);
}

static void file_answers_for_a_render_that_has_ended(void **state)
{
    (void)state;
    static const uint32_t slices[] = {0, 1, 17, 48};
    for (size_t i = 0; i < sizeof slices / sizeof *slices; i++) {
        glint_render *render = begin(REGION STOP), *opened, *again;
        struct glint_slice slice;
        filmed_run(&offline_crew, render, slices[i]);
        const int fd = filmed_write(render);
        assert_int_equal(glint_render_open(&opened, fd, NULL), GLINT_OK);
        close(fd);
        filmed_assert_same(render, opened);
        same_tiles(render, opened);
        same_mattes(render, opened);
        same_plans(render, opened);
        assert_false(glint_render_take(opened, &slice));
        assert_false(glint_render_extend(opened, 1000, 0));
        const int copy = filmed_write(opened);
        assert_int_equal(glint_render_open(&again, copy, NULL), GLINT_OK);
        close(copy);
        filmed_assert_same(opened, again);
        glint_render_destroy(&render);
        glint_render_destroy(&opened);
        glint_render_destroy(&again);
    }
}

static void more_samples_go_on_where_the_film_ends(void **state)
{
    (void)state;
    glint_render *twin = whole(STOP), *render = whole("'stop':{'samples':11},");
    assert_false(glint_render_extend(render, 10, 0));
    assert_true(glint_render_extend(render, 11, 0));
    assert_true(glint_render_complete(render));
    assert_true(glint_render_extend(render, 64, 0));
    filmed_run(&offline_crew, render, 29); // into the pass from 16 to 32
    assert_false(glint_render_extend(render, 31, 0));
    assert_true(glint_render_extend(render, 32, 0));
    glint_render_destroy(&render);
    render = whole("'stop':{'samples':11},");
    assert_true(glint_render_extend(render, 24, 0));
    finish(render);
    struct glint_render_state x, y;
    glint_render_state(render, &x);
    glint_render_state(twin, &y);
    assert_int_equal(x.samples, 24);
    assert_true(x.camera_rays == y.camera_rays && x.progress == 1.0);
    size_t n, m;
    uint8_t *a = filmed_exr(render, render->job.outputs, &n);
    uint8_t *b = filmed_exr(twin, render->job.outputs, &m);
    assert_true(n == m && memcmp(a, b, n) == 0);
    free(a);
    free(b);
    glint_render_destroy(&render);
    glint_render_destroy(&twin);
}

static void ended_film_goes_on_once_its_job_wants_more(void **state)
{
    (void)state;
    glint_render *twin = whole(STOP), *less = whole("'stop':{'samples':16},"), *more = begin(STOP);
    const int fd = filmed_write(less);
    assert_int_equal(glint_render_restore(more, fd, NULL), GLINT_OK);
    assert_false(glint_render_complete(more));
    finish(more);
    filmed_assert_same(more, twin);
    close(fd);
    glint_render_destroy(&less);
    glint_render_destroy(&more);
    glint_render_destroy(&twin);
}

static void assert_refused(glint_render *render, int fd, glint_status status, const char *pointer)
{
    struct glint_error err = {0};
    assert_int_equal(lseek(fd, 0, SEEK_SET), 0);
    assert_int_equal(glint_render_restore(render, fd, &err), status);
    assert_string_equal(err.fault[0].pointer, pointer);
    glint_error_finish(&err);
}

static void film_of_another_job_is_refused(void **state)
{
    (void)state;
    static const char *const other[][2] = {{"'seed':7," STOP REGION, "/job/seed"},
                                           {"'camera':'side'," STOP REGION, "/job/camera"},
                                           {"'frame':1," STOP REGION, "/job/frame"},
                                           {"'region':[10,6,75,49]," STOP, "/job/region"},
                                           {REGION "'sample_range':[0,24],", "/job/sample_range"}};
    glint_render *render = begin(REGION STOP), *twin = whole(REGION STOP);
    for (size_t i = 0; i < sizeof other / sizeof *other; i++) {
        glint_render *stranger = begin(other[i][0]);
        filmed_run(&offline_crew, stranger, 9);
        const int fd = filmed_write(stranger);
        assert_refused(render, fd, GLINT_E_RANGE, other[i][1]);
        close(fd);
        glint_render_destroy(&stranger);
    }
    finish(render); // as it was
    filmed_assert_same(render, twin);
    glint_render_destroy(&render);
    glint_render_destroy(&twin);
}

static void film_of_another_revision_is_refused(void **state)
{
    (void)state;
    struct glint_posed other = filmed_scene(&offline_crew);
    glint_resident_set_revision(other.resident, "feed");
    glint_render *render = begin(STOP);
    glint_render *stranger = filmed_render(&offline_crew, &other, STOP);
    const int fd = filmed_write(stranger);
    assert_refused(render, fd, GLINT_E_RANGE, "/revision");
    close(fd);
    glint_render_destroy(&render);
    glint_render_destroy(&stranger);
    glint_resident_release(&other.resident);
}

static void render_that_was_offered_a_torn_film_begins_anew(void **state)
{
    (void)state;
    glint_render *render = begin(STOP), *other = begin(STOP), *twin = whole(STOP);
    filmed_run(&offline_crew, other, 20);
    const int fd = filmed_write(other);
    const off_t size = lseek(fd, 0, SEEK_END);
    for (int k = 0; k < 8; k++) {
        assert_int_equal(ftruncate(fd, size - 1 - size / 8 * k), 0);
        assert_refused(render, fd, GLINT_E_SYNTAX, "");
    }
    finish(render);
    filmed_assert_same(render, twin);
    close(fd);
    glint_render_destroy(&render);
    glint_render_destroy(&other);
    glint_render_destroy(&twin);
}

// Samples of a range are those that a whole run takes there: together they have its rays.
static void ranges_together_take_the_samples_of_a_whole_run(void **state)
{
    (void)state;
    static const char *const range[] = {"'sample_range':[0,5],", "'sample_range':[5,6],",
                                        "'sample_range':[6,17],", "'sample_range':[17,24],"};
    glint_render *twin = whole(STOP);
    struct glint_render_state all, part;
    uint64_t camera = 0, bounce = 0, shadow = 0;
    for (size_t i = 0; i < sizeof range / sizeof *range; i++) {
        glint_render *render = whole(range[i]);
        glint_render_state(render, &part);
        camera += part.camera_rays;
        bounce += part.bounce_rays;
        shadow += part.shadow_rays;
        assert_false(glint_render_extend(render, 100, 0));
        glint_render_destroy(&render);
    }
    glint_render_state(twin, &all);
    assert_true(camera == all.camera_rays && bounce == all.bounce_rays &&
                shadow == all.shadow_rays);
    glint_render_destroy(&twin);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(film_of_any_moment_goes_on_to_the_same_bytes),
        cmocka_unit_test(coverage_through_bounces_goes_on_to_the_same_bytes),
        cmocka_unit_test(exact_coverage_goes_on_to_the_same_bytes),
        cmocka_unit_test(render_may_be_restored_again_and_again),
        cmocka_unit_test(decision_to_stop_by_error_is_the_same),
        cmocka_unit_test(file_answers_for_a_render_that_has_ended),
        cmocka_unit_test(more_samples_go_on_where_the_film_ends),
        cmocka_unit_test(ended_film_goes_on_once_its_job_wants_more),
        cmocka_unit_test(film_of_another_job_is_refused),
        cmocka_unit_test(film_of_another_revision_is_refused),
        cmocka_unit_test(render_that_was_offered_a_torn_film_begins_anew),
        cmocka_unit_test(ranges_together_take_the_samples_of_a_whole_run),
    };
    return cmocka_run_group_tests(tests, filmed_start, filmed_stop);
}
