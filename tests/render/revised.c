#include "tests/render/revised.h"

#include "scene/internal.h"
#include "tests/stability/stable.h"

#include <stdlib.h>
#include <string.h>

const struct revised_edit revised_base = {
    "[0.8,0.1,0.1]", "[1,0.5,0]", "", "'primitive':'box'", "5", "'radiance':[0.2,0.3,0.4]", ""};

static char *picture(float first)
{
    const float rgb[12] = {first, 0.5f, 0.25f, 1, 0, 0, 0, 1, 0, 0.5f, 0.5f, 0.5f};
    return stable_png(2, 2, rgb);
}

char *revised_text(const struct revised_edit *e, float first_texel)
{
    char *png = picture(first_texel);
    char *text = stable_text(
        "{'environment':{%s},'images':{'p':{'data':'%s'}},"
        "'materials':{'red':{'base_color':%s},'wood':{'base_color_texture':{'image':'p'}},"
        "'glow':{'emission':[4,4,4]}},"
        "'meshes':{'ball':{'primitive':'sphere','segments':48},'box':{%s},"
        "'sheet':{'primitive':'quad','size':[9,9]}%s},"
        "'instances':{'ball':{'mesh':'ball','material':'red','transform':{'translation':%s}},"
        "'cube':{'mesh':'box','material':'wood','transform':{'translation':[-1,0.5,0],"
        "'rotation':[0,0.6,0,0.8],'scale':[1,2,0.5]}%s},"
        "'floor':{'mesh':'sheet','material':'wood','transform':{'rotation':[-1,0,0,1],"
        "'translation':[0,-0.6,0]}},"
        "'lid':{'mesh':'sheet','material':'glow','transform':{'rotation':[1,0,0,1],"
        "'translation':[0,4,0],'scale':[0.1,0.1,0.1]}}},"
        "'lights':{'lamp':{'type':'point','intensity':%s,'transform':{'translation':[2,3,2]}}},"
        "'cameras':{'eye':{'yfov':0.9,'transform':{'translation':[0,1,6]}}}}",
        e->sky, png, e->red, e->box, e->more, e->place, e->cube, e->lamp);
    free(png);
    return text;
}

static void free_import(void *import)
{
    struct glint_import *owned = import;
    glint_import_destroy(&owned);
}

glint_resident *revised_load(char *text, const glint_resident *from)
{
    struct glint_error err = {0};
    struct glint_import *import = NULL;
    struct glint_scene *scene = NULL;
    glint_resident *r = NULL;
    const struct glint_import_source source = {
        .type = GLINT_SCENE_NATIVE, .bytes = (const uint8_t *)text, .size = strlen(text)};
    if (glint_import_run(offline_crew.importer, &source, NULL, &import, &err) ||
        glint_scene_parse(&scene, import->text, import->length, import->asset, import->assets,
                          &err) ||
        glint_resident_create(
            &r, offline_crew.devices,
            &(struct glint_resident_order){scene, free_import, import, NULL, from}, &err))
        offline_die(text, &err);
    free(text);
    return r;
}

struct glint_frame *revised_show(glint_resident *r, bool live)
{
    return stable_frame_of(
        &offline_crew, r,
        stable_text("{'scene':'s','live':%s,'outputs':['beauty','normal','depth','crypto_object'],"
                    "'resolution':[64,48],'max_bounces':3,'stop':{'samples':16}}",
                    live ? "true" : "false"));
}

unsigned revised_made(const glint_resident *r)
{
    unsigned bits = 0;
    for (int p = 0; p < GLINT_PARTS; p++)
        bits |= glint_resident_change(r)->fate[p] > GLINT_LATER ? 1u << p : 0;
    return bits;
}
