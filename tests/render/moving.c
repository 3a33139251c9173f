#include "tests/render/moving.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define WALL "'wall':{'mesh':'wall','material':'white','transform':{'translation':[0,0,-1.5]}}"
#define DARK "'environment':{'radiance':[0,0,0]}"
#define WALL_MESH "'wall':{'primitive':'quad','size':[20,20]}"

char *moving_box(void)
{
    return stable_text(
        "{" MOVING_MATERIALS ",'meshes':{" WALL_MESH ",'box':{'primitive':'box'}},'nodes':{'n':{}},"
        "'instances':{" WALL ",'box':{'mesh':'box','material':'red','node':'n'}},"
        "'animations':{'a':{'channels':{'c':{'node':'n','path':'translation','times':[0,1],"
        "'values':[-1.5,-0.3,0,1.5,0.4,0]}}}}," MOVING_CAMERA "," MOVING_LAMP "}");
}

char *moving_bar(void)
{
    return stable_text(
        "{" MOVING_MATERIALS ",'meshes':{" WALL_MESH
        ",'bar':{'primitive':'box','size':[2.4,0.3,0.3]}},"
        "'nodes':{'n':{}},'instances':{" WALL ",'bar':{'mesh':'bar','material':'red','node':'n',"
        "'transform':{'translation':[0.3,0,0]}}},"
        "'animations':{'a':{'channels':{'c':{'node':'n','path':'rotation','times':[0,1],"
        "'values':[0,0,0,1,0,0,0.70710678,0.70710678]}}}}," MOVING_CAMERA "," MOVING_LAMP "}");
}

#define LEVELS 9

// A column of four sides from y = 0 to 2. One writer for each list of numbers.
enum list { POSITIONS, NORMALS, JOINTS, WEIGHTS, SWELLING };

static void write_vertex(FILE *out, enum list list, int level, int corner)
{
    static const double side[4][2] = {{-1, 1}, {1, 1}, {1, -1}, {-1, -1}};
    const double y = 2.0 * level / (LEVELS - 1), *s = side[corner];
    const double second = fmin(fmax(y - 0.5, 0), 1);
    if (list == POSITIONS)
        fprintf(out, "%g,%g,%g,", 0.25 * s[0], y, 0.25 * s[1]);
    else if (list == NORMALS)
        fprintf(out, "%g,0,%g,", s[0] * sqrt(0.5), s[1] * sqrt(0.5));
    else if (list == JOINTS)
        fprintf(out, "0,1,0,0,");
    else if (list == WEIGHTS)
        fprintf(out, "%g,%g,0,0,", 1 - second, second);
    else
        fprintf(out, "%g,0,0,", 0.4 * s[0] * sin(0.5 * M_PI * y));
}

// malloc'd, without the last comma.
static char *column_list(enum list list)
{
    char *text;
    size_t size;
    FILE *out = open_memstream(&text, &size);
    for (int level = 0; level < LEVELS; level++)
        for (int corner = 0; corner < 4; corner++)
            write_vertex(out, list, level, corner);
    fclose(out);
    text[strlen(text) - 1] = 0;
    return text;
}

static char *column_indices(void)
{
    char *text;
    size_t size;
    FILE *out = open_memstream(&text, &size);
    for (int i = 0; i < 4 * (LEVELS - 1); i++) {
        const int a = i, b = i / 4 * 4 + (i + 1) % 4;
        fprintf(out, "%s%d,%d,%d,%d,%d,%d", i ? "," : "", a, b, b + 4, a, b + 4, a + 4);
    }
    fclose(out);
    return text;
}

