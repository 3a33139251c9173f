#include "palette.h"

#include <math.h>
#include <stdio.h>

static const struct {
    const char *name;
    unsigned srgb;
} ceramics[GLINT_PALETTE_COLORS] = {
    {"ink", 0x22304f},        {"indigo", 0x2f4a7d}, {"denim", 0x4a72a4}, {"sky", 0x86b3c9},
    {"petrol", 0x1f6f78},     {"jade", 0x3f9a86},   {"sage", 0x93b48b},  {"moss", 0x6d8142},
    {"pear", 0xc3c15a},       {"cream", 0xf1e4c8},  {"honey", 0xe9b44c}, {"amber", 0xdf8a2f},
    {"terracotta", 0xc65a35}, {"coral", 0xe0775f},  {"blush", 0xe7b0a0}, {"cherry", 0xa72c3a},
    {"plum", 0x6d3155},       {"violet", 0x54447f},
};

// Reflectance of the metals at normal incidence, linear Rec. 709.
static const struct {
    const char *id;
    struct glint_look look;
} others[] = {
    {"polished gold", {{1.00, 0.77, 0.34}, 0.12, 1, 0, 0}},
    {"satin brass", {{0.91, 0.74, 0.42}, 0.28, 1, 0, 0}},
    {"satin copper", {{0.95, 0.64, 0.54}, 0.24, 1, 0, 0}},
    {"brushed steel", {{0.62, 0.60, 0.57}, 0.36, 1, 0, 0}},
    {"mirror", {{0.95, 0.95, 0.95}, 0, 1, 0, 0}},
    {"clear glass", {{1, 1, 1}, 0, 0, 1, 1.52}},
    {"frosted glass", {{0.97, 0.99, 0.985}, 0.22, 0, 1, 1.5}},
    {"satin glass", {{1, 0.97, 0.93}, 0.4, 0, 1, 1.5}},
    {"lacquer", {{0.012, 0.017, 0.022}, 0.14, 0, 0, 1.5}},
    {"plaster", {{0.070, 0.122, 0.145}, 0.9, 0, 0, 1.5}},
    {"paper", {{0.085, 0.135, 0.155}, 0.9, 0, 0, 1.5}},
};

static double linear(unsigned byte)
{
    const double v = byte / 255.0;
    return v <= 0.04045 ? v / 12.92 : pow((v + 0.055) / 1.055, 2.4);
}

const char *glint_palette_name(unsigned color)
{
    return ceramics[color].name;
}

void glint_palette_write(struct glint_document *d)
{
    for (unsigned i = 0; i < GLINT_PALETTE_COLORS; i++) {
        const unsigned c = ceramics[i].srgb;
        struct glint_look look = {
            .color = {linear(c >> 16 & 255), linear(c >> 8 & 255), linear(c & 255)}};
        char id[40];
        look.roughness = 0.7;
        snprintf(id, sizeof id, "ceramic %s", ceramics[i].name);
        glint_document_material(d, id, &look);
        look.roughness = 0.22;
        snprintf(id, sizeof id, "glazed %s", ceramics[i].name);
        glint_document_material(d, id, &look);
    }
    for (size_t i = 0; i < sizeof others / sizeof *others; i++)
        glint_document_material(d, others[i].id, &others[i].look);
}
