// rows.c - which instances are drawn, where the scene's centre lies, and what mattes they belong to.
#include "kernels/gk_matte.h"
#include "protocol/cryptomatte.h"
#include "scene/internal.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

static const float quad_position[12] = {-0.5f, -0.5f, 0, 0.5f,  -0.5f, 0,
                                        0.5f,  0.5f,  0, -0.5f, 0.5f,  0};
static const float quad_uv[8] = {0, 1, 1, 1, 1, 0, 0, 0};
static const uint32_t quad_index[6] = {0, 2, 1, 0, 3, 2}; // faces -z, where area lights look

void glint_row_point(const struct glint_row *row, const float p[3], double out[3])
{
    for (int i = 0; i < 3; i++)
        out[i] = (double)row->transform[i] * p[0] + (double)row->transform[4 + i] * p[1] +
                 (double)row->transform[8 + i] * p[2] + (double)row->transform[12 + i];
}

static void cofactors(const float t[16], double c[9])
{
    double m[9]; // row-major
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++)
            m[3 * i + j] = t[4 * j + i];
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++) {
            const int a = (i + 1) % 3, b = (i + 2) % 3, p = (j + 1) % 3, q = (j + 2) % 3;
            c[3 * i + j] = m[3 * a + p] * m[3 * b + q] - m[3 * a + q] * m[3 * b + p];
        }
}

double glint_row_determinant(const struct glint_row *row)
{
    double c[9];
    cofactors(row->transform, c);
    return row->transform[0] * c[0] + row->transform[4] * c[1] + row->transform[8] * c[2];
}

void glint_row_normal_matrix(const struct glint_row *row, double m[9])
{
    cofactors(row->transform, m);
    const double determinant = glint_row_determinant(row);
    for (int i = 0; i < 9; i++)
        m[i] /= determinant;
}

static bool emissive(const struct glint_material *m)
{
    return m->emission[0] > 0.0f || m->emission[1] > 0.0f || m->emission[2] > 0.0f;
}

struct bounds {
    double lo[3], hi[3];
    bool any;
};

static void grow(struct bounds *b, const struct glint_row *row)
{
    for (uint32_t i = 0; i < row->mesh->vertices; i++) {
        double p[3];
        glint_row_point(row, row->mesh->position + 3 * (size_t)i, p);
        for (int k = 0; k < 3; k++) {
            b->lo[k] = b->any ? fmin(b->lo[k], p[k]) : p[k];
            b->hi[k] = b->any ? fmax(b->hi[k], p[k]) : p[k];
        }
        b->any = true;
    }
}

// Moves everything to its own centre: floats are finest around zero.
static void centre_rows(struct glint_resident *r)
{
    struct bounds b = {0};
    for (uint32_t i = 0; i < r->rows; i++)
        grow(&b, &r->row[i]);
    double square = 0.0;
    for (int k = 0; k < 3; k++) {
        r->centre[k] = b.any ? 0.5 * (b.lo[k] + b.hi[k]) : 0.0;
        square += b.any ? 0.25 * (b.hi[k] - b.lo[k]) * (b.hi[k] - b.lo[k]) : 0.0;
    }
    r->radius = sqrt(square);
    for (uint32_t i = 0; i < r->rows; i++)
        for (int k = 0; k < 3; k++)
            r->row[i].transform[12 + k] = (float)(r->row[i].transform[12 + k] - r->centre[k]);
}

static void area_light_row(struct glint_resident *r, uint32_t light, uint32_t nth)
{
    const struct glint_light *l = &r->scene->light[light];
    struct glint_row *row = &r->row[r->rows++];
    row->mesh = &r->quad;
    row->material = r->scene->materials + nth;
    row->template_index = GLINT_NONE;
    row->emits = true;
    memcpy(row->transform, l->transform, sizeof row->transform);
    for (int k = 0; k < 3; k++) {
        row->transform[k] *= l->size[0];
        row->transform[4 + k] *= l->size[1];
    }
}

static void collect_rows(struct glint_resident *r)
{
    const struct glint_scene *s = r->scene;
    for (uint32_t i = 0; i < s->instances; i++) {
        const struct glint_instance *in = &s->instance[i];
        if (!in->visible)
            continue;
        struct glint_row *row = &r->row[r->rows++];
        row->mesh = &s->mesh[in->mesh];
        row->material = in->material;
        row->template_index = GLINT_NONE;
        row->emits = emissive(&s->material[in->material]);
        memcpy(row->transform, in->transform, sizeof row->transform);
        r->kept[in->mesh].uses++;
    }
    uint32_t nth = 0;
    for (uint32_t i = 0; i < s->lights; i++)
        if (s->light[i].kind == GLINT_LIGHT_AREA)
            area_light_row(r, i, nth++);
}

// A key and a row that has it. Area lights are objects of their own, with their own name as material.
struct named {
    struct glint_matte_key key;
    uint32_t row; // GLINT_NONE: nothing is drawn
};

