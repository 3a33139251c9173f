// Films of parts of a job add up to the film of all: the same frame, bit for bit.
#include "protocol/exr.h"
#include "protocol/film_merge.h"
#include "tests/render/filmed.h"

#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#define MAX_PARTS 8
#define ALL UINT32_MAX // slices: until it is complete

struct parts {
    struct glint_film_part part[MAX_PARTS];
    size_t count;
};

static void add_part(struct parts *p, const char *members, uint32_t slices)
{
    static const char *const name[MAX_PARTS] = {"A", "B", "C", "D", "E", "F", "G", "H"};
    glint_render *render = filmed_render(&offline_crew, &filmed, members);
    glint_film_file *file;
    filmed_run(&offline_crew, render, slices);
    const int fd = filmed_write(render);
    assert_int_equal(glint_film_file_open(&file, fd, NULL), GLINT_OK);
    close(fd);
    glint_render_destroy(&render);
    p->part[p->count] = (struct glint_film_part){file, name[p->count]};
    p->count++;
}

static struct parts make_parts(const char *const *members, size_t count)
{
    struct parts p = {.count = 0};
    for (size_t i = 0; i < count; i++)
        add_part(&p, members[i], ALL);
    return p;
}

static void drop_parts(struct parts *p)
{
    for (size_t i = 0; i < p->count; i++) {
        glint_film_file *file = (glint_film_file *)p->part[i].file;
        glint_film_file_close(&file);
    }
}

static uint8_t *exr_of(const glint_film_sum *sum, size_t *size)
{
    const struct glint_film_source *source = glint_film_sum_source(sum);
    const struct glint_exr_options options = {.compression = GLINT_EXR_ZIP, .zip_level = 1};
    const struct glint_job *job = source->info->job;
    struct glint_frame *frame;
    uint8_t *bytes;
    assert_int_equal(glint_film_frame(source, job->region, job->outputs, &frame, NULL, NULL),
                     GLINT_OK);
    assert_int_equal(glint_exr_write(frame, &options, &bytes, size, NULL, NULL), GLINT_OK);
    glint_frame_destroy(&frame);
    return bytes;
}

// The parts, merged, make the frame of a run of `members`.
static void check_merged(const struct parts *p, const char *members)
{
    glint_render *twin = filmed_render(&offline_crew, &filmed, members);
    struct glint_error err = {0};
    glint_film_sum *sum;
    size_t n, m;
    filmed_run(&offline_crew, twin, ALL);
    if (glint_film_merge(&sum, p->part, p->count, false, &err))
        offline_die("merge", &err);
    uint8_t *a = exr_of(sum, &n), *b = filmed_exr(twin, twin->job.outputs, &m);
    assert_true(n == m && memcmp(a, b, n) == 0);
    const char *const *warning;
    assert_int_equal(glint_film_sum_warnings(sum, &warning), 0);
    free(a);
    free(b);
    glint_film_sum_destroy(&sum);
    glint_render_destroy(&twin);
}

static void check_split(const char *const *members, size_t count, const char *whole)
{
    struct parts p = make_parts(members, count);
    check_merged(&p, whole);
    for (size_t i = 0; i < p.count / 2; i++) { // in any order
        const struct glint_film_part other = p.part[i];
        p.part[i] = p.part[p.count - 1 - i];
        p.part[p.count - 1 - i] = other;
    }
    check_merged(&p, whole);
    drop_parts(&p);
}

#define STOP "'stop':{'samples':20},"

static void regions_make_one_frame(void **state)
{
    (void)state;
    static const char *const two[] = {STOP "'region':[0,0,37,64],", STOP "'region':[37,0,63,64],"};
    static const char *const three[] = {STOP "'region':[5,3,80,7],", STOP "'region':[5,10,1,50],",
                                        STOP "'region':[6,10,79,50],"};
    check_split(two, 2, STOP);
    check_split(three, 3, STOP "'region':[5,3,80,57],");
}

static void odd_sample_ranges_make_one_frame(void **state)
{
    (void)state;
    static const char *const three[] = {"'sample_range':[0,3],", "'sample_range':[3,14],",
                                        "'sample_range':[14,20],"};
    check_split(three, 3, STOP);
}

static void boxes_of_pixels_and_samples_make_one_frame(void **state)
{
    (void)state;
    static const char *const five[] = {
        "'sample_range':[0,7],'region':[0,0,100,30],",
        "'sample_range':[7,20],'region':[0,0,100,30],",
        "'sample_range':[0,13],'region':[0,30,50,34],",
        "'sample_range':[0,13],'region':[50,30,50,34],",
        "'sample_range':[13,20],'region':[0,30,100,34],",
    };
    check_split(five, 5, STOP);
}

