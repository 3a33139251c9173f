// Animations of any magnitude: what the parser lets pass stays in the world at all times.
#include "scene/pose.h"
#include "scene_text.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define ROUNDS 3000
#define NODES 3

static double draw(uint64_t *state) // [0, 1), Knuth's multiplier
{
    *state = *state * 6364136223846793005ull + 1442695040888963407ull;
    return (double)(*state >> 33) * 0x1p-31;
}

// Of either sign, mostly moderate, up to 1e12.
static double magnitude(uint64_t *state)
{
    const double exponent = draw(state) < 0.1 ? 12 * draw(state) : 4 * draw(state) - 2;
    return (draw(state) < 0.5 ? -1 : 1) * pow(10, exponent);
}

static void add_numbers(struct glint_text *t, int count, uint64_t *state)
{
    for (int i = 0; i < count; i++)
        glint_text_print(t, "%s%.9g", i ? "," : "", magnitude(state));
}

static void add_quaternion(struct glint_text *t, uint64_t *state)
{
    double q[4], length = 0;
    for (int k = 0; k < 4; k++) {
        q[k] = draw(state) - 0.5;
        length = hypot(length, q[k]);
    }
    for (int k = 0; k < 4; k++)
        glint_text_print(t, "%s%.9g", k ? "," : "", q[k] / length);
}

static void add_value(struct glint_text *t, int path, uint64_t *state)
{
    if (path == GLINT_PATH_ROTATION)
        add_quaternion(t, state);
    else
        add_numbers(t, path == GLINT_PATH_WEIGHTS ? 1 : 3, state);
}

static void add_keys(struct glint_text *t, int path, bool cubic, uint64_t *state)
{
    const int keys = 1 + (int)(4 * draw(state));
    double time = 0;
    glint_text_add(t, "'times':[");
    for (int i = 0; i < keys; i++, time += 1e-3 + fabs(magnitude(state)) * 1e-3)
        glint_text_print(t, "%s%.9g", i ? "," : "", time);
    glint_text_add(t, "],'values':[");
    for (int i = 0; i < keys; i++) {
        glint_text_add(t, i ? "," : "");
        if (cubic) {
            add_numbers(t,
                        path == GLINT_PATH_ROTATION  ? 4
                        : path == GLINT_PATH_WEIGHTS ? 1
                                                     : 3,
                        state);
            glint_text_add(t, ",");
        }
        add_value(t, path, state);
        if (cubic) {
            glint_text_add(t, ",");
            add_numbers(t,
                        path == GLINT_PATH_ROTATION  ? 4
                        : path == GLINT_PATH_WEIGHTS ? 1
                                                     : 3,
                        state);
        }
    }
    glint_text_add(t, "]");
}

static void add_channel(struct glint_text *t, int number, uint64_t *state)
{
    static const char *const paths[] = {"translation", "rotation", "scale", "weights"};
    static const char *const kinds[] = {"linear", "step", "cubicspline"};
    const int path = number % 4, kind = (int)(3 * draw(state));
    const int node = path == GLINT_PATH_WEIGHTS ? NODES - 1 : number / 4;
    glint_text_print(t, "%s'c%d':{'node':'n%d','path':'%s','interpolation':'%s',",
                     t->bytes[t->length - 1] == '{' ? "" : ",", number, node, paths[path],
                     kinds[kind]);
    add_keys(t, path, kind == GLINT_INTERPOLATION_CUBICSPLINE, state);
    glint_text_add(t, "}");
}

static void add_nodes(struct glint_text *t, uint64_t *state)
{
    for (int i = 0; i < NODES; i++) {
        glint_text_print(t, "%s'n%d':{", i ? "," : "", i);
        if (i)
            glint_text_print(t, "'parent':'n%d',", i - 1);
        glint_text_add(t, "'transform':{'translation':[");
        add_numbers(t, 3, state);
        glint_text_add(t, "],'rotation':[");
        add_quaternion(t, state);
        glint_text_add(t, "],'scale':[");
        add_numbers(t, 3, state);
        glint_text_add(t, "]}}");
    }
}

