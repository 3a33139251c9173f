// light.c - a large soft light from the upper left, a smaller warm one on the right, a dim sky that
// goes from warm grey to blue, and the camera.
#include "compose.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#define SKY_WIDTH 64
#define SKY_HEIGHT 32

static void add_area(struct glint_document *d, const char *id, const double from[3],
                     const double to[3], const double color[3], double radiance,
                     const double size[2])
{
    cJSON *light = cJSON_AddObjectToObject(d->lights, id);
    cJSON_AddStringToObject(light, "type", "area");
    cJSON_AddItemToObject(light, "color", glint_document_numbers(color, 3));
    cJSON_AddItemToObject(light, "intensity", glint_document_number(radiance));
    cJSON_AddItemToObject(light, "size", glint_document_numbers(size, 2));
    cJSON_AddItemToObject(light, "transform", glint_document_aim(from, to));
}

// Radiance of the sky at height y = -1..1, azimuth angle a (0: -z).
static void sky(double y, double a, double rgb[3])
{
    static const double floor_[3] = {0.03, 0.027, 0.024}, low[3] = {0.26, 0.235, 0.205},
                        high[3] = {0.15, 0.185, 0.235};
    const double t = y < 0 ? y + 1 : y;
    const double glow = 1 + 0.6 * cos(a - 2.2);
    for (int k = 0; k < 3; k++)
        rgb[k] = (y < 0 ? floor_[k] + (low[k] - floor_[k]) * t * t * t
                        : low[k] + (high[k] - low[k]) * t) *
                 glow;
}

static void to_rgbe(const double rgb[3], unsigned char out[4])
{
    const double most = fmax(rgb[0], fmax(rgb[1], rgb[2]));
    int exponent;
    const double scale = frexp(most, &exponent) * 256 / most;
    for (int k = 0; k < 3; k++)
        out[k] = (unsigned char)(rgb[k] * scale);
    out[3] = (unsigned char)(exponent + 128);
}

static char *base64(char *to, const unsigned char *bytes, size_t size)
{
    static const char digit[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    for (size_t i = 0; i < size; i += 3) {
        const unsigned left = (unsigned)(size - i);
        const unsigned bits = (unsigned)bytes[i] << 16 | (left > 1 ? bytes[i + 1] << 8 : 0) |
                              (left > 2 ? bytes[i + 2] : 0);
        *to++ = digit[bits >> 18];
        *to++ = digit[bits >> 12 & 63];
        *to++ = left > 1 ? digit[bits >> 6 & 63] : '=';
        *to++ = left > 2 ? digit[bits & 63] : '=';
    }
    *to = '\0';
    return to;
}

static void add_sky(struct glint_document *d)
{
    static const char head[] = "#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 32 +X 64\n";
    static const char prefix[] = "data:image/vnd.radiance;base64,";
    static unsigned char file[sizeof head - 1 + SKY_HEIGHT * SKY_WIDTH * 4];
    static char uri[sizeof prefix + sizeof file * 4 / 3 + 8];
    memcpy(file, head, sizeof head - 1);
    unsigned char *to = file + sizeof head - 1;
    for (int y = 0; y < SKY_HEIGHT; y++)
        for (int x = 0; x < SKY_WIDTH; x++, to += 4) {
            double rgb[3];
            sky(cos(M_PI * (y + 0.5) / SKY_HEIGHT), 2 * M_PI * ((x + 0.5) / SKY_WIDTH - 0.5), rgb);
            to_rgbe(rgb, to);
        }
    memcpy(uri, prefix, sizeof prefix);
    base64(uri + sizeof prefix - 1, file, sizeof file);
    cJSON *image = cJSON_AddObjectToObject(d->images, "sky");
    cJSON_AddStringToObject(image, "data", uri);
    cJSON *environment = cJSON_AddObjectToObject(d->root, "environment");
    cJSON_AddStringToObject(environment, "image", "sky");
}

static void add_camera(struct glint_document *d)
{
    const double from[3] = {0.5, 1.38, 4.9}, to[3] = {0.02, 0.50, -0.2};
    cJSON *camera = cJSON_AddObjectToObject(d->cameras, "front");
    cJSON_AddItemToObject(camera, "transform", glint_document_aim(from, to));
    cJSON_AddItemToObject(camera, "yfov", glint_document_number(0.385));
    cJSON_AddItemToObject(camera, "lens_radius", glint_document_number(0.02));
    cJSON_AddItemToObject(camera, "focus_distance", glint_document_number(4.75));
}

void glint_compose_light(struct glint_document *d)
{
    add_area(d, "soft box", (double[]){-2.2, 5.2, 0.9}, (double[]){0, 0.3, -0.9},
             (double[]){1, 0.98, 0.95}, 25, (double[]){3, 3});
    add_area(d, "warm lamp", (double[]){3.4, 3.1, 0.6}, (double[]){0, 0.3, -0.8},
             (double[]){1, 0.66, 0.36}, 17, (double[]){1.8, 1.8});
    add_sky(d);
    add_camera(d);
}
