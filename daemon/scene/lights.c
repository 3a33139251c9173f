// lights.c - the table of everything that next-event estimation can choose, and how often it does.
#include "kernels/gk_light_grid.h"
#include "scene/alias.h"
#include "scene/internal.h"
#include "scene/light_grid.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

static double luminance(const float L[3])
{
    return 0.2126 * L[0] + 0.7152 * L[1] + 0.0722 * L[2];
}

static double light_area(const struct gk_light *l)
{
    double n[3];
    for (int k = 0; k < 3; k++) {
        const int a = (k + 1) % 3, b = (k + 2) % 3;
        n[k] = (double)l->a[a] * l->b[b] - (double)l->a[b] * l->b[a];
    }
    return 0.5 * sqrt(n[0] * n[0] + n[1] * n[1] + n[2] * n[2]);
}

// Mean of an emission texture, so that the choice of a light follows what it gives.
static double texture_mean(const struct glint_resident *r, uint32_t texture)
{
    if (texture == GK_NONE)
        return 1.0;
    const struct gk_texture *t =
        (const struct gk_texture *)glint_table_host(r, GLINT_TABLE_TEXTURES) + texture;
    const struct glint_image *image = &r->scene->image[t->image];
    const float *decode = glint_table_host(r, GLINT_TABLE_DECODE);
    const uint8_t *p = image->pixels;
    const size_t n = (size_t)image->width * image->height;
    double sum = 0.0;
    for (size_t i = 0; i < n; i++)
        sum += 0.2126 * decode[p[4 * i]] + 0.7152 * decode[p[4 * i + 1]] +
               0.0722 * decode[p[4 * i + 2]];
    return sum / (double)n;
}

static uint32_t count_lights(const struct glint_resident *r)
{
    uint32_t n = 0;
    for (uint32_t i = 0; i < r->rows; i++)
        n += r->row[i].emits ? glint_row_kept(r, &r->row[i])->triangles : 0;
    for (uint32_t i = 0; i < r->scene->lights; i++)
        n += r->scene->light[i].kind != GLINT_LIGHT_AREA;
    return n;
}

// Motion keys of the table: 1 where nothing that shines moves.
static uint32_t count_keys(const struct glint_resident *r)
{
    const uint32_t keys = glint_resident_keys(r);
    for (uint32_t i = 0; i < r->rows; i++)
        if (r->row[i].emits && glint_row_moves(r, &r->row[i]))
            return keys;
    for (uint32_t i = 0; r->pose && i < r->scene->lights; i++)
        if (r->scene->light[i].kind != GLINT_LIGHT_AREA && r->pose->light[i].moves)
            return keys;
    return 1;
}

// Entry `index` of the table at a key.
static struct gk_light *light_at(const struct glint_resident *r, uint32_t index, uint32_t key)
{
    struct gk_light *table = glint_table_host(r, GLINT_TABLE_LIGHTS);
    return table + (size_t)key * r->lighting.light_stride + index;
}

static void triangle_light(const struct glint_resident *r, const struct glint_row *row,
                           uint32_t index, uint32_t key, struct gk_light *l)
{
    const struct glint_kept *k = glint_row_kept(r, row);
    const struct gk_material *m =
        (const struct gk_material *)glint_table_host(r, GLINT_TABLE_MATERIALS) + row->material;
    const bool flip = glint_row_mirrors(row);
    float p[3][3];
    for (int c = 0; c < 3; c++) {
        double world[3];
        glint_row_vertex(r, row, key, k->index[3 * index + (flip && c ? 3 - c : c)], world);
        for (int a = 0; a < 3; a++)
            p[c][a] = (float)world[a];
    }
    memset(l, 0, sizeof *l);
    for (int a = 0; a < 3; a++) {
        l->p[a] = p[0][a];
        l->a[a] = p[1][a] - p[0][a];
        l->b[a] = p[2][a] - p[0][a];
        l->L[a] = m->emission[a];
    }
    const bool two_sided = m->flags & GK_MATERIAL_TWO_SIDED_EMISSION;
    l->kind = GK_LIGHT_TRIANGLE | (flip ? GK_LIGHT_TURNED : 0u) | (two_sided ? 1u << 4 : 0u);
    l->triangle = row->triangle + index;
    l->material = m->emission_texture != GK_NONE ? row->material : GK_NONE;
}

