#include "protocol/scene_parts.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

// JSON without the backslashes.
static char *json(const char *quoted)
{
    char *text = strdup(quoted);
    for (char *c = text; *c; c++)
        if (*c == '\'')
            *c = '"';
    return text;
}

static struct glint_scene *parse_with(const char *quoted, const struct glint_asset *asset, size_t n)
{
    struct glint_error err = {0};
    struct glint_scene *scene;
    char *text = json(quoted);
    if (glint_scene_parse(&scene, text, strlen(text), asset, n, &err))
        fail_msg("%s: %s", err.fault[0].pointer, err.fault[0].detail);
    free(text);
    return scene;
}

static struct glint_scene *parse(const char *quoted)
{
    return parse_with(quoted, NULL, 0);
}

// The faults of the text must be at exactly these pointers, in any order, "|" between.
static void refuse_with(const char *quoted, const struct glint_asset *asset, size_t n,
                        const char *pointers)
{
    struct glint_error err = {0};
    struct glint_scene *scene;
    char *text = json(quoted), *want = strdup(pointers), *rest = want;
    if (!glint_scene_parse(&scene, text, strlen(text), asset, n, &err))
        fail_msg("accepted: %s", quoted);
    assert_null(scene);
    size_t found = 0, wanted = 0;
    for (char *p; (p = strsep(&rest, "|")); wanted++)
        for (size_t i = 0; i < err.count; i++)
            if (strcmp(p, err.fault[i].pointer) == 0) {
                found++;
                break;
            }
    if (found != wanted || err.count != wanted)
        for (size_t i = 0; i < err.count; i++)
            print_message("# %s: %s\n", err.fault[i].pointer, err.fault[i].detail);
    assert_int_equal(found, wanted);
    assert_int_equal(err.count, wanted);
    glint_error_finish(&err);
    free(text);
    free(want);
}

static void refuse(const char *quoted, const char *pointers)
{
    refuse_with(quoted, NULL, 0, pointers);
}

#define TRIANGLE "'meshes':{'t':{'positions':[0,0,0, 1,0,0, 0,1,0]}},'materials':{'m':{}}"

static void an_item_gets_what_is_said_and_defaults_for_the_rest(void **state)
{
    (void)state;
    struct glint_scene *s = parse("{'materials':{'red':{'base_color':[1,0,0.5],'roughness':0.25,'"
                                  "alpha_mode':'mask','thin':true},"
                                  "'b':{'name':'B'}},'meshes':{'t':{'positions':[0,0,0, 1,0,0, "
                                  "0,1,0, 0,0,1],'indices':[0,1,2, 0,2,3]}},"
                                  "'objects':{'o':{'name':'Obj','asset':'A'}},"
                                  "'instances':{'i':{'mesh':'t','material':'b','object':'o','"
                                  "visible':false},'j':{'mesh':'t','material':'red'},"
                                  "'o':{'mesh':'t','material':'red'}},"
                                  "'lights':{'l':{'type':'area','size':[2,3]}},'cameras':{'c':{'"
                                  "yfov':1,'lens_radius':0.1,'focus_distance':4}},"
                                  "'environment':{'radiance':[1,2,3],'rotation':0.5}}");
    assert_true(s->materials == 2 && s->objects == 2 && s->instances == 3 && s->warnings == 0);
    assert_string_equal(s->material[0].name, "red");
    assert_true(s->material[0].base_color[2] == 0.5f &&
                s->material[0].alpha_mode == GLINT_ALPHA_MASK);
    assert_true(s->material[0].thin && s->material[0].double_sided && s->material[0].ior == 1.5f);
    assert_int_equal(s->material[0].normal_texture.image, GLINT_NONE);
    assert_string_equal(s->material[1].name, "B");
    assert_true(s->material[1].roughness == 1 && s->material[1].metallic == 0);
    assert_int_equal(s->mesh[0].triangles, 2);
    assert_int_equal(s->mesh[0].index[5], 3);
    assert_true(!s->instance[0].visible && s->instance[1].visible);
    assert_int_equal(s->instance[0].object, 0);
    assert_string_equal(s->object[s->instance[1].object].name, "j");
    assert_string_equal(s->object[s->instance[1].object].asset, "");
    assert_int_equal(s->instance[2].object, 0); // an object of its id is there
    assert_true(s->light[0].kind == GLINT_LIGHT_AREA && s->light[0].size[1] == 3);
    assert_true(s->camera[0].focus_distance == 4 && s->camera[0].transform[10] == 1);
    assert_true(s->environment.radiance[2] == 3 && s->environment.image == GLINT_NONE);
    glint_scene_destroy(&s);
    assert_null(s);
    glint_scene_destroy(&s);
}

