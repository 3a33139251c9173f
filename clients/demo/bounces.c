// bounces.c - scenes about mattes through reflections and refractions: curved strips from polished
// to rough, a glass body before a plant, water with things behind and above it.
#include "dice.h"
#include "scenes.h"

#include <math.h>
#include <stdio.h>

static void put(struct glint_document *d, const char *name, const char *mesh, const char *material,
                const char *asset, const double at[3], const double scale[3])
{
    const struct glint_place p = {.at = {at[0], at[1], at[2]},
                                  .scale = {scale[0], scale[1], scale[2]}};
    glint_document_put(d, name, mesh, material, asset, &p);
}

static void add_ceramics(struct glint_document *d)
{
    static const double colors[][3] = {{0.75, 0.12, 0.08}, {0.80, 0.45, 0.05}, {0.75, 0.70, 0.12},
                                       {0.15, 0.50, 0.15}, {0.08, 0.40, 0.60}, {0.30, 0.15, 0.55}};
    for (int i = 0; i < 6; i++) {
        char id[16];
        struct glint_look look = {.color = {colors[i][0], colors[i][1], colors[i][2]},
                                  .roughness = 0.6};
        snprintf(id, sizeof id, "ceramic%d", i);
        glint_document_material(d, id, &look);
    }
    glint_document_sphere(d, "ball", 48);
}

static void add_floor(struct glint_document *d, const char *name, double y, double size,
                      const double color[3])
{
    struct glint_look look = {.color = {color[0], color[1], color[2]}, .roughness = 0.9};
    const double box[3] = {size, 0.1, size};
    struct glint_shape shape = {0};
    glint_document_material(d, name, &look);
    glint_shape_box(&shape, box, 0.001, 1);
    glint_document_mesh(d, name, &shape);
    put(d, name, name, name, "set", (double[]){0, y - 0.05, 0}, (double[]){1, 1, 1});
}

// From the floor up: bulging, then hollow and leaning over the floor.
static void strip_outline(struct glint_profile *p)
{
    const double radius = 0.6;
    for (int i = 0; i <= 48; i++) {
        const double b = -1.2 + 1.2 * i / 48;
        glint_profile_add(p, radius * (cos(b) - 1), radius * (sin(b) + 1) - 0.03);
    }
    for (int i = 1; i <= 48; i++) {
        const double a = 1.2 * i / 48;
        glint_profile_add(p, radius * (1 - cos(a)), radius * (1 + sin(a)) - 0.03);
    }
}

void glint_scene_strips(struct glint_document *d)
{
    struct glint_profile outline = {0};
    strip_outline(&outline);
    for (int i = 0; i < 8; i++) {
        struct glint_shape shape = {0};
        char name[24];
        snprintf(name, sizeof name, "strip%d", i);
        glint_document_material(
            d, name,
            &(struct glint_look){
                .color = {0.9, 0.9, 0.9}, .roughness = 0.1 * i, .metallic = 1, .ior = 1.5});
        glint_shape_extrude(&shape, &outline, 0.36);
        glint_document_mesh(d, name, &shape);
        put(d, name, name, name, "strips", (double[]){0.4 * (i - 3.5), 0, 0}, (double[]){1, 1, 1});
    }
    add_ceramics(d);
    add_floor(d, "floor", 0, 30, (double[]){0.55, 0.5, 0.42});
    for (int i = 0; i < 12; i++) {
        char name[24], material[16];
        const double r = 0.07 + 0.02 * (i % 3);
        snprintf(name, sizeof name, "ball%d", i);
        snprintf(material, sizeof material, "ceramic%d", i % 6);
        put(d, name, "ball", material, "balls",
            (double[]){0.28 * (i - 5.5), r, 0.35 + 0.35 * (i % 2)}, (double[]){r, r, r});
    }
    glint_scene_light(d, (double[]){-3, 4, 5}, 20, 2);
    glint_scene_sky(d, 0.35);
    glint_scene_camera(d, (double[]){0, 1.0, 4.6}, (double[]){0, 0.5, 0}, 0.45);
}

static void add_leaf(struct glint_document *d, struct glint_dice *dice, int number)
{
    const double height = glint_dice_range(dice, 0.15, 1.25);
    const double a = glint_dice_range(dice, 0, 2 * M_PI);
    const double out = glint_dice_range(dice, 0.05, 0.45) * (1.3 - 0.6 * height);
    const double size = glint_dice_range(dice, 0.05, 0.11);
    char name[32], material[16];
    snprintf(name, sizeof name, "plant/leaf%03d", number);
    snprintf(material, sizeof material, "leaf%u", glint_dice_below(dice, 4));
    const struct glint_place p = {
        .at = {out * sin(a), height, -0.9 + out * cos(a)},
        .turn = a,
        .lean = glint_dice_range(dice, -0.6, 0.9),
        .roll = glint_dice_range(dice, -0.5, 0.5),
        .scale = {0.45 * size, 0.12 * size, size},
    };
    glint_document_put(d, name, "ball", material, "plant", &p);
}

