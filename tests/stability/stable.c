#include "tests/stability/stable.h"

#include "kernels/gk_film.h"
#include "protocol/png.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static char *unquoted(char *text)
{
    for (char *c = text; *c; c++)
        *c = *c == '\'' ? '"' : *c;
    return text;
}

char *stable_text(const char *format, ...)
{
    char *text = NULL;
    va_list args;
    va_start(args, format);
    assert_true(vasprintf(&text, format, args) >= 0);
    va_end(args);
    return unquoted(text);
}

char *stable_job(const char *members)
{
    return stable_text("{'scene':'s','outputs':['beauty','variance'],%s}", members);
}

// ---- checked renders

static bool may_be_negative(const char *channel)
{
    return channel[0] == 'N' || strncmp(channel, "Crypto", 6) == 0;
}

static void check_pixels(const struct glint_frame *f)
{
    for (uint32_t c = 0; c < f->channels; c++) {
        const char *name = f->channel[c].name;
        if (strncmp(name, "Crypto", 6) == 0) // hashes, which are no numbers
            continue;
        for (size_t i = 0; i < stable_pixels(f); i++) {
            const float x = f->channel[c].plane[i];
            if (!isfinite(x) || (x < 0.0f && !may_be_negative(name)))
                fail_msg("%s of pixel %zu is %g", name, i, x);
        }
    }
}

static uint64_t rejected_samples(const struct glint_render *r)
{
    const uint32_t tiles = glint_film_columns(r->film) * glint_film_rows(r->film);
    uint64_t sum = 0;
    for (uint32_t t = 0; t < tiles; t++) {
        struct glint_film_tile at;
        glint_film_tile(r->film, t, &at);
        const uint32_t *words = (const uint32_t *)glint_buffer_host(at.planes) + at.planes_offset;
        for (int i = 0; i < GK_TILE_PIXELS; i++)
            sum += words[GK_PLANE_REJECTED * GK_TILE_PIXELS + i];
    }
    return sum;
}

static void check_counters(const struct glint_render *r)
{
    struct glint_render_state state;
    glint_render_state(r, &state);
    const uint64_t rejected = rejected_samples(r);
    if (rejected * 1000000 > state.camera_rays)
        fail_msg("%llu of %llu samples were rejected", (unsigned long long)rejected,
                 (unsigned long long)state.camera_rays);
}

struct glint_frame *stable_frame_of(const struct offline *o, glint_resident *scene, char *text)
{
    struct glint_error err = {0};
    struct glint_job *job = offline_job(text);
    glint_render *render = NULL;
    struct glint_frame *frame = NULL;
    if (glint_render_create(&render, o->devices, scene, NULL, job, &err))
        offline_die("render", &err);
    offline_render(o, render);
    if (glint_render_frame(render, job->outputs, &frame, NULL, &err))
        offline_die("frame", &err);
    check_pixels(frame);
    check_counters(render);
    glint_render_destroy(&render);
    glint_job_destroy(&job);
    free(text);
    return frame;
}

struct glint_frame *stable_frame(const struct offline *o, char *scene, char *job)
{
    glint_resident *resident = offline_load_text(o, scene);
    struct glint_frame *frame = stable_frame_of(o, resident, job);
    glint_resident_release(&resident);
    free(scene);
    return frame;
}

uint64_t stable_rejected(const struct offline *o, char *scene, char *text)
{
    struct glint_error err = {0};
    glint_resident *resident = offline_load_text(o, scene);
    struct glint_job *job = offline_job(text);
    glint_render *render = NULL;
    if (glint_render_create(&render, o->devices, resident, NULL, job, &err))
        offline_die("render", &err);
    offline_render(o, render);
    const uint64_t rejected = rejected_samples(render);
    glint_render_destroy(&render);
    glint_job_destroy(&job);
    glint_resident_release(&resident);
    free(scene);
    free(text);
    return rejected;
}

static glint_status load(const struct offline *o, const char *text, struct glint_error *err)
{
    const struct glint_import_limits limits = {(size_t)1 << 30, 60.0};
    struct glint_import *import = NULL;
    struct glint_scene *scene = NULL;
    glint_resident *resident = NULL;
    glint_status st = glint_import_run(o->importer,
                                       &(struct glint_import_source){.type = GLINT_SCENE_NATIVE,
                                                                     .bytes = (const uint8_t *)text,
                                                                     .size = strlen(text)},
                                       &limits, &import, err);
    if (!st)
        st = glint_scene_parse(&scene, import->text, import->length, import->asset, import->assets,
                               err);
    if (!st)
        st = glint_resident_create(&resident, o->devices,
                                   &(struct glint_resident_order){.scene = scene}, err);
    if (st)
        glint_scene_destroy(&scene);
    else
        glint_resident_release(&resident);
    glint_import_destroy(&import);
    return st;
}

void stable_refused(const struct offline *o, char *text, const char *pointer)
{
    struct glint_error err = {0};
    if (!load(o, text, &err))
        fail_msg("a scene with a fault at %s was taken", pointer);
    bool named = false;
    for (size_t i = 0; i < err.count; i++)
        named |= strcmp(err.fault[i].pointer, pointer) == 0;
    if (!named)
        fail_msg("%s is not named: %s", pointer, err.count ? err.fault[0].pointer : "no fault is");
    glint_error_finish(&err);
    free(text);
}

