#include "protocol/job.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cjson/cJSON.h>
#include <cmocka.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

// JSON without the backslashes.
static char *json(const char *quoted)
{
    char *text = strdup(quoted);
    for (char *c = text; *c; c++)
        if (*c == '\'')
            *c = '"';
    return text;
}

static struct glint_job *parse(const char *quoted)
{
    struct glint_error err = {0};
    struct glint_job *job;
    char *text = json(quoted);
    if (glint_job_parse(&job, text, strlen(text), &err))
        fail_msg("%s: %s", err.fault[0].pointer, err.fault[0].detail);
    free(text);
    return job;
}

// Exactly one fault at each pointer ("|" between), whose detail has the words after "=".
static void refuse(const char *quoted, const char *faults)
{
    struct glint_error err = {0};
    struct glint_job *job;
    char *text = json(quoted), *want = strdup(faults), *rest = want;
    assert_int_equal(glint_job_parse(&job, text, strlen(text), &err), GLINT_E_RANGE);
    assert_null(job);
    size_t wanted = 0;
    for (char *p; (p = strsep(&rest, "|")); wanted++) {
        char *words = strchr(p, '=');
        size_t i = 0;
        if (words)
            *words++ = '\0';
        while (i < err.count && strcmp(err.fault[i].pointer, p))
            i++;
        if (i == err.count)
            fail_msg("no fault at %s, but at %s: %s", p, err.fault[0].pointer, err.fault[0].detail);
        if (words && !strstr(err.fault[i].detail, words))
            fail_msg("%s: %s", p, err.fault[i].detail);
    }
    assert_int_equal(err.count, wanted);
    glint_error_finish(&err);
    free(text);
    free(want);
}

static void only_the_scene_is_required(void **state)
{
    (void)state;
    struct glint_job *j = parse("{'scene':'bathroom'}");
    assert_string_equal(j->scene, "bathroom");
    assert_string_equal(j->name, "");
    assert_null(j->camera_name);
    assert_false(j->has_camera);
    assert_true(j->width == 1280 && j->height == 720);
    assert_memory_equal(j->region, ((uint32_t[]){0, 0, 1280, 720}), 16);
    assert_int_equal(j->outputs, GLINT_OUT_BEAUTY | GLINT_OUT_CRYPTO);
    assert_memory_equal(j->dial, glint_preset_table[0].setting, GLINT_DIAL_COUNT);
    assert_true(j->matte_slots == 12 && j->matte_levels == 6);
    assert_true(j->filter == GLINT_FILTER_BLACKMAN_HARRIS && j->filter_width == 1.5f);
    assert_true(j->max_bounces == 8 && j->seed == 0 && j->frame == 0 && j->priority == 0);
    assert_true(j->stop.samples == 256 && j->stop.seconds == 0 && j->stop.error == 0);
    glint_job_destroy(&j);
    assert_null(j);
    refuse("{}", "/scene=required");
    refuse("[]", "=an object");
}

static void three_faults_are_one_error_that_names_all_three(void **state)
{
    (void)state;
    refuse("{'scene':'a','resolution':[0,720],'camera':{'yfov':4},'stop':{'samples':0}}",
           "/resolution/0|/camera/yfov|/stop/samples");
}

static void unknown_members_are_faults_that_say_what_exists(void **state)
{
    (void)state;
    refuse("{'scene':'a','surfels':{'count':1},'poisson':{},'layers':{},'split':{},'smaples':1}",
           "/surfels=max_bounces|/poisson|/layers|/split|/smaples");
    refuse("{'scene':'a','accuracy':{'through':'none','speed':1},'mattes':{'gi':'path','beta':0.1,"
           "'path_list':1},"
           "'filter':{'radius':1},'stop':{'sample':1},'camera':{'yfov':1,'fov':1}}",
           "/accuracy/through=traversal|/accuracy/speed|/mattes/gi|/mattes/beta=eviction|/mattes/"
           "path_list|"
           "/filter/radius=kind, width|/stop/sample|/camera/fov");
}

