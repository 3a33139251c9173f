#include "scene_text.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

const char *const scene_rich =
    "{'fps':29.97,'images':{'env':{'asset':'%s','width':2,'height':1,'format':'rgba8'}},"
    "'materials':{'m~/\\u00e4':{'base_color':[0.1,0.2,0.3],'emission':[1e-7,3e9,0],'ior':1.333,"
    "'alpha_mode':'blend','specular':0.3,'specular_color':[1.5,0.1,0],'clearcoat':0.7,"
    "'clearcoat_roughness':0.1,'clearcoat_normal_scale':-0.5,'attenuation_color':[0.9,0.1,0.2],"
    "'attenuation_distance':0.03,'collimation':0.6,'priority':7,'clearcoat_normal_map':{'image':"
    "'env','filter':'nearest','uv_set':1,'offset':[0.1,-0.2],'scale':[3,0.7],'rotation':0.3},"
    "'base_color_texture':{'image':'env','wrap_v':'mirror'}},'plain':{}},"
    "'meshes':{'s':{'primitive':'sphere','segments':9},'q':{'positions':[0,0,0, 1,0,0, 0,1,0],"
    "'normals':[0.1,0.2,5, 0,0,1, 0,0,1],'tangents':[1,0,0,-1, 1,0,0,1, 1,0,0,1]},"
    "'q2':{'positions':[0,0,0, 1,0,0, 0,1,0],'normals':[0.1,0.2,5, 0,0,1, 0,0,1],"
    "'tangents':[1,0,0,-1, 1,0,0,1, 1,0,0,1]},"
    "'moving':{'positions':[0,0,0, 1,0,0, 0,1,0],'uvs1':[0.1,0.2, 0.3,0.4, 0.5,0.6],"
    "'colors':[0.1,0.2,0.3,0.4, 2,0,0,1, 1,1,1,1],'joints':[0,1,0,0, 1,0,0,0, 0,0,0,0],"
    "'weights':[0.3,0.9,0,0, 1,0,0,0, 1,0,0,0],'targets':[{'positions':[0.1,0,0, 0,0,0, 0,0,0]},"
    "{'tangents':[0,0,0, 0,0,0.7, 0,0,0]}],'target_weights':[0.3,0]}},"
    "'objects':{'o':{'name':'two words','asset':'set/a'}},"
    "'nodes':{'late':{'parent':'early','transform':{'translation':[0.1,0.2,0.3],'rotation':"
    "[0.1,0.7,0.2,0.5],'scale':[1,-2,0.3]}},'early':{'name':'E','transform':[0,0.1,0,0, -0.3,0,0,0,"
    "0,0,0.7,0, 0.1,0.2,0.3,1]},'still':{}},"
    "'skins':{'sk':{'joints':['late','still'],'inverse_bind':[1,0,0,0, 0,1,0,0, 0,0,1,0, 0.1,0,0,1,"
    "0.3,0,0,0, 0,1,0,0, 0,0,1,0, 0,0,0,1]},'plain':{'joints':['still']}},"
    "'instances':{'i':{'mesh':'s','material':'plain','object':'o'},'j':{'mesh':'q2','material':'m~/"
    "\\u00e4','transform':{'translation':[0.1,0.2,0.3],'rotation':[0.1,0.7,0.2,0.5],'scale':[1,2,3]"
    "}},'k':{'mesh':'moving','material':'plain','node':'late','skin':'sk','weights':[0.1,-0.2]},"
    "'l':{'mesh':'moving','material':'plain','node':'early'}},"
    "'animations':{'walk':{'name':'Walk','channels':{'r':{'node':'late','path':'rotation','times':"
    "[0,0.1],'values':[0,0,0,1.01, 0.6,0,0,0.8]},'w':{'node':'late','path':'weights',"
    "'interpolation':'cubicspline','times':[0.7],'values':[0.1,0.2,0.3,0.4,0.5,0.6]},'s':{'node':"
    "'still','path':'scale','interpolation':'step','times':[0],'values':[0,0.1,1]}}},'empty':{}},"
    "'lights':{'l':{'type':'spot','inner_cone':0.3,'node':'still','transform':{'translation':"
    "[0,1,0]}}},"
    "'cameras':{'c':{'yfov':0.7,'lens_radius':0.01,'focus_distance':2.5,'node':'late'},"
    "'flat':{'projection':'orthographic','ymag':1.7}},"
    "'media':{'fog':{'density':0.3,'albedo':[0.9,0.8,0.7],'g':0.6,'box':[-1,-2,-3,1,2,0.3]}},"
    "'environment':{'image':'env','rotation':1.1}}";

char *json(const char *quoted)
{
    char *text = strdup(quoted);
    for (char *c = text; *c; c++)
        if (*c == '\'')
            *c = '"';
    return text;
}

struct glint_scene *reparse(const char *text, size_t length, const struct glint_asset *asset,
                            size_t n, const struct glint_scene *checked)
{
    struct glint_error err = {0};
    struct glint_scene *scene;
    if (glint_scene_parse_from(&scene, text, length, asset, n, checked, &err))
        fail_msg("%s: %s in %s", err.fault[0].pointer, err.fault[0].detail, text);
    return scene;
}

struct glint_scene *parse_with(const char *quoted, const struct glint_asset *asset, size_t n)
{
    char *text = json(quoted);
    struct glint_scene *scene = reparse(text, strlen(text), asset, n, NULL);
    free(text);
    return scene;
}

struct glint_scene *parse(const char *quoted)
{
    return parse_with(quoted, NULL, 0);
}

static bool has_fault(const struct glint_error *err, const char *pointer, const char *words)
{
    for (size_t i = 0; i < err->count; i++)
        if (strcmp(pointer, err->fault[i].pointer) == 0 &&
            (!words || strstr(err->fault[i].detail, words)))
            return true;
    return false;
}

void refuse_with(const char *quoted, const struct glint_asset *asset, size_t n,
                 const char *pointers)
{
    struct glint_error err = {0};
    struct glint_scene *scene;
    char *text = json(quoted), *want = strdup(pointers), *rest = want;
    if (!glint_scene_parse(&scene, text, strlen(text), asset, n, &err))
        fail_msg("accepted: %s", quoted);
    assert_null(scene);
    size_t found = 0, wanted = 0;
    for (char *p; (p = strsep(&rest, "|")); wanted++) {
        char *words = strchr(p, '=');
        if (words)
            *words++ = '\0';
        if (has_fault(&err, p, words))
            found++;
        else
            print_message("# no fault at %s of %s\n", p, words ? words : "any kind");
    }
    if (found != wanted || err.count != wanted)
        for (size_t i = 0; i < err.count; i++)
            print_message("# %s: %s\n", err.fault[i].pointer, err.fault[i].detail);
    assert_int_equal(found, wanted);
    assert_int_equal(err.count, wanted);
    glint_error_finish(&err);
    free(text);
    free(want);
}

void refuse(const char *quoted, const char *pointers)
{
    refuse_with(quoted, NULL, 0, pointers);
}

struct glint_asset name_asset(const void *bytes, size_t size)
{
    struct glint_asset asset = {.bytes = bytes, .size = size};
    assert_true(glint_asset_name(bytes, size, asset.sha256));
    return asset;
}