static void every_fault_is_named(void **state)
{
    (void)state;
    refuse("{'materials':{'m':{'metallic':2,'colour':1,'emission':[-1,0,0]}},'lamps':{},"
           "'instances':{'i':{'mesh':'t','material':'m'}}}",
           "/materials/m/metallic|/materials/m/colour|/materials/m/emission/0|/lamps|/instances/i/"
           "mesh");
    refuse("[]", "");
    refuse("{'materials':[],'meshes':{'':{'primitive':'quad'}}}", "/materials|/meshes/");
    refuse("{'materials':{'m':7}}", "/materials/m");
    refuse("{'materials':{'m':{'normal_map':{'image':'x'}},'n':{'normal_map':{}}}}",
           "/materials/m/normal_map/image|/materials/n/normal_map/image");
    refuse("{'lights':{'a':{},'b':{'type':'spot','inner_cone':1,'outer_cone':0.5},'c':{'type':'"
           "lamp'}}}",
           "/lights/a/type|/lights/b/inner_cone|/lights/c/type");
    refuse("{'cameras':{'a':{},'b':{'yfov':3.2},'c':{'yfov':0}}}",
           "/cameras/a/yfov|/cameras/b/yfov|/cameras/c/yfov");
    refuse("{'environment':{'image':'x','radiance':[1,1]}}",
           "/environment/image|/environment/radiance");
    refuse("{'images':{'i':{'data':'data:image/png;base64,AA'}}}", "/images/i/data");
    refuse("{" TRIANGLE ",'instances':{'i':{},'j':{'mesh':'t','material':3,'object':'nobody'}}}",
           "/instances/i/mesh|/instances/i/material|/instances/j/material|/instances/j/object");
}

static void what_no_triangle_can_be_made_of_is_refused(void **state)
{
    (void)state;
    refuse("{'meshes':{'a':{},'b':{'positions':[]},'c':{'positions':[0,0]},'d':{'positions':[0,0,0]"
           "}}}",
           "/meshes/a/positions|/meshes/b/positions|/meshes/c/positions|/meshes/d/positions");
    refuse("{'meshes':{'a':{'positions':[0,0,0, 1,0,0, 0,1,0],'indices':[0,1,3]},"
           "'b':{'positions':[0,0,0, 1,0,0, 0,1,0],'indices':[]},"
           "'c':{'positions':[0,0,0, 1,0,0, 0,1,0],'normals':[0,0,1]},"
           "'d':{'positions':[0,0,0, 1e999,0,0, 0,1e13,0],'uvs':['x',0, 0,0, 0,0]}}}",
           "/meshes/a/indices/2|/meshes/b/indices|/meshes/c/normals|/meshes/d/positions/3|"
           "/meshes/d/positions/7|/meshes/d/uvs/0");
    refuse("{'meshes':{'a':{'primitive':'cone'},'b':{'primitive':'sphere','segments':2},"
           "'c':{'primitive':'box','radius':1},'d':{'primitive':'quad','size':[1,0]}}}",
           "/meshes/a/primitive|/meshes/b/segments|/meshes/c/radius|/meshes/d/size/1");
    refuse("{'meshes':{'a':{'positions':[0,0,0, 1,0,0, 0,1,0],'tangents':[1,0,0,1, 1,0,0,0, "
           "1,0,0,1]}}}",
           "/meshes/a");
}