// With slots for all that bounces bring.
static void coverage_through_bounces_makes_one_frame(void **state)
{
    (void)state;
#define THROUGH "'mattes':{'levels':4,'slots':32,'through':'glossy','classes':true},"
    static const char *const three[] = {THROUGH "'sample_range':[0,5],'region':[0,0,70,64],",
                                        THROUGH "'sample_range':[5,12],'region':[0,0,70,64],",
                                        THROUGH "'sample_range':[0,12],'region':[70,0,30,64],"};
    check_split(three, 3, THROUGH "'stop':{'samples':12},");
}

// Three names and the background do not fit into what two films have kept of them.
// With a slot for every name there is, whatever the number that is asked for.
static void exact_coverage_makes_one_frame(void **state)
{
    (void)state;
#define EXACT "'mattes':{'levels':'auto','slots':4,'through':'glossy','eviction':'exact'},"
    static const char *const three[] = {EXACT "'sample_range':[0,5],",
                                        EXACT "'sample_range':[5,6],",
                                        EXACT "'sample_range':[6,12],"};
    check_split(three, 3, EXACT "'stop':{'samples':12},");
}

static void names_that_found_no_slot_are_warned_of(void **state)
{
    (void)state;
#define TIGHT "'mattes':{'levels':'auto','slots':4,'through':'glossy','eviction':'drop'},"
    static const char *const two[] = {TIGHT "'sample_range':[0,5],",
                                      TIGHT "'sample_range':[5,16],"};
    struct parts p = make_parts(two, 2);
    glint_film_sum *sum;
    const char *const *warning;
    assert_int_equal(glint_film_merge(&sum, p.part, p.count, false, NULL), GLINT_OK);
    assert_int_equal(glint_film_sum_warnings(sum, &warning), 1);
    assert_non_null(strstr(warning[0], "slots for coverage were full"));
    glint_film_sum_destroy(&sum);
    drop_parts(&p);
}

// A sum that is a film again: of later samples, of a part, to go on from.
static void sum_is_a_film_that_goes_on(void **state)
{
    (void)state;
    static const char *const two[] = {"'sample_range':[0,9],", "'sample_range':[9,16],"};
    struct parts p = make_parts(two, 2);
    glint_film_sum *sum;
    assert_int_equal(glint_film_merge(&sum, p.part, p.count, false, NULL), GLINT_OK);
    const int fd = filmed_file();
    assert_int_equal(glint_film_sum_write(sum, fd, NULL), GLINT_OK);
    glint_render *render = filmed_render(&offline_crew, &filmed, STOP);
    glint_render *twin = filmed_render(&offline_crew, &filmed, STOP);
    lseek(fd, 0, SEEK_SET);
    assert_int_equal(glint_render_restore(render, fd, NULL), GLINT_OK);
    close(fd);
    filmed_run(&offline_crew, render, ALL);
    filmed_run(&offline_crew, twin, ALL);
    size_t n, m;
    uint8_t *a = filmed_exr(render, render->job.outputs, &n);
    uint8_t *b = filmed_exr(twin, twin->job.outputs, &m);
    assert_true(n == m && memcmp(a, b, n) == 0);
    free(a);
    free(b);
    glint_render_destroy(&render);
    glint_render_destroy(&twin);
    glint_film_sum_destroy(&sum);
    drop_parts(&p);
}

// Merging is refused with so many faults, the first of which says so.
static void assert_refused(const struct parts *p, size_t faults, const char *first)
{
    struct glint_error err = {0};
    glint_film_sum *sum;
    assert_int_equal(glint_film_merge(&sum, p->part, p->count, false, &err), GLINT_E_RANGE);
    assert_null(sum);
    assert_int_equal(err.count, faults);
    if (!strstr(err.fault[0].detail, first))
        fail_msg("%s", err.fault[0].detail);
    glint_error_finish(&err);
}

static void overlaps_are_refused_each_with_its_pixels_and_samples(void **state)
{
    (void)state;
    static const char *const three[] = {"'sample_range':[0,8],'region':[0,0,60,64],",
                                        "'sample_range':[4,8],'region':[50,10,50,20],",
                                        "'sample_range':[0,8],'region':[40,0,20,64],"};
    struct parts p = make_parts(three, 3);
    assert_refused(&p, 3, "A and B both have samples 4 to 8 of the 10 x 20 pixels at 50, 10");
    drop_parts(&p);
}

static void other_jobs_are_refused_with_every_difference(void **state)
{
    (void)state;
    static const char *const two[] = {STOP "'region':[0,0,50,64],",
                                      STOP "'seed':3,'camera':'side','region':[50,0,50,64],"};
    struct parts p = make_parts(two, 2);
    // The seed, the camera's name, and where it is.
    assert_refused(&p, 3, "of B is not 0");
    drop_parts(&p);
}

