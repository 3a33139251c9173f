#include "scene/energy.h"

#include "base/thread.h"
#include "scene/energy_rows.h"

#include <stdatomic.h>
#include <stdbool.h>
#include <string.h>
#include <unistd.h>

#define STEPS GLINT_ENERGY_STEPS
#define MOST_HELPERS 7

static pthread_mutex_t mutex = PTHREAD_MUTEX_INITIALIZER; // guards what is below
static bool made[STEPS];
static float table[STEPS][GK_ENERGY_PART];
static bool made_glass[STEPS];
static float glass[STEPS][GK_ENERGY_PARTS * GK_ENERGY_PART];

// ---- rows, by all cores

typedef void row_fn(float *parts, float ior, int y);

struct rows {
    row_fn *fill;
    float *parts;
    float ior;
    atomic_int next; // relaxed: a row is whose turn it was; the join publishes it
};

static void *take_rows(void *arg)
{
    struct rows *r = arg;
    for (int y;
         (y = atomic_fetch_add_explicit(&r->next, 1, memory_order_relaxed)) < GK_ENERGY_SIDE;)
        r->fill(r->parts, r->ior, y);
    return NULL;
}

// Where no thread is to be had the caller does all of it.
static void fill(row_fn *row, float *parts, float ior)
{
    struct rows r = {.fill = row, .parts = parts, .ior = ior};
    pthread_t helper[MOST_HELPERS];
    const long cores = sysconf(_SC_NPROCESSORS_ONLN);
    int helpers = 0;
    while (helpers < MOST_HELPERS && helpers + 1 < cores &&
           !glint_thread_start(&helper[helpers], "energy", take_rows, &r, NULL))
        helpers++;
    take_rows(&r);
    while (helpers > 0)
        pthread_join(helper[--helpers], NULL);
}

// ---- parts

static int usual_step(void)
{
    float taken;
    return glint_energy_step(GLINT_ENERGY_USUAL, &taken);
}

static const float *part_of(int step, float ior)
{
    pthread_mutex_lock(&mutex);
    if (!made[step] &&
        step == usual_step()) // a copy: who asks for glass is told apart by the pointer
        memcpy(table[step], glint_energy_usual_glass, sizeof table[step]);
    else if (!made[step])
        fill(glint_energy_part_row, table[step], ior);
    made[step] = true;
    pthread_mutex_unlock(&mutex);
    return table[step];
}

const float *glint_energy_white(void)
{
    return glint_energy_usual_white;
}

const float *glint_energy_interface(float ior)
{
    float taken;
    const int step = glint_energy_step(ior, &taken);
    return part_of(step, taken);
}

const float *glint_energy_glass(float ior)
{
    float taken;
    const int step = glint_energy_step(ior, &taken);
    if (step == usual_step())
        return glint_energy_usual_glass;
    const float *outside = part_of(step, taken);
    pthread_mutex_lock(&mutex);
    if (!made_glass[step]) {
        memcpy(glass[step], outside, sizeof table[step]);
        fill(glint_energy_glass_row, glass[step], taken);
    }
    made_glass[step] = true;
    pthread_mutex_unlock(&mutex);
    return glass[step];
}