static void settings_of_methods_that_do_not_exist_are_faults(void **state)
{
    (void)state;
    refuse(
        "{'scene':'a','outputs':['beauty','gi'],"
        "'accuracy':{'preset':'preview','gi':'surfel','transparency':'layered','primary':'split'},"
        "'mattes':{'through':'all','eviction':'all'}}",
        "/outputs/1=crypto_asset|/accuracy/preset=production, reference|"
        "/accuracy/gi=path, none|/accuracy/transparency=traced|/accuracy/primary=full|"
        "/mattes/through=glossy, delta, none|/mattes/eviction=exact, drop, direct_first, uss");
}

static void what_does_not_go_with_mattes_is_a_fault(void **state)
{
    (void)state;
    refuse("{'scene':'a','live':true,'mattes':{'eviction':'exact'}}", "/mattes/eviction=live");
    refuse("{'scene':'a','outputs':['beauty','matte_sums']}", "/outputs=crypto_object");
    refuse("{'scene':'a','mattes':{'path_ids':'all'}}", "/mattes/path_ids=list, previous");
}

static void a_live_job_stops_by_samples_or_seconds(void **state)
{
    (void)state;
    struct glint_job *j = parse("{'scene':'a','live':true,'stop':{'samples':9,'seconds':2}}");
    assert_true(j->live);
    glint_job_destroy(&j);
    j = parse("{'scene':'a','live':false,'stop':{'error':0.1}}");
    assert_false(j->live);
    glint_job_destroy(&j);
    refuse("{'scene':'a','live':true,'stop':{'error':0.1}}", "/stop/error=live");
    refuse("{'scene':'a','live':1}", "/live=boolean");
}

static void time_is_frames_and_the_part_of_them_that_the_shutter_is_open(void **state)
{
    (void)state;
    struct glint_job *j = parse("{'scene':'a'}");
    assert_true(j->fps == 0 && j->shutter[0] == 0 && j->shutter[1] == 0 && !j->animation);
    glint_job_destroy(&j);
    j = parse("{'scene':'a','frame':7,'fps':30,'shutter':[-0.25,0.5],'animation':'walk','outputs':"
              "['motion']}");
    assert_true(j->frame == 7 && j->fps == 30 && j->shutter[0] == -0.25f && j->shutter[1] == 0.5f);
    assert_string_equal(j->animation, "walk");
    assert_int_equal(j->outputs, GLINT_OUT_MOTION);
    glint_job_destroy(&j);
    j = parse("{'scene':'a','fps':0.01,'shutter':[2,2]}");
    assert_true(j->fps == 0.01f && j->shutter[0] == 2);
    glint_job_destroy(&j);
    refuse("{'scene':'a','fps':0.005,'shutter':[0.5,0.25],'animation':4}",
           "/fps=neither|/shutter=opens at 0.5|/animation=string");
    refuse("{'scene':'a','fps':-1,'shutter':[-17,16.5]}", "/fps|/shutter/0|/shutter/1");
    refuse("{'scene':'a','fps':1001,'shutter':0.5}", "/fps|/shutter=array");
    refuse("{'scene':'a','shutter':[0]}", "/shutter=2 numbers");
}

static void a_preset_sets_the_dials_and_explicit_ones_override_it(void **state)
{
    (void)state;
    struct glint_job *j =
        parse("{'scene':'a','accuracy':{'gi':'none','lights':'power','preset':'reference'},"
              "'mattes':{'eviction':'direct_first'}}");
    for (int d = 0; d < GLINT_DIAL_COUNT; d++)
        if (strcmp(glint_dial_table[d].parent, "accuracy") == 0)
            assert_int_equal(j->dial[d], d == GLINT_DIAL_GI || d == GLINT_DIAL_LIGHTS);
    assert_int_equal(j->dial[GLINT_DIAL_EVICTION], GLINT_EVICTION_DIRECT_FIRST);
    assert_int_equal(j->dial[GLINT_DIAL_THROUGH], GLINT_THROUGH_NONE);
    glint_job_destroy(&j);
}

static void a_stop_without_samples_imposes_none(void **state)
{
    (void)state;
    struct glint_job *j = parse("{'scene':'a','stop':{'seconds':2.5,'error':0.01}}");
    assert_int_equal(j->stop.samples, GLINT_MAX_SAMPLES);
    assert_true(j->stop.seconds == 2.5 && j->stop.error == 0.01);
    glint_job_destroy(&j);
    refuse("{'scene':'a','stop':{'samples':16777217,'seconds':0,'error':-1}}",
           "/stop/samples|/stop/seconds|/stop/error");
    refuse("{'scene':'a','stop':256}", "/stop=an object");
}