static void transforms_are_affine_and_have_an_inverse(void **state)
{
    (void)state;
    refuse("{" TRIANGLE ",'instances':{"
           "'a':{'mesh':'t','material':'m','transform':[1,0,0,0, 0,1,0,0, 0,0,0,0, 0,0,0,1]},"
           "'b':{'mesh':'t','material':'m','transform':[1,0,0,0, 0,1,0,0, 1,1,0,0, 0,0,0,1]},"
           "'c':{'mesh':'t','material':'m','transform':[1,0,0,1, 0,1,0,0, 0,0,1,0, 0,0,0,1]},"
           "'d':{'mesh':'t','material':'m','transform':{'rotation':[0,0,0,0]}},"
           "'e':{'mesh':'t','material':'m','transform':{'scale':[1,0,1]}},"
           "'f':{'mesh':'t','material':'m','transform':[1,0,0]},"
           "'g':{'mesh':'t','material':'m','transform':{'rotate':[0,0,0,1]}},"
           "'h':{'mesh':'t','material':'m','transform':[0.1,0.2,0.3,0, 0.4,0.5,0.6,0, "
           "0.7,0.8,0.9,0, 0,0,0,1]}}}",
           "/instances/a/transform|/instances/b/transform|/instances/c/transform|"
           "/instances/d/transform/rotation|/instances/e/transform|/instances/f/transform|"
           "/instances/g/transform/rotate|/instances/h/transform");
    refuse("{" TRIANGLE
           ",'instances':{'a':{'mesh':'t','material':'m','transform':{'scale':[1e6,1,1],"
           "'translation':[9.999999e11,0,0]}}}}",
           "/instances/a");
}

static void parts_compose_as_translation_rotation_scale(void **state)
{
    (void)state;
    // Half a turn's root about z: x goes to y, y to -x; twice as long before, moved after.
    struct glint_scene *s =
        parse("{" TRIANGLE ",'instances':{'i':{'mesh':'t','material':'m','transform':"
              "{'translation':[5,6,7],'rotation':[0,0,3,3],'scale':[2,3,1e-5]}}}}");
    const float want[16] = {0, 2, 0, 0, -3, 0, 0, 0, 0, 0, 1e-5f, 0, 5, 6, 7, 1};
    for (int k = 0; k < 16; k++)
        assert_true(fabsf(s->instance[0].transform[k] - want[k]) < 1e-6f);
    glint_scene_destroy(&s);
}

static void cameras_are_made_rigid_and_keep_their_view(void **state)
{
    (void)state;
    struct glint_scene *s =
        parse("{'cameras':{'c':{'yfov':1,'transform':[2,0,0,0, 0,3,1,0, 0,0,4,0, 7,8,9,1]},"
              "'d':{'yfov':1,'transform':[0,0,-1,0, 0,1,0,0, 1,0,0,0, 0,0,0,1]}}}");
    const float want[16] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 7, 8, 9, 1};
    for (int k = 0; k < 16; k++)
        assert_true(fabsf(s->camera[0].transform[k] - want[k]) < 1e-6f);
    assert_true(s->camera[1].transform[2] == -1 && s->camera[1].transform[8] == 1);
    glint_scene_destroy(&s);
}

// ---- normals

static void normals_are_made_unit_and_zero_ones_follow_the_face(void **state)
{
    (void)state;
    struct glint_scene *s =
        parse("{'meshes':{'t':{'positions':[0,0,0, 0,2,0, 0,0,2, 9,9,9],'indices':[0,1,2],"
              "'normals':[3,0,4, 0,0,0, 0,1,0, 0,0,0]}},'cameras':{'c':{'yfov':1}}}");
    const float want[12] = {0.6f, 0, 0.8f, 1, 0, 0, 0, 1, 0, 0, 0, 1};
    for (int k = 0; k < 12; k++)
        assert_true(fabsf(s->mesh[0].normal[k] - want[k]) < 1e-6f);
    glint_scene_destroy(&s);
}

// ---- assets

struct triangle_asset {
    float position[9], normal[9], uv[6];
    uint32_t index[3];
};

