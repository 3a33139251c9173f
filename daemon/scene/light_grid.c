#include "scene/light_grid.h"

#include "kernels/gk_light_grid.h"
#include "scene/alias.h"
#include "scene/light_clusters.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#define CLUSTERS 2048u
#define ENTRIES (1u << 20) // cells times clusters
#define CELLS 1024u
#define MAX_SIDE 32u

// Share of the choice that goes by power alone: what the estimate of a cell calls dark is still
// found, at no more than 1/DEFENCE times the variance of the power table.
#define DEFENCE 0.05

#define KEEP_STEPS 65536.0
#define MEMBER_STEPS 0x1p24

// What cells are computed with: one array a term, in single precision, powers near 1.
enum { AT_X, AT_Y, AT_Z, SPREAD, MEAN, LINEAR_X, LINEAR_Y, LINEAR_Z, QUADRIC, TERMS = QUADRIC + 6 };

struct build {
    const struct glint_light_grid_order *order;
    struct glint_scene_lighting *lighting;
    struct glint_shine *shine; // [lights]
    uint32_t *by_cluster;      // [members] lights
    uint32_t members;
    struct glint_cluster cluster[CLUSTERS];
    uint32_t clusters;
    float term[TERMS][CLUSTERS], sun[CLUSTERS], everywhere[CLUSTERS];
    double low[3], size[3]; // of the box
    uint32_t *word;
};

// ---- the box and its cells

// Around the lights, as far as there is something to be lit.
static void box_of_lights(struct build *b)
{
    const double *half = b->order->half;
    double low[3] = {INFINITY, INFINITY, INFINITY}, high[3] = {-INFINITY, -INFINITY, -INFINITY};
    for (uint32_t i = 0; i < b->members; i++) {
        const struct glint_shine *s = &b->shine[b->by_cluster[i]];
        for (int k = 0; s->sun == 0.0 && k < 3; k++) {
            low[k] = fmin(low[k], s->moment[k] / s->power);
            high[k] = fmax(high[k], s->moment[k] / s->power);
        }
    }
    double widest = 0.0, room = 0.0;
    for (int k = 0; k < 3; k++) {
        widest = fmax(widest, high[k] - low[k]);
        room = fmax(room, half[k]);
    }
    const double margin = 0.25 * widest + 0.02 * room;
    for (int k = 0; k < 3; k++) {
        const bool any = low[k] <= high[k]; // else they are all suns
        b->low[k] = any ? fmax(low[k] - margin, fmin(-half[k], low[k])) : -half[k];
        b->size[k] = (any ? fmin(high[k] + margin, fmax(half[k], high[k])) : half[k]) - b->low[k];
    }
}

// Cells nearly cubes, at most `most` of them. Walls seldom lie on their borders: on which side a point
// of such a wall is would be a matter of rounding, and the two weights of MIS would disagree.
static void divide(struct build *b, uint32_t most)
{
    struct glint_scene_lighting *l = b->lighting;
    double widest = fmax(b->size[0], fmax(b->size[1], b->size[2]));
    widest = widest > 0.0 ? widest : 1.0;
    for (int k = 0; k < 3; k++) {
        b->size[k] = fmax(b->size[k], 1e-3 * widest);
        b->low[k] -= 0.00731 * b->size[k];
        b->size[k] *= 1.01862;
    }
    double side = cbrt(b->size[0] * b->size[1] * b->size[2] / most);
    for (uint32_t cells = UINT32_MAX; cells > most; side *= 1.02) {
        cells = 1;
        for (int k = 0; k < 3; k++) {
            l->grid_size[k] = (uint32_t)fmin(fmax(floor(b->size[k] / side), 1.0), MAX_SIDE);
            cells *= l->grid_size[k];
        }
    }
    for (int k = 0; k < 3; k++) {
        l->grid_origin[k] = (float)b->low[k];
        l->grid_scale[k] = (float)(l->grid_size[k] / b->size[k]);
    }
}

// ---- clusters

static glint_status prepare(struct build *b, struct glint_error *err)
{
    const struct glint_light_grid_order *o = b->order;
    b->shine = malloc(o->lights * sizeof *b->shine);
    b->by_cluster = malloc(o->lights * sizeof *b->by_cluster);
    if (!b->shine || !b->by_cluster)
        return glint_fail(err, GLINT_E_NOMEM, "", "no memory for %u lights", o->lights);
    for (uint32_t i = 0; i < o->lights; i++)
        if (o->power[i] > 0.0) {
            b->shine[i] = glint_light_shine(&o->light[i], o->power[i]);
            b->by_cluster[b->members++] = i;
        }
    return GLINT_OK;
}