static void the_region_lies_inside_the_resolution(void **state)
{
    (void)state;
    struct glint_job *j = parse("{'scene':'a','resolution':[100,50],'region':[99,0,1,50]}");
    assert_memory_equal(j->region, ((uint32_t[]){99, 0, 1, 50}), 16);
    glint_job_destroy(&j);
    refuse("{'scene':'a','resolution':[100,50],'region':[99,0,2,50]}", "/region");
    refuse("{'scene':'a','resolution':[100,50],'region':[0,0,0,50]}", "/region");
    refuse("{'scene':'a','resolution':[100,50],'region':[0,0,-1,50]}", "/region/2");
    refuse("{'scene':'a','resolution':[16385,50],'region':[0,0,16000,16000]}", "/resolution/0");
    refuse("{'scene':'a','resolution':[100.5,50]}", "/resolution/0=integer");
    refuse("{'scene':'a','resolution':[100]}", "/resolution=2 numbers");
}

static void a_sample_range_says_which_samples_and_how_many(void **state)
{
    (void)state;
    struct glint_job *j = parse("{'scene':'a','sample_range':[5,21],'stop':{'seconds':9}}");
    assert_true(j->sample_range[0] == 5 && j->sample_range[1] == 21);
    assert_int_equal(j->stop.samples, 16);
    assert_true(j->stop.seconds == 9);
    glint_job_destroy(&j);
    j = parse("{'scene':'a'}");
    assert_true(j->sample_range[0] == 0 && j->sample_range[1] == 0);
    glint_job_destroy(&j);
    refuse("{'scene':'a','sample_range':[8,8]}", "/sample_range=from 8 to 8");
    refuse("{'scene':'a','sample_range':[0,16777217]}", "/sample_range/1");
    refuse("{'scene':'a','sample_range':[1]}", "/sample_range");
    refuse("{'scene':'a','sample_range':[0,4],'stop':{'samples':4,'error':0.1}}",
           "/stop/samples|/stop/error=sample range");
    refuse("{'scene':'a','sample_range':[0,4],'live':true}", "/live");
}

static void a_copy_is_an_equal_job_of_its_own(void **state)
{
    (void)state;
    struct glint_job *j = parse("{'scene':'a','name':'n','camera':'c','animation':'x'}"), copy;
    assert_int_equal(glint_job_copy(&copy, j, NULL), GLINT_OK);
    char *was = glint_job_write(j);
    glint_job_destroy(&j);
    char *is = glint_job_write(&copy);
    assert_string_equal(is, was);
    free(was);
    free(is);
    glint_arena_finish(&copy.arena);
}

static void slots_are_even_and_twice_the_levels(void **state)
{
    (void)state;
    struct glint_job *j = parse("{'scene':'a','mattes':{'levels':9}}");
    assert_int_equal(j->matte_slots, 18);
    glint_job_destroy(&j);
    j = parse("{'scene':'a','mattes':{'levels':2,'slots':4}}");
    assert_int_equal(j->matte_slots, 4);
    glint_job_destroy(&j);
    refuse("{'scene':'a','mattes':{'levels':3,'slots':4}}", "/mattes/slots=at least 6");
    refuse("{'scene':'a','mattes':{'slots':13}}", "/mattes/slots=even");
    refuse("{'scene':'a','mattes':{'levels':17}}", "/mattes/levels");
    refuse("{'scene':'a','mattes':{'levels':21,'slots':34}}", "/mattes/levels|/mattes/slots");
}