static struct triangle_asset make_triangle(void)
{
    return (struct triangle_asset){
        {0, 0, 0, 1, 0, 0, 0, 1, 0}, {0, 0, 1, 0, 0, 1, 0, 0, 1}, {0, 0, 1, 0, 0, 1}, {0, 1, 2}};
}

static struct glint_asset name(const void *bytes, size_t size)
{
    struct glint_asset asset = {.bytes = bytes, .size = size};
    assert_true(glint_asset_name(bytes, size, asset.sha256));
    return asset;
}

static void hashes_are_sha256(void **state)
{
    (void)state;
    const struct glint_asset abc = name("abc", 3);
    assert_string_equal(abc.sha256,
                        "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad");
}

static char *mesh_text(const char *hash, const char *rest)
{
    char *text = NULL;
    assert_true(asprintf(&text, "{'meshes':{'t':{'asset':'%s',%s}}}", hash, rest) > 0);
    return text;
}

#define WHOLE "'vertices':3,'triangles':1,'attributes':['normal','uv']"

static void a_mesh_asset_is_borrowed_in_place(void **state)
{
    (void)state;
    const struct triangle_asset t = make_triangle();
    const struct glint_asset asset = name(&t, sizeof t);
    char *text = mesh_text(asset.sha256, WHOLE);
    struct glint_scene *s = parse_with(text, &asset, 1);
    assert_ptr_equal(s->mesh[0].position, t.position);
    assert_ptr_equal(s->mesh[0].normal, t.normal);
    assert_ptr_equal(s->mesh[0].uv, t.uv);
    assert_null(s->mesh[0].tangent);
    assert_ptr_equal(s->mesh[0].index, t.index);
    assert_string_equal(s->mesh[0].asset, asset.sha256);
    glint_scene_destroy(&s);
    char shifted[sizeof t + 1];
    memcpy(shifted + 1, &t, sizeof t);
    struct glint_asset odd = asset;
    odd.bytes = (const uint8_t *)(((uintptr_t)shifted & 1) ? shifted : shifted + 1);
    memmove((void *)odd.bytes, &t, sizeof t);
    s = parse_with(text, &odd, 1);
    assert_int_equal((uintptr_t)s->mesh[0].index % 4, 0);
    assert_int_equal(s->mesh[0].index[2], 2);
    glint_scene_destroy(&s);
    free(text);
}

static void an_asset_must_be_there_and_have_the_size_that_the_counts_say(void **state)
{
    (void)state;
    const struct triangle_asset t = make_triangle();
    const struct glint_asset asset = name(&t, sizeof t);
    static const char *const wrong[] = {
        "'vertices':3,'triangles':1",
        "'vertices':2,'triangles':1,'attributes':['normal','uv']",
        "'vertices':2147483647,'triangles':2147483647,'attributes':['normal','uv','tangent']",
    };
    for (size_t i = 0; i < sizeof wrong / sizeof *wrong; i++) {
        char *text = mesh_text(asset.sha256, wrong[i]);
        refuse_with(text, &asset, 1, "/meshes/t/asset");
        refuse_with(text, NULL, 0, "/meshes/t/asset");
        free(text);
    }
    char *text = mesh_text(asset.sha256, "'vertices':3,'triangles':0,'attributes':['uv','uv']");
    refuse_with(text, &asset, 1, "/meshes/t/triangles|/meshes/t/attributes/1");
    free(text);
    refuse("{'meshes':{'t':{'asset':'abc'," WHOLE "}}}", "/meshes/t/asset");
    refuse("{'meshes':{'t':{'asset':7}}}", "/meshes/t/vertices|/meshes/t/triangles");
}

static void what_an_asset_holds_is_checked(void **state)
{
    (void)state;
    struct triangle_asset bad[5];
    for (int i = 0; i < 5; i++)
        bad[i] = make_triangle();
    bad[0].position[4] = NAN;
    bad[1].position[8] = -INFINITY;
    bad[2].index[2] = 3;
    bad[3].normal[0] = NAN;
    bad[4].uv[5] = INFINITY;
    for (int i = 0; i < 5; i++) {
        const struct glint_asset asset = name(&bad[i], sizeof bad[i]);
        char *text = mesh_text(asset.sha256, WHOLE);
        refuse_with(text, &asset, 1, "/meshes/t/asset");
        free(text);
    }
}

