// rows.c - which instances are drawn, where the scene's centre lies, and what mattes they belong to.
#include "protocol/cryptomatte.h"
#include "scene/internal.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

static const float quad_position[12] = {-0.5f, -0.5f, 0, 0.5f, -0.5f, 0, 0.5f, 0.5f, 0, -0.5f, 0.5f, 0};
static const float quad_uv[8] = {0, 1, 1, 1, 1, 0, 0, 0};
static const uint32_t quad_index[6] = {0, 2, 1, 0, 3, 2}; // faces -z, where area lights look

void glint_row_point(const struct glint_row *row, const float p[3], double out[3])
{
    for (int i = 0; i < 3; i++)
        out[i] = (double)row->transform[i] * p[0] + (double)row->transform[4 + i] * p[1]
                 + (double)row->transform[8 + i] * p[2] + (double)row->transform[12 + i];
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

// (object, material) -> key. Area lights are objects of their own, with their own name as material.
struct pair {
    uint32_t object, material, row;
};

static int by_pair(const void *a, const void *b)
{
    const struct pair *p = a, *q = b;
    if (p->object != q->object)
        return p->object < q->object ? -1 : 1;
    return p->material < q->material ? -1 : p->material > q->material;
}

static void key_fill(struct glint_matte_key *key, const char *object, const char *material,
                     const char *asset)
{
    const char *name[3] = {object, material, asset};
    for (int k = 0; k < 3; k++) {
        key->name[k] = name[k];
        key->id[k] = k == 2 && !*name[k] ? 0 : glint_cryptomatte_id(name[k]);
    }
}

static uint32_t instance_pairs(const struct glint_resident *r, struct pair *pair)
{
    uint32_t n = 0;
    for (uint32_t i = 0; i < r->scene->instances; i++) {
        const struct glint_instance *in = &r->scene->instance[i];
        if (!in->visible)
            continue;
        pair[n] = (struct pair){in->object, in->material, n};
        n++;
    }
    return n;
}

static void assign_keys(struct glint_resident *r, struct pair *pair)
{
    const struct glint_scene *s = r->scene;
    const uint32_t n = instance_pairs(r, pair);
    qsort(pair, n, sizeof *pair, by_pair);
    r->mattes = 2;
    for (uint32_t i = 0; i < n; i++) {
        if (i == 0 || by_pair(&pair[i - 1], &pair[i]) != 0) {
            const struct glint_object *o = &s->object[pair[i].object];
            key_fill(&r->matte[r->mattes++], o->name, s->material[pair[i].material].name, o->asset);
        }
        r->row[pair[i].row].matte = r->mattes - 1;
    }
    uint32_t row = n;
    for (uint32_t i = 0; i < s->lights; i++)
        if (s->light[i].kind == GLINT_LIGHT_AREA) {
            key_fill(&r->matte[r->mattes], s->light[i].name, s->light[i].name, "");
            r->row[row++].matte = r->mattes++;
        }
}

glint_status glint_resident_build_rows(struct glint_resident *r, struct glint_error *err)
{
    const struct glint_scene *s = r->scene;
    const size_t capacity = (size_t)s->instances + s->lights;
    r->quad = (struct glint_mesh){.id = "area light", .vertices = 4, .triangles = 2,
                                  .position = quad_position, .uv = quad_uv, .index = quad_index};
    r->row = calloc(capacity + 1, sizeof *r->row);
    r->kept = calloc((size_t)s->meshes + 1, sizeof *r->kept);
    r->matte = calloc(capacity + 2, sizeof *r->matte);
    struct pair *pair = calloc(capacity + 1, sizeof *pair);
    if (!r->row || !r->kept || !r->matte || !pair) {
        free(pair);
        return glint_fail(err, GLINT_E_NOMEM, "", "no memory for %zu instances", capacity);
    }
    collect_rows(r);
    centre_rows(r);
    assign_keys(r, pair);
    free(pair);
    return GLINT_OK;
}
