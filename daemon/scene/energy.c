#include "scene/energy.h"

#include "kernels/gk_coat.h"

#include <pthread.h>

#define SIDE GK_ENERGY_SIDE

// Fibonacci lattice: the error is a tenth of that of a grid with as many points, for light that
// leaves below the horizon cuts a grid along its lines. 5e-4 of the albedo.
#define POINTS 1597u
#define STEP 987u

// Single-scattering albedos for one direction and roughness.
struct albedos {
    double white, coat;
};

static pthread_once_t once = PTHREAD_ONCE_INIT;
static float table[GK_ENERGY_ENTRIES];

// Adds what the visible normal of the numbers (u, v) reflects: G2/G1, times F.
static void add_normal(struct gk_vec wo, float alpha, float u, float v, struct albedos *sum)
{
    const struct gk_vec h = gk_ggx_sample(wo, alpha, u, v);
    const float cos_m = gk_dot(wo, h);
    const double zi = 2.0 * (double)cos_m * (double)h.z - (double)wo.z;
    if (zi <= 0.0)
        return;
    const float a2 = alpha * alpha;
    const double so = gk_ggx_s(wo.z, a2), si = gk_ggx_s((float)zi, a2), zo = wo.z;
    const double w = zi * (zo + so) / (so * zi + si * zo);
    sum->white += w;
    sum->coat += w * (double)gk_fresnel_dielectric(gk_saturate(cos_m), GK_COAT_ETA);
}

// Integrates over the two numbers that choose a visible normal; half a turn, for the lobe is
// symmetric.
static struct albedos integrate(float cosine, float alpha)
{
    const float sine = sqrtf(fmaxf(1.0f - cosine * cosine, 0.0f));
    const struct gk_vec wo = gk_vec(sine, 0.0f, cosine);
    struct albedos sum = {0, 0};
    for (uint32_t i = 0; i < POINTS; i++)
        add_normal(wo, alpha, 0.5f * ((float)i + 0.5f) / (float)POINTS,
                   ((float)(i * STEP % POINTS) + 0.5f) / (float)POINTS, &sum);
    return (struct albedos){sum.white / POINTS, sum.coat / POINTS};
}

// 1 - 2 Int E c dc of the row as kernels interpolate it: linear in x = sqrt(c), so 4 x^3 dx.
static double mean_loss(const float *row)
{
    double sum = 0.0;
    const double h = 1.0 / (SIDE - 1);
    for (int i = 0; i + 1 < SIDE; i++) {
        const double x = i * h, y = x + h, slope = ((double)row[i + 1] - (double)row[i]) / h;
        const double start = (double)row[i] - slope * x;
        sum += start * (pow(y, 4) - pow(x, 4)) + slope * 0.8 * (pow(y, 5) - pow(x, 5));
    }
    return 1.0 - sum;
}

static void fill_row(int y)
{
    const float root = (float)y / (SIDE - 1), alpha = root * root;
    float *white = table + GK_ENERGY_WHITE + (size_t)y * SIDE;
    float *coat = table + GK_ENERGY_COAT + (size_t)y * SIDE;
    for (int x = 0; x < SIDE; x++) {
        const float edge = (float)x / (SIDE - 1), cosine = fmaxf(edge * edge, 1e-6f);
        const struct albedos a = integrate(cosine, fmaxf(alpha, 1e-6f));
        white[x] = y > 0 ? (float)a.white : 1.0f; // a smooth surface loses nothing
        coat[x] = y > 0 ? (float)a.coat : gk_fresnel_dielectric(cosine, GK_COAT_ETA);
    }
    table[GK_ENERGY_MEAN_LOSS + y] = (float)mean_loss(white);
}

static void fill_table(void)
{
    for (int y = 0; y < SIDE; y++)
        fill_row(y);
}

const float *glint_energy_table(void)
{
    pthread_once(&once, fill_table);
    return table;
}
