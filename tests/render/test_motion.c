// Motion blur: what an open shutter shows is the mean of the moments that it is open for.
#include "tests/render/moving.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static struct offline o;

#define SIDE 64
#define STILLS 64
#define BLOCK 8

static const char *const colour[3] = {"R", "G", "B"};
static const char *const variance[3] = {"variance.R", "variance.G", "variance.B"};

static struct glint_frame *frame_at(const struct glint_posed *scene, double open, double close,
                                    int samples, int seed)
{
    char *job = moving_job(open, close, SIDE, samples, seed);
    struct glint_frame *f = offline_frame_posed(&o, scene, job, 0);
    free(job);
    return f;
}

// Of one pixel and channel over the stills.
struct pixel {
    double mean, variance;
    double halves; // mean of one half of the stills less that of the other
};

static void add_still(struct pixel *to, const struct glint_frame *f, int channel, int index)
{
    const float *value = glint_frame_find(f, colour[channel]);
    const float *spread = glint_frame_find(f, variance[channel]);
    const bool half = index % 4 == 1 || index % 4 == 2; // a steady change is the same in both
    for (size_t i = 0; i < stable_pixels(f); i++) {
        to[i].mean += value[i] / STILLS;
        to[i].variance += spread[i] / (STILLS * STILLS);
        to[i].halves += (half ? -2.0 : 2.0) * value[i] / STILLS;
    }
}

static struct pixel *stills_of(const struct glint_posed *scene, int samples, size_t pixels)
{
    struct pixel *p = calloc(3 * pixels, sizeof *p);
    for (int i = 0; i < STILLS; i++) {
        const double time = (i + 0.5) / STILLS;
        struct glint_frame *f = frame_at(scene, time, time, samples, i + 1);
        for (int c = 0; c < 3; c++)
            add_still(p + c * pixels, f, c, i);
        glint_frame_destroy(&f);
    }
    return p;
}

// A block of pixels of the blurred frame beside the mean of the stills.
struct block {
    double blurred, mean, error, halves;
};

static struct block block_at(const struct glint_frame *f, const struct pixel *stills, int channel,
                             uint32_t x, uint32_t y)
{
    const float *value = glint_frame_find(f, colour[channel]);
    const float *spread = glint_frame_find(f, variance[channel]);
    const double n = BLOCK * BLOCK;
    struct block b = {0};
    for (uint32_t k = 0; k < BLOCK * BLOCK; k++) {
        const size_t i = (size_t)(y + k / BLOCK) * f->width + x + k % BLOCK;
        const struct pixel *p = &stills[channel * stable_pixels(f) + i];
        b.blurred += value[i] / n;
        b.mean += p->mean / n;
        b.error += (p->variance + spread[i]) / (n * n);
        b.halves += p->halves / n;
    }
    b.error = sqrt(b.error);
    return b;
}

// Five standard errors, and what the rule of 64 moments may miss: twice what its halves differ by,
// and 1/200 where they happen to agree.
static double bound_of(const struct block *b)
{
    return 5 * b->error + 2 * fabs(b->halves) + b->mean / 200;
}

struct outcome {
    double worst;  // difference by bound
    double moving; // share of blocks that differ from the still of the middle by more than theirs
    double bound;  // mean bound by mean value
};

static struct outcome compare(const struct glint_frame *blurred, const struct glint_frame *still,
                              const struct pixel *stills)
{
    struct outcome out = {0};
    double blocks = 0, bounds = 0, values = 0;
    for (int c = 0; c < 3; c++)
        for (uint32_t y = 0; y < blurred->height; y += BLOCK)
            for (uint32_t x = 0; x < blurred->width; x += BLOCK, blocks++) {
                const struct block b = block_at(blurred, stills, c, x, y);
                const struct block s = block_at(still, stills, c, x, y);
                const double bound = bound_of(&b);
                const double ratio = fabs(b.blurred - b.mean) / bound;
                if (ratio > 1)
                    print_message("# %s %u %u: %.5f, stills %.5f, bound %.5f\n", colour[c], x, y,
                                  b.blurred, b.mean, bound);
                out.worst = fmax(out.worst, ratio);
                out.moving += fabs(s.blurred - s.mean) > bound;
                bounds += bound;
                values += b.mean;
            }
    out.moving /= blocks;
    out.bound = bounds / values;
    return out;
}

