// strips - the ray-cone weight of mattes against brute force, on strips of metal of roughness 0 to
// 0.7: strips SCENE.json FOLDER [WIDTH HEIGHT SAMPLES]. SCENE: what `glint-demo-scene strips` prints.
//
// One bounce. FOLDER/strips.csv has a row for each setting of the weight, reading of brute force,
// roughness, bend and distance, of the two last one by itself:
//   tv     mean over the pixels of the total variation between mattes and brute force
//   floor  mean absolute error of the floor's matte
//   off    pixels where the matte of anything is off by more than 0.1
// and FOLDER/*.png the floor's mattes of some settings. Pixels are those that one strip fills.
#include "protocol/cryptomatte.h"
#include "protocol/png.h"
#include "tests/accuracy/subrays.h"

#include "kernels/gk_wave.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define OFF 0.1f
#define STRIPS 8

struct setting {
    double alpha;
    bool clamp, cut;
    const char *picture; // NULL: none
};

static const struct setting settings[] = {{0, true, false, "w1"},
                                          {0.05, true, false, NULL},
                                          {0.05, false, false, NULL},
                                          {0.1, true, false, "w01"},
                                          {0.1, false, false, "w01-unclamped"},
                                          {0.3, true, false, NULL},
                                          {0.3, false, false, NULL},
                                          {1, true, false, "ws"},
                                          {1, false, false, "ws-unclamped"},
                                          {0.05, true, true, NULL},
                                          {0.05, false, true, NULL},
                                          {0.1, true, true, "w01-cut"},
                                          {0.1, false, true, NULL},
                                          {0.3, true, true, NULL},
                                          {0.3, false, true, NULL},
                                          {1, true, true, NULL},
                                          {1, false, true, NULL}};

// Nearer than so many metres; the last: whatever.
static const float near_than[] = {0.25f, 0.5f, 1.0f, 2.0f, INFINITY, INFINITY};
static const char *const distance_name[] = {"0-0.25", "0.25-0.5", "0.5-1", "1-2", "2-", "any"};
enum { DISTANCES = sizeof distance_name / sizeof *distance_name, BULGING = 0, HOLLOW, ANY, BENDS };
static const char *const bend_name[BENDS] = {"bulging", "hollow", "any"};
static const char *const reading_name[SUBRAYS_READINGS] = {"coverage", "share"};

struct row {
    double pixels, tv, floor, off;
};

struct program {
    struct offline o;
    glint_resident *scene;
    const char *folder;
    int width, height, samples;
    const struct glint_matte_key *key;
    uint32_t keys, floor;
    struct subrays_pixel *pixel; // [height][width]
    FILE *csv;
};

static struct glint_job *job_of(const struct program *p, const struct setting *s)
{
    char text[640];
    snprintf(text, sizeof text,
             "{\"scene\":\"s\",\"resolution\":[%d,%d],\"max_bounces\":1,\"stop\":{\"samples\":%d},"
             "\"outputs\":[\"beauty\",\"crypto_object\"],\"filter\":{\"kind\":\"box\"},"
             "\"accuracy\":{\"microfacet\":\"single\"},\"mattes\":{\"through\":\"glossy\","
             "\"levels\":16,\"slots\":32,\"alpha\":%g,\"clamp\":%s,\"diffuse_cut\":%s}}",
             p->width, p->height, p->samples, s->alpha, s->clamp ? "true" : "false",
             s->cut ? "true" : "false");
    return offline_job(text);
}

static glint_render *render_of(const struct program *p, const struct setting *s)
{
    struct glint_error err = {0};
    glint_render *render = NULL;
    struct glint_job *job = job_of(p, s);
    if (glint_render_create(&render, p->o.devices, p->scene, NULL, job, &err))
        offline_die("render", &err);
    glint_job_destroy(&job);
    return render;
}

static uint32_t key_of_id(const struct program *p, uint32_t id)
{
    for (uint32_t k = GK_MATTE_BACKGROUND + 1; k < p->keys; k++)
        if (p->key[k].id[GLINT_MATTE_OBJECT] == id)
            return k;
    return GK_MATTE_BACKGROUND;
}

// Coverage by keys of pixel i.
static void mattes_of(const struct program *p, const struct glint_frame *f, size_t i,
                      float part[SUBRAYS_KEYS])
{
    memset(part, 0, SUBRAYS_KEYS * sizeof *part);
    for (int rank = 0; rank < 16; rank++) {
        char name[32];
        uint32_t id;
        snprintf(name, sizeof name, "CryptoGlossObject%02d.%c", rank / 2, "RB"[rank % 2]);
        memcpy(&id, &glint_frame_find(f, name)[i], sizeof id);
        name[strlen(name) - 1] = "GA"[rank % 2];
        part[key_of_id(p, id)] += glint_frame_find(f, name)[i];
    }
}

static int distance_of(const struct subrays_pixel *p)
{
    int d = 0;
    while (d < DISTANCES - 2 && p->distance >= near_than[d])
        d++;
    return d;
}

static void add(struct row *to, const struct program *p, const float *ours, const float *theirs)
{
    float sum = 0.0f, worst = 0.0f;
    for (uint32_t k = 0; k < p->keys; k++) {
        const float error = fabsf(ours[k] - theirs[k]);
        sum += 0.5f * error;
        worst = fmaxf(worst, error);
    }
    to->pixels++;
    to->tv += sum;
    to->floor += fabsf(ours[p->floor] - theirs[p->floor]);
    to->off += worst > OFF;
}

typedef struct row table[SUBRAYS_READINGS][STRIPS][BENDS][DISTANCES];

