// Between which keys of a motion a path's vertex lies, and how far: its normal follows what turns.
#define GK_MOTION
#define GK_CAMERA_MOTION
#define GK_CLEARCOAT // so that a hit is whole
#include "kernels/gk_vertex.h"
#include "tests/kernel/check.h"

#include <math.h>

enum { SEGMENTS = 4 };

// Keys of a turn about z by 20 degrees each, one of the camera by 1 m along x.
static struct gk_turn turn[SEGMENTS + 1];
static struct gk_frame frame = {.motion_segments = SEGMENTS, .filter_width = 1.0f};

static void make_keys(void)
{
    for (int k = 0; k <= SEGMENTS; k++) {
        const float s = sinf((float)k * 0.349066f), c = cosf((float)k * 0.349066f);
        const float normal[9] = {c, -s, 0, s, c, 0, 0, 0, 1};
        for (int i = 0; i < 9; i++)
            turn[k].normal[i] = normal[i];
        frame.camera_key[k][0] = (float)(k * k);
    }
}

// The normal of a hit at a time, of a mesh whose normal is x.
static struct gk_vec normal_at(float time)
{
    const struct gk_triangle triangle = {.flags = 0};
    const struct gk_instance instance = {.matte = 2, .light = GK_NONE, .mover = 0};
    const struct gk_mover mover = {.turn = 0, .flow = GK_NONE};
    const struct gk_material material = {.ior = 1.0f, .opacity = 1.0f};
    const struct gk_wave_rect rect = {0};
    const struct gk_resident scene = {.triangle = &triangle,
                                      .instance = &instance,
                                      .mover = &mover,
                                      .turn = turn,
                                      .material = &material};
    static float wave[GK_COLUMNS];
    wave[GK_COL_DX] = -1.0f;
    wave[GK_COL_T] = 1.0f;
    wave[GK_COL_TIME] = time;
    wave[GK_COL_NX] = 1.0f;
    return gk_vertex_load(wave, 1, 0, &frame, &rect, &scene).hit.ng;
}

static void a_normal_lies_between_those_of_its_two_keys(void **state)
{
    (void)state;
    make_keys();
    for (int i = 0; i <= 64; i++) {
        const double at = i / 64.0 * SEGMENTS, key = fmin(floor(at), SEGMENTS - 1), w = at - key;
        const double a = key * 0.349066, b = a + 0.349066;
        const double x = (1 - w) * cos(a) + w * cos(b), y = (1 - w) * sin(a) + w * sin(b);
        const struct gk_vec n = normal_at((float)i / 64.0f);
        assert_within((double)n.x - x / hypot(x, y), 1e-6);
        assert_within((double)n.y - y / hypot(x, y), 1e-6);
    }
}

static void a_camera_lies_between_its_two_keys(void **state)
{
    (void)state;
    make_keys();
    for (int i = 0; i <= 64; i++) {
        const double at = i / 64.0 * SEGMENTS, key = fmin(floor(at), SEGMENTS - 1), w = at - key;
        const struct gk_vec o = gk_camera_vector(&frame, frame.origin, 0, (float)i / 64.0f);
        assert_within((double)o.x - ((1 - w) * key * key + w * (key + 1) * (key + 1)), 1e-6);
    }
}

static void lights_lie_between_their_two_keys(void **state)
{
    (void)state;
    frame.light_stride = 10;
    for (int i = 0; i <= 64; i++) {
        const double at = i / 64.0 * SEGMENTS, key = fmin(floor(at), SEGMENTS - 1);
        const struct gk_light_keys k = gk_light_keys_at(&frame, (float)i / 64.0f);
        assert_int_equal(k.from, 10 * (int)key);
        assert_int_equal(k.to, k.from + 10);
        assert_within((double)k.w - (at - key), 1e-6);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_normal_lies_between_those_of_its_two_keys),
        cmocka_unit_test(a_camera_lies_between_its_two_keys),
        cmocka_unit_test(lights_lie_between_their_two_keys),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