// samples: of each still.
static void assert_mean_of_stills(char *text, int samples)
{
    struct glint_posed scene = offline_load_posed_text(&o, text);
    struct glint_frame *blurred = frame_at(&scene, 0, 1, samples * STILLS, 0);
    struct glint_frame *still = frame_at(&scene, 0.5, 0.5, samples * STILLS, 0);
    struct pixel *stills = stills_of(&scene, samples, stable_pixels(blurred));
    const struct outcome out = compare(blurred, still, stills);
    print_message("# worst block %.2f of its bound; bounds %.2f %%; %.0f %% of blocks are moving\n",
                  out.worst, 100 * out.bound, 100 * out.moving);
    assert_true(out.worst <= 1);
    assert_true(out.moving > 0.05);
    free(stills);
    glint_frame_destroy(&still);
    glint_frame_destroy(&blurred);
    glint_resident_release(&scene.resident);
    free(text);
}

static void a_box_that_passes_is_the_mean_of_its_stills(void **state)
{
    (void)state;
    assert_mean_of_stills(moving_box(), 8);
}

static void a_bar_that_turns_is_the_mean_of_its_stills(void **state)
{
    (void)state;
    assert_mean_of_stills(moving_bar(), 8);
}

static void a_column_that_bends_and_swells_is_the_mean_of_its_stills(void **state)
{
    (void)state;
    assert_mean_of_stills(moving_column(), 8);
}

static void a_camera_that_moves_sees_the_mean_of_its_stills(void **state)
{
    (void)state;
    assert_mean_of_stills(moving_camera(), 8);
}

static void an_emitter_that_passes_lights_as_the_mean_of_its_stills(void **state)
{
    (void)state;
    assert_mean_of_stills(moving_emitter(), 32);
}

static void lamps_that_pass_light_as_the_mean_of_their_stills(void **state)
{
    (void)state;
    assert_mean_of_stills(moving_lamps(), 32);
}

static struct glint_frame *frame_of(char *text, char *members)
{
    struct glint_posed scene = offline_load_posed_text(&o, text);
    char *whole =
        stable_text("'resolution':[64,48],'max_bounces':2,'stop':{'samples':8},%s", members);
    char *job = stable_job(whole);
    free(whole);
    struct glint_frame *f = offline_frame_posed(&o, &scene, job, 0);
    glint_resident_release(&scene.resident);
    free(job);
    free(text);
    return f;
}

static void a_shutter_without_length_shows_a_still(void **state)
{
    (void)state;
    struct glint_frame *a = frame_of(moving_bar(), "'fps':1,'shutter':[0.25,0.25]");
    struct glint_frame *b = frame_of(moving_bar(), "'fps':4,'shutter':[1,1]");
    struct glint_frame *c = frame_of(moving_bar(), "'fps':4,'shutter':[0,0]");
    struct glint_frame *rest = frame_of(moving_bar(), "'animation':'none'");
    stable_assert_same(a, b);
    stable_assert_same(c, rest); // its first key is how it rests
    assert_true(stable_equal(a, c, "R") < stable_pixels(a));
    glint_frame_destroy(&a);
    glint_frame_destroy(&b);
    glint_frame_destroy(&c);
    glint_frame_destroy(&rest);
}

// ---- stills beside scenes that are written as they are then

static void write_numbers(FILE *out, const char *name, const float *number, size_t count)
{
    fprintf(out, ",'%s':[", name);
    for (size_t i = 0; i < count; i++)
        fprintf(out, "%s%.9g", i ? "," : "", number[i]);
    fputc(']', out);
}

// The last instance of the scene as it is at `time`: its vertices, and where they are.
static void write_posed(FILE *out, const struct glint_posed *rest, double time)
{
    const struct glint_scene *s = glint_resident_scene(rest->resident);
    const struct glint_pose_request request = {.open = time, .close = time};
    const uint32_t last = s->instances - 1;
    const struct glint_mesh *mesh = &s->mesh[s->instance[last].mesh];
    struct glint_pose *pose;
    double m[16];
    float transform[16];
    assert_int_equal(glint_pose_create(&pose, s, &request, NULL), GLINT_OK);
    const struct glint_pose_instance *in = &pose->instance[last];
    glint_pose_instance_at(pose, s, last, 0, m);
    for (int i = 0; i < 16; i++)
        transform[i] = (float)m[i];
    fprintf(out, "'meshes':{'wall':{'primitive':'quad','size':[20,20]},'it':{'indices':[");
    for (uint32_t i = 0; i < 3 * mesh->triangles; i++)
        fprintf(out, "%s%u", i ? "," : "", mesh->index[i]);
    fputc(']', out);
    write_numbers(out, "positions", in->deforms ? in->position : mesh->position,
                  3 * mesh->vertices);
    if (mesh->normal)
        write_numbers(out, "normals", in->deforms ? in->normal : mesh->normal, 3 * mesh->vertices);
    fprintf(out, "}},'instances':{'wall':{'mesh':'wall','material':'white','transform':"
                 "{'translation':[0,0,-1.5]}},'it':{'mesh':'it','material':'red'");
    write_numbers(out, "transform", transform, 16);
    fprintf(out, "}}");
    glint_pose_release(&pose);
}