static int by_name(const void *a, const void *b)
{
    const struct glint_matte_key *p = &((const struct named *)a)->key,
                                 *q = &((const struct named *)b)->key;
    int order = 0;
    for (int k = 0; !order && k < 3; k++)
        order = (p->id[k] > q->id[k]) - (p->id[k] < q->id[k]);
    for (int k = 0; !order && k < 3; k++)
        order = strcmp(p->name[k], q->name[k]);
    return order;
}

// NULL for what is not there: no ID.
static struct glint_matte_key key_of(const char *object, const char *material, const char *asset)
{
    struct glint_matte_key key = {.name = {object, material, asset}};
    for (int k = 0; k < 3; k++) {
        if (k < 2 && key.name[k] && !*key.name[k])
            key.name[k] = "default"; // CONVENTIONS a
        key.id[k] = !key.name[k] || !*key.name[k] ? 0 : glint_cryptomatte_id(key.name[k]);
    }
    return key;
}

static uint32_t name_rows(const struct glint_scene *s, struct named *out)
{
    uint32_t n = 0, row = 0;
    for (uint32_t i = 0; i < s->instances; i++) {
        const struct glint_instance *in = &s->instance[i];
        const struct glint_object *o = &s->object[in->object];
        out[n++] = (struct named){key_of(o->name, s->material[in->material].name, o->asset),
                                  in->visible ? row++ : GLINT_NONE};
    }
    for (uint32_t i = 0; i < s->lights; i++)
        if (s->light[i].kind == GLINT_LIGHT_AREA)
            out[n++] = (struct named){key_of(s->light[i].name, s->light[i].name, ""), row++};
    return n;
}

// One key for all rows whose three names are the same: a slot of a pixel holds all of them.
static void assign_keys(struct glint_resident *r, struct named *named)
{
    const uint32_t n = name_rows(r->scene, named);
    qsort(named, n, sizeof *named, by_name);
    r->mattes = 2;
    for (uint32_t i = 0; i < n; i++) {
        if (i == 0 || by_name(&named[i - 1], &named[i]) != 0)
            r->matte[r->mattes++] = named[i].key;
        if (named[i].row != GLINT_NONE)
            r->row[named[i].row].matte = r->mattes - 1;
    }
}

// Manifests have the names of what no instance uses, too.
static void append_unused(struct glint_resident *r, bool *used)
{
    const struct glint_scene *s = r->scene;
    bool *used_material = used + s->objects;
    for (uint32_t i = 0; i < s->instances; i++)
        used[s->instance[i].object] = used_material[s->instance[i].material] = true;
    for (uint32_t i = 0; i < s->objects; i++)
        if (!used[i])
            r->matte[r->mattes++] = key_of(s->object[i].name, NULL, s->object[i].asset);
    for (uint32_t i = 0; i < s->materials; i++)
        if (!used_material[i])
            r->matte[r->mattes++] = key_of(NULL, s->material[i].name, NULL);
}

static glint_status build_keys(struct glint_resident *r, size_t capacity, struct glint_error *err)
{
    const size_t things = (size_t)r->scene->objects + r->scene->materials;
    struct named *named = calloc(capacity + 1, sizeof *named);
    bool *used = calloc(things + 1, sizeof *used);
    r->matte = calloc(capacity + things + 2, sizeof *r->matte);
    glint_status st = GLINT_OK;
    if (!named || !used || !r->matte)
        st = glint_fail(err, GLINT_E_NOMEM, "", "no memory for the names of %zu instances",
                        capacity);
    if (!st)
        assign_keys(r, named);
    if (!st && r->mattes - 1 > GK_MATTE_MAX_KEY)
        st = glint_fail(err, GLINT_E_RANGE, "/instances",
                        "%u combinations of object, material and asset are "
                        "more than the %u that mattes tell apart",
                        r->mattes - 2, GK_MATTE_MAX_KEY - 1);
    if (!st)
        append_unused(r, used);
    free(named);
    free(used);
    return st;
}

glint_status glint_resident_build_rows(struct glint_resident *r, struct glint_error *err)
{
    const struct glint_scene *s = r->scene;
    const size_t capacity = (size_t)s->instances + s->lights;
    r->quad = (struct glint_mesh){.id = "area light",
                                  .vertices = 4,
                                  .triangles = 2,
                                  .position = quad_position,
                                  .uv = quad_uv,
                                  .index = quad_index};
    r->row = calloc(capacity + 1, sizeof *r->row);
    r->kept = calloc((size_t)s->meshes + 1, sizeof *r->kept);
    if (!r->row || !r->kept)
        return glint_fail(err, GLINT_E_NOMEM, "", "no memory for %zu instances", capacity);
    collect_rows(r);
    centre_rows(r);
    return build_keys(r, capacity, err);
}
