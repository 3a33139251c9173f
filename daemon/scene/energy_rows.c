#include "scene/energy_rows.h"

#include "kernels/gk_fresnel.h"
#include "kernels/gk_ggx.h"

#define SIDE GK_ENERGY_SIDE

// Fibonacci lattice: the error is a tenth of that of a grid with as many points, for light that
// leaves below the horizon cuts a grid along its lines. 5e-4 of the albedo.
#define POINTS 1597u
#define STEP 987u
#define FEWER_POINTS 610u // 1e-3, for what a transmitting interface has besides
#define FEWER_STEP 377u

// The default of glTF, water, the default of Blender.
const float glint_energy_usual_ior[GLINT_ENERGY_USUALS] = {1.5f, 1.33f, 1.45f};

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

void glint_energy_part_row(float *part, float ior, int y)
{
    float *row = part + (size_t)y * SIDE;
    const float root = (float)y / (SIDE - 1), alpha = root * root;
    for (int x = 0; x < SIDE; x++) {
        const float edge = (float)x / (SIDE - 1), cosine = fmaxf(edge * edge, 1e-6f);
        const float smooth = ior > 0.0f ? gk_fresnel_dielectric(cosine, ior) : 1.0f;
        row[x] = y > 0 ? albedo(cosine, alpha, ior) : smooth;
    }
    part[SIDE * SIDE + y] = row_mean(row);
}

// G2/G1 of GGX for light that leaves under zi, 0 at and below the horizon.
static double passed_on(double zo, double zi, float alpha)
{
    if (zi <= 0.0)
        return 0.0;
    const float a2 = alpha * alpha;
    const double so = gk_ggx_s((float)zo, a2), si = gk_ggx_s((float)zi, a2);
    return zi * (zo + so) / (so * zi + si * zo);
}

enum { REFLECT, BOTH, SPARED, OPEN, ALBEDOS };

struct albedos {
    double of[ALBEDOS];
};

// Of one visible normal: what is reflected and refracted, and what is not totally reflected.
static struct albedos refracted(struct gk_vec wo, struct gk_vec h, float alpha, float eta)
{
    const float cos_m = gk_saturate(gk_dot(wo, h)), f = gk_fresnel_dielectric(cos_m, eta);
    const double up = 2.0 * (double)cos_m * (double)h.z - (double)wo.z;
    const double down = -(double)gk_refract(wo, h, cos_m, eta).z;
    const double white = passed_on((double)wo.z, up, alpha);
    const double clear = passed_on((double)wo.z, down, alpha);
    const double reflect = (double)f * white, open = f < 1.0f ? 1.0 : 0.0;
    return (struct albedos){{[REFLECT] = reflect,
                             [BOTH] = reflect + (double)(1.0f - f) * clear,
                             [SPARED] = open * (clear - white),
                             [OPEN] = open * white}};
}

// Of one visible normal: what gk_scatter.h lets through, first of all.
static struct albedos scattered(struct gk_vec wo, struct gk_vec h, float alpha, float eta)
{
    const float cos_m = gk_saturate(gk_dot(wo, h));
    const double zi = 2.0 * (double)cos_m * (double)h.z - (double)wo.z;
    const float least = fminf(cos_m, fminf(wo.z, gk_saturate((float)zi)));
    const double share = 1.0 - (double)gk_fresnel_dielectric(least, eta);
    return (struct albedos){{share * passed_on((double)wo.z, zi, alpha)}};
}

typedef struct albedos facet_fn(struct gk_vec wo, struct gk_vec h, float alpha, float eta);

static struct albedos mean_albedos(facet_fn *facet, float cosine, float alpha, float eta)
{
    const struct gk_vec wo = gk_vec(sqrtf(fmaxf(1.0f - cosine * cosine, 0.0f)), 0.0f, cosine);
    struct albedos sum = {{0}};
    if (alpha == 0.0f)
        return facet(wo, gk_vec(0.0f, 0.0f, 1.0f), alpha, eta);
    for (uint32_t i = 0; i < FEWER_POINTS; i++) {
        const float u = 0.5f * ((float)i + 0.5f) / (float)FEWER_POINTS;
        const float v = ((float)(i * FEWER_STEP % FEWER_POINTS) + 0.5f) / (float)FEWER_POINTS;
        const struct albedos one = facet(wo, gk_ggx_sample(wo, alpha, u, v), alpha, eta);
        for (int k = 0; k < ALBEDOS; k++)
            sum.of[k] += one.of[k];
    }
    for (int k = 0; k < ALBEDOS; k++)
        sum.of[k] /= FEWER_POINTS;
    return sum;
}

// to[k]: the part for the k-th albedo, or NULL. Nothing asks for the mean albedos of these parts.
static void facet_row(facet_fn *facet, float eta, float *const to[ALBEDOS], int row)
{
    const float y = (float)row / (SIDE - 1);
    for (int i = row * SIDE; i < (row + 1) * SIDE; i++) {
        const float x = (float)(i % SIDE) / (SIDE - 1), cosine = fmaxf(x * x, 1e-6f);
        const struct albedos a = mean_albedos(facet, cosine, y * y, eta);
        for (int k = 0; k < ALBEDOS; k++)
            if (to[k])
                to[k][i] = (float)a.of[k];
    }
}

void glint_energy_glass_row(float *parts, float ior, int y)
{
    float *inside = parts + GK_ENERGY_INSIDE;
    float *const outer[] = {NULL, parts + GK_ENERGY_BOTH, parts + GK_ENERGY_SPARED, NULL};
    float *const inner[] = {inside, inside + GK_ENERGY_BOTH, inside + GK_ENERGY_SPARED,
                            parts + GK_ENERGY_OPEN};
    float *const through[ALBEDOS] = {parts + GK_ENERGY_SCATTER};
    facet_row(refracted, ior, outer, y);
    facet_row(refracted, 1.0f / ior, inner, y);
    facet_row(scattered, ior, through, y);
}

int glint_energy_step(float ior, float *taken)
{
    const float root = (ior - 1.0f) / (ior + 1.0f);
    const int step = (int)gk_clamp(rintf(root * GLINT_ENERGY_STEPS), 0.0f, GLINT_ENERGY_STEPS - 1);
    const float nearest = (float)step / GLINT_ENERGY_STEPS;
    *taken = (1.0f + nearest) / (1.0f - nearest);
    return step;
}
