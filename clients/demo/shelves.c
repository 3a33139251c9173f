// shelves.c - the shelves and what lies on them.
#include "compose.h"
#include "dice.h"
#include "palette.h"

#include <math.h>
#include <stdio.h>

#define HALF_TURN 1.95 // radians the shelves reach to either side of -z
#define PEBBLES 6

static const char *const kinds[] = {"bead", "cube", "rod", "pebble", "ring", "cone"};
enum kind { BEAD, CUBE, ROD, PEBBLE, RING, CONE, KINDS };

static void add_shelves(struct glint_document *d)
{
    struct glint_profile p = {0};
    struct glint_shape shape = {0};
    glint_profile_add(&p, STAGE_RADIUS, FLOOR);
    for (int i = 0; i < SHELVES; i++) {
        const double radius = STAGE_RADIUS + i * SHELF_DEPTH, top = (i + 1) * SHELF_RISE;
        glint_profile_arc(&p, radius + SHELF_EDGE, top - SHELF_EDGE, SHELF_EDGE, M_PI, M_PI / 2, 3);
    }
    glint_profile_add(&p, STAGE_RADIUS + SHELVES * SHELF_DEPTH, SHELVES * SHELF_RISE);
    glint_profile_add(&p, STAGE_RADIUS + SHELVES * SHELF_DEPTH, FLOOR);
    glint_shape_lathe(&shape, &p, M_PI - HALF_TURN, M_PI + HALF_TURN, 128);
    glint_shape_cap(&shape, &p, M_PI - HALF_TURN, FLOOR, -1);
    glint_shape_cap(&shape, &p, M_PI + HALF_TURN, FLOOR, 1);
    glint_document_mesh(d, "shelves", &shape);
    glint_document_put(d, "shelves", "shelves", "plaster", "set",
                       &(struct glint_place){.scale = {1, 1, 1}});
}

static void add_set(struct glint_document *d, const char *name, const struct glint_profile *profile,
                    double half_turn)
{
    struct glint_shape shape = {0};
    glint_shape_lathe(&shape, profile, M_PI - half_turn, M_PI + half_turn, 128);
    glint_document_mesh(d, name, &shape);
    glint_document_put(d, name, name, "paper", "set", &(struct glint_place){.scale = {1, 1, 1}});
}

// The floor sweeps up into the wall, so that no horizon shows; the front is open.
static void add_backdrop(struct glint_document *d)
{
    const double foot = 4.6, bend = 2.5;
    struct glint_profile floor_ = {0}, wall = {0};
    glint_profile_add(&floor_, foot, FLOOR);
    glint_profile_add(&floor_, 0, FLOOR);
    add_set(d, "floor", &floor_, M_PI);
    glint_profile_arc(&wall, foot, FLOOR + bend, bend, 0, -M_PI / 2, 24);
    add_set(d, "wall", &wall, 2.4);
}

static void add_rod(struct glint_document *d)
{
    struct glint_profile p = {0};
    struct glint_shape shape = {0};
    glint_profile_add(&p, 0, 0);
    glint_profile_arc(&p, 0.36, 0.06, 0.06, -M_PI / 2, 0, 2);
    glint_profile_arc(&p, 0.36, 2.14, 0.06, 0, M_PI / 2, 2);
    glint_profile_add(&p, 0, 2.2);
    glint_shape_lathe(&shape, &p, 0, 2 * M_PI, 20);
    glint_document_mesh(d, "rod", &shape);
}

static void add_cone(struct glint_document *d)
{
    struct glint_profile p = {0};
    struct glint_shape shape = {0};
    glint_profile_add(&p, 0, 0);
    glint_profile_arc(&p, 0.82, 0.08, 0.08, -M_PI / 2, 0.42, 3);
    glint_profile_arc(&p, 0, 1.9, 0.09, 0.42, M_PI / 2, 3);
    glint_shape_lathe(&shape, &p, 0, 2 * M_PI, 24);
    glint_document_mesh(d, "cone", &shape);
}

// Each about one unit in radius, and but for beads, cubes, pebbles and rings standing on y = 0.
static void add_meshes(struct glint_document *d)
{
    struct glint_shape shape = {0};
    glint_document_sphere(d, "bead", 20);
    glint_shape_box(&shape, (double[]){1.6, 1.6, 1.6}, 0.14, 1);
    glint_document_mesh(d, "cube", &shape);
    glint_shape_torus(&shape, 0.66, 0.3, 24, 10);
    glint_document_mesh(d, "ring", &shape);
    add_rod(d);
    add_cone(d);
    for (int i = 0; i < PEBBLES; i++) {
        char id[24];
        snprintf(id, sizeof id, "pebble%d", i);
        glint_shape_pebble(&shape, 7u + (uint32_t)i, 20);
        glint_document_mesh(d, id, &shape);
    }
}