static void gaps_are_refused_unless_that_is_wanted(void **state)
{
    (void)state;
    static const char *const two[] = {"'sample_range':[0,4],'region':[0,0,50,64],",
                                      "'sample_range':[4,8],'region':[50,0,50,64],"};
    struct parts p = make_parts(two, 2);
    assert_refused(&p, 1, "6400 of the 100 x 64 pixels at 0, 0 have not all samples from 0 to 8");
    glint_film_sum *sum;
    assert_int_equal(glint_film_merge(&sum, p.part, p.count, true, NULL), GLINT_OK);
    assert_false(glint_film_sum_source(sum)->complete);
    const int fd = filmed_file();
    assert_int_equal(glint_film_sum_write(sum, fd, NULL), GLINT_E_RANGE);
    close(fd);
    // Where there are samples it is what these samples show.
    struct glint_frame *frame, *left;
    const struct glint_film_source *source = glint_film_sum_source(sum);
    const uint32_t rect[4] = {0, 0, 50, 64}, outputs = source->info->job->outputs;
    glint_render *part = filmed_render(&offline_crew, &filmed, two[0]);
    filmed_run(&offline_crew, part, ALL);
    assert_int_equal(glint_film_frame(source, rect, outputs, &frame, NULL, NULL), GLINT_OK);
    assert_int_equal(glint_render_frame(part, outputs, &left, NULL, NULL), GLINT_OK);
    stable_assert_same(frame, left);
    glint_frame_destroy(&frame);
    glint_frame_destroy(&left);
    glint_render_destroy(&part);
    glint_film_sum_destroy(&sum);
    drop_parts(&p);
}

static void film_that_is_not_complete_is_refused_unless_that_is_wanted(void **state)
{
    (void)state;
    struct parts p = {.count = 0};
    add_part(&p, STOP "'region':[0,0,50,64],", 8); // into the pass from 4 to 8
    add_part(&p, STOP "'region':[50,0,50,64],", ALL);
    struct glint_error err = {0};
    glint_film_sum *sum;
    assert_int_equal(glint_film_merge(&sum, p.part, p.count, false, &err), GLINT_E_RANGE);
    assert_non_null(strstr(err.fault[0].detail, "A is not complete: it has 4 of 20 samples"));
    glint_error_finish(&err);
    assert_int_equal(glint_film_merge(&sum, p.part, p.count, true, NULL), GLINT_OK);
    struct glint_frame *frame;
    const struct glint_film_source *source = glint_film_sum_source(sum);
    assert_int_equal(
        glint_film_frame(source, source->info->job->region, GLINT_OUT_SAMPLES, &frame, NULL, NULL),
        GLINT_OK);
    const float *samples = glint_frame_find(frame, "samples.Y");
    for (size_t i = 0; i < 6400; i++)
        assert_true(i % 100 < 50 ? samples[i] == 4 || samples[i] == 8 : samples[i] == 20);
    glint_frame_destroy(&frame);
    glint_film_sum_destroy(&sum);
    drop_parts(&p);
}

static void double_sums_are_merged_with_a_warning_where_samples_were_split(void **state)
{
    (void)state;
    static const char *const two[] = {"'accuracy':{'precision':'float64'},'sample_range':[0,3],",
                                      "'accuracy':{'precision':'float64'},'sample_range':[3,8],"};
    struct parts p = make_parts(two, 2);
    glint_film_sum *sum;
    const char *const *warning;
    assert_int_equal(glint_film_merge(&sum, p.part, p.count, false, NULL), GLINT_OK);
    assert_int_equal(glint_film_sum_warnings(sum, &warning), 1);
    assert_non_null(strstr(warning[0], "double precision"));
    glint_film_sum_destroy(&sum);
    drop_parts(&p);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(regions_make_one_frame),
        cmocka_unit_test(odd_sample_ranges_make_one_frame),
        cmocka_unit_test(boxes_of_pixels_and_samples_make_one_frame),
        cmocka_unit_test(coverage_through_bounces_makes_one_frame),
        cmocka_unit_test(exact_coverage_makes_one_frame),
        cmocka_unit_test(names_that_found_no_slot_are_warned_of),
        cmocka_unit_test(sum_is_a_film_that_goes_on),
        cmocka_unit_test(overlaps_are_refused_each_with_its_pixels_and_samples),
        cmocka_unit_test(other_jobs_are_refused_with_every_difference),
        cmocka_unit_test(gaps_are_refused_unless_that_is_wanted),
        cmocka_unit_test(film_that_is_not_complete_is_refused_unless_that_is_wanted),
        cmocka_unit_test(double_sums_are_merged_with_a_warning_where_samples_were_split),
    };
    return cmocka_run_group_tests(tests, filmed_start, filmed_stop);
}
