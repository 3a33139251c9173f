#include "tests/render/effect_worlds.h"

#include "tests/stability/stable.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

// ---- scenes

#define SKY "'environment':{'radiance':[1,0.9,0.8]},"
#define LAMP "'lamp':{'mesh':'down','material':'lamp','transform':{'translation':[0,2.9,0]}},"
#define QUAD "'indices':[0,1,2,0,2,3],'positions':"
#define QUAD_UV ",'uvs':[0,0,1,0,1,1,0,1]"
#define BASE_TEXTURE "'ior':1,'base_color_texture':{'image':'i'}"

const struct effect_world effect_sky = {SKY, "'ior':1", "", "", 24};
const struct effect_world effect_lamp = {"", "'ior':1", "", LAMP, 24};
const struct effect_world effect_textured = {SKY, BASE_TEXTURE, "", "", 24};
const struct effect_world effect_glossy = {SKY, "'roughness':0.4", "", "", 24};
const struct effect_world effect_polished = {SKY, "'roughness':0,'metallic':1", "", "", 24};
const struct effect_world effect_glass = {SKY, "'roughness':0,'transmission':1", "", "", 24};
const struct effect_world effect_image_sky = {"'environment':{'image':'i'},", "'ior':1", "", "",
                                              24};

// What some causes are compared with.
#define POINT "'lights':{'p':{'type':'point'}},"
static const struct effect_world dark = {"'environment':{'radiance':[0,0,0]},", "'ior':1", "", "",
                                         24};
static const struct effect_world bulb = {POINT, "'ior':1", "", "", 24};
static const struct effect_world shining = {"", "'ior':1,'emission':[1,1,1]", "", "", 24};
// Areas alone, and with a point among them.
static const struct effect_world areas = {"", "'ior':1,'emission':[1,1,1]", "", "", 64};
static const struct effect_world crowd = {POINT, "'ior':1,'emission':[1,1,1]", "", "", 64};
static const struct effect_world clear = {SKY, "'ior':1,'transmission':1", "", "", 24};
static const struct effect_world smooth = {SKY, "'roughness':0", "", "", 24};
static const struct effect_world metal = {SKY, "'ior':1,'metallic':1", "", "", 24};
#define DRAWN "','material':'ball','transform':{'translation':[-1,-1,0.5]}},"
#define SHEET "'two':{'mesh':'sheet" DRAWN
#define PAINTED "'two':{'mesh':'painted" DRAWN
static const struct effect_world sheet = {SKY, BASE_TEXTURE, "", SHEET, 24};
static const struct effect_order straight = {"'beauty'", "box", "", 0};
static const struct effect_order single = {"'beauty'", "box", "'accuracy':{'microfacet':'single'},",
                                           3};
static const struct effect_order by_power = {"'beauty'", "box", "'accuracy':{'lights':'power'},",
                                             0};

const struct effect_order effect_beauty = {"'beauty'", "box", "", 3};

// 12 x 9 texels of different colours.
static char *paint(void)
{
    float rgb[12 * 9 * 3];
    for (int i = 0; i < 12 * 9 * 3; i++)
        rgb[i] = (float)(i * 37 % 64 + 1) / 64.0f;
    return stable_png(12, 9, rgb);
}

