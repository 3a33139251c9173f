// mtl_material.c - the numbers of a library's material as those of metallic-roughness.
//
// MTL says how a phong surface shines; what is said of a physical one (Pr, Pm, Pc, Pcr) goes first.
// Where it must be translated:
//   roughness   the exponent Ns is that of a Beckmann width alpha = sqrt(2 / (Ns + 2)) (Walter,
//               Marschner, Li, Torrance 2007, section 5.2), and alpha is roughness^2 here. Illum 0
//               and 1 have no highlight: roughness 1, specular 0
//   Ks          0.5 is a dielectric of index 1.5, as the programs that write these files mean it:
//               reflectance 0.08 Ks at normal incidence. With a black Kd it is a metal of colour Ks
//   d, Tr       opacity, which blends, but for illum 6 and 7, which refract: glass of index Ni that
//               tints by Tf, and illum 4 and 9, the same without bending light
#include "scene/mtl.h"

#include <math.h>
#include <string.h>

#define HIGHLIGHT 2.0f // specular colour for Ks 1: 0.08 over the 0.04 of index 1.5
#define METAL 0.2f     // brightest Ks beside a black Kd that is taken for a dielectric still
#define BLACK 0.02f

static float or_else(float value, float otherwise)
{
    return isnan(value) ? otherwise : value;
}

static float unit(float value)
{
    return fminf(fmaxf(value, 0), 1);
}

static float brightest(const float c[3])
{
    return isnan(c[0]) ? 0 : fmaxf(c[0], fmaxf(c[1], c[2]));
}

static void set_unit(float out[3], const float c[3])
{
    for (int i = 0; i < 3; i++)
        out[i] = unit(c[i]);
}

static bool physical(const struct glint_mtl *m)
{
    return !isnan(m->pr) || !isnan(m->pm) || m->map[GLINT_MTL_ROUGHNESS].path ||
           m->map[GLINT_MTL_METALLIC].path;
}

static float roughness_of(const struct glint_mtl *m)
{
    const float dull = m->illum <= 1 ? 0 : or_else(m->ns, 0); // NaN: as if it shone
    return sqrtf(sqrtf(2 / (fmaxf(dull, 0) + 2)));
}

static void set_highlight(const struct glint_mtl *m, struct glint_material *to)
{
    const float ks = m->illum <= 1 ? 0 : brightest(m->ks);
    to->roughness = roughness_of(m);
    if (ks > METAL && brightest(m->kd) <= BLACK && !m->map[GLINT_MTL_DIFFUSE].path) {
        to->metallic = 1;
        set_unit(to->base_color, m->ks);
    } else if (ks > 0) {
        for (int i = 0; i < 3; i++)
            to->specular_color[i] = HIGHLIGHT * unit(m->ks[i]);
    } else {
        to->specular = 0;
    }
}

static void set_physical(const struct glint_mtl *m, struct glint_material *to)
{
    to->roughness = unit(or_else(m->pr, m->map[GLINT_MTL_ROUGHNESS].path ? 1 : roughness_of(m)));
    to->metallic = unit(or_else(m->pm, m->map[GLINT_MTL_METALLIC].path ? 1 : 0));
    if (m->ni > 1)
        to->ior = fminf(m->ni, 10);
}

static bool refracts(const struct glint_mtl *m)
{
    return m->illum == 6 || m->illum == 7;
}

static bool glass(const struct glint_mtl *m)
{
    return refracts(m) || m->illum == 4 || m->illum == 9;
}

static void set_glass(const struct glint_mtl *m, struct glint_material *to)
{
    to->transmission = 1;
    to->thin = !refracts(m);
    to->metallic = 0;
    to->specular = 1;
    to->ior = m->ni > 1 ? fminf(m->ni, 10) : 1.5f;
    for (int i = 0; i < 3; i++) {
        to->specular_color[i] = 1;
        to->base_color[i] = isnan(m->tf[0]) ? 1 : unit(m->tf[i]);
    }
    if (isnan(m->ns) && isnan(m->pr))
        to->roughness = 0;
}

static void set_opacity(const struct glint_mtl *m, struct glint_material *to)
{
    const float opacity = unit(!isnan(m->d) ? m->d : 1 - or_else(m->tr, 0));
    if (opacity >= 1)
        return;
    to->opacity = opacity;
    to->alpha_mode = GLINT_ALPHA_BLEND;
}

void glint_mtl_convert(struct glint_obj *o, const struct glint_mtl *m, struct glint_material *to)
{
    const bool textured = m->map[GLINT_MTL_DIFFUSE].path;
    if (!isnan(m->kd[0]))
        set_unit(to->base_color, m->kd);
    if (textured && (isnan(m->kd[0]) || brightest(m->kd) <= 0)) {
        // written by programs for which the map takes the place of the colour
        for (int i = 0; i < 3; i++)
            to->base_color[i] = 1;
    }
    if (brightest(m->kd) > 1)
        glint_obj_warn(o, "material \"%.200s\": Kd is cut at 1", to->name);
    if (physical(m))
        set_physical(m, to);
    else
        set_highlight(m, to);
    if (glass(m))
        set_glass(m, to);
    else
        set_opacity(m, to);
    to->clearcoat = unit(or_else(m->pc, 0));
    to->clearcoat_roughness = unit(or_else(m->pcr, 0));
    for (int i = 0; i < 3; i++)
        to->emission[i] =
            isnan(m->ke[0]) ? (float)(m->map[GLINT_MTL_EMISSION].path != NULL) : m->ke[i];
}