static void half_images_are_finite_and_not_negative(void **state)
{
    (void)state;
    static const uint16_t good[4] = {0x3c00, 0x8000, 0x7bff, 1}, infinite[4] = {0, 0x7c00, 0, 0},
                          negative[4] = {0, 0, 0, 0x8001}, nan[4] = {0xffff, 0, 0, 0};
    const uint16_t *const all[] = {good, infinite, negative, nan};
    for (int i = 0; i < 4; i++) {
        const struct glint_asset asset = name(all[i], 8);
        char *text = NULL;
        assert_true(asprintf(&text,
                             "{'images':{'i':{'asset':'%s','width':1,'height':1,'format':"
                             "'rgba16f'}},'environment':{'image':'i'}}",
                             asset.sha256) > 0);
        if (i > 0) {
            refuse_with(text, &asset, 1, "/images/i/asset");
        } else {
            struct glint_scene *s = parse_with(text, &asset, 1);
            assert_ptr_equal(s->image[s->environment.image].pixels, good);
            glint_scene_destroy(&s);
        }
        free(text);
    }
}

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

// ---- completion

static void an_empty_scene_gets_camera_and_light_and_three_warnings(void **state)
{
    (void)state;
    struct glint_scene *s = parse("{}");
    assert_int_equal(s->warnings, 3);
    assert_int_equal(s->cameras, 1);
    assert_true(s->has_environment && s->environment.radiance[1] == 1);
    assert_int_equal(glint_scene_complete(s, NULL), GLINT_OK);
    assert_int_equal(s->warnings, 3);
    glint_scene_destroy(&s);
}

static void the_added_camera_sees_the_whole_box(void **state)
{
    (void)state;
    struct glint_scene *s = parse(
        "{'meshes':{'b':{'primitive':'box','size':[4,1,2]}},'materials':{'m':{}},'instances':{"
        "'i':{'mesh':'b','material':'m','transform':{'translation':[10,20,30]}},"
        "'hidden':{'mesh':'b','material':'m','visible':false,'transform':{'translation':[1000,0,0]}"
        "}}}");
    const float *c = s->camera[0].transform;
    const double reach = tan(0.5 * s->camera[0].yfov);
    double nearest = 1;
    for (int i = 0; i < 8; i++) {
        const double p[3] = {10 + (i & 1 ? 2 : -2), 20 + (i & 2 ? 0.5 : -0.5),
                             30 + (i & 4 ? 1 : -1)};
        double view[3] = {0, 0, 0};
        for (int a = 0; a < 3; a++)
            for (int k = 0; k < 3; k++)
                view[a] += c[4 * a + k] * (p[k] - c[12 + k]);
        assert_true(view[2] < 0);
        const double x = fabs(view[0] / view[2]) / reach, y = fabs(view[1] / view[2]) / reach;
        assert_true(x <= 1 && y <= 1);
        nearest = fmin(nearest, 1 - fmax(x, y));
    }
    assert_true(nearest < 0.5); // and is not lost in it
    for (int a = 0; a < 3; a++)
        for (int b = 0; b < 3; b++) {
            double dot = 0;
            for (int k = 0; k < 3; k++)
                dot += (double)c[4 * a + k] * c[4 * b + k];
            assert_true(fabs(dot - (a == b)) < 1e-6);
        }
    glint_scene_destroy(&s);
}

static void an_environment_is_added_only_where_nothing_emits(void **state)
{
    (void)state;
    static const struct {
        const char *text;
        bool added;
    } cases[] = {
        {"{'meshes':{'q':{'primitive':'quad'}},'materials':{'m':{'emission':[0,0,1]}},"
         "'instances':{'i':{'mesh':'q','material':'m'}}}",
         false},
        {"{'meshes':{'q':{'primitive':'quad'}},'materials':{'m':{'emission':[0,0,1]}},"
         "'instances':{'i':{'mesh':'q','material':'m','visible':false}}}",
         true},
        {"{'lights':{'l':{'type':'sun'}}}", false},
        {"{'meshes':{'q':{'primitive':'quad'}},'materials':{'m':{'emission':[0,0,1]}}}", true},
    };
    for (size_t i = 0; i < 4; i++) {
        struct glint_scene *s = parse(cases[i].text);
        assert_int_equal(s->has_environment, cases[i].added);
        glint_scene_destroy(&s);
    }
}

