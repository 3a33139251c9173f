#include "scene/energy.h"

#include "kernels/gk_energy.h"
#include "kernels/gk_fresnel.h"
#include "kernels/gk_ggx.h"

#include <pthread.h>
#include <stdbool.h>

#define SIDE GK_ENERGY_SIDE
#define STEPS 640 // 1.5 is step 128

// Fibonacci lattice: the error is a tenth of that of a grid with as many points, for light that
// leaves below the horizon cuts a grid along its lines. 5e-4 of the albedo.
#define POINTS 1597u
#define STEP 987u

static pthread_mutex_t mutex = PTHREAD_MUTEX_INITIALIZER; // guards what is below
static bool made[STEPS + 1];                              // the last is white
static float table[STEPS + 1][GK_ENERGY_PART];

// What the visible normal of the numbers (u, v) reflects: G2/G1, times F. ior 0: F is 1.
static double reflected(struct gk_vec wo, float alpha, float ior, float u, float v)
{
    const struct gk_vec h = gk_ggx_sample(wo, alpha, u, v);
    const float cos_m = gk_saturate(gk_dot(wo, h));
    const double zi = 2.0 * (double)cos_m * (double)h.z - (double)wo.z;
    if (zi <= 0.0)
        return 0.0;
    const float a2 = alpha * alpha;
    const double so = gk_ggx_s(wo.z, a2), si = gk_ggx_s((float)zi, a2), zo = wo.z;
    const double fresnel = ior > 0.0f ? (double)gk_fresnel_dielectric(cos_m, ior) : 1.0;
    return fresnel * zi * (zo + so) / (so * zi + si * zo);
}

// Integrates over the two numbers that choose a visible normal; half a turn, for the lobe is
// symmetric.
static float albedo(float cosine, float alpha, float ior)
{
    const float sine = sqrtf(fmaxf(1.0f - cosine * cosine, 0.0f));
    const struct gk_vec wo = gk_vec(sine, 0.0f, cosine);
    double sum = 0.0;
    for (uint32_t i = 0; i < POINTS; i++)
        sum += reflected(wo, alpha, ior, 0.5f * ((float)i + 0.5f) / (float)POINTS,
                         ((float)(i * STEP % POINTS) + 0.5f) / (float)POINTS);
    return (float)(sum / POINTS);
}

// 2 Int E c dc of the row as kernels interpolate it: linear in x = sqrt(c), so 4 x^3 dx.
static float row_mean(const float *row)
{
    double sum = 0.0;
    const double h = 1.0 / (SIDE - 1);
    for (int i = 0; i + 1 < SIDE; i++) {
        const double x = i * h, y = x + h, slope = ((double)row[i + 1] - (double)row[i]) / h;
        const double start = (double)row[i] - slope * x;
        sum += start * (pow(y, 4) - pow(x, 4)) + slope * 0.8 * (pow(y, 5) - pow(x, 5));
    }
    return (float)sum;
}

static void fill_part(float *part, float ior)
{
    for (int y = 0; y < SIDE; y++) {
        float *row = part + (size_t)y * SIDE;
        const float root = (float)y / (SIDE - 1), alpha = root * root;
        for (int x = 0; x < SIDE; x++) {
            const float edge = (float)x / (SIDE - 1), cosine = fmaxf(edge * edge, 1e-6f);
            const float smooth = ior > 0.0f ? gk_fresnel_dielectric(cosine, ior) : 1.0f;
            row[x] = y > 0 ? albedo(cosine, alpha, ior) : smooth;
        }
        part[SIDE * SIDE + y] = row_mean(row);
    }
}

static const float *part_of(int step, float ior)
{
    pthread_mutex_lock(&mutex);
    if (!made[step])
        fill_part(table[step], ior);
    made[step] = true;
    pthread_mutex_unlock(&mutex);
    return table[step];
}

const float *glint_energy_white(void)
{
    return part_of(STEPS, 0.0f);
}

const float *glint_energy_interface(float ior)
{
    const float root = (ior - 1.0f) / (ior + 1.0f);
    const int step = (int)gk_clamp(rintf(root * STEPS), 0.0f, STEPS - 1);
    const float nearest = (float)step / STEPS;
    return part_of(step, (1.0f + nearest) / (1.0f - nearest));
}