static void levels_may_be_as_many_as_it_takes(void **state)
{
    (void)state;
    struct glint_job *j = parse("{'scene':'a','mattes':{'levels':'auto'}}");
    assert_true(j->matte_levels == 0 && j->matte_slots == 32);
    char *text = glint_job_write(j);
    assert_non_null(strstr(text, "\"slots\":32,\"levels\":\"auto\","));
    free(text);
    glint_job_destroy(&j);
    j = parse("{'scene':'a','mattes':{'levels':'auto','slots':4}}");
    assert_int_equal(j->matte_slots, 4);
    glint_job_destroy(&j);
    refuse("{'scene':'a','mattes':{'levels':'all'}}", "/mattes/levels=auto");
    refuse("{'scene':'a','mattes':{'levels':0}}", "/mattes/levels");
    refuse("{'scene':'a','mattes':{'levels':true}}", "/mattes/levels");
    refuse("{'scene':'a','mattes':{'levels':'auto','slots':13}}", "/mattes/slots=even");
}

static void a_filter_has_the_width_of_its_kind_by_default(void **state)
{
    (void)state;
    struct glint_job *j = parse("{'scene':'a','filter':{'kind':'box'}}");
    assert_true(j->filter == GLINT_FILTER_BOX && j->filter_width == 1);
    glint_job_destroy(&j);
    j = parse("{'scene':'a','filter':{'width':2}}");
    assert_true(j->filter == GLINT_FILTER_BLACKMAN_HARRIS && j->filter_width == 2);
    glint_job_destroy(&j);
    refuse("{'scene':'a','filter':{'kind':'gauss','width':17}}", "/filter/kind=box|/filter/width");
}

static void a_camera_is_a_name_or_an_object(void **state)
{
    (void)state;
    struct glint_job *j = parse("{'scene':'a','camera':'Camera.001'}");
    assert_string_equal(j->camera_name, "Camera.001");
    glint_job_destroy(&j);
    j = parse("{'scene':'a','camera':{'yfov':0.5,'transform':{'translation':[1,2,3]}}}");
    assert_true(j->has_camera && j->camera.yfov == 0.5f && j->camera.transform[13] == 2);
    assert_null(j->camera_name);
    glint_job_destroy(&j);
    refuse("{'scene':'a','camera':7}", "/camera");
    refuse("{'scene':'a','camera':{}}", "/camera/yfov=required");
    j = parse("{'scene':'a','camera':{'projection':'orthographic','ymag':2.5}}");
    assert_true(j->camera.projection == GLINT_ORTHOGRAPHIC && j->camera.ymag == 2.5f);
    assert_int_equal(j->camera.node, GLINT_NONE);
    glint_job_destroy(&j);
    refuse("{'scene':'a','camera':{'projection':'orthographic','yfov':1,'ymag':0}}",
           "/camera/ymag");
    refuse("{'scene':'a','camera':{'projection':'orthographic'}}", "/camera/ymag=required");
    refuse("{'scene':'a','camera':{'projection':'fisheye','yfov':1,'node':'n'}}",
           "/camera/projection=orthographic|/camera/node=world");
}

static void names_and_numbers_have_their_limits(void **state)
{
    (void)state;
    refuse("{'scene':'a/b'}", "/scene");
    refuse("{'scene':''}", "/scene");
    refuse("{'scene':7}", "/scene");
    refuse("{'scene':'a','max_bounces':1025,'seed':-1,'priority':101,'frame':1.5,'name':null}",
           "/max_bounces|/seed|/priority|/frame|/name");
    refuse("{'scene':'a','outputs':[]}", "/outputs");
    refuse("{'scene':'a','adaptive':true,'live':true}", "/adaptive=live");
    refuse("{'scene':'a','adaptive':true,'stop':{'samples':63}}", "/adaptive=at least 64");
    refuse("{'scene':'a','adaptive':true,'sample_range':[0,64]}", "/adaptive=range");
    refuse("{'scene':'a','estimate':'none','outputs':['variance'],'adaptive':true,"
           "'accuracy':{'error':0.1},'stop':{'samples':64,'error':0.1}}",
           "/stop/error|/accuracy/error|/adaptive|/outputs=noise");
    refuse("{'scene':'a','outputs':['depth','depth']}", "/outputs/1=twice");
    refuse("{'scene':'a','scene':'b'}", "/scene=more than once");
}

