#include "accuracy_stat.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#define ROUNDS 1000 // of the bootstrap
#define MAX_VALUES 64

// 97.5% quantile of Student's t; Cornish and Fisher's expansion, within 0.1% from 6 degrees on.
static double student(size_t degrees)
{
    static const double few[] = {0, 12.706, 4.303, 3.182, 2.776, 2.571};
    if (degrees <= 5)
        return few[degrees];
    const double z = 1.959964, n = (double)degrees, z3 = z * z * z, z5 = z3 * z * z;
    return z + (z3 + z) / (4 * n) + (5 * z5 + 16 * z3 + 3 * z) / (96 * n * n) +
           (3 * z5 * z * z + 19 * z5 + 17 * z3 - 15 * z) / (384 * n * n * n);
}

struct glint_accuracy_interval glint_accuracy_mean_of(const double *value, size_t n)
{
    double sum = 0, squares = 0;
    for (size_t i = 0; i < n; i++)
        sum += value[i];
    const double mean = sum / (double)n;
    for (size_t i = 0; i < n; i++)
        squares += (value[i] - mean) * (value[i] - mean);
    const double half =
        n > 1 ? student(n - 1) * sqrt(squares / ((double)(n - 1) * (double)n)) : INFINITY;
    return (struct glint_accuracy_interval){mean, mean - half, mean + half};
}

static int ascending(const void *a, const void *b)
{
    const double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

// Sorts.
static double median(double *value, size_t n)
{
    qsort(value, n, sizeof *value, ascending);
    return n % 2 ? value[n / 2] : 0.5 * (value[n / 2 - 1] + value[n / 2]);
}

// PCG-XSH-RR, O'Neill 2014.
static uint32_t draw(uint64_t *state)
{
    *state = *state * 6364136223846793005u + 1442695040888963407u;
    const uint32_t mixed = (uint32_t)(((*state >> 18) ^ *state) >> 27);
    const unsigned turn = (unsigned)(*state >> 59);
    return mixed >> turn | mixed << (-turn & 31);
}

struct glint_accuracy_interval glint_accuracy_median_of(const double *value, size_t n)
{
    double again[MAX_VALUES], medians[ROUNDS];
    uint64_t state = 1;
    n = n < MAX_VALUES ? n : MAX_VALUES;
    for (int r = 0; r < ROUNDS; r++) {
        for (size_t i = 0; i < n; i++)
            again[i] = value[draw(&state) % n];
        medians[r] = median(again, n);
    }
    qsort(medians, ROUNDS, sizeof *medians, ascending);
    memcpy(again, value, n * sizeof *again);
    return (struct glint_accuracy_interval){median(again, n), medians[ROUNDS / 40],
                                            medians[ROUNDS - 1 - ROUNDS / 40]};
}

// ---- points

static double cost_of(const struct glint_accuracy_row *row, enum glint_accuracy_cost cost)
{
    return cost == GLINT_COST_CPU ? row->cpu : row->rays[0] + row->rays[1] + row->rays[2];
}

static bool is_of(const struct glint_accuracy_row *row, const char *knob, const char *value,
                  unsigned spp)
{
    return row->spp == spp && strcmp(row->seed, "all") != 0 && !strcmp(row->value, value) &&
           !strcmp(row->knob, knob);
}

static bool is_limited(const struct glint_accuracy_row *row)
{
    const char *colon = strrchr(row->ref_id, ':');
    return colon && strcmp(colon, ":limited") == 0;
}

bool glint_accuracy_point_of(struct glint_accuracy_point *out,
                             const struct glint_accuracy_table *table, const char *knob,
                             const char *value, unsigned spp)
{
    double error[MAX_VALUES];
    *out = (struct glint_accuracy_point){.spp = spp};
    for (size_t i = 0; i < table->rows && out->seeds < MAX_VALUES; i++) {
        const struct glint_accuracy_row *row = &table->row[i];
        if (!is_of(row, knob, value, spp))
            continue;
        error[out->seeds++] = isfinite(row->tv) ? row->tv : row->rmse61;
        for (int c = 0; c < GLINT_COSTS; c++)
            out->cost[c] += cost_of(row, (enum glint_accuracy_cost)c);
        out->limited |= is_limited(row);
    }
    for (int c = 0; c < GLINT_COSTS && out->seeds; c++)
        out->cost[c] /= out->seeds;
    if (out->seeds)
        out->error = glint_accuracy_mean_of(error, out->seeds);
    return out->seeds;
}

// In one of both and in neither worse.
static bool beats(const struct glint_accuracy_point *a, const struct glint_accuracy_point *b, int c)
{
    const double cost = a->cost[c] - b->cost[c], error = a->error.middle - b->error.middle;
    return cost <= 0 && error <= 0 && (cost < 0 || error < 0);
}

void glint_accuracy_mark_front(struct glint_accuracy_point *point, size_t count)
{
    for (size_t i = 0; i < count; i++)
        for (int c = 0; c < GLINT_COSTS; c++) {
            point[i].front[c] = true;
            for (size_t j = 0; j < count; j++)
                if (beats(&point[j], &point[i], c))
                    point[i].front[c] = false;
        }
}

bool glint_accuracy_ratio(struct glint_accuracy_interval *out,
                          const struct glint_accuracy_table *table,
                          const struct glint_accuracy_row *setting,
                          const struct glint_accuracy_row *twin, enum glint_accuracy_cost cost)
{
    double ratio[MAX_VALUES];
    size_t n = 0;
    for (size_t i = 0; i < table->rows && n < MAX_VALUES; i++) {
        const struct glint_accuracy_row *row = &table->row[i];
        if (!is_of(row, setting->knob, setting->value, setting->spp))
            continue;
        const struct glint_accuracy_row *other =
            glint_accuracy_table_find(table, twin->knob, twin->value, row->seed, row->spp);
        if (other && cost_of(other, cost) > 0)
            ratio[n++] = cost_of(row, cost) / cost_of(other, cost);
    }
    if (n)
        *out = glint_accuracy_median_of(ratio, n);
    return n;
}

double glint_accuracy_error_at(const struct glint_accuracy_point *line, size_t count,
                               enum glint_accuracy_cost cost, double at)
{
    size_t i = 0;
    if (!count)
        return NAN;
    while (i + 1 < count && line[i].cost[cost] < at)
        i++;
    const struct glint_accuracy_point *b = &line[i];
    if (i == 0 || b->cost[cost] < at)
        return b->error.middle * sqrt(b->cost[cost] / at);
    const struct glint_accuracy_point *a = b - 1;
    const double share = log(at / a->cost[cost]) / log(b->cost[cost] / a->cost[cost]);
    return a->error.middle * pow(b->error.middle / a->error.middle, share);
}
