// accuracy_knobs.c - the table of knobs, and of what is not built.
#include "protocol/accuracy_knobs.h"

#define PLAIN GLINT_DIAL_COUNT

const char *const glint_accuracy_metric_name[GLINT_METRICS] = {
    [GLINT_METRIC_COLOUR] = "colour", [GLINT_METRIC_MATTE] = "matte"};

const struct glint_knob glint_knob_table[] = {
    {.dial = GLINT_DIAL_GI},
    {.dial = GLINT_DIAL_TRANSPARENCY, .effects = {"alpha blending"}},
    {.dial = GLINT_DIAL_PRIMARY},
    {.dial = GLINT_DIAL_PRECISION},
    // Robust traversal has the expectation of the watertight one: rays that slip by a vertex have none.
    {.dial = GLINT_DIAL_TRAVERSAL, .twin = "robust"},
    // Survival by throughput has the expectation of none and ends paths that bring nothing.
    {.dial = GLINT_DIAL_ROULETTE, .twin = "throughput"},
    {.dial = GLINT_DIAL_LIGHTS, .effects = {"light table"}},
    {.dial = GLINT_DIAL_MICROFACET, .effects = {"multiple scattering"}},
    {.dial = PLAIN,
     .parent = "",
     .name = "max_bounces",
     .exact = "128",
     .ladder = {"1", "2", "3", "5", "8", "16"}},
    {.dial = PLAIN,
     .parent = "filter",
     .name = "kind",
     .exact = "box",
     .ladder = {"blackman_harris"},
     .other_question = true},
    {.dial = GLINT_DIAL_THROUGH, .metric = GLINT_METRIC_MATTE, .effects = {"microfacet"}},
    {.dial = GLINT_DIAL_VARIANCE, .metric = GLINT_METRIC_MATTE, .effects = {"microfacet"}},
    {.dial = GLINT_DIAL_COVERAGE, .metric = GLINT_METRIC_MATTE, .effects = {"microfacet"}},
    {.dial = GLINT_DIAL_PATH_IDS,
     .base = "{\"mattes\": {\"coverage\": \"opaque_full\"}}",
     .metric = GLINT_METRIC_MATTE,
     .effects = {"microfacet"}},
    {.dial = GLINT_DIAL_EVICTION,
     .with = "{\"mattes\": {\"slots\": 8, \"levels\": 4}}",
     .metric = GLINT_METRIC_MATTE,
     .effects = {"ID coverage"}},
    {.dial = PLAIN,
     .parent = "mattes",
     .name = "slots",
     .exact = "32",
     .ladder = {"4", "6", "8", "12", "16", "24"},
     .metric = GLINT_METRIC_MATTE,
     .effects = {"ID coverage"}},
    {.dial = PLAIN,
     .parent = "mattes",
     .name = "alpha",
     .exact = "0",
     .ladder = {"0.05", "0.1", "0.3", "1"},
     .base = "{\"mattes\": {\"alpha\": 0}}",
     .metric = GLINT_METRIC_MATTE,
     .other_question = true,
     .effects = {"microfacet"}},
    {.dial = PLAIN,
     .parent = "mattes",
     .name = "clamp",
     .exact = "true",
     .ladder = {"false"},
     .base = "{\"mattes\": {\"alpha\": 1}}",
     .metric = GLINT_METRIC_MATTE,
     .effects = {"microfacet"}},
};
const size_t glint_knob_count = sizeof glint_knob_table / sizeof *glint_knob_table;

const struct glint_unbuilt glint_unbuilt_table[] = {
    {"ordered transparency: eq5, linear, per-channel, hybrid K", "sorted two-pass; path tracing",
     "rmse61, flip"},
    {"source precision of layers: fp16, 8-bit", "fp32 registers", "rmse61"},
    {"screen-space ambient occlusion at partly covered points", "traced occlusion", "rmse61"},
    {"denoiser on the split G-buffer", "off, converged", "rmse61, flip"},
    {"surfels: count, density, order, gradients, weights", "per-pixel path tracing", "rmse61"},
    {"screen-space refraction and diffusion", "traced glass", "flip, rmse61"},
    {"caustic shadow map, its filter", "shadow rays; photon-free path tracing", "rmse61"},
    {"low-resolution particles", "full resolution", "rmse61, ssim"},
    {"split primary rays: fields, second branch, resolve", "both branches traced", "flip, rmse61"},
    {"rough mirror: blurred reflection", "sampled lobe", "flip"},
    {"gradients and Poisson: method, iterations, norm, preparation", "DCT; path tracing", "rmse"},
    {"roulette: the bounce that it starts at", "none", "efficiency"},
    {"light sampling: a tree, without MIS, by the BSDF alone", "the same mean", "efficiency"},
    {"texture filter, fast mathematics, half BVH", "exact", "rmse"},
    {NULL, NULL, NULL},
};

const char *glint_knob_name(const struct glint_knob *knob)
{
    return knob->dial == PLAIN ? knob->name : glint_dial_table[knob->dial].name;
}

const char *glint_knob_parent(const struct glint_knob *knob)
{
    return knob->dial == PLAIN ? knob->parent : glint_dial_table[knob->dial].parent;
}

const char *glint_knob_setting(const struct glint_knob *knob, size_t index)
{
    if (knob->dial != PLAIN)
        return glint_dial_table[knob->dial].setting[index];
    return index ? knob->ladder[index - 1] : knob->exact;
}

const char *glint_knob_twin(const struct glint_knob *knob)
{
    return knob->twin ? knob->twin : glint_knob_setting(knob, 0);
}

bool glint_knob_unbiased(const struct glint_knob *knob, size_t index)
{
    if (knob->dial == PLAIN)
        return index == 0;
    return glint_dial_table[knob->dial].unbiased >> index & 1;
}