// ---- writing

static const char *const rich =
    "{'images':{'env':{'asset':'%s','width':2,'height':1,'format':'rgba8'}},"
    "'materials':{'m~/\\u00e4':{'base_color':[0.1,0.2,0.3],'emission':[1e-7,3e9,0],'ior':1.333,"
    "'base_color_texture':{'image':'env','wrap_v':'mirror'}},'plain':{}},"
    "'meshes':{'s':{'primitive':'sphere','segments':9},'q':{'positions':[0,0,0, 1,0,0, 0,1,0],"
    "'normals':[0.1,0.2,5, 0,0,1, 0,0,1],'tangents':[1,0,0,-1, 1,0,0,1, 1,0,0,1]},"
    "'q2':{'positions':[0,0,0, 1,0,0, 0,1,0],'normals':[0.1,0.2,5, 0,0,1, 0,0,1],"
    "'tangents':[1,0,0,-1, 1,0,0,1, 1,0,0,1]}},"
    "'objects':{'o':{'name':'two words','asset':'set/a'}},"
    "'instances':{'i':{'mesh':'s','material':'plain','object':'o'},'j':{'mesh':'q2','material':'m~/"
    "\\u00e4',"
    "'transform':{'translation':[0.1,0.2,0.3],'rotation':[0.1,0.7,0.2,0.5],'scale':[1,2,3]}}},"
    "'lights':{'l':{'type':'spot','inner_cone':0.3,'transform':{'translation':[0,1,0]}}},"
    "'cameras':{'c':{'yfov':0.7,'lens_radius':0.01,'focus_distance':2.5}},"
    "'environment':{'image':'env','rotation':1.1}}";

#define SAME(A, B, FIELD) assert_memory_equal(&(A)->FIELD, &(B)->FIELD, sizeof(A)->FIELD)

static void assert_same_array(const void *a, const void *b, size_t bytes)
{
    assert_int_equal(!a, !b);
    if (a)
        assert_memory_equal(a, b, bytes);
}

static void assert_same_mesh(const struct glint_mesh *a, const struct glint_mesh *b)
{
    assert_string_equal(a->id, b->id);
    SAME(a, b, vertices);
    SAME(a, b, triangles);
    assert_same_array(a->position, b->position, 12ull * a->vertices);
    assert_same_array(a->normal, b->normal, 12ull * a->vertices);
    assert_same_array(a->uv, b->uv, 8ull * a->vertices);
    assert_same_array(a->tangent, b->tangent, 16ull * a->vertices);
    assert_same_array(a->index, b->index, 12ull * a->triangles);
}

static void assert_same_material(const struct glint_material *a, const struct glint_material *b)
{
    assert_string_equal(a->id, b->id);
    assert_string_equal(a->name, b->name);
    const size_t from = offsetof(struct glint_material, base_color);
    struct glint_material x = *a, y = *b; // bools leave padding between them
    assert_memory_equal((char *)&x + from, (char *)&y + from,
                        offsetof(struct glint_material, thin) - from);
    assert_true(a->thin == b->thin && a->double_sided == b->double_sided);
    SAME(a, b, emission);
    SAME(a, b, normal_scale);
    for (size_t i = 0; i < GLINT_TEXTURE_SLOTS; i++)
        assert_memory_equal(glint_texture_of(&x, i), glint_texture_of(&y, i),
                            sizeof(struct glint_texture));
}