// A vase of solid glass, and a rough one beside it.
static void add_glass(struct glint_document *d)
{
    static const double outline[][2] = {{0, 0},       {0.20, 0},    {0.26, 0.04}, {0.33, 0.20},
                                        {0.35, 0.38}, {0.31, 0.58}, {0.20, 0.76}, {0.15, 0.90},
                                        {0.17, 1.00}, {0.15, 1.03}, {0, 1.03}};
    struct glint_profile p = {0};
    struct glint_shape shape = {0};
    for (size_t i = 0; i < sizeof outline / sizeof *outline; i++)
        glint_profile_add(&p, outline[i][0], outline[i][1]);
    glint_shape_lathe(&shape, &p, 0, 2 * M_PI, 96);
    glint_document_mesh(d, "vase", &shape);
    glint_document_material(d, "clear glass", &(struct glint_look){{1, 1, 1}, 0.02, 0, 1, 1.5});
    glint_document_material(d, "rough glass",
                            &(struct glint_look){{0.97, 0.99, 0.98}, 0.2, 0, 1, 1.5});
    put(d, "glass", "vase", "clear glass", "glass", (double[]){-0.32, 0.002, 0.2},
        (double[]){1, 1, 1});
    put(d, "rough glass", "vase", "rough glass", "glass", (double[]){0.42, 0.002, 0.1},
        (double[]){0.9, 0.8, 0.9});
}

void glint_scene_plant(struct glint_document *d)
{
    static const double greens[4][3] = {
        {0.10, 0.32, 0.06}, {0.20, 0.42, 0.08}, {0.06, 0.22, 0.08}, {0.38, 0.45, 0.10}};
    struct glint_dice dice = {5};
    add_ceramics(d);
    for (int i = 0; i < 4; i++) {
        char id[16];
        snprintf(id, sizeof id, "leaf%d", i);
        glint_document_material(
            d, id,
            &(struct glint_look){{greens[i][0], greens[i][1], greens[i][2]}, 0.5, 0, 0, 1.5});
    }
    add_floor(d, "floor", 0, 8, (double[]){0.6, 0.57, 0.52});
    for (int i = 0; i < 260; i++)
        add_leaf(d, &dice, i);
    put(d, "pot", "ball", "ceramic0", "plant", (double[]){0, 0.1, -0.9},
        (double[]){0.22, 0.1, 0.22});
    add_glass(d);
    glint_scene_light(d, (double[]){2, 4, 2}, 14, 1.5);
    glint_scene_sky(d, 0.6);
    glint_scene_camera(d, (double[]){0, 0.85, 3.0}, (double[]){0, 0.6, -0.4}, 0.5);
}

// Height of the water, which is no wave twice, and its normal.
static void wave(double x, double z, double *height, double normal[3])
{
    static const struct {
        double x, z, size, shift;
    } part[] = {{9, 4, 0.0050, 0}, {-5, 11, 0.0040, 1}, {17, -9, 0.0016, 2}, {7, 23, 0.0011, 3}};
    double dx = 0, dz = 0;
    *height = 0;
    for (size_t i = 0; i < sizeof part / sizeof *part; i++) {
        const double a = part[i].x * x + part[i].z * z + part[i].shift;
        *height += part[i].size * sin(a);
        dx += part[i].size * part[i].x * cos(a);
        dz += part[i].size * part[i].z * cos(a);
    }
    const double length = sqrt(dx * dx + dz * dz + 1);
    normal[0] = -dx / length;
    normal[1] = 1 / length;
    normal[2] = -dz / length;
}

void glint_scene_water(struct glint_document *d)
{
    struct glint_shape shape = {0};
    add_ceramics(d);
    glint_shape_field(&shape, 6.0, 160, wave);
    glint_document_mesh(d, "water", &shape);
    glint_document_material(d, "water", &(struct glint_look){{1, 1, 1}, 0.06, 0, 1, 1.33});
    put(d, "water", "water", "water", "water", (double[]){0, 0, 0}, (double[]){1, 1, 1});
    add_floor(d, "ground", -0.5, 9, (double[]){0.45, 0.42, 0.36});
    for (int i = 0; i < 24; i++) {
        char name[24], material[16];
        const double a = 2.4 * i, far = 0.5 + 0.09 * i, r = 0.09 + 0.03 * (i % 3);
        snprintf(name, sizeof name, "%s%d", i % 2 ? "buoy" : "stone", i);
        snprintf(material, sizeof material, "ceramic%d", i % 6);
        put(d, name, "ball", material, i % 2 ? "buoys" : "stones",
            (double[]){far * sin(a), i % 2 ? 0.25 + 0.03 * i : -0.5 + r, far * cos(a) - 0.6},
            (double[]){r, r, r});
    }
    glint_scene_sky(d, 1.0);
    glint_scene_camera(d, (double[]){0, 1.1, 3.2}, (double[]){0, 0.05, -0.4}, 0.6);
}