// Nearly all pixels are the same to within rounding; at edges samples may fall to either side.
static void assert_nearly_equal(const struct glint_frame *a, const struct glint_frame *b)
{
    size_t unequal = 0;
    for (int c = 0; c < 3; c++) {
        const float *p = glint_frame_find(a, colour[c]), *q = glint_frame_find(b, colour[c]);
        for (size_t i = 0; i < stable_pixels(a); i++)
            unequal += !(fabsf(p[i] - q[i]) <= 1e-3f * fabsf(p[i]));
    }
    print_message("# %zu of %zu values differ by more than 0.1 %%\n", unequal,
                  3 * stable_pixels(a));
    assert_true(unequal * 100 < 3 * stable_pixels(a));
}

static void assert_still_as_written(char *text, double time)
{
    struct glint_posed rest = offline_load_posed_text(&o, text);
    char *written;
    size_t size;
    FILE *out = open_memstream(&written, &size);
    fprintf(out, "{" MOVING_MATERIALS "," MOVING_CAMERA "," MOVING_LAMP ",");
    write_posed(out, &rest, time);
    fputc('}', out);
    fclose(out);
    char *quoted = stable_text("%s", written);
    struct glint_posed same = offline_load_posed_text(&o, quoted);
    struct glint_frame *a = frame_at(&rest, time, time, 16, 1);
    struct glint_frame *b = frame_at(&same, 0, 0, 16, 1);
    assert_nearly_equal(a, b);
    glint_frame_destroy(&a);
    glint_frame_destroy(&b);
    glint_resident_release(&rest.resident);
    glint_resident_release(&same.resident);
    free(quoted);
    free(written);
    free(text);
}

static void a_still_shows_the_scene_as_it_is_then(void **state)
{
    (void)state;
    assert_still_as_written(moving_box(), 0.3);
    assert_still_as_written(moving_bar(), 0.7);
    assert_still_as_written(moving_column(), 0.9);
}

// A box beside a node that carries nothing that is seen.
static char *idle_scene(const char *more)
{
    return stable_text(
        "{'materials':{'m':{'base_color':[0.8,0.2,0.2]},'glow':{'emission':[3,3,3]}},"
        "'meshes':{'box':{'primitive':'box'}},'nodes':{'n':{}},"
        "'instances':{'a':{'mesh':'box','material':'m'},'b':{'mesh':'box','material':'glow',"
        "'transform':{'translation':[2,1,0]}},'c':{'mesh':'box','material':'m','node':'n',"
        "'visible':false}},'cameras':{'eye':{'yfov':0.6,'transform':{'translation':[0,0,6]}}}%s}",
        more);
}

static void an_animation_of_nothing_that_is_seen_leaves_every_bit(void **state)
{
    (void)state;
    struct glint_frame *still = frame_of(idle_scene(""), "'fps':1,'shutter':[0,1]");
    struct glint_frame *idle =
        frame_of(idle_scene(",'animations':{'a':{'channels':{'c':{'node':'n','path':'translation',"
                            "'times':[0,1],'values':[0,0,0,1,0,0]}}}}"),
                 "'fps':1,'shutter':[0,1]");
    stable_assert_same(still, idle);
    glint_frame_destroy(&still);
    glint_frame_destroy(&idle);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_box_that_passes_is_the_mean_of_its_stills),
        cmocka_unit_test(a_bar_that_turns_is_the_mean_of_its_stills),
        cmocka_unit_test(a_column_that_bends_and_swells_is_the_mean_of_its_stills),
        cmocka_unit_test(a_camera_that_moves_sees_the_mean_of_its_stills),
        cmocka_unit_test(an_emitter_that_passes_lights_as_the_mean_of_its_stills),
        cmocka_unit_test(lamps_that_pass_light_as_the_mean_of_their_stills),
        cmocka_unit_test(a_shutter_without_length_shows_a_still),
        cmocka_unit_test(a_still_shows_the_scene_as_it_is_then),
        cmocka_unit_test(an_animation_of_nothing_that_is_seen_leaves_every_bit),
    };
    offline_start(&o, offline_workers());
    const int failed = cmocka_run_group_tests(tests, NULL, NULL);
    offline_finish(&o);
    return failed;
}