static void assert_same_scene(const struct glint_scene *a, const struct glint_scene *b)
{
    assert_true(a->images == b->images && a->materials == b->materials && a->meshes == b->meshes);
    assert_true(a->objects == b->objects && a->instances == b->instances && a->lights == b->lights);
    assert_true(a->cameras == b->cameras && a->has_environment == b->has_environment);
    for (uint32_t i = 0; i < a->images; i++)
        assert_memory_equal(a->image[i].pixels, b->image[i].pixels, 8);
    for (uint32_t i = 0; i < a->materials; i++)
        assert_same_material(&a->material[i], &b->material[i]);
    for (uint32_t i = 0; i < a->meshes; i++)
        assert_same_mesh(&a->mesh[i], &b->mesh[i]);
    for (uint32_t i = 0; i < a->objects; i++) {
        assert_string_equal(a->object[i].name, b->object[i].name);
        assert_string_equal(a->object[i].asset, b->object[i].asset);
    }
    for (uint32_t i = 0; i < a->instances; i++) {
        assert_string_equal(a->instance[i].id, b->instance[i].id);
        assert_memory_equal(&a->instance[i].object, &b->instance[i].object,
                            offsetof(struct glint_instance, visible) -
                                offsetof(struct glint_instance, object));
        assert_int_equal(a->instance[i].visible, b->instance[i].visible);
    }
    for (uint32_t i = 0; i < a->lights; i++)
        assert_memory_equal(&a->light[i].kind, &b->light[i].kind,
                            offsetof(struct glint_light, size) -
                                offsetof(struct glint_light, kind));
    for (uint32_t i = 0; i < a->cameras; i++)
        assert_memory_equal(a->camera[i].transform, b->camera[i].transform,
                            sizeof(struct glint_camera) - offsetof(struct glint_camera, transform) -
                                4);
    if (a->has_environment)
        assert_memory_equal(&a->environment, &b->environment, sizeof a->environment);
}

static struct glint_scene *reparse(const char *text, size_t length, const struct glint_asset *asset,
                                   size_t n)
{
    struct glint_error err = {0};
    struct glint_scene *scene;
    if (glint_scene_parse(&scene, text, length, asset, n, &err))
        fail_msg("%s: %s in %s", err.fault[0].pointer, err.fault[0].detail, text);
    return scene;
}

static void parsing_what_was_written_gives_an_equal_scene(void **state)
{
    (void)state;
    static const uint8_t pixels[8] = {1, 2, 3, 4, 5, 6, 7, 8};
    struct glint_asset *asset = malloc(sizeof *asset);
    uint8_t *own = malloc(8);
    memcpy(own, pixels, 8);
    *asset = name(own, 8);
    size_t assets = 1, length, again_length;
    char *quoted = NULL, *text, *again;
    assert_true(asprintf(&quoted, rich, asset->sha256) > 0);
    struct glint_scene *a = parse_with(quoted, asset, 1);
    assert_int_equal(glint_scene_write(a, &text, &length, &asset, &assets, NULL), GLINT_OK);
    assert_int_equal(assets, 3); // the image, the sphere, and q and q2 as one
    for (size_t i = 0; i < assets; i++)
        assert_string_equal(asset[i].sha256, name(asset[i].bytes, asset[i].size).sha256);
    struct glint_scene *b = reparse(text, length, asset, assets);
    assert_same_scene(a, b);
    assert_int_equal(glint_scene_write(b, &again, &again_length, &asset, &assets, NULL), GLINT_OK);
    assert_int_equal(assets, 3);
    assert_string_equal(again, text);
    assert_int_equal(again_length, strlen(text));
    glint_scene_destroy(&a);
    glint_scene_destroy(&b);
    for (size_t i = 0; i < assets; i++)
        free((void *)asset[i].bytes);
    free(asset);
    free(quoted);
    free(text);
    free(again);
}

static void different_words_for_one_scene_are_written_as_equal_bytes(void **state)
{
    (void)state;
    struct glint_scene *s[2] = {parse("{'cameras':{'c':{'yfov':0.50,'name':'c'}},'lights':{'l':{'"
                                      "type':'sun','intensity':1}}}"),
                                parse("{'lights':{'l':{'type':'sun','transform':{'scale':[1,1,1]}}}"
                                      ",'cameras':{'c':{'yfov':5e-1}}}")};
    char *text[2];
    size_t length, assets = 0;
    struct glint_asset *asset = NULL;
    for (int i = 0; i < 2; i++) {
        assert_int_equal(glint_scene_write(s[i], &text[i], &length, &asset, &assets, NULL),
                         GLINT_OK);
        glint_scene_destroy(&s[i]);
    }
    assert_string_equal(text[0], text[1]);
    assert_null(asset);
    free(text[0]);
    free(text[1]);
}

