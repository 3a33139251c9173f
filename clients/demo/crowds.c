// crowds.c - scenes with many IDs in a pixel: forty stripes that a rough mirror shows, and a tuft of
// blades.
#include "dice.h"
#include "scenes.h"

#include <math.h>
#include <stdio.h>

static void add_colors(struct glint_document *d, struct glint_dice *dice, int count)
{
    for (int i = 0; i < count; i++) {
        char id[16];
        struct glint_look look = {.roughness = 0.8};
        for (int k = 0; k < 3; k++)
            look.color[k] = glint_dice_range(dice, 0.05, 0.85);
        snprintf(id, sizeof id, "color%02d", i);
        glint_document_material(d, id, &look);
    }
}

static void add_unit_box(struct glint_document *d)
{
    struct glint_shape box = {0};
    glint_shape_box(&box, (double[]){1, 1, 1}, 0.01, 1);
    glint_document_mesh(d, "box", &box);
}

// Widths fall as 1/rank; the mirror stands before the camera, the stripes behind it.
void glint_scene_forty(struct glint_document *d)
{
    struct glint_dice dice = {40};
    double all = 0, x = -2;
    add_colors(d, &dice, 40);
    add_unit_box(d);
    for (int i = 1; i <= 40; i++)
        all += 1.0 / i;
    for (int i = 1; i <= 40; i++) {
        const double width = 4 / (i * all);
        char name[16], material[16];
        snprintf(name, sizeof name, "stripe%02d", i);
        snprintf(material, sizeof material, "color%02d", i - 1);
        const struct glint_place p = {.at = {x + width / 2, 0, 3}, .scale = {width, 4, 0.05}};
        glint_document_put(d, name, "box", material, "stripes", &p);
        x += width;
    }
    glint_document_material(d, "mirror", &(struct glint_look){{0.95, 0.95, 0.95}, 0.45, 1, 0, 1.5});
    const struct glint_place mirror = {.at = {0, 0, -2}, .scale = {6, 6, 0.05}};
    glint_document_put(d, "mirror", "box", "mirror", "mirror", &mirror);
    glint_scene_sky(d, 1);
    glint_scene_camera(d, (double[]){0, 0, 1}, (double[]){0, 0, -2}, 0.3);
}

void glint_scene_cluster(struct glint_document *d)
{
    struct glint_dice dice = {15};
    add_colors(d, &dice, 24);
    add_unit_box(d);
    glint_document_material(d, "ground", &(struct glint_look){{0.5, 0.45, 0.4}, 0.9, 0, 0, 1.5});
    const struct glint_place ground = {.at = {0, -0.05, 0}, .scale = {8, 0.1, 8}};
    glint_document_put(d, "ground", "box", "ground", "ground", &ground);
    for (int i = 0; i < 1200; i++) {
        const double a = glint_dice_range(&dice, 0, 2 * M_PI);
        const double out = 0.6 * sqrt(glint_dice_range(&dice, 0, 1));
        const double tall = glint_dice_range(&dice, 0.5, 1.0);
        char name[24], material[16];
        snprintf(name, sizeof name, "tuft/blade%04d", i);
        snprintf(material, sizeof material, "color%02u", glint_dice_below(&dice, 24));
        const struct glint_place p = {.at = {out * sin(a), tall / 2, out * cos(a)},
                                      .turn = glint_dice_range(&dice, 0, M_PI),
                                      .lean = glint_dice_range(&dice, -0.25, 0.25),
                                      .scale = {0.005, tall, 0.002}};
        glint_document_put(d, name, "box", material, "tuft", &p);
    }
    glint_scene_light(d, (double[]){2, 4, 3}, 16, 1.5);
    glint_scene_sky(d, 0.6);
    glint_scene_camera(d, (double[]){0, 0.8, 4}, (double[]){0, 0.45, 0}, 0.4);
}