// Every triangle of a row has its entry, in the order of the row: a hit finds it by its number.
// One of no power at the first key is never chosen.
static void add_row(struct glint_resident *r, uint32_t index, uint32_t keys, double *power)
{
    const struct glint_row *row = &r->row[index];
    const struct glint_kept *k = glint_row_kept(r, row);
    const struct gk_material *m =
        (const struct gk_material *)glint_table_host(r, GLINT_TABLE_MATERIALS) + row->material;
    const uint32_t texture = m->emission_texture;
    const double mean = texture_mean(r, texture);
    struct gk_instance *in = (struct gk_instance *)glint_table_host(r, GLINT_TABLE_INSTANCES);
    in[index].light = r->lights;
    for (uint32_t i = 0; i < k->triangles; i++) {
        for (uint32_t key = 0; key < keys; key++)
            triangle_light(r, row, i, key, light_at(r, r->lights, key));
        const struct gk_light *l = light_at(r, r->lights, 0);
        const double sides = l->kind >> 4 ? 2.0 : 1.0;
        // Of what the texture shows there; a little of all of it, for spots that fell between.
        const double shown =
            texture == GK_NONE
                ? 1.0
                : 0.95 * glint_resident_emission(r, texture, l->triangle) + 0.05 * mean;
        power[r->lights++] = M_PI * luminance(l->L) * shown * light_area(l) * sides;
    }
}

// Radiant power that a light sends into the scene.
static double punctual_power(const struct glint_resident *r, const struct glint_light *from,
                             const struct gk_light *l)
{
    const double Y = luminance(l->L);
    if (from->kind == GLINT_LIGHT_SUN)
        return Y * M_PI * fmax(r->radius * r->radius, 1e-30);
    if (from->kind == GLINT_LIGHT_SPOT)
        return Y * 2.0 * M_PI * (1.0 - 0.5 * (cos(from->inner_cone) + cos(from->outer_cone)));
    return Y * 4.0 * M_PI;
}

// KHR_lights_punctual: falloff ((cos a - cos outer) / max(1e-3, cos inner - cos outer))^2, clamped.
static void cone(const struct glint_light *from, struct gk_light *l)
{
    const bool spot = from->kind == GLINT_LIGHT_SPOT;
    const double outer = spot ? cos(from->outer_cone) : -2.0;
    const double inner = spot ? cos(from->inner_cone) : -1.0;
    l->b[0] = (float)outer;
    l->b[1] = (float)(1.0 / fmax(1e-3, inner - outer));
}

// `to_world`: of the light, at the key that the entry is for.
static void punctual_light(const struct glint_resident *r, const struct glint_light *from,
                           const double to_world[16], struct gk_light *l)
{
    const double *z = to_world + 8, length = sqrt(z[0] * z[0] + z[1] * z[1] + z[2] * z[2]);
    memset(l, 0, sizeof *l);
    for (int k = 0; k < 3; k++) {
        const double back = length > 0.0 ? z[k] / length : 0.0; // +z, against the beam
        const double place = to_world[12 + k] - r->centre[k];
        l->p[k] = (float)(from->kind == GLINT_LIGHT_SUN ? back : place);
        l->a[k] = from->kind == GLINT_LIGHT_SPOT ? (float)-back : 0.0f;
        l->L[k] = from->color[k] * from->intensity;
    }
    cone(from, l);
    l->kind = from->kind == GLINT_LIGHT_SUN ? GK_LIGHT_SUN : GK_LIGHT_POINT;
    l->triangle = l->material = GK_NONE;
}

