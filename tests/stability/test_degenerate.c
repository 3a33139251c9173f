// Scenes of almost nothing and scenes that are wrong: an answer or a named fault, and no trace of it
// in the next picture.
#include "tests/stability/stable.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <sys/wait.h>
#include <unistd.h>

static struct offline o;

// ---- almost nothing

static struct glint_frame *tiny(const char *scene, const char *job)
{
    return stable_frame(&o, stable_text("%s", scene), stable_job(job));
}

static void assert_shows(struct glint_frame *f, double radiance, double coverage)
{
    assert_float_equal(stable_least(f, "G"), radiance, 1e-6);
    assert_float_equal(stable_most(f, "G"), radiance, 1e-6);
    assert_float_equal(stable_least(f, "A"), coverage, 0.0);
    glint_frame_destroy(&f);
}

static void scene_of_nothing_shows_its_environment(void **state)
{
    (void)state;
    const char *const job = "'resolution':[17,3],'stop':{'samples':1}";
    assert_shows(tiny("{}", job), 1.0, 0.0);
    assert_shows(tiny("{'environment':{'radiance':[0,0,0]}}", job), 0.0, 0.0);
    assert_shows(tiny("{'environment':{'radiance':[2,3,4]},'cameras':{'c':{'yfov':3.1}}}", job),
                 3.0, 0.0);
}

static void mesh_without_a_proper_triangle_shows_nothing(void **state)
{
    (void)state;
    assert_shows(tiny("{'environment':{'radiance':[5,5,5]},'materials':{'m':{'emission':[9,9,9]}},"
                      "'meshes':{'t':{'positions':[0,0,-1,0,0,-1,0,0,-1]}},"
                      "'instances':{'t':{'mesh':'t','material':'m'}},'cameras':{'c':{'yfov':1}}}",
                      "'resolution':[5,5],'stop':{'samples':4}"),
                 5.0, 0.0);
}

#define WALL(material)                                                                   \
    "'materials':{'m':{" material "}},'meshes':{'q':{'primitive':'quad','size':[9,9]}}," \
    "'instances':{'q':{'mesh':'q','material':'m'}},"                                     \
    "'cameras':{'c':{'yfov':0.5,'transform':{'translation':[0,0,2]}}}"

static void scene_without_light_is_black(void **state)
{
    (void)state;
    const char *const job = "'resolution':[9,9],'stop':{'samples':4}";
    assert_shows(tiny("{'environment':{'radiance':[0,0,0]}," WALL("") "}", job), 0.0, 1.0);
    assert_shows(tiny("{'environment':{'radiance':[0,0,0]},'lights':{'p':{'type':'point','"
                      "intensity':0}}," WALL("") "}",
                      job),
                 0.0, 1.0);
    assert_shows(tiny("{'environment':{'radiance':[0,0,0]},'lights':{'p':{'type':'sun','color':[0,"
                      "0,0]}}," WALL("'transmission':1") "}",
                      job),
                 0.0, 1.0);
}

static void one_pixel_and_one_sample_make_a_frame(void **state)
{
    (void)state;
    assert_shows(
        tiny("{'environment':{'radiance':[1,1,1]}," WALL("'base_color':[0.5,0.5,0.5],'ior':1") "}",
             "'resolution':[1,1],'stop':{'samples':1}"),
        0.5, 1.0);
    assert_shows(
        tiny("{'environment':{'radiance':[1,1,1]}," WALL("'base_color':[0.5,0.5,0.5],'ior':1") "}",
             "'resolution':[300,1],'region':[150,0,1,1],'stop':{'samples':1}"),
        0.5, 1.0);
    // No bounce: only what the wall emits.
    assert_shows(
        tiny("{'environment':{'radiance':[1,1,1]}," WALL("'emission':[0.25,0.25,0.25]") "}",
             "'resolution':[4,4],'max_bounces':0,'stop':{'samples':2}"),
        0.25, 1.0);
}

static void job_of_no_samples_is_refused(void **state)
{
    (void)state;
    struct glint_error err = {0};
    struct glint_job *job = NULL;
    char *text = stable_job("'stop':{'samples':0}");
    assert_int_equal(glint_job_parse(&job, text, strlen(text), &err), GLINT_E_RANGE);
    assert_string_equal(err.fault[0].pointer, "/stop/samples");
    assert_null(job);
    glint_error_finish(&err);
    free(text);
}

// ---- wrong scenes, and the next picture

