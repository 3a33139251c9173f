// The size of work-groups is a matter of speed alone. Linked with --wrap=glint_launch.
#include "tests/stability/stable.h"

#include <stdlib.h>

static size_t group; // 0: as asked

glint_status __real_glint_launch(glint_worker *worker, glint_program *program, const char *kernel,
                                 size_t global, size_t local, const struct glint_arg *args,
                                 size_t count, struct glint_error *err);
glint_status __wrap_glint_launch(glint_worker *worker, glint_program *program, const char *kernel,
                                 size_t global, size_t local, const struct glint_arg *args,
                                 size_t count, struct glint_error *err);

glint_status __wrap_glint_launch(glint_worker *worker, glint_program *program, const char *kernel,
                                 size_t global, size_t local, const struct glint_arg *args,
                                 size_t count, struct glint_error *err)
{
    return __real_glint_launch(worker, program, kernel, global, group ? group : local, args, count,
                               err);
}

// Glass, metal, a lamp, and mattes through bounces in full tables.
static struct glint_frame *still_life(size_t size)
{
    group = size;
    return stable_frame(
        &offline_crew,
        stable_text("{'environment':{'radiance':[0.2,0.3,0.4]},'materials':{"
                    "'glass':{'transmission':1,'roughness':0.1},"
                    "'gold':{'base_color':[1,0.8,0.3],'metallic':1,'roughness':0.3},"
                    "'lamp':{'emission':[9,9,9]}},'objects':{'a':{},'b':{},'c':{}},"
                    "'meshes':{'s':{'primitive':'sphere','segments':24}},'instances':{"
                    "'a':{'mesh':'s','material':'glass','object':'a'},"
                    "'b':{'mesh':'s','material':'gold','object':'b','transform':{'translation':"
                    "[1,0,-2]}},"
                    "'c':{'mesh':'s','material':'lamp','object':'c','transform':{'translation':"
                    "[-2,1,-2]}}},"
                    "'cameras':{'eye':{'yfov':0.7,'transform':{'translation':[0,0,5]}}}}"),
        stable_text("{'scene':'s','outputs':['beauty','normal','crypto_object'],"
                    "'resolution':[40,40],'mattes':{'levels':2,'slots':4,'through':'glossy',"
                    "'classes':true},'stop':{'samples':24}}"));
}

static void pictures_do_not_depend_on_the_size_of_work_groups(void **state)
{
    (void)state;
    struct glint_frame *usual = still_life(0), *small = still_life(8);
    stable_assert_same(usual, small);
    glint_frame_destroy(&usual);
    glint_frame_destroy(&small);
}

// Many triangles and instances, of which a scene of three has none: rows that a path of this one would
// read beyond the end of that one's tables.
static struct glint_frame *crowd(void)
{
    return stable_frame(
        &offline_crew,
        stable_text("{'environment':{'radiance':[1,1,1]},'materials':{'grey':{'base_color':"
                    "[0.5,0.5,0.5]},'lamp':{'emission':[9,9,9]}},"
                    "'meshes':{'s':{'primitive':'sphere','segments':128}},'instances':{"
                    "'a':{'mesh':'s','material':'grey'},'b':{'mesh':'s','material':'lamp',"
                    "'transform':{'translation':[1,0,-2]}}},"
                    "'cameras':{'eye':{'yfov':0.7,'transform':{'translation':[0,0,5]}}}}"),
        stable_text("{'scene':'s','outputs':['beauty'],'resolution':[64,64],"
                    "'stop':{'samples':16}}"));
}

// A group is filled up with copies of a path whose light goes to nobody. Every path brings
// at most 1 where a body is white and convex: light that counted twice would be seen.
static void what_fills_the_last_group_leaves_nothing_behind(void **state)
{
    (void)state;
    struct glint_frame *before = crowd();
    struct glint_frame *f = stable_frame(
        &offline_crew,
        stable_text(
            "{'environment':{'radiance':[1,1,1]},'materials':{'white':{'base_color':[1,1,1],"
            "'roughness':1,'specular':0}},'meshes':{'s':{'primitive':'sphere','segments':9}},"
            "'instances':{'a':{'mesh':'s','material':'white'}},"
            "'cameras':{'eye':{'yfov':0.7,'transform':{'translation':[0,0,5]}}}}"),
        stable_text("{'scene':'s','outputs':['beauty'],'resolution':[37,41],"
                    "'stop':{'samples':16}}"));
    assert_true(stable_most(f, "R") < 1.01);
    glint_frame_destroy(&before);
    glint_frame_destroy(&f);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(pictures_do_not_depend_on_the_size_of_work_groups),
        cmocka_unit_test(what_fills_the_last_group_leaves_nothing_behind),
    };
    return cmocka_run_group_tests(tests, offline_crew_start, offline_crew_finish);
}