char *effect_scene(const struct effect_world *w)
{
    char *picture = paint();
    char *text = stable_text(
        "{%s'images':{'i':{'data':'%s'}},"
        "'materials':{'grey':{'base_color':[0.5,0.4,0.3],'ior':1},'ball':{%s},"
        "'lamp':{'base_color':[0,0,0],'ior':1,'emission':[8,8,8]}},"
        "'meshes':{'wall':{'primitive':'quad','size':[6,6]},"
        "'down':{" QUAD "[-0.5,0,-0.5,0.5,0,-0.5,0.5,0,0.5,-0.5,0,0.5]},"
        "'sheet':{" QUAD "[0,0,0,1,0,0,1,1,0,0,1,0]" QUAD_UV ",'uvs1':[0,0,2,0,2,2,0,2]},"
        "'painted':{" QUAD "[0,0,0,1,0,0,1,1,0,0,1,0]" QUAD_UV
        ",'colors':[1,0,0,1,0,1,0,1,0,0,1,1,1,1,1,1]},"
        "'ball':{'primitive':'sphere','segments':%d}},'instances':{%s"
        "'wall':{'mesh':'wall','material':'grey','transform':{'translation':[0,0,-1]}},"
        "'ball':{'mesh':'ball','material':'ball','transform':{'translation':[0.3,-1,0.2]}}},"
        "'cameras':{'eye':{'yfov':0.9%s,'transform':{'translation':[0,0,2.9]}}}}",
        w->light, picture, w->ball, w->segments, w->more, w->camera);
    free(picture);
    return text;
}

char *effect_job(const struct effect_order *of, const uint32_t size[2], uint32_t samples)
{
    return stable_text("{'scene':'s','resolution':[%u,%u],'outputs':[%s],"
                       "'filter':{'kind':'%s','width':1},%s'max_bounces':%d,'stop':{'samples':%u}}",
                       size[0], size[1], of->outputs, of->filter, of->more, of->bounces, samples);
}

// The bits of rows named "a|b"; no name for none.
uint64_t effect_bits(const char *names)
{
    uint64_t bits = 0;
    char copy[256], *rest = NULL;
    snprintf(copy, sizeof copy, "%s", names);
    for (char *name = strtok_r(copy, "|", &rest); name; name = strtok_r(NULL, "|", &rest)) {
        const uint64_t bit = glint_effect_bit(name);
        if (!bit)
            fail_msg("there is no row \"%s\"", name);
        bits |= bit;
    }
    return bits;
}

const struct effect_forcing effect_forcings[] = {
    {"microfacet", &effect_sky, ""},
    {"transmission", &effect_glossy, ""},
    {"textures", &effect_lamp, ""},
    {"roughness textures", &effect_glossy, "textures"},
    {"emission textures", &effect_lamp, "textures"},
    {"texture pools", &effect_textured, ""},
    {"normal maps", &effect_textured, ""},
    {"instances", &effect_sky, ""},
    {"alpha cut-outs", &effect_sky, ""}, // has neither define nor pass: the tracer's own
    {"emission", &effect_sky, ""},
    {"light table", &effect_sky, "next-event estimation"},
    {"next-event estimation", &effect_sky, ""},
    {"constant environment", &effect_lamp, ""},
    {"environment image", &effect_sky, "next-event estimation"},
    {"depth of field", &effect_sky, ""},
    {"Blackman-Harris filter", &effect_sky, ""},
    {"multiple scattering", &effect_polished, ""},
    {"specular", &effect_glossy, ""},
    {"clearcoat", &effect_glossy, ""},
    {"collimation", &effect_glass, ""},
    {"second texture coordinates", &effect_textured, ""},
    {"texture transforms", &effect_textured, ""},
    {"nearest texels", &effect_textured, ""},
    {"layer textures", &effect_textured, ""},
    {"vertex colours", &effect_sky, ""},
    {"inside of solids", &effect_glass, ""},
    {"nested dielectrics", &effect_glass, ""},
    {"medium", &effect_lamp, ""},
    {"single-sided surfaces", &effect_sky, ""},
    {"alpha blending", &effect_sky, ""},
    {"motion", &effect_lamp, ""},
    {"camera motion", &effect_sky, ""},
    {"light grid", &effect_lamp, ""},
    {"light grid of many", &areas, ""},
    {"orthographic view", &effect_sky, ""},
    {"motion vectors", &effect_sky, "first-hit AOVs"},
    {"first-hit AOVs", &effect_sky, ""},
    {"batch sums", &effect_sky, ""},
    {"ID coverage", &effect_sky, ""},
    {"mattes through bounces", &effect_glass, "ID coverage"},
    {"mattes through glossy lobes", &effect_glass, "mattes through bounces|ID coverage"},
    {"full mattes of opaque surfaces", &effect_glass,
     "mattes through glossy lobes|mattes through bounces|ID coverage"},
    {"each matte once on a path", &effect_glass, "mattes through bounces|ID coverage"},
    {"slot tables shared by work-items", &effect_glass, "mattes through bounces|ID coverage"},
};
const size_t effect_forcing_count = sizeof effect_forcings / sizeof *effect_forcings;