static void outputs_have_names_both_ways(void **state)
{
    (void)state;
    uint32_t all = 0;
    for (int bit = 0; bit < 32; bit++)
        if (glint_output_name(1u << bit)) {
            assert_int_equal(glint_output_from_name(glint_output_name(1u << bit)), 1u << bit);
            all |= 1u << bit;
        }
    assert_int_equal(all, (GLINT_OUT_MATTE_SUMS << 1) - 1);
    assert_int_equal(glint_output_from_name("gi"), 0);
    assert_null(glint_output_name(3));
}

static void assert_same(const struct glint_job *a, const struct glint_job *b)
{
    assert_string_equal(a->scene, b->scene);
    assert_string_equal(a->name, b->name);
    assert_int_equal(!a->camera_name, !b->camera_name);
    if (a->camera_name)
        assert_string_equal(a->camera_name, b->camera_name);
    assert_int_equal(a->has_camera, b->has_camera);
    assert_memory_equal(a->camera.transform, b->camera.transform, sizeof a->camera.transform);
    assert_true(a->camera.yfov == b->camera.yfov && a->camera.lens_radius == b->camera.lens_radius);
    assert_true(a->camera.focus_distance == b->camera.focus_distance);
    assert_true(a->camera.projection == b->camera.projection && a->camera.ymag == b->camera.ymag);
    assert_true(a->fps == b->fps && a->live == b->live);
    assert_memory_equal(a->shutter, b->shutter, sizeof a->shutter);
    assert_int_equal(!a->animation, !b->animation);
    if (a->animation)
        assert_string_equal(a->animation, b->animation);
    assert_true(a->width == b->width && a->height == b->height && a->outputs == b->outputs);
    assert_memory_equal(a->region, b->region, sizeof a->region);
    assert_memory_equal(a->sample_range, b->sample_range, sizeof a->sample_range);
    assert_memory_equal(a->dial, b->dial, sizeof a->dial);
    assert_true(a->matte_slots == b->matte_slots && a->matte_levels == b->matte_levels);
    assert_true(a->filter == b->filter && a->filter_width == b->filter_width);
    assert_true(a->estimate == b->estimate && a->adaptive == b->adaptive);
    assert_true(a->max_bounces == b->max_bounces && a->seed == b->seed && a->frame == b->frame);
    assert_true(a->stop.samples == b->stop.samples && a->stop.seconds == b->stop.seconds);
    assert_true(a->stop.error == b->stop.error && a->priority == b->priority);
}

static void parsing_what_was_written_gives_an_equal_job(void **state)
{
    (void)state;
    static const char named_camera[] =
        "{'scene':'s-1.2_3','name':'shot \\u00e4 "
        "\\n','camera':'Cam','resolution':[33,7],'region':[1,2,3,4],"
        "'frame':1001,'outputs':['variance','depth'],'accuracy':{'preset':'reference','gi':'none'},"
        "'mattes':{'eviction':'direct_first','slots':32,'levels':16,'through':'glossy','alpha':0.3,"
        "'clamp':false,'diffuse_cut':false,'env_id':false,'classes':true,'cone_width':1920,"
        "'variance':'eq3',"
        "'coverage':'opaque_full'},'filter':{'kind':'box','width':0.7},"
        "'estimate':'batches','max_bounces':0,'seed':4294967295,'stop':{'samples':3,'seconds':0.1,'"
        "error':1e-3},'"
        "priority':-100}";
    static const char own_camera[] =
        "{'scene':'a','camera':{'name':'c','yfov':0.7,'lens_radius':0.1,'focus_distance':3,"
        "'transform':{'rotation':[0.1,0.2,0.3,0.9],'translation':[0.1,0.2,0.3]}}}";
    static const char moving[] =
        "{'scene':'a','frame':3,'fps':23.976,'shutter':[-0.1,0.4],'animation':'none','live':true,"
        "'outputs':['motion','beauty'],'camera':{'projection':'orthographic','ymag':0.3}}";
    static const char *const jobs[] = {"{'scene':'a'}",
                                       "{'scene':'a','stop':{}}",
                                       named_camera,
                                       own_camera,
                                       moving,
                                       "{'scene':'a','sample_range':[3,77]}",
                                       "{'scene':'a','mattes':{'levels':'auto','slots':20}}"};
    for (size_t i = 0; i < sizeof jobs / sizeof *jobs; i++) {
        struct glint_job *a = parse(jobs[i]), *b;
        char *text = glint_job_write(a);
        assert_null(strchr(text, '\n'));
        struct glint_error err = {0};
        if (glint_job_parse(&b, text, strlen(text), &err))
            fail_msg("%s: %s in %s", err.fault[0].pointer, err.fault[0].detail, text);
        assert_same(a, b);
        char *again = glint_job_write(b);
        assert_string_equal(again, text);
        free(again);
        free(text);
        glint_job_destroy(&a);
        glint_job_destroy(&b);
    }
}