static void compare(const struct program *p, const struct glint_frame *f, table rows)
{
    for (size_t i = 0; i < (size_t)p->width * (size_t)p->height; i++) {
        const struct subrays_pixel *b = &p->pixel[i];
        float ours[SUBRAYS_KEYS];
        if (!b->first)
            continue;
        mattes_of(p, f, i, ours);
        const int strip = p->key[b->first].name[GLINT_MATTE_OBJECT][5] - '0';
        const int bend[] = {b->curvature > 0.0f ? BULGING : HOLLOW, ANY};
        const int distance[] = {distance_of(b), DISTANCES - 1};
        for (int r = 0; r < SUBRAYS_READINGS; r++)
            for (int k = 0; k < 4; k++)
                add(&rows[r][strip][bend[k / 2]][distance[k % 2]], p, ours, b->part[r]);
    }
}

static void write_rows(const struct program *p, const struct setting *s, table rows)
{
    for (int r = 0; r < SUBRAYS_READINGS; r++)
        for (int strip = 0; strip < STRIPS; strip++)
            for (int b = 0; b < BENDS; b++)
                for (int d = 0; d < DISTANCES; d++) {
                    const struct row *row = &rows[r][strip][b][d];
                    if (row->pixels > 0 && (b == ANY || d == DISTANCES - 1))
                        fprintf(p->csv, "%g,%d,%d,%s,%.1f,%s,%s,%.0f,%.4f,%.4f,%.0f\n", s->alpha,
                                s->clamp, s->cut, reading_name[r], 0.1 * strip, bend_name[b],
                                distance_name[d], row->pixels, row->tv / row->pixels,
                                row->floor / row->pixels, row->off);
                }
}

static void write_picture(const struct program *p, const char *name, const float *plane)
{
    char path[1024];
    uint8_t *bytes = NULL;
    size_t size = 0;
    struct glint_error err = {0};
    if (glint_png_coverage(plane, (uint32_t)p->width, (uint32_t)p->height, &bytes, &size, &err))
        offline_die("picture", &err);
    snprintf(path, sizeof path, "%s/%s.png", p->folder, name);
    FILE *f = fopen(path, "wb");
    if (!f || fwrite(bytes, 1, size, f) != size || fclose(f))
        perror(path);
    free(bytes);
}

// The floor as the frame covers it, or as brute force does.
static void picture(const struct program *p, const struct glint_frame *f, int reading,
                    const char *name)
{
    const size_t pixels = (size_t)p->width * (size_t)p->height;
    float *plane = calloc(pixels, sizeof *plane);
    for (size_t i = 0; plane && i < pixels; i++) {
        float part[SUBRAYS_KEYS];
        if (f)
            mattes_of(p, f, i, part);
        plane[i] = f ? part[p->floor] : p->pixel[i].part[reading][p->floor];
    }
    if (plane)
        write_picture(p, name, plane);
    free(plane);
}

static void judge(const struct program *p, const struct setting *s)
{
    struct glint_error err = {0};
    struct glint_frame *f = NULL;
    static table rows;
    glint_render *render = render_of(p, s);
    offline_render(&p->o, render);
    if (glint_render_frame(render, GLINT_OUT_CRYPTO_OBJECT, &f, NULL, &err))
        offline_die("frame", &err);
    memset(rows, 0, sizeof rows);
    compare(p, f, rows);
    write_rows(p, s, rows);
    if (s->picture)
        picture(p, f, 0, s->picture);
    fflush(p->csv);
    glint_frame_destroy(&f);
    glint_render_destroy(&render);
}

static void brute_force(struct program *p)
{
    glint_render *render = render_of(p, &settings[0]);
    struct subrays *s = subrays_create(p->scene, render, "strip");
    for (int y = 0; y < p->height; y++)
        for (int x = 0; x < p->width; x++)
            subrays_look(s, (uint32_t)x, (uint32_t)y, &p->pixel[y * p->width + x]);
    subrays_destroy(s);
    glint_render_destroy(&render);
    for (int r = 0; r < SUBRAYS_READINGS; r++)
        picture(p, NULL, r, reading_name[r]);
}

static void open_csv(struct program *p)
{
    char path[1024];
    snprintf(path, sizeof path, "%s/strips.csv", p->folder);
    p->csv = fopen(path, "w");
    if (!p->csv) {
        perror(path);
        exit(1);
    }
    fprintf(p->csv, "alpha,clamp,cut,reading,roughness,bend,distance,pixels,tv,floor,off\n");
}

int main(int argc, char **argv)
{
    if (argc != 3 && argc != 6) {
        fprintf(stderr, "usage: strips SCENE.json FOLDER [WIDTH HEIGHT SAMPLES]\n");
        return 64;
    }
    struct program p = {.folder = argv[2],
                        .width = argc > 3 ? atoi(argv[3]) : 160,
                        .height = argc > 3 ? atoi(argv[4]) : 90,
                        .samples = argc > 3 ? atoi(argv[5]) : 1024};
    p.pixel = calloc((size_t)p.width * (size_t)p.height, sizeof *p.pixel);
    if (!p.pixel)
        return 1;
    open_csv(&p);
    offline_start(&p.o, 1);
    p.scene = offline_load(&p.o, argv[1]);
    p.keys = glint_resident_mattes(p.scene, &p.key);
    p.floor = key_of_id(&p, glint_cryptomatte_id("floor"));
    brute_force(&p);
    for (size_t i = 0; i < sizeof settings / sizeof *settings; i++)
        judge(&p, &settings[i]);
    fclose(p.csv);
    glint_resident_release(&p.scene);
    offline_finish(&p.o);
    free(p.pixel);
    return 0;
}
