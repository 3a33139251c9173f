// still_life.c - the stage, and the glass and metal on it.
#include "compose.h"
#include "palette.h"

#include <math.h>
#include <stdio.h>

#define GAP 0.0005 // metres between things that stand on each other: no two faces coincide
#define BOWL_X (-0.88)
#define BOWL_Z 0.24
#define TUMBLER_X 0.36
#define TUMBLER_Z 0.60

static void put(struct glint_document *d, const char *name, const char *mesh, const char *material,
                const char *asset, double x, double y, double z, double turn)
{
    glint_document_put(
        d, name, mesh, material, asset,
        &(struct glint_place){.at = {x, y + GAP, z}, .turn = turn, .scale = {1, 1, 1}});
}

static void put_ball(struct glint_document *d, const char *name, const char *mesh,
                     const char *material, const char *asset, double x, double z, double radius)
{
    glint_document_put(
        d, name, mesh, material, asset,
        &(struct glint_place){.at = {x, radius + GAP, z}, .scale = {radius, radius, radius}});
}

static void add_stage(struct glint_document *d)
{
    struct glint_profile p = {0};
    struct glint_shape shape = {0};
    const double r = STAGE_RADIUS - 0.01;
    glint_profile_add(&p, 0, FLOOR + GAP);
    glint_profile_arc(&p, r - 0.015, FLOOR + GAP + 0.015, 0.015, -M_PI / 2, 0, 4);
    glint_profile_arc(&p, r - 0.015, -0.015, 0.015, 0, M_PI / 2, 4);
    glint_profile_add(&p, 0, 0);
    glint_shape_lathe(&shape, &p, 0, 2 * M_PI, 160);
    glint_document_mesh(d, "stage", &shape);
    put(d, "stage", "stage", "lacquer", "set", 0, -GAP, 0, 0);
}

// Beads that touch the wall and not each other: one below, then rings of them.
static void fill_bowl(struct glint_document *d, double inner, double centre)
{
    static const struct {
        double tilt;
        int beads;
    } rings[] = {{0, 1}, {0.545, 6}, {1.08, 10}};
    const double bead = 0.0565, reach = inner - bead - GAP;
    int number = 0;
    for (size_t r = 0; r < sizeof rings / sizeof *rings; r++)
        for (int i = 0; i < rings[r].beads; i++) {
            const double a = 2 * M_PI * (i + 0.3 * (double)r) / rings[r].beads;
            const struct glint_place p = {.at = {BOWL_X + reach * sin(rings[r].tilt) * sin(a),
                                                 centre - reach * cos(rings[r].tilt) + GAP,
                                                 BOWL_Z + reach * sin(rings[r].tilt) * cos(a)},
                                          .scale = {bead, bead, bead}};
            char name[32], material[40];
            snprintf(name, sizeof name, "bowl/bead%03d", ++number);
            snprintf(material, sizeof material, "glazed %s",
                     glint_palette_name((unsigned)(number * 5) % GLINT_PALETTE_COLORS));
            glint_document_put(d, name, "bead", material, "bead", &p);
        }
}

// A vessel with a wall of even thickness, closed: down inside, up outside.
static void add_bowl(struct glint_document *d)
{
    struct glint_profile p = {0};
    struct glint_shape shape = {0};
    const double c = 0.30, outer = 0.30, inner = 0.282;
    glint_profile_add(&p, 0, 0);
    glint_profile_arc(&p, 0.11, 0.006, 0.006, -M_PI / 2, 0, 3);
    const double start = -acos(0.116 / outer);
    glint_profile_arc(&p, 0, c, outer, start, -0.12, 28);
    glint_profile_arc(&p, (outer + inner) / 2 * cos(0.12), c - (outer + inner) / 2 * sin(0.12),
                      (outer - inner) / 2, 0, M_PI, 6);
    glint_profile_arc(&p, 0, c, inner, -0.12, -M_PI / 2, 32);
    glint_shape_lathe(&shape, &p, 0, 2 * M_PI, 128);
    glint_document_mesh(d, "bowl", &shape);
    put(d, "copper bowl", "bowl", "satin copper", "metal", BOWL_X, 0, BOWL_Z, 0);
    fill_bowl(d, inner, c);
}

static void add_cylinder(struct glint_document *d)
{
    struct glint_profile p = {0};
    struct glint_shape shape = {0};
    const double r = 0.19, h = 0.62, edge = 0.012;
    glint_profile_add(&p, 0, 0);
    glint_profile_arc(&p, r - edge, edge, edge, -M_PI / 2, 0, 4);
    glint_profile_arc(&p, r - edge, h - edge, edge, 0, M_PI / 2, 4);
    glint_profile_add(&p, 0, h);
    glint_shape_lathe(&shape, &p, 0, 2 * M_PI, 128);
    glint_document_mesh(d, "cylinder", &shape);
    put(d, "steel cylinder", "cylinder", "brushed steel", "metal", 1.00, 0, -0.24, 0);
}