char *moving_column(void)
{
    char *list[5], *indices = column_indices();
    for (int i = 0; i < 5; i++)
        list[i] = column_list((enum list)i);
    char *text = stable_text(
        "{" MOVING_MATERIALS ",'meshes':{" WALL_MESH ",'column':{'positions':[%s],'normals':[%s],"
        "'joints':[%s],'weights':[%s],'targets':[{'positions':[%s]}],'indices':[%s]}},"
        "'nodes':{'foot':{'transform':{'translation':[0,-1.2,0]}},"
        "'knee':{'parent':'foot','transform':{'translation':[0,1,0]}},'weights':{}},"
        "'skins':{'s':{'joints':['foot','knee'],'inverse_bind':[1,0,0,0,0,1,0,0,0,0,1,0,0,0,0,1,"
        "1,0,0,0,0,1,0,0,0,0,1,0,0,-1,0,1]}},"
        "'instances':{" WALL ",'column':{'mesh':'column','material':'red','skin':'s',"
        "'node':'weights'}},'animations':{'a':{'channels':{"
        "'bend':{'node':'knee','path':'rotation','times':[0,1],"
        "'values':[0,0,0,1,0,0,-0.5,0.8660254]},"
        "'swell':{'node':'weights','path':'weights','times':[0,1],'values':[0,1]}}}}," MOVING_CAMERA
        "," MOVING_LAMP "}",
        list[POSITIONS], list[NORMALS], list[JOINTS], list[WEIGHTS], list[SWELLING], indices);
    for (int i = 0; i < 5; i++)
        free(list[i]);
    free(indices);
    return text;
}

char *moving_camera(void)
{
    return stable_text(
        "{" MOVING_MATERIALS ",'meshes':{" WALL_MESH ",'box':{'primitive':'box'}},'nodes':{'n':{}},"
        "'instances':{" WALL ",'box':{'mesh':'box','material':'red'}},"
        "'animations':{'a':{'channels':{'go':{'node':'n','path':'translation','times':[0,1],"
        "'values':[-0.7,0,6,0.7,0.2,5.5]},'turn':{'node':'n','path':'rotation','times':[0,1],"
        "'values':[0,-0.05,0,0.99875,0,0.1,0.02,0.994786]}}}},"
        "'cameras':{'eye':{'yfov':0.6,'node':'n'}}," MOVING_LAMP "}");
}

char *moving_emitter(void)
{
    return stable_text(
        "{" MOVING_MATERIALS ",'meshes':{" WALL_MESH
        ",'panel':{'primitive':'quad','size':[0.6,0.6]}},"
        "'nodes':{'n':{}},'instances':{" WALL ",'panel':{'mesh':'panel','material':'glow',"
        "'node':'n','transform':{'rotation':[0,0.70710678,0,0.70710678]}}},"
        "'lights':{'area':{'type':'area','intensity':4,'size':[0.5,0.5],'node':'n',"
        "'transform':{'translation':[0,1,0.2]}}},"
        "'animations':{'a':{'channels':{'c':{'node':'n','path':'translation','times':[0,1],"
        "'values':[-1.5,-0.6,-0.8,1.5,0.6,-0.8]},'d':{'node':'n','path':'rotation','times':[0,1],"
        "'values':[0,0,0,1,0,0.25881905,0,0.96592583]}}}}," MOVING_CAMERA "," DARK "}");
}

char *moving_lamps(void)
{
    return stable_text(
        "{" MOVING_MATERIALS ",'meshes':{" WALL_MESH "},'nodes':{'n':{}},'instances':{" WALL "},"
        "'lights':{'point':{'type':'point','intensity':1,'node':'n'},"
        "'spot':{'type':'spot','intensity':8,'outer_cone':0.3,'node':'n',"
        "'transform':{'translation':[0,0.5,1]}}},"
        "'animations':{'a':{'channels':{'c':{'node':'n','path':'translation','times':[0,1],"
        "'values':[-1.2,0,-0.9,1.2,0.3,-0.9]},'d':{'node':'n','path':'rotation','times':[0,1],"
        "'values':[0,0,0,1,0.1,0,0,0.99498744]}}}}," MOVING_CAMERA "," DARK "}");
}

char *moving_job(double open, double close, int side, int samples, int seed)
{
    char *members = stable_text("'fps':1,'frame':0,'shutter':[%.9g,%.9g],'resolution':[%d,%d],"
                                "'filter':{'kind':'box','width':1},'max_bounces':2,'seed':%d,"
                                "'stop':{'samples':%d}",
                                open, close, side, side * 3 / 4, seed, samples);
    char *job = stable_job(members);
    free(members);
    return job;
}
