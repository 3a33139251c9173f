// dials.c - the table of accuracy dials and the presets over it.
#include "protocol/dials.h"

#include <string.h>

const struct glint_dial_row glint_dial_table[GLINT_DIAL_COUNT] = {
    [GLINT_DIAL_GI] = {"gi",
                       "accuracy",
                       {"path", "none"},
                       0x1,
                       "none: direct light only, every path ends at its first surface"},
    [GLINT_DIAL_TRANSPARENCY] = {"transparency", "accuracy", {"traced"}, 0x1, ""},
    [GLINT_DIAL_PRIMARY] = {"primary", "accuracy", {"full"}, 0x1, ""},
    [GLINT_DIAL_THROUGH] = {"through",
                            "mattes",
                            {"glossy", "delta", "none"},
                            0x1,
                            "delta: through mirrors and clear glass alone; none: what is seen "
                            "directly"},
    [GLINT_DIAL_VARIANCE] = {"variance",
                             "mattes",
                             {"exact", "eq3"},
                             0x1,
                             "eq3: Yoshimura et al. 2022, Eq. 3 in the place of Eq. 2"},
    [GLINT_DIAL_COVERAGE] = {"coverage",
                             "mattes",
                             {"redistribute", "opaque_full"},
                             0x1,
                             "opaque_full: Yoshimura et al. 2022, Eq. 8; sums exceed one"},
    [GLINT_DIAL_PATH_IDS] = {"path_ids",
                             "mattes",
                             {"list", "previous"},
                             0x1,
                             "previous: with opaque_full, what a path meets again after something "
                             "else is covered again (Yoshimura et al. 2022, Eq. 8)"},
    [GLINT_DIAL_EVICTION] = {"eviction",
                             "mattes",
                             {"exact", "drop", "direct_first", "uss", "uss_direct_first", "spill"},
                             0x39,
                             "exact: a slot for every name; direct_first: Yoshimura et al. 2022, "
                             "Alg. 1; uss: unbiased space "
                             "saving, Ting 2018; spill: exact while the tile has places"},
    [GLINT_DIAL_PRECISION] = {"precision",
                              "accuracy",
                              {"float64", "float32"},
                              0x1,
                              "float32: compensated sums (Neumaier 1974)"},
    [GLINT_DIAL_TRAVERSAL] =
        {"traversal",
         "accuracy",
         {"watertight", "robust", "fast"},
         0x3,
         "robust: rays aimed at a vertex may slip between its triangles; fast: "
         "rays at an edge as well"},
    [GLINT_DIAL_ROULETTE] = {"roulette",
                             "accuracy",
                             {"none", "throughput"},
                             0x3,
                             "throughput: Arvo and Kirk 1990, survival by path throughput"},
    [GLINT_DIAL_LIGHTS] = {"lights",
                           "accuracy",
                           {"spatial", "power", "uniform"},
                           0x7,
                           "power: the same choice everywhere; uniform: every emitter with equal "
                           "probability"},
    [GLINT_DIAL_MICROFACET] = {"microfacet",
                               "accuracy",
                               {"multiple", "single"},
                               0x1,
                               "single: light that meets several microfacets is lost"},
};

const struct glint_preset glint_preset_table[] = {
    {"production",
     {[GLINT_DIAL_THROUGH] = GLINT_THROUGH_NONE,
      [GLINT_DIAL_EVICTION] = GLINT_EVICTION_SPILL,
      [GLINT_DIAL_PRECISION] = 1,
      [GLINT_DIAL_TRAVERSAL] = GLINT_TRAVERSAL_FAST,
      [GLINT_DIAL_ROULETTE] = 1}},
    {"reference",
     {[GLINT_DIAL_THROUGH] = GLINT_THROUGH_NONE, [GLINT_DIAL_EVICTION] = GLINT_EVICTION_SPILL}},
    {NULL, {0}},
};

const size_t glint_preset_count = sizeof glint_preset_table / sizeof *glint_preset_table - 1;

int glint_dial_setting(enum glint_dial dial, const char *setting)
{
    const char *const *name = glint_dial_table[dial].setting;
    for (int i = 0; name[i]; i++)
        if (strcmp(name[i], setting) == 0)
            return i;
    return -1;
}