static void add_punctual(struct glint_resident *r, uint32_t index, uint32_t keys, double *power)
{
    const struct glint_light *from = &r->scene->light[index];
    for (uint32_t key = 0; key < keys; key++) {
        double to_world[16];
        glint_pose_light_at(r->pose, r->scene, index, key, to_world);
        punctual_light(r, from, to_world, light_at(r, r->lights, key));
    }
    power[r->lights] = punctual_power(r, from, light_at(r, r->lights, 0));
    r->lights += power[r->lights] > 0.0;
}

// power: what each gives, on return how often each is really chosen.
static glint_status choose_by(struct glint_resident *r, double *power, struct glint_error *err)
{
    struct gk_alias *alias = glint_table_host(r, GLINT_TABLE_ALIAS);
    struct gk_light *light = glint_table_host(r, GLINT_TABLE_LIGHTS);
    double total = 0.0;
    for (uint32_t i = 0; i < r->lights; i++)
        total += power[i];
    if (total == 0.0)
        r->lights = 0; // all black
    if (!r->lights)
        return GLINT_OK;
    if (!glint_alias_build(power, r->lights, &alias->keep, &alias->other, 2))
        return glint_fail(err, GLINT_E_NOMEM, "", "no memory for the light table");
    glint_alias_round(&alias->keep, &alias->other, r->lights, 2, power);
    for (uint32_t i = 0; i < r->lights; i++)
        light[i].choice = (float)power[i];
    return GLINT_OK;
}

// Where each light is wanted, when there are so many that it matters.
static glint_status choose_where(struct glint_resident *r, const double *power,
                                 struct glint_error *err)
{
    uint32_t shining = 0, *words = NULL;
    for (uint32_t i = 0; i < r->lights; i++)
        shining += power[i] > 0.0;
    r->facts.light_grid = shining >= GLINT_LIGHT_GRID_LEAST;
    if (!r->facts.light_grid)
        return GLINT_OK;
    const struct glint_light_grid_order order = {glint_table_host(r, GLINT_TABLE_LIGHTS), power,
                                                 r->lights, r->half};
    size_t count;
    glint_status st = glint_light_grid_build(&words, &count, &r->lighting, &order, err);
    r->facts.light_grid_many = !st && r->lighting.grid_many;
    if (!st)
        st = glint_buffer_create(&r->table[GLINT_TABLE_LIGHT_CELLS], r->devices,
                                 count * sizeof *words, err);
    if (!st)
        memcpy(glint_table_host(r, GLINT_TABLE_LIGHT_CELLS), words, count * sizeof *words);
    free(words);
    return st;
}

glint_status glint_resident_build_lights(struct glint_resident *r, struct glint_error *err)
{
    const uint32_t capacity = count_lights(r) + 1, keys = count_keys(r);
    double *power = calloc(capacity, sizeof *power);
    if (!power)
        return glint_fail(err, GLINT_E_NOMEM, "", "no memory for %u lights", capacity);
    glint_status st = glint_buffer_create(&r->table[GLINT_TABLE_LIGHTS], r->devices,
                                          (size_t)keys * capacity * sizeof(struct gk_light), err);
    if (!st)
        st = glint_buffer_create(&r->table[GLINT_TABLE_ALIAS], r->devices,
                                 (size_t)capacity * sizeof(struct gk_alias), err);
    r->lighting.light_stride = keys > 1 ? capacity : 0;
    r->facts.motion |= keys > 1;
    if (!st) {
        for (uint32_t i = 0; i < r->rows; i++)
            if (r->row[i].emits)
                add_row(r, i, keys, power);
        for (uint32_t i = 0; i < r->scene->lights; i++)
            if (r->scene->light[i].kind != GLINT_LIGHT_AREA)
                add_punctual(r, i, keys, power);
        st = choose_where(r, power, err);
        if (!st)
            st = choose_by(r, power, err);
    }
    free(power);
    r->facts.light_table = r->lights > 0;
    r->lighting.lights = r->lights;
    r->stats.lights = r->lights;
    return st;
}