// Settings of a dial whose other setting is another image: to force one is to ask for that image.
const char effect_twins[] = "float64 film|uniform light choice";

#define CONSTANT "constant environment"
#define TABLE "light table|next-event estimation"
#define TURNED "'two':{'mesh':'ball','material':'ball','transform':{'scale':[0.5,0.5,0.5]}},"
#define BEAUTY                   \
    {                            \
        "'beauty'", "box", "", 3 \
    }

// Rows whose cause is no member of these scenes are asked with facts alone, below.
const char effect_by_facts[] =
    "texture pools|motion|camera motion|slot tables shared by work-items";

const struct effect_cause effect_causes[] = {
    {"microfacet", {SKY, "'roughness':0", "", "", 24}, BEAUTY, "microfacet|" CONSTANT},
    {"microfacet",
     {SKY, "'ior':1,'metallic':1", "", "", 24},
     {"'beauty'", "box", "'accuracy':{'microfacet':'single'},", 3},
     "microfacet|" CONSTANT},
    {"second texture coordinates",
     {SKY, "'ior':1,'base_color_texture':{'image':'i','uv_set':1}", "", SHEET, 24},
     BEAUTY,
     "second texture coordinates|textures|" CONSTANT},
    {"vertex colours",
     {SKY, BASE_TEXTURE, "", PAINTED, 24},
     BEAUTY,
     "vertex colours|textures|" CONSTANT},
    {"transmission",
     {SKY, "'ior':1,'transmission':1", "", "", 24},
     BEAUTY,
     "transmission|microfacet|" CONSTANT},
    {"textures", {SKY, BASE_TEXTURE, "", "", 24}, BEAUTY, "textures|" CONSTANT},
    {"normal maps",
     {SKY, "'ior':1,'normal_map':{'image':'i'}", "", "", 24},
     BEAUTY,
     "normal maps|textures|" CONSTANT},
    {"instances", {SKY, "'ior':1", "", TURNED, 24}, BEAUTY, "instances|" CONSTANT},
    {"multiple scattering",
     {SKY, "'ior':1,'metallic':1", "", "", 24},
     BEAUTY,
     "multiple scattering|microfacet|" CONSTANT},
    {"multiple scattering",
     {SKY, "'transmission':1", "", "", 24},
     BEAUTY,
     "multiple scattering|transmission|microfacet|" CONSTANT},
    {"specular",
     {SKY, "'roughness':0,'specular':0.5", "", "", 24},
     BEAUTY,
     "specular|microfacet|" CONSTANT},
    {"clearcoat",
     {SKY, "'ior':1,'clearcoat':0.5", "", "", 24},
     BEAUTY,
     "clearcoat|microfacet|" CONSTANT},
    {"collimation",
     {SKY, "'ior':1,'transmission':1,'collimation':0.5", "", "", 24},
     BEAUTY,
     "multiple scattering|collimation|transmission|microfacet|" CONSTANT},
    {"texture transforms",
     {SKY, "'ior':1,'base_color_texture':{'image':'i','offset':[0.5,0]}", "", "", 24},
     BEAUTY,
     "texture transforms|textures|" CONSTANT},
    {"nearest texels",
     {SKY, "'ior':1,'base_color_texture':{'image':'i','filter':'nearest'}", "", "", 24},
     BEAUTY,
     "nearest texels|textures|" CONSTANT},
    {"roughness textures",
     {SKY, "'ior':1,'metallic_roughness_texture':{'image':'i'}", "", "", 24},
     BEAUTY,
     "roughness textures|textures|" CONSTANT},
    {"emission textures",
     {"", "'ior':1,'emission':[1,1,1],'emission_texture':{'image':'i'}", "", "", 24},
     {"'beauty'", "box", "", 0},
     "emission textures|textures|emission|light grid|light table"},
    {"layer textures",
     {SKY, "'ior':1,'transmission':1,'transmission_texture':{'image':'i'}", "", "", 24},
     BEAUTY,
     "layer textures|textures|transmission|microfacet|" CONSTANT},
    {"inside of solids",
     {SKY, "'ior':1,'transmission':1,'attenuation_color':[0.5,1,1],'attenuation_distance':1", "",
      "", 24},
     BEAUTY,
     "inside of solids|transmission|microfacet|" CONSTANT},
    {"nested dielectrics",
     {SKY, "'ior':1,'transmission':1,'priority':1", "", "", 24},
     BEAUTY,
     "nested dielectrics|transmission|microfacet|" CONSTANT},
    {"medium",
     {SKY "'media':{'fog':{'density':0.1,'albedo':[1,1,1],'box':[-1,-1,-1,1,1,1]}},", "'ior':1", "",
      "", 24},
     BEAUTY,
     "medium|" CONSTANT},
    {"single-sided surfaces",
     {SKY, "'ior':1,'double_sided':false", "", "", 24},
     BEAUTY,
     "single-sided surfaces|" CONSTANT},
    {"alpha blending",
     {SKY, "'ior':1,'alpha_mode':'blend'", "", "", 24},
     BEAUTY,
     "alpha blending|" CONSTANT},
    {"light grid",
     {"", "'ior':1,'emission':[1,1,1]", "", "", 64},
     {"'beauty'", "box", "", 0},
     "emission|light grid|light table"},
    {"light grid of many",
     {POINT, "'ior':1,'emission':[1,1,1]", "", "", 64},
     {"'beauty'", "box", "", 0},
     "emission|light grid of many|light grid|light table"},
    {"orthographic view",
     {SKY, "'ior':1", ",'projection':'orthographic','ymag':2", "", 24},
     BEAUTY,
     "orthographic view|" CONSTANT},
    {"motion vectors",
     {SKY, "'ior':1", "", "", 24},
     {"'beauty','motion'", "box", "", 3},
     "motion vectors|first-hit AOVs|" CONSTANT},
    {"alpha cut-outs",
     {SKY, "'ior':1,'alpha_mode':'mask'", "", "", 24},
     BEAUTY,
     "alpha cut-outs|" CONSTANT},
    {"emission", {"", "'ior':1", "", LAMP, 24}, {"'beauty'", "box", "", 0}, "emission|light table"},
    {"light table", {POINT, "'ior':1", "", "", 24}, {"'beauty'", "box", "", 0}, "light table"},
    {"next-event estimation", {POINT, "'ior':1", "", "", 24}, BEAUTY, TABLE},
    {"uniform light choice",
     {POINT, "'ior':1", "", "", 24},
     {"'beauty'", "box", "'accuracy':{'lights':'uniform'},", 3},
     TABLE "|uniform light choice"},
    {CONSTANT, {SKY, "'ior':1", "", "", 24}, BEAUTY, CONSTANT},
    {"environment image",
     {"'environment':{'image':'i'},", "'ior':1", "", "", 24},
     BEAUTY,
     "environment image|next-event estimation"},
    {"depth of field",
     {SKY, "'ior':1", ",'lens_radius':0.1,'focus_distance':3", "", 24},
     BEAUTY,
     "depth of field|" CONSTANT},
    {"Blackman-Harris filter",
     {SKY, "'ior':1", "", "", 24},
     {"'beauty'", "blackman_harris", "", 3},
     "Blackman-Harris filter|" CONSTANT},
    {"float64 film",
     {SKY, "'ior':1", "", "", 24},
     {"'beauty'", "box", "'accuracy':{'precision':'float64'},", 3},
     "float64 film|" CONSTANT},
    {"first-hit AOVs",
     {SKY, "'ior':1", "", "", 24},
     {"'beauty','depth'", "box", "", 3},
     "first-hit AOVs|" CONSTANT},
    {"batch sums",
     {SKY, "'ior':1", "", "", 24},
     {"'beauty'", "box", "'estimate':'batches',", 3},
     "batch sums|" CONSTANT},
    {"ID coverage",
     {SKY, "'ior':1", "", "", 24},
     {"'beauty','crypto_object'", "box", "", 3},
     "ID coverage|" CONSTANT},
    {"mattes through bounces",
     {SKY, "'ior':1", "", "", 24},
     {"'beauty','crypto_object'", "box", "'mattes':{'through':'delta'},", 3},
     "mattes through bounces|ID coverage|" CONSTANT},
    {"mattes through bounces", // at alpha 0 they widen no cone
     {SKY, "'ior':1", "", "", 24},
     {"'beauty','crypto_object'", "box", "'mattes':{'through':'glossy','alpha':0},", 3},
     "mattes through bounces|ID coverage|" CONSTANT},
    {"mattes through glossy lobes",
     {SKY, "'ior':1", "", "", 24},
     {"'beauty','crypto_object'", "box", "'mattes':{'through':'glossy'},", 3},
     "mattes through glossy lobes|mattes through bounces|ID coverage|" CONSTANT},
    {"full mattes of opaque surfaces",
     {SKY, "'ior':1", "", "", 24},
     {"'beauty','crypto_object'", "box",
      "'mattes':{'through':'delta','coverage':'opaque_full','path_ids':'previous'},", 3},
     "full mattes of opaque surfaces|mattes through bounces|ID coverage|" CONSTANT},
    {"each matte once on a path",
     {SKY, "'ior':1", "", "", 24},
     {"'beauty','crypto_object'", "box", "'mattes':{'through':'delta','coverage':'opaque_full'},",
      3},
     "each matte once on a path|full mattes of opaque surfaces|mattes through bounces|"
     "ID coverage|" CONSTANT},
};
const size_t effect_cause_count = sizeof effect_causes / sizeof *effect_causes;