// Rods that lean outwards without reaching the wall.
static void fill_tumbler(struct glint_document *d, double foot)
{
    static const unsigned color[5] = {12, 4, 10, 15, 3};
    for (int i = 0; i < 5; i++) {
        const double a = 2 * M_PI * i / 5 + 0.4;
        char name[32], material[40];
        snprintf(name, sizeof name, "tumbler/rod%03d", i + 1);
        snprintf(material, sizeof material, "ceramic %s", glint_palette_name(color[i]));
        glint_document_put(d, name, "rod", material, "rod",
                           &(struct glint_place){.at = {TUMBLER_X + 0.062 * sin(a), foot + 0.006,
                                                        TUMBLER_Z + 0.062 * cos(a)},
                                                 .turn = a,
                                                 .lean = 0.13,
                                                 .scale = {0.045, 0.24 + 0.02 * (i % 3), 0.045}});
    }
}

// A glass with straight walls and a thick foot: one closed body.
static void add_tumbler(struct glint_document *d)
{
    struct glint_profile p = {0};
    struct glint_shape shape = {0};
    const double r = 0.17, wall = 0.012, h = 0.46, foot = 0.05, edge = 0.02;
    glint_profile_add(&p, 0, 0);
    glint_profile_arc(&p, r - edge, edge, edge, -M_PI / 2, 0, 6);
    glint_profile_arc(&p, r - wall / 2, h - wall / 2, wall / 2, 0, M_PI, 8);
    glint_profile_arc(&p, r - wall - edge, foot + edge, edge, 0, -M_PI / 2, 6);
    glint_profile_add(&p, 0, foot);
    glint_shape_lathe(&shape, &p, 0, 2 * M_PI, 128);
    glint_document_mesh(d, "tumbler", &shape);
    put(d, "tumbler", "tumbler", "clear glass", "glass", TUMBLER_X, 0, TUMBLER_Z, 0);
    fill_tumbler(d, foot);
}

static void add_panels(struct glint_document *d)
{
    struct glint_shape shape = {0};
    glint_shape_box(&shape, (double[]){0.62, 1.06, 0.05}, 0.018, 4);
    glint_document_mesh(d, "panel", &shape);
    put(d, "frosted panel", "panel", "frosted glass", "glass", -0.52, 0.53, -0.30, 0.42);
}

// A round mirror that leans against the cylinder.
static void add_mirror(struct glint_document *d)
{
    struct glint_profile p = {0};
    struct glint_shape shape = {0};
    const double r = 0.30, t = 0.012;
    glint_profile_add(&p, 0, -t);
    glint_profile_arc(&p, r, 0, t, -M_PI / 2, M_PI / 2, 8);
    glint_profile_add(&p, 0, t);
    glint_shape_lathe(&shape, &p, 0, 2 * M_PI, 160);
    glint_document_mesh(d, "mirror", &shape);
    const double lean = 0.2;
    glint_document_put(d, "mirror", "mirror", "mirror", "metal",
                       &(struct glint_place){.at = {0.76, r * cos(lean) + t + GAP, 0.02},
                                             .turn = -0.85,
                                             .lean = M_PI / 2 - lean,
                                             .scale = {1, 1, 1}});
}

// Drops of gold before everything else.
static void add_drops(struct glint_document *d)
{
    static const double drop[5][3] = {{-0.46, 0.98, 0.045},
                                      {-0.30, 1.06, 0.028},
                                      {0.12, 1.02, 0.036},
                                      {-0.62, 0.86, 0.026},
                                      {0.24, 1.10, 0.022}};
    for (int i = 0; i < 5; i++) {
        char name[24];
        snprintf(name, sizeof name, "gold drop %d", i + 1);
        put_ball(d, name, "drop", "polished gold", "metal", drop[i][0], drop[i][1], drop[i][2]);
    }
}

static void add_ring(struct glint_document *d)
{
    struct glint_shape shape = {0};
    const double major = 0.34, minor = 0.07;
    glint_shape_torus(&shape, major, minor, 160, 48);
    glint_document_mesh(d, "torus", &shape);
    glint_document_put(d, "gold ring", "torus", "polished gold", "metal",
                       &(struct glint_place){.at = {0.10, major + minor + GAP, -0.36},
                                             .turn = 0.45,
                                             .lean = M_PI / 2,
                                             .scale = {1, 1, 1}});
}

void glint_compose_still_life(struct glint_document *d)
{
    glint_document_sphere(d, "ball", 96);
    glint_document_sphere(d, "drop", 48);
    add_stage(d);
    add_panels(d);
    add_ring(d);
    add_bowl(d);
    add_cylinder(d);
    add_mirror(d);
    add_tumbler(d);
    add_drops(d);
    put_ball(d, "clear ball", "ball", "clear glass", "glass", -0.10, 0.64, 0.23);
    put_ball(d, "satin ball", "ball", "satin glass", "glass", -0.46, 0.24, 0.18);
    put_ball(d, "mirror ball", "ball", "mirror", "metal", 0.70, 0.72, 0.12);
}