// Terms in units of a power of two near the total: emission times 2^k leaves every bit as it is.
static void tabulate(struct build *b)
{
    double total = 0.0, most_sun = 0.0;
    for (uint32_t c = 0; c < b->clusters; c++) {
        const struct glint_shine *s = &b->cluster[c].shine;
        total += s->mean;
        most_sun = fmax(most_sun, s->sun);
    }
    int exponent;
    frexp(fmax(total, most_sun), &exponent);
    for (uint32_t c = 0; c < b->clusters; c++) {
        const struct glint_shine *s = &b->cluster[c].shine;
        const bool sun = s->sun > 0.0;
        double square = sun ? 1.0 : s->square / s->power;
        for (int k = 0; k < 3; k++) {
            const double at = sun ? 0.0 : s->moment[k] / s->power;
            square -= at * at;
            b->term[AT_X + k][c] = (float)at;
            b->term[LINEAR_X + k][c] = (float)ldexp(s->linear[k], -exponent);
        }
        for (int k = 0; k < 6; k++)
            b->term[QUADRIC + k][c] = (float)ldexp(s->quadric[k], -exponent);
        b->term[SPREAD][c] = (float)fmax(square, 0.0);
        b->term[MEAN][c] = (float)ldexp(s->mean, -exponent);
        b->sun[c] = (float)ldexp(s->sun, -exponent);
    }
}

// What goes by power alone.
static void defend(struct build *b)
{
    double total = 0.0, power[CLUSTERS] = {0};
    for (uint32_t c = 0; c < b->clusters; c++) {
        for (uint32_t i = 0; i < b->cluster[c].count; i++)
            power[c] += b->order->power[b->by_cluster[b->cluster[c].first + i]];
        total += power[c];
    }
    for (uint32_t c = 0; c < b->clusters; c++)
        b->everywhere[c] = (float)(DEFENCE * b->clusters * power[c] / total);
}

// Irradiance that each cluster may bring to a cell around p whose points lie `variance` from it in
// the mean square. Directions are shortened where the cell or the cluster is wide beside the
// distance between them: there they point anywhere.
static void weigh(const struct build *b, const double p[3], double variance, float *weight)
{
    const float px = (float)p[0], py = (float)p[1], pz = (float)p[2], wide = (float)variance;
    const float(*t)[CLUSTERS] = b->term;
    for (uint32_t c = 0; c < b->clusters; c++) {
        const float x = px - t[AT_X][c], y = py - t[AT_Y][c], z = pz - t[AT_Z][c];
        const float square = x * x + y * y + z * z + t[SPREAD][c] + wide;
        const float inverse = 1.0f / square, root = sqrtf(inverse);
        const float linear = t[LINEAR_X][c] * x + t[LINEAR_Y][c] * y + t[LINEAR_Z][c] * z;
        const float quadric =
            t[QUADRIC][c] * x * x + t[QUADRIC + 1][c] * y * y + t[QUADRIC + 2][c] * z * z +
            2.0f *
                (t[QUADRIC + 3][c] * x * y + t[QUADRIC + 4][c] * x * z + t[QUADRIC + 5][c] * y * z);
        const float intensity = t[MEAN][c] + linear * root + quadric * inverse;
        const float least = 0.02f * t[MEAN][c];
        weight[c] = (intensity > least ? intensity : least) * inverse + b->sun[c];
    }
}

// ---- tables

// Vose's method on shares that sum to n, keeps in steps of 1/65536; then what is really chosen how
// often, counted in steps.
static void fill_cell(struct build *b, float *share, uint32_t *entry)
{
    const uint32_t n = b->clusters, whole = (uint32_t)KEEP_STEPS;
    uint16_t stack[CLUSTERS];
    uint32_t steps[CLUSTERS], small = 0, large = n;
    for (uint32_t i = 0; i < n; i++) {
        steps[i] = 0;
        if (share[i] < 1.0f)
            stack[small++] = (uint16_t)i;
        else
            stack[--large] = (uint16_t)i;
    }
    while (small > 0 && large < n) {
        const uint32_t s = stack[--small], l = stack[large];
        const float rounded = fmaxf(roundf(share[s] * (float)KEEP_STEPS), 1.0f);
        const uint32_t keep = rounded < (float)whole ? (uint32_t)rounded : whole - 1;
        entry[2 * s] = keep << 16 | l;
        steps[s] += keep;
        steps[l] += whole - keep;
        share[l] -= (float)(whole - keep) * (float)(1.0 / KEEP_STEPS);
        if (share[l] < 1.0f) {
            large++;
            stack[small++] = (uint16_t)l;
        }
    }
    while (large < n)
        stack[small++] = stack[large++];
    while (small > 0) {
        const uint32_t i = stack[--small];
        entry[2 * i] = (whole - 1) << 16 | i;
        steps[i] += whole;
    }
    for (uint32_t i = 0; i < n; i++) {
        const float p = (float)(steps[i] / (KEEP_STEPS * n));
        memcpy(&entry[2 * i + 1], &p, sizeof p);
    }
}

