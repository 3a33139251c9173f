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

// ---- primitives

static struct glint_scene *primitive(const char *members)
{
    char *text = NULL;
    assert_true(asprintf(&text,
                         "{'meshes':{'p':{'primitive':%s}},'materials':{'m':{}},"
                         "'instances':{'i':{'mesh':'p','material':'m'}}}",
                         members) > 0);
    struct glint_scene *s = parse(text);
    free(text);
    return s;
}

static const float *corner(const struct glint_mesh *m, uint32_t t, int k)
{
    return m->position + 3 * (size_t)m->index[3 * t + k];
}

// Twice the area vector of a triangle.
static void face(const struct glint_mesh *m, uint32_t t, double n[3])
{
    const float *a = corner(m, t, 0), *b = corner(m, t, 1), *c = corner(m, t, 2);
    for (int k = 0; k < 3; k++) {
        const int i = (k + 1) % 3, j = (k + 2) % 3;
        n[k] = ((double)b[i] - a[i]) * ((double)c[j] - a[j]) -
               ((double)b[j] - a[j]) * ((double)c[i] - a[i]);
    }
}

static double volume(const struct glint_mesh *m)
{
    double sum = 0;
    for (uint32_t t = 0; t < m->triangles; t++) {
        double n[3];
        face(m, t, n);
        const float *a = corner(m, t, 0);
        sum += (n[0] * a[0] + n[1] * a[1] + n[2] * a[2]) / 6;
    }
    return sum;
}

static double area(const struct glint_mesh *m)
{
    double sum = 0;
    for (uint32_t t = 0; t < m->triangles; t++) {
        double n[3];
        face(m, t, n);
        sum += 0.5 * sqrt(n[0] * n[0] + n[1] * n[1] + n[2] * n[2]);
    }
    return sum;
}

static int edge_uses(const struct glint_mesh *m, const float *from, const float *to)
{
    int uses = 0;
    for (uint32_t t = 0; t < m->triangles; t++)
        for (int k = 0; k < 3; k++)
            uses += memcmp(corner(m, t, k), from, 12) == 0 &&
                    memcmp(corner(m, t, (k + 1) % 3), to, 12) == 0;
    return uses;
}

// Zeros of either sign are one place.
static void drop_signs_of_zero(const struct glint_mesh *m)
{
    float *p = (float *)m->position;
    for (size_t i = 0; i < 3 * (size_t)m->vertices; i++)
        p[i] += 0.0f;
}

static void assert_closed(const struct glint_mesh *m)
{
    drop_signs_of_zero(m);
    for (uint32_t t = 0; t < m->triangles; t++)
        for (int k = 0; k < 3; k++) {
            const float *a = corner(m, t, k), *b = corner(m, t, (k + 1) % 3);
            assert_int_equal(edge_uses(m, a, b), 1);
            assert_int_equal(edge_uses(m, b, a), 1);
        }
}

static void assert_normals_face_outwards(const struct glint_mesh *m)
{
    for (uint32_t t = 0; t < m->triangles; t++) {
        double n[3];
        face(m, t, n);
        assert_true(n[0] * n[0] + n[1] * n[1] + n[2] * n[2] > 0);
        for (int k = 0; k < 3; k++) {
            const float *v = m->normal + 3 * (size_t)m->index[3 * t + k];
            assert_true(n[0] * v[0] + n[1] * v[1] + n[2] * v[2] > 0);
        }
    }
}

static void a_box_is_closed_and_has_its_volume(void **state)
{
    (void)state;
    struct glint_scene *s = primitive("'box','size':[1,2,4]");
    assert_int_equal(s->mesh[0].triangles, 12);
    assert_closed(&s->mesh[0]);
    assert_normals_face_outwards(&s->mesh[0]);
    assert_true(fabs(volume(&s->mesh[0]) - 8) < 1e-12);
    assert_true(fabs(area(&s->mesh[0]) - 28) < 1e-12);
    glint_scene_destroy(&s);
}

static void a_sphere_is_closed_and_tends_to_its_volume(void **state)
{
    (void)state;
    static const char *const small[] = {"'sphere','segments':3", "'sphere','segments':7,'radius':2",
                                        "'sphere','segments':8"};
    for (size_t i = 0; i < 3; i++) {
        struct glint_scene *s = primitive(small[i]);
        assert_closed(&s->mesh[0]);
        assert_normals_face_outwards(&s->mesh[0]);
        glint_scene_destroy(&s);
    }
    struct glint_scene *s = primitive("'sphere','segments':512,'radius':2");
    const double exact = 4 * M_PI / 3 * 8;
    assert_true(volume(&s->mesh[0]) < exact && volume(&s->mesh[0]) > 0.9998 * exact);
    for (uint32_t i = 0; i < s->mesh[0].vertices; i++)
        for (int k = 0; k < 3; k++)
            assert_true(fabsf(s->mesh[0].position[3 * i + k] - 2 * s->mesh[0].normal[3 * i + k]) <
                        1e-6f);
    glint_scene_destroy(&s);
}

static void flat_primitives_face_z_and_have_their_area(void **state)
{
    (void)state;
    struct glint_scene *s = primitive("'quad','size':[2,3]");
    assert_true(fabs(area(&s->mesh[0]) - 6) < 1e-12);
    assert_normals_face_outwards(&s->mesh[0]);
    assert_true(s->mesh[0].normal[2] == 1 && s->mesh[0].position[2] == 0);
    assert_true(s->mesh[0].uv[0] == 0 && s->mesh[0].uv[1] == 0); // upper left
    assert_true(s->mesh[0].position[0] == -1 && s->mesh[0].position[1] == 1.5f);
    glint_scene_destroy(&s);
    s = primitive("'disk','radius':3,'segments':12");
    assert_true(fabs(area(&s->mesh[0]) - 12 * 0.5 * 9 * sin(M_PI / 6)) < 1e-5);
    assert_normals_face_outwards(&s->mesh[0]);
    glint_scene_destroy(&s);
}

static void primitives_cannot_multiply_without_bound(void **state)
{
    (void)state;
    struct glint_text t = {0};
    glint_text_add(&t, "{\"meshes\":{");
    for (int i = 0; i < 40; i++)
        glint_text_print(&t, "%s\"m%d\":{\"primitive\":\"sphere\",\"segments\":1024}", i ? "," : "",
                         i);
    glint_text_add(&t, "}}");
    char *text = glint_text_take(&t, NULL);
    struct glint_scene *s;
    struct glint_error err = {0};
    assert_int_equal(glint_scene_parse(&s, text, strlen(text), NULL, 0, &err), GLINT_E_RANGE);
    assert_string_equal(err.fault[0].pointer, "/meshes/m31"); // 1025 * 513 * 32 > 2^24
    glint_error_finish(&err);
    free(text);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_box_is_closed_and_has_its_volume),
        cmocka_unit_test(a_sphere_is_closed_and_tends_to_its_volume),
        cmocka_unit_test(flat_primitives_face_z_and_have_their_area),
        cmocka_unit_test(primitives_cannot_multiply_without_bound),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
