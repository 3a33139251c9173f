#include "scene/energy.h"

#include "base/thread.h"
#include "scene/energy_rows.h"

#include <stdbool.h>
#include <string.h>

#define STEPS GLINT_ENERGY_STEPS

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
};

static void fill_row(void *user, size_t y)
{
    const struct rows *r = user;
    r->fill(r->parts, r->ior, (int)y);
}

static void fill(row_fn *row, float *parts, float ior)
{
    glint_thread_each("energy", GK_ENERGY_SIDE, fill_row, &(struct rows){row, parts, ior});
}

// ---- parts

// All parts of the usual interface that is taken for this step, or NULL.
static const float *usual(int step)
{
    float taken;
    for (int i = 0; i < GLINT_ENERGY_USUALS; i++)
        if (glint_energy_step(glint_energy_usual_ior[i], &taken) == step)
            return glint_energy_usual_glass[i];
    return NULL;
}

// An interface of ior 1, as lamps have it, reflects nothing: its table is zeros as it is.
static const float *part_of(int step, float ior)
{
    pthread_mutex_lock(&mutex);
    const float *known = made[step] ? NULL : usual(step);
    if (known) // a copy: who asks for glass is told apart by the pointer
        memcpy(table[step], known, sizeof table[step]);
    else if (!made[step] && step > 0)
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
    const float *known = usual(step);
    if (known)
        return known;
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