static char *make_scene(uint64_t *state)
{
    struct glint_text t = {0};
    glint_text_add(&t, "{'materials':{'m':{}},'meshes':{'t':{'positions':[");
    add_numbers(&t, 9, state);
    glint_text_add(&t, "],'targets':[{'positions':[");
    add_numbers(&t, 9, state);
    glint_text_print(&t, "]}]}},'instances':{'i':{'mesh':'t','material':'m','node':'n%d'}},",
                     NODES - 1);
    glint_text_print(&t, "'cameras':{'c':{'yfov':1,'node':'n%d'}},'nodes':{", NODES - 1);
    add_nodes(&t, state);
    glint_text_add(&t, "},'animations':{'a':{'channels':{");
    for (int i = 0; i < 4 * NODES; i++)
        if (draw(state) < 0.3 && (i % 4 != GLINT_PATH_WEIGHTS || i / 4 == NODES - 1))
            add_channel(&t, i, state);
    glint_text_add(&t, "}}}}");
    return glint_text_take(&t, NULL);
}

// ---- where it goes

static const float *position_at(const struct glint_scene *s, const struct glint_pose *p,
                                uint32_t key)
{
    const struct glint_pose_instance *in = &p->instance[0];
    if (!in->position)
        return s->mesh[0].position;
    return in->position + (in->bends ? (size_t)key * s->mesh[0].vertices * 3 : 0);
}

static void assert_in_the_world(const struct glint_scene *s, const struct glint_pose *p,
                                uint32_t key)
{
    double m[16];
    const float *position = position_at(s, p, key);
    glint_pose_instance_at(p, s, 0, key, m);
    for (int v = 0; v < 3; v++)
        for (int k = 0; k < 3; k++) {
            double at = m[12 + k];
            for (int i = 0; i < 3; i++)
                at += m[4 * i + k] * position[3 * v + i];
            assert_true(fabs(at) <= 1.00001 * GLINT_MAX_COORDINATE);
        }
    glint_pose_camera_at(p, s, 0, key, m);
    for (int k = 0; k < 16; k++)
        assert_true(fabs(m[k]) <= 1.00001 * GLINT_MAX_COORDINATE);
}

static void assert_stays(const struct glint_scene *s, uint64_t *state)
{
    for (int i = 0; i < 4; i++) {
        struct glint_pose_request request = {.animation = 0};
        struct glint_pose *pose;
        request.open = fabs(magnitude(state)) * 1e-3;
        request.close = request.open + (i % 2 ? fabs(magnitude(state)) * 1e-3 : 0);
        assert_int_equal(glint_pose_create(&pose, s, &request, NULL), GLINT_OK);
        for (uint32_t key = 0; key < pose->keys && !pose->instance[0].hidden; key++)
            assert_in_the_world(s, pose, key);
        glint_pose_release(&pose);
    }
}

static void what_is_accepted_stays_in_the_world_at_all_times(void **unused)
{
    (void)unused;
    uint64_t state = 4;
    int accepted = 0;
    for (int i = 0; i < ROUNDS; i++) {
        char *quoted = make_scene(&state), *text = json(quoted);
        struct glint_error err = {0};
        struct glint_scene *s;
        const glint_status status = glint_scene_parse(&s, text, strlen(text), NULL, 0, &err);
        assert_true(status == GLINT_OK || status == GLINT_E_RANGE);
        if (!status)
            assert_stays(s, &state);
        accepted += !status;
        glint_scene_destroy(&s);
        glint_error_finish(&err);
        free(text);
        free(quoted);
    }
    print_message("# %d of %d accepted\n", accepted, ROUNDS);
    assert_true(accepted > ROUNDS / 20 && accepted < ROUNDS * 19 / 20);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(what_is_accepted_stays_in_the_world_at_all_times),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