static void fill_cells(struct build *b)
{
    const uint32_t *size = b->lighting->grid_size, n = b->clusters;
    double step[3], variance = 0.0;
    for (int k = 0; k < 3; k++) {
        step[k] = b->size[k] / size[k];
        variance += step[k] * step[k] / 12.0;
    }
    uint32_t *entry = b->word;
    for (uint32_t z = 0; z < size[2]; z++)
        for (uint32_t y = 0; y < size[1]; y++)
            for (uint32_t x = 0; x < size[0]; x++, entry += 2 * n) {
                float weight[CLUSTERS];
                const double p[3] = {b->low[0] + (x + 0.5) * step[0],
                                     b->low[1] + (y + 0.5) * step[1],
                                     b->low[2] + (z + 0.5) * step[2]};
                weigh(b, p, variance, weight);
                double total = 0.0;
                for (uint32_t c = 0; c < n; c++)
                    total += weight[c];
                const float scale = (float)((1.0 - DEFENCE) * n / total);
                for (uint32_t c = 0; c < n; c++)
                    weight[c] = weight[c] * scale + b->everywhere[c];
                fill_cell(b, weight, entry);
            }
}

// One cluster's alias table over its lights, and their shares.
static bool fill_members(struct build *b, uint32_t cluster, double *share)
{
    const struct glint_cluster *c = &b->cluster[cluster];
    const uint32_t *light = b->by_cluster + c->first;
    uint32_t *record = b->word + b->lighting->grid_members + 3 * (size_t)c->first;
    uint32_t *owner = b->word + b->lighting->grid_owners;
    for (uint32_t i = 0; i < c->count; i++)
        share[i] = b->shine[light[i]].power;
    if (!glint_alias_build(share, c->count, (float *)record, record + 2, 3))
        return false;
    glint_alias_round((float *)record, record + 2, c->count, 3, share);
    for (uint32_t i = 0; i < c->count; i++) {
        const float p = (float)share[i];
        record[3 * i + 1] = light[i];
        record[3 * i + 2] = light[record[3 * i + 2]];
        owner[2 * light[i]] = cluster;
        memcpy(&owner[2 * light[i] + 1], &p, sizeof p);
    }
    return true;
}

static size_t lay_out(struct build *b)
{
    struct glint_scene_lighting *l = b->lighting;
    const uint32_t cells = l->grid_size[0] * l->grid_size[1] * l->grid_size[2];
    l->grid_clusters = b->clusters;
    l->grid_members = 2 * (cells + 1) * b->clusters;
    l->grid_owners = l->grid_members + 3 * b->members;
    return (size_t)l->grid_owners + 2 * (size_t)b->order->lights;
}

static glint_status fill(struct build *b, struct glint_error *err)
{
    double *share = malloc(b->members * sizeof *share);
    bool done = share != NULL;
    uint32_t *record = b->word + b->lighting->grid_members - 2 * b->clusters;
    for (uint32_t c = 0; done && c < b->clusters; c++) {
        record[2 * c] = b->cluster[c].first;
        record[2 * c + 1] = b->cluster[c].count;
        done = fill_members(b, c, share);
    }
    free(share);
    if (!done)
        return glint_fail(err, GLINT_E_NOMEM, "", "no memory for %u lights", b->members);
    fill_cells(b);
    return GLINT_OK;
}

// Whether some light has no area. A point that is close outshines all others of its cluster and of the
// cells around it, so that many candidates must look for it, and no ray of a surface's own finds it. An
// area that is as close is found by such rays, and MIS takes from the light sample what they bring.
static bool has_point(const struct build *b)
{
    bool any = false;
    for (uint32_t i = 0; i < b->members; i++)
        any |= (b->order->light[b->by_cluster[i]].kind & GK_LIGHT_KIND) != GK_LIGHT_TRIANGLE;
    return any;
}

glint_status glint_light_grid_build(uint32_t **words, size_t *count,
                                    struct glint_scene_lighting *lighting,
                                    const struct glint_light_grid_order *order,
                                    struct glint_error *err)
{
    *words = NULL;
    struct build *b = calloc(1, sizeof *b);
    if (!b)
        return glint_fail(err, GLINT_E_NOMEM, "", "no memory for the light grid");
    b->order = order;
    b->lighting = lighting;
    glint_status st = prepare(b, err);
    if (!st) {
        b->clusters =
            glint_light_clusters(b->cluster, CLUSTERS, b->by_cluster, b->members, b->shine);
        lighting->grid_many = b->clusters >= GK_GRID_MANY && has_point(b);
        tabulate(b);
        defend(b);
        box_of_lights(b);
        divide(b, ENTRIES / b->clusters < CELLS ? ENTRIES / b->clusters : CELLS);
        *count = lay_out(b);
        b->word = calloc(*count, sizeof *b->word);
        st = b->word ? fill(b, err)
                     : glint_fail(err, GLINT_E_NOMEM, "", "no memory for the light grid");
    }
    if (st)
        free(b->word);
    else
        *words = b->word;
    free(b->shine);
    free(b->by_cluster);
    free(b);
    return st;
}