// ---- sums over pixels

size_t stable_pixels(const struct glint_frame *f)
{
    return (size_t)f->width * f->height;
}

double stable_most(const struct glint_frame *f, const char *channel)
{
    const float *p = glint_frame_find(f, channel);
    double most = -INFINITY;
    for (size_t i = 0; i < stable_pixels(f); i++)
        most = fmax(most, p[i]);
    return most;
}

double stable_least(const struct glint_frame *f, const char *channel)
{
    const float *p = glint_frame_find(f, channel);
    double least = INFINITY;
    for (size_t i = 0; i < stable_pixels(f); i++)
        least = fmin(least, p[i]);
    return least;
}

struct stable_mean stable_mean(const struct glint_frame *f, const char *channel)
{
    const float *p = glint_frame_find(f, channel);
    const double n = (double)stable_pixels(f);
    double sum = 0.0, squares = 0.0;
    for (size_t i = 0; i < stable_pixels(f); i++)
        sum += p[i];
    for (size_t i = 0; i < stable_pixels(f); i++)
        squares += (p[i] - sum / n) * (p[i] - sum / n);
    return (struct stable_mean){sum / n, sqrt(squares / (n * fmax(n - 1.0, 1.0)))};
}

size_t stable_equal(const struct glint_frame *a, const struct glint_frame *b, const char *channel)
{
    const float *p = glint_frame_find(a, channel), *q = glint_frame_find(b, channel);
    size_t equal = 0;
    for (size_t i = 0; i < stable_pixels(a); i++)
        equal += memcmp(&p[i], &q[i], sizeof *p) == 0;
    return equal;
}

void stable_assert_same(const struct glint_frame *a, const struct glint_frame *b)
{
    assert_int_equal(a->channels, b->channels);
    for (uint32_t c = 0; c < a->channels; c++)
        assert_int_equal(stable_equal(a, b, a->channel[c].name), stable_pixels(a));
}

// ---- pictures

static char *data_uri(const char *type, const uint8_t *bytes, size_t size)
{
    static const char digit[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    char *text = malloc(strlen(type) + (size + 2) / 3 * 4 + 1);
    assert_non_null(text);
    char *out = stpcpy(text, type);
    for (size_t i = 0; i < size; i += 3) {
        const size_t left = size - i;
        const uint32_t bits = (uint32_t)bytes[i] << 16 | (left > 1 ? bytes[i + 1] << 8 : 0) |
                              (left > 2 ? bytes[i + 2] : 0);
        *out++ = digit[bits >> 18];
        *out++ = digit[bits >> 12 & 63];
        *out++ = left > 1 ? digit[bits >> 6 & 63] : '=';
        *out++ = left > 2 ? digit[bits & 63] : '=';
    }
    *out = 0;
    return text;
}

static void rgbe(const float *rgb, uint8_t out[4])
{
    const float most = fmaxf(rgb[0], fmaxf(rgb[1], rgb[2]));
    int exponent = 0;
    frexpf(most, &exponent);
    for (int k = 0; k < 3; k++)
        out[k] = (uint8_t)ldexpf(rgb[k], 8 - exponent);
    out[3] = most > 0.0f ? (uint8_t)(exponent + 128) : 0;
}

char *stable_hdr(uint32_t width, uint32_t height, const float *rgb)
{
    char head[80];
    const int length = snprintf(
        head, sizeof head, "#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y %u +X %u\n", height, width);
    const size_t pixels = (size_t)width * height;
    uint8_t *bytes = malloc((size_t)length + 4 * pixels);
    assert_non_null(bytes);
    memcpy(bytes, head, (size_t)length);
    for (size_t i = 0; i < pixels; i++)
        rgbe(rgb + 3 * i, bytes + length + 4 * i);
    char *uri = data_uri("data:image/vnd.radiance;base64,", bytes, (size_t)length + 4 * pixels);
    free(bytes);
    return uri;
}

char *stable_png(uint32_t width, uint32_t height, const float *rgb)
{
    struct glint_error err = {0};
    const size_t pixels = (size_t)width * height;
    float *plane = malloc(3 * pixels * sizeof *plane);
    assert_non_null(plane);
    for (size_t i = 0; i < 3 * pixels; i++)
        plane[i % 3 * pixels + i / 3] = rgb[i];
    const struct glint_png_image image = {width, height, plane, plane + pixels, plane + 2 * pixels,
                                          NULL};
    const struct glint_png_options options = {0, GLINT_TONEMAP_CLIP};
    uint8_t *bytes = NULL;
    size_t size = 0;
    if (glint_png_color(&image, &options, &bytes, &size, &err))
        offline_die("png", &err);
    char *uri = data_uri("data:image/png;base64,", bytes, size);
    free(bytes);
    free(plane);
    return uri;
}

double stable_random(uint64_t *state) // splitmix64
{
    uint64_t z = *state += 0x9e3779b97f4a7c15u;
    z = (z ^ z >> 30) * 0xbf58476d1ce4e5b9u;
    z = (z ^ z >> 27) * 0x94d049bb133111ebu;
    return (double)((z ^ z >> 31) >> 11) * 0x1p-53;
}
