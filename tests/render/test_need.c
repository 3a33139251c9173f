// What a job is expected to take of the memory, against what it takes.
#include "jobs/need.h"
#include "kernels/gk_film.h"
#include "kernels/gk_wave.h"
#include "tests/stability/stable.h"

#include <stdlib.h>

static glint_resident *load_ball(void)
{
    char *text = stable_text(
        "{'environment':{'radiance':[1,1,1]},'materials':{'m':{'ior':1}},'meshes':{'b':{'primitive'"
        ":"
        "'sphere'}},'instances':{'b':{'mesh':'b','material':'m'}},'cameras':{'eye':{'yfov':1}}}");
    glint_resident *scene = offline_load_text(&offline_crew, text);
    free(text);
    return scene;
}

static glint_render *render_of(glint_resident *scene, const struct glint_job *job)
{
    struct glint_error err = {0};
    glint_render *render = NULL;
    if (glint_render_create(&render, offline_crew.devices, scene, NULL, job, &err))
        offline_die("render", &err);
    return render;
}

static struct glint_need need_of(const glint_resident *scene, const struct glint_job *job)
{
    struct glint_pose_request request;
    struct glint_need need;
    assert_int_equal(glint_posed_request(&request, glint_resident_scene(scene), job, NULL),
                     GLINT_OK);
    glint_need_estimate(&need, scene, &request, job, 2);
    return need;
}

static void a_film_takes_what_was_expected(void **state)
{
    (void)state;
    glint_resident *scene = load_ball();
    struct glint_job *job =
        offline_job("{\"scene\":\"s\",\"resolution\":[100,50],\"outputs\":[\"beauty\",\"depth\"]}");
    const struct glint_need need = need_of(scene, job);
    glint_render *render = render_of(scene, job);
    const glint_film *film = render->film;
    const uint64_t tiles = (uint64_t)glint_film_columns(film) * glint_film_rows(film);
    assert_int_equal(tiles, 7 * 4);
    assert_int_equal(need.film,
                     tiles * glint_film_tile_bytes(film) + glint_render_wave_bytes(scene, job, 2));
    glint_render_destroy(&render);
    glint_job_destroy(&job);
    glint_resident_release(&scene);
}

static uint64_t scene_need(const glint_resident *scene, const char *text)
{
    struct glint_job *job = offline_job(text);
    const struct glint_need need = need_of(scene, job);
    glint_job_destroy(&job);
    return need.scene;
}

static uint64_t structures(const glint_resident *scene)
{
    struct glint_resident_stats s;
    glint_resident_stats(scene, &s);
    return s.bvh_bytes;
}

// A scene is loaded with the structure that most jobs trace; others are made for the first that does.
static void a_structure_is_needed_by_who_makes_it(void **state)
{
    static const char *const text[] = {
        "{\"scene\":\"s\",\"resolution\":[16,16],\"accuracy\":{\"traversal\":\"robust\"}}",
        "{\"scene\":\"s\",\"resolution\":[16,16],\"live\":true}"};
    (void)state;
    glint_resident *scene = load_ball();
    assert_int_equal(scene_need(scene, "{\"scene\":\"s\",\"resolution\":[16,16]}"), 0);
    for (size_t i = 0; i < sizeof text / sizeof *text; i++) {
        const uint64_t before = structures(scene), need = scene_need(scene, text[i]);
        struct glint_job *job = offline_job(text[i]);
        glint_render *render = render_of(scene, job);
        assert_true(structures(scene) > before);
        assert_true(need >= structures(scene) - before);
        assert_int_equal(scene_need(scene, text[i]), 0);
        glint_render_destroy(&render);
        glint_job_destroy(&job);
    }
    glint_resident_release(&scene);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_film_takes_what_was_expected),
        cmocka_unit_test(a_structure_is_needed_by_who_makes_it),
    };
    return cmocka_run_group_tests(tests, offline_crew_start, offline_crew_finish);
}
