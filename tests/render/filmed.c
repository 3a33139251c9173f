#include "tests/render/filmed.h"

#include "protocol/exr.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <unistd.h>

static const char *const scene_text =
    "{'materials':{'grey':{'base_color':[0.6,0.5,0.4]},'glass':{'transmission':1,'roughness':0.2},"
    "'lamp':{'base_color':[0,0,0],'emission':[5,4,3]}},"
    "'meshes':{'room':{'primitive':'box','size':[4,4,8]},'s':{'primitive':'sphere','segments':%u},"
    "'q':{'primitive':'quad'}},"
    "'instances':{'r':{'mesh':'room','material':'grey'},'s':{'mesh':'s','material':'glass'},"
    "'l':{'mesh':'q','material':'lamp','transform':{'translation':[0,1.9,1],'rotation':[1,0,0,1]}},"
    "'m':{'mesh':'q','material':'grey','node':'n'}},'nodes':{'n':{}},"
    "'animations':{'a':{'channels':{'c':{'node':'n','path':'translation','times':[0,1],"
    "'values':[-1,0,1,1,0.5,1]}}}},'fps':1,"
    "'cameras':{'eye':{'yfov':0.9,'transform':{'translation':[0,0,3.5]}},"
    "'side':{'yfov':0.7,'transform':{'translation':[1,0.5,3.2]}}}}";

struct glint_posed filmed_scene_of(const struct offline *o, uint32_t segments)
{
    char *text = stable_text(scene_text, segments);
    const struct glint_posed scene = offline_load_posed_text(o, text);
    free(text);
    return scene;
}

struct glint_posed filmed_scene(const struct offline *o)
{
    return filmed_scene_of(o, 24);
}

struct glint_posed filmed;

int filmed_start(void **state)
{
    offline_crew_start(state);
    filmed = filmed_scene(&offline_crew);
    return 0;
}

int filmed_stop(void **state)
{
    glint_resident_release(&filmed.resident);
    return offline_crew_finish(state);
}

struct glint_job *filmed_job(const char *members)
{
    char *text = stable_text(
        "{'scene':'s','outputs':['beauty','variance','samples','crypto_object','crypto_material',"
        "'crypto_asset','depth','normal','albedo','motion'],%s%s"
        "'resolution':[100,64],'shutter':[0,0.25],'max_bounces':4}",
        members, strstr(members, "mattes") ? "" : "'mattes':{'levels':4,'slots':8},");
    struct glint_job *job = offline_job(text);
    free(text);
    return job;
}

glint_render *filmed_render(const struct offline *o, const struct glint_posed *scene,
                            const char *members)
{
    struct glint_error err = {0};
    struct glint_job *job = filmed_job(members);
    struct glint_posed posed;
    glint_render *render = NULL;
    if (glint_posed_for(&posed, o->devices, scene, job, &err) ||
        glint_render_create(&render, o->devices, posed.resident, posed.pose, job, &err))
        offline_die("render", &err);
    glint_resident_release(&posed.resident);
    glint_job_destroy(&job);
    return render;
}

uint32_t filmed_run(const struct offline *o, glint_render *render, uint32_t slices)
{
    struct glint_error err = {0};
    struct glint_slice slice;
    uint32_t n = 0;
    while (n < slices && glint_render_take(render, &slice)) {
        if (glint_render_run(render, glint_devices_worker(o->devices, 0), &slice, &err))
            offline_die("slice", &err);
        glint_render_give_back(render, &slice, true);
        n++;
    }
    return n;
}

int filmed_file(void)
{
    const int fd = memfd_create("film", MFD_CLOEXEC);
    assert_true(fd >= 0);
    return fd;
}

int filmed_write(glint_render *render)
{
    struct glint_error err = {0};
    const int fd = filmed_file();
    if (glint_render_film(render, fd, &err))
        offline_die("film", &err);
    assert_int_equal(lseek(fd, 0, SEEK_SET), 0);
    return fd;
}

uint8_t *filmed_exr(glint_render *render, uint32_t outputs, size_t *size)
{
    struct glint_error err = {0};
    struct glint_frame *frame;
    uint8_t *bytes = NULL;
    const struct glint_exr_options options = {.compression = GLINT_EXR_ZIP, .zip_level = 1};
    if (glint_render_frame(render, outputs, &frame, NULL, &err) ||
        glint_exr_write(frame, &options, &bytes, size, NULL, &err))
        offline_die("frame", &err);
    glint_frame_destroy(&frame);
    return bytes;
}

static void same_frames(glint_render *a, glint_render *b)
{
    size_t n, m;
    uint8_t *x = filmed_exr(a, a->job.outputs, &n), *y = filmed_exr(b, a->job.outputs, &m);
    assert_int_equal(n, m);
    assert_memory_equal(x, y, n);
    free(x);
    free(y);
}

static void same_states(glint_render *a, glint_render *b)
{
    struct glint_render_state x, y;
    glint_render_state(a, &x);
    glint_render_state(b, &y);
    assert_int_equal(x.samples, y.samples);
    assert_int_equal(x.target_samples, y.target_samples);
    assert_true(x.progress == y.progress);
    assert_true(x.estimate.error == y.estimate.error ||
                (isnan(x.estimate.error) && isnan(y.estimate.error)));
    assert_int_equal(x.camera_rays, y.camera_rays);
    assert_int_equal(x.bounce_rays, y.bounce_rays);
    assert_int_equal(x.shadow_rays, y.shadow_rays);
    assert_memory_equal(x.count, y.count, sizeof x.count);
    assert_int_equal(glint_render_complete(a), glint_render_complete(b));
}

static void same_curves(glint_render *a, glint_render *b)
{
    struct glint_convergence_point x[GLINT_CURVE_POINTS], y[GLINT_CURVE_POINTS];
    const size_t n = glint_render_convergence(a, x, GLINT_CURVE_POINTS);
    assert_int_equal(n, glint_render_convergence(b, y, GLINT_CURVE_POINTS));
    for (size_t i = 0; i < n; i++) {
        assert_int_equal(x[i].samples, y[i].samples);
        assert_int_equal(x[i].rays, y[i].rays);
        assert_true(x[i].error == y[i].error);
    }
}

void filmed_assert_same(glint_render *a, glint_render *b)
{
    same_states(a, b);
    same_curves(a, b);
    same_frames(a, b);
}