// Height of a mesh's centre above what it lies on, in units of its scale along y.
static double rest(enum kind kind)
{
    static const double height[KINDS] = {1, 0.8, 0, 1.08, 0.3, 0};
    return height[kind];
}

static void shape_thing(enum kind kind, struct glint_dice *dice, struct glint_place *p, double size)
{
    for (int k = 0; k < 3; k++)
        p->scale[k] = size;
    if (kind == PEBBLE) {
        p->scale[1] *= glint_dice_range(dice, 0.45, 0.68);
        p->scale[2] *= 0.88;
    } else if (kind == ROD) {
        p->scale[1] *= glint_dice_range(dice, 0.75, 1.3);
    }
}

// The colour runs round the shelves and shifts from shelf to shelf; neighbours differ by a little.
static void choose_material(struct glint_dice *dice, double along, int shelf, char id[40])
{
    const double n = GLINT_PALETTE_COLORS;
    const double place = along * 0.95 * n + shelf * 0.25 + glint_dice_range(dice, -0.9, 0.9);
    const unsigned color = (unsigned)(place + n) % GLINT_PALETTE_COLORS;
    const unsigned chance = glint_dice_below(dice, 100);
    if (chance < 6)
        snprintf(id, 40, "%s", chance < 4 ? "satin brass" : "satin copper");
    else
        snprintf(id, 40, "%s %s", chance < 45 ? "ceramic" : "glazed", glint_palette_name(color));
}

struct row {
    int shelf, things;
    double size; // of the largest thing
    int count[KINDS];
};

static void put_thing(struct glint_document *d, struct glint_dice *dice, struct row *row,
                      enum kind kind, double along)
{
    const double radius = STAGE_RADIUS + (row->shelf + 0.55) * SHELF_DEPTH;
    const double angle = M_PI + (2 * along - 1) * (HALF_TURN - 0.03);
    struct glint_place p = {.turn = glint_dice_range(dice, 0, 2 * M_PI)};
    shape_thing(kind, dice, &p, row->size * glint_dice_range(dice, 0.88, 1));
    p.at[0] = radius * sin(angle);
    p.at[1] = (row->shelf + 1) * SHELF_RISE + rest(kind) * p.scale[1] + 0.0005;
    p.at[2] = radius * cos(angle);
    if (kind == CUBE)
        p.turn = angle + glint_dice_range(dice, -0.5, 0.5);
    char mesh[24], name[48], material[40];
    if (kind == PEBBLE)
        snprintf(mesh, sizeof mesh, "pebble%u", glint_dice_below(dice, PEBBLES));
    else
        snprintf(mesh, sizeof mesh, "%s", kinds[kind]);
    snprintf(name, sizeof name, "shelf%02d/%s%03d", row->shelf + 1, kinds[kind],
             ++row->count[kind]);
    choose_material(dice, along, row->shelf, material);
    glint_document_put(d, name, mesh, material, kinds[kind], &p);
}

// Things stand in runs of one kind.
static void fill_shelf(struct glint_document *d, struct glint_dice *dice, int shelf)
{
    struct row row = {.shelf = shelf, .size = 0.044 + 0.0012 * shelf};
    const double radius = STAGE_RADIUS + (shelf + 0.5) * SHELF_DEPTH;
    row.things = (int)(radius * 2 * HALF_TURN / (2.35 * row.size));
    enum kind kind = BEAD;
    int left = 0;
    for (int i = 0; i < row.things; i++, left--) {
        if (left == 0) {
            left = 3 + (int)glint_dice_below(dice, 6);
            kind = (enum kind)((kind + 1 + glint_dice_below(dice, KINDS - 1)) % KINDS);
        }
        put_thing(d, dice, &row, kind, (i + 0.5) / row.things);
    }
}

void glint_compose_shelves(struct glint_document *d)
{
    struct glint_dice dice = {2022};
    add_backdrop(d);
    add_shelves(d);
    add_meshes(d);
    for (int i = 0; i < SHELVES; i++)
        fill_shelf(d, &dice, i);
}