// ---- size

// A grid of 1000 x 500 quads. Loose bound: only something quadratic could exceed it.
static void a_million_triangles_in_an_asset_parse_without_being_copied(void **state)
{
    (void)state;
    const uint32_t w = 1001, h = 501, vertices = w * h, triangles = 2 * (w - 1) * (h - 1);
    const struct glint_mesh shape = {.vertices = vertices, .triangles = triangles};
    const struct glint_mesh_layout at = glint_mesh_layout(&shape, GLINT_MESH_NORMAL);
    uint8_t *bytes = calloc(1, at.bytes);
    float *normal = (float *)(bytes + at.at[1]);
    uint32_t *index = (uint32_t *)(bytes + at.at[GLINT_MESH_ARRAYS - 1]);
    for (uint32_t i = 0; i < vertices; i++)
        normal[3 * i + i % 3] = 1;
    for (uint32_t i = 0; i < 3 * triangles; i++)
        index[i] = i % vertices;
    const struct glint_asset asset = name(bytes, at.bytes);
    char *text = NULL;
    assert_true(asprintf(&text,
                         "{'cameras':{'c':{'yfov':1}},'meshes':{'t':{'asset':'%s','vertices':%u,"
                         "'triangles':%u,'attributes':['normal']}}}",
                         asset.sha256, vertices, triangles) > 0);
    struct timespec from, to;
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &from);
    struct glint_scene *s = parse_with(text, &asset, 1);
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &to);
    const double ms =
        1e3 * (double)(to.tv_sec - from.tv_sec) + 1e-6 * (double)(to.tv_nsec - from.tv_nsec);
    print_message("# %.2f ms of CPU for %u triangles\n", ms, triangles);
    assert_true(ms < 1000);
    assert_ptr_equal(s->mesh[0].normal, normal);
    assert_true(s->arena.bytes < 10000);
    glint_scene_destroy(&s);
    free(text);
    free(bytes);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(an_item_gets_what_is_said_and_defaults_for_the_rest),
        cmocka_unit_test(every_fault_is_named),
        cmocka_unit_test(what_no_triangle_can_be_made_of_is_refused),
        cmocka_unit_test(transforms_are_affine_and_have_an_inverse),
        cmocka_unit_test(parts_compose_as_translation_rotation_scale),
        cmocka_unit_test(cameras_are_made_rigid_and_keep_their_view),
        cmocka_unit_test(normals_are_made_unit_and_zero_ones_follow_the_face),
        cmocka_unit_test(hashes_are_sha256),
        cmocka_unit_test(a_mesh_asset_is_borrowed_in_place),
        cmocka_unit_test(an_asset_must_be_there_and_have_the_size_that_the_counts_say),
        cmocka_unit_test(what_an_asset_holds_is_checked),
        cmocka_unit_test(half_images_are_finite_and_not_negative),
        cmocka_unit_test(a_box_is_closed_and_has_its_volume),
        cmocka_unit_test(a_sphere_is_closed_and_tends_to_its_volume),
        cmocka_unit_test(flat_primitives_face_z_and_have_their_area),
        cmocka_unit_test(primitives_cannot_multiply_without_bound),
        cmocka_unit_test(an_empty_scene_gets_camera_and_light_and_three_warnings),
        cmocka_unit_test(the_added_camera_sees_the_whole_box),
        cmocka_unit_test(an_environment_is_added_only_where_nothing_emits),
        cmocka_unit_test(parsing_what_was_written_gives_an_equal_scene),
        cmocka_unit_test(different_words_for_one_scene_are_written_as_equal_bytes),
        cmocka_unit_test(a_million_triangles_in_an_asset_parse_without_being_copied),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