// "name":"setting" of the dials of a parent, as the first preset has them.
static void add_dials(char *text, size_t size, const char *parent)
{
    for (int d = 0; d < GLINT_DIAL_COUNT; d++) {
        const struct glint_dial_row *row = &glint_dial_table[d];
        const size_t n = strlen(text);
        if (strcmp(row->parent, parent) == 0)
            snprintf(text + n, size - n, "%s\"%s\":\"%s\"", text[n - 1] == '{' ? "" : ",",
                     row->name, row->setting[glint_preset_table[0].setting[d]]);
    }
}

static void add(char *text, size_t size, const char *more)
{
    const size_t n = strlen(text);
    snprintf(text + n, size - n, "%s", more);
}

static void defaults_that_are_spelled_out_give_an_equal_job(void **state)
{
    (void)state;
    struct glint_job *a = parse("{'scene':'a'}");
    char *text = glint_job_write(a), want[2048] = "";
    add(want, sizeof want,
        "{\"scene\":\"a\",\"name\":\"\",\"frame\":0,\"fps\":0,\"shutter\":[0,0],"
        "\"live\":false,\"adaptive\":false,\"estimate\":\"halves\",\"max_bounces\":8,\"seed\":0,"
        "\"priority\":0,"
        "\"resolution\":[1280,720],\"region\":[0,0,1280,720],"
        "\"outputs\":[\"beauty\",\"crypto_object\",\"crypto_material\",\"crypto_asset\"],"
        "\"accuracy\":{");
    add_dials(want, sizeof want, "accuracy");
    add(want, sizeof want,
        "},\"mattes\":{\"slots\":12,\"levels\":6,\"alpha\":0.1,\"clamp\":true,"
        "\"diffuse_cut\":true,\"env_id\":true,\"classes\":false,\"depth_bins\":0,"
        "\"cone_width\":0");
    add_dials(want, sizeof want, "mattes");
    add(want, sizeof want,
        "},\"filter\":{\"kind\":\"blackman_harris\",\"width\":1.5},\"stop\":{\"samples\":256}}");
    assert_string_equal(text, want);
    free(text);
    glint_job_destroy(&a);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(only_the_scene_is_required),
        cmocka_unit_test(three_faults_are_one_error_that_names_all_three),
        cmocka_unit_test(unknown_members_are_faults_that_say_what_exists),
        cmocka_unit_test(settings_of_methods_that_do_not_exist_are_faults),
        cmocka_unit_test(what_does_not_go_with_mattes_is_a_fault),
        cmocka_unit_test(a_live_job_stops_by_samples_or_seconds),
        cmocka_unit_test(time_is_frames_and_the_part_of_them_that_the_shutter_is_open),
        cmocka_unit_test(a_preset_sets_the_dials_and_explicit_ones_override_it),
        cmocka_unit_test(a_stop_without_samples_imposes_none),
        cmocka_unit_test(the_region_lies_inside_the_resolution),
        cmocka_unit_test(a_sample_range_says_which_samples_and_how_many),
        cmocka_unit_test(a_copy_is_an_equal_job_of_its_own),
        cmocka_unit_test(slots_are_even_and_twice_the_levels),
        cmocka_unit_test(levels_may_be_as_many_as_it_takes),
        cmocka_unit_test(a_filter_has_the_width_of_its_kind_by_default),
        cmocka_unit_test(a_camera_is_a_name_or_an_object),
        cmocka_unit_test(names_and_numbers_have_their_limits),
        cmocka_unit_test(outputs_have_names_both_ways),
        cmocka_unit_test(parsing_what_was_written_gives_an_equal_job),
        cmocka_unit_test(defaults_that_are_spelled_out_give_an_equal_job),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
