// rows.c - which instances are drawn and where they are, relative to the scene's centre.
#include "scene/internal.h"

#include <stdlib.h>
#include <string.h>

void glint_row_vertex(const struct glint_resident *r, const struct glint_row *row, uint32_t key,
                      uint32_t vertex, double out[3])
{
    const struct glint_kept *k = &r->kept[row->kept];
    const float *p = k->position + 3 * ((size_t)(key % k->keys) * k->mesh->vertices + vertex);
    const float *t = row->motion ? row->motion + 16 * (size_t)key : row->transform;
    for (int i = 0; i < 3; i++)
        out[i] = (double)t[i] * p[0] + (double)t[4 + i] * p[1] + (double)t[8 + i] * p[2] +
                 (double)t[12 + i];
}

struct glint_kept *glint_row_kept(const struct glint_resident *r, const struct glint_row *row)
{
    return &r->kept[row->kept];
}

bool glint_row_moves(const struct glint_resident *r, const struct glint_row *row)
{
    return row->motion || r->kept[row->kept].keys > 1;
}

bool glint_row_mirrors(const struct glint_row *row)
{
    const float *t = row->transform;
    double determinant = 0.0;
    for (int i = 0; i < 3; i++) {
        const int j = (i + 1) % 3, k = (i + 2) % 3;
        determinant += t[i] * ((double)t[4 + j] * t[8 + k] - (double)t[4 + k] * t[8 + j]);
    }
    return determinant < 0.0;
}

bool glint_resident_draws(const struct glint_resident *r, uint32_t instance)
{
    return r->scene->instance[instance].visible && !(r->pose && r->pose->instance[instance].hidden);
}

bool glint_resident_shows(const struct glint_resident *r, uint32_t light)
{
    return r->scene->light[light].kind == GLINT_LIGHT_AREA &&
           !(r->pose && r->pose->light[light].hidden);
}

static bool emissive(const struct glint_material *m)
{
    return m->emission[0] > 0.0f || m->emission[1] > 0.0f || m->emission[2] > 0.0f;
}

// ---- where things are

// Transforms of one row in the world: at each key, then a frame earlier and later.
struct path {
    double at[GLINT_POSE_MAX_KEYS][16];
    const double *flow; // [2][16] or NULL
    bool moves;
};

static void path_of_instance(const struct glint_resident *r, uint32_t i, struct path *out)
{
    const struct glint_pose_instance *in = r->pose ? &r->pose->instance[i] : NULL;
    out->moves = in && in->moves;
    out->flow = in ? in->flow_transform : NULL;
    for (uint32_t k = 0; k < (out->moves ? r->pose->keys : 1); k++)
        glint_pose_instance_at(r->pose, r->scene, i, k, out->at[k]);
}

static void path_of_light(const struct glint_resident *r, uint32_t i, struct path *out)
{
    const struct glint_pose_placement *l = r->pose ? &r->pose->light[i] : NULL;
    out->moves = l && l->moves;
    out->flow = l ? l->flow_transform : NULL;
    for (uint32_t k = 0; k < (out->moves ? r->pose->keys : 1); k++)
        glint_pose_light_at(r->pose, r->scene, i, k, out->at[k]);
}

// To the centre; size: of an area light along its x and y.
static void relative(const struct glint_resident *r, const double world[16], const float *size,
                     float out[16])
{
    for (int i = 0; i < 16; i++)
        out[i] = (float)(size && i < 8 ? world[i] * (double)size[i / 4] : world[i]);
    for (int k = 0; k < 3; k++)
        out[12 + k] = (float)(world[12 + k] - r->centre[k]);
}

#define FLOATS_OF_PATH ((GLINT_POSE_MAX_KEYS + 2) * 16)

static void place_row(struct glint_resident *r, uint32_t index, const struct path *path,
                      const float *size)
{
    struct glint_row *row = &r->row[index];
    float *room = r->motion ? r->motion + (size_t)index * FLOATS_OF_PATH : NULL;
    relative(r, path->at[0], size, row->transform);
    for (uint32_t k = 0; path->moves && k < r->pose->keys; k++)
        relative(r, path->at[k], size, room + 16 * (size_t)k);
    row->motion = path->moves ? room : NULL;
    for (uint32_t k = 0; path->flow && k < 2; k++)
        relative(r, path->flow + 16 * k, size, room + 16 * (size_t)(GLINT_POSE_MAX_KEYS + k));
    row->flow = path->flow ? room + 16 * (size_t)GLINT_POSE_MAX_KEYS : NULL;
}

static void place_rows(struct glint_resident *r)
{
    struct path path;
    uint32_t row = 0;
    for (uint32_t i = 0; i < r->scene->instances; i++)
        if (glint_resident_draws(r, i)) {
            path_of_instance(r, i, &path);
            place_row(r, row++, &path, NULL);
        }
    for (uint32_t i = 0; i < r->scene->lights; i++)
        if (glint_resident_shows(r, i)) {
            path_of_light(r, i, &path);
            place_row(r, row++, &path, r->scene->light[i].size);
        }
}

// ---- which are drawn

static void add_row(struct glint_resident *r, uint32_t kept, uint32_t material, uint32_t instance,
                    bool emits)
{
    struct glint_row *row = &r->row[r->rows++];
    row->mesh = r->kept[kept].mesh;
    row->kept = kept;
    row->material = material;
    row->instance = instance;
    row->emits = emits;
    r->kept[kept].uses++;
}

static void collect_rows(struct glint_resident *r)
{
    const struct glint_scene *s = r->scene;
    for (uint32_t i = 0; i < s->instances; i++)
        if (glint_resident_draws(r, i)) {
            const struct glint_instance *in = &s->instance[i];
            add_row(r, glint_kept_of(r, i), in->material, i, emissive(&s->material[in->material]));
        }
    uint32_t nth = 0;
    for (uint32_t i = 0; i < s->lights; i++) {
        if (glint_resident_shows(r, i))
            add_row(r, s->meshes, s->materials + nth, GLINT_NONE, true);
        nth += s->light[i].kind == GLINT_LIGHT_AREA;
    }
}

glint_status glint_resident_build_rows(struct glint_resident *r, struct glint_error *err)
{
    const struct glint_scene *s = r->scene;
    const size_t capacity = (size_t)s->instances + s->lights + 1;
    r->row = calloc(capacity, sizeof *r->row);
    if (r->pose)
        r->motion = malloc(capacity * FLOATS_OF_PATH * sizeof *r->motion);
    if (!r->row || (r->pose && !r->motion))
        return glint_fail(err, GLINT_E_NOMEM, "", "no memory for %zu instances", capacity);
    glint_status st = glint_resident_list_kept(r, err);
    if (st)
        return st;
    collect_rows(r);
    st = glint_resident_keep(r, err);
    if (!st)
        st = glint_resident_find_centre(r, err);
    if (!st)
        place_rows(r);
    return st;
}