static const struct effect_comparison comparison[] = {
    {"multiple scattering", &metal, &single},
    {"normal maps", &effect_textured, &effect_beauty},
    {"specular", &smooth, &effect_beauty},
    {"collimation", &clear, &effect_beauty},
    {"second texture coordinates", &sheet, &effect_beauty},
    {"vertex colours", &sheet, &effect_beauty},
    {"texture transforms", &effect_textured, &effect_beauty},
    {"nearest texels", &effect_textured, &effect_beauty},
    {"roughness textures", &effect_textured, &effect_beauty},
    {"emission textures", &shining, &straight},
    {"layer textures", &clear, &effect_beauty},
    {"inside of solids", &clear, &effect_beauty},
    {"nested dielectrics", &clear, &effect_beauty},
    {"light grid", &shining, &by_power},
    {"light grid of many", &crowd, &by_power},
    {"emission", &dark, &straight},
    {"light table", &dark, &straight},
    {"next-event estimation", &dark, &effect_beauty},
    {"uniform light choice", &bulb, &effect_beauty},
    {"constant environment", &dark, &effect_beauty},
};

struct effect_comparison effect_without(const char *effect)
{
    for (size_t i = 0; i < sizeof comparison / sizeof *comparison; i++)
        if (!strcmp(comparison[i].effect, effect))
            return comparison[i];
    return (struct effect_comparison){effect, &effect_sky, &effect_beauty};
}