static const struct {
    const char *scene, *pointer;
} wrong[] = {
    {"'meshes':{'t':{'positions':[0,0,0,1e999,0,0,0,1,0]}}", "/meshes/t/positions/3"},
    {"'meshes':{'t':{'positions':[0,0,0,1,0,0,0,1,0],'normals':[0,0,1,0,-1e999,0,0,0,1]}}",
     "/meshes/t/normals/4"},
    {"'meshes':{'t':{'positions':[0,0,0,1,0,0,0,1,0],'uvs':[0,0,0,0,0,1e39]}}", "/meshes/t/uvs/5"},
    {"'meshes':{'t':{'positions':[0,0,0,1,0,0,0,1,0],'indices':[0,1,7]}}", "/meshes/t/indices/2"},
    {"'materials':{'m':{}},'meshes':{'t':{'primitive':'quad'}},'instances':{'i':{'mesh':'t','"
     "material':'m',"
     "'transform':[1,0,0,0,0,1e999,0,0,0,0,1,0,0,0,0,1]}}",
     "/instances/i/transform/5"},
    {"'materials':{'m':{}},'meshes':{'t':{'primitive':'quad'}},'instances':{'i':{'mesh':'t','"
     "material':'m',"
     "'transform':[1,0,0,0,1,0,0,0,0,0,1,0,0,0,0,1]}}",
     "/instances/i/transform"},
    {"'materials':{'m':{'emission':[0,1e999,0]}}", "/materials/m/emission/1"},
    {"'materials':{'m':{'roughness':1e999}}", "/materials/m/roughness"},
    {"'lights':{'l':{'type':'point','intensity':1e999}}", "/lights/l/intensity"},
    {"'lights':{'l':{'type':'sun','transform':{'rotation':[0,0,0,0]}}}",
     "/lights/l/transform/rotation"},
    {"'cameras':{'c':{'yfov':1e999}}", "/cameras/c/yfov"},
    {"'cameras':{'c':{'yfov':1,'transform':{'translation':[0,-1e999,0]}}}",
     "/cameras/c/transform/translation/1"},
    {"'environment':{'radiance':[1,1,1e999]}", "/environment/radiance/2"},
    {"'environment':{'rotation':1e999}", "/environment/rotation"},
    {"'images':{'i':{'data':'data:image/vnd.radiance;base64,AAAA'}}", "/images/i/data"},
};

static void what_is_not_finite_is_a_fault_that_names_the_item(void **state)
{
    (void)state;
    for (size_t i = 0; i < sizeof wrong / sizeof *wrong; i++)
        stable_refused(&o, stable_text("{%s}", wrong[i].scene), wrong[i].pointer);
}

#define PICTURE 24

// A picture with glass, metal, a lamp and a textured sky: its red, green and blue.
static void picture(const struct offline *with, float rgb[3][PICTURE * PICTURE])
{
    float sky[8 * 4 * 3];
    for (int i = 0; i < 8 * 4 * 3; i++)
        sky[i] = 0.25f * (float)(1 + i % 7);
    char *uri = stable_hdr(8, 4, sky);
    struct glint_frame *f = stable_frame(
        with,
        stable_text(
            "{'images':{'s':{'data':'%s'}},'environment':{'image':'s'},"
            "'materials':{'glass':{'transmission':1,'roughness':0.1},'metal':{'metallic':1,'"
            "roughness':0.4},"
            "'lamp':{'emission':[4,3,2]}},'meshes':{'s':{'primitive':'sphere','segments':24}},"
            "'instances':{'a':{'mesh':'s','material':'glass'},"
            "'b':{'mesh':'s','material':'metal','transform':{'translation':[1,0,-2]}},"
            "'c':{'mesh':'s','material':'lamp','transform':{'translation':[-2,1,-2]}}},"
            "'cameras':{'c':{'yfov':0.8,'transform':{'translation':[0,0,5]}}}}",
            uri),
        stable_text("{'scene':'s','outputs':['beauty'],'resolution':[%d,%d],'stop':{'samples':8}}",
                    PICTURE, PICTURE));
    for (int c = 0; c < 3; c++)
        memcpy(rgb[c], glint_frame_find(f, (const char[]){"RGB"[c], 0}), sizeof rgb[c]);
    glint_frame_destroy(&f);
    free(uri);
}

// Rendered by a process that has done nothing else.
static float fresh[3][PICTURE * PICTURE];

static void picture_after_all_those_is_that_of_a_fresh_process(void **state)
{
    (void)state;
    static float now[3][PICTURE * PICTURE];
    what_is_not_finite_is_a_fault_that_names_the_item(NULL);
    picture(&o, now);
    assert_memory_equal(now, fresh, sizeof now);
}

static void render_in_child(int out)
{
    struct offline own;
    offline_start(&own, offline_workers());
    picture(&own, fresh);
    offline_finish(&own);
    _exit(write(out, fresh, sizeof fresh) == (ssize_t)sizeof fresh ? 0 : 1);
}

// Before this process has a device of its own.
static int start(void **state)
{
    (void)state;
    int ends[2], status = 1;
    if (pipe(ends))
        return -1;
    const pid_t child = fork();
    if (child == 0)
        render_in_child(ends[1]);
    close(ends[1]);
    size_t got = 0;
    ssize_t n = 1;
    while (n > 0 && (n = read(ends[0], (char *)fresh + got, sizeof fresh - got)) > 0)
        got += (size_t)n;
    close(ends[0]);
    waitpid(child, &status, 0);
    offline_start(&o, offline_workers());
    return got == sizeof fresh && status == 0 ? 0 : -1;
}

static int finish(void **state)
{
    (void)state;
    offline_finish(&o);
    return 0;
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(scene_of_nothing_shows_its_environment),
        cmocka_unit_test(mesh_without_a_proper_triangle_shows_nothing),
        cmocka_unit_test(scene_without_light_is_black),
        cmocka_unit_test(one_pixel_and_one_sample_make_a_frame),
        cmocka_unit_test(job_of_no_samples_is_refused),
        cmocka_unit_test(what_is_not_finite_is_a_fault_that_names_the_item),
        cmocka_unit_test(picture_after_all_those_is_that_of_a_fresh_process),
    };
    return cmocka_run_group_tests(tests, start, finish);
}
