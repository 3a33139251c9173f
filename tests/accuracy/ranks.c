// ranks - what a file of few ranks costs in accuracy, however exact the table is that it comes from.
//
//   ranks SCENE.json WIDTHxHEIGHT SAMPLES
//
// One line of CSV for each number of levels and each type: frames as clients get them, against the
// table of exact eviction with the same samples. A file of n ranks names n of a pixel's names, so the
// matte of one of its n + 1 largest is wrong by all that it has: none is better than the (n+1)th.
//   written  ranks in the file: as many as `levels`, or with auto as many as it takes
//   worst    largest error of a name's matte in any pixel
//   best     largest (n+1)th coverage of a pixel, in the exact table
//   left     most coverage of a pixel that has no rank
//   pixels   that have more names than ranks
#include "tests/render/offline.h"

#include "protocol/film_parts.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static const char *const levels[] = {"2", "4", "6", "8", "12", "16", "\"auto\""};
static const char *const types[] = {"CryptoObject", "CryptoGlossObject"};
#define COUNT(a) (sizeof(a) / sizeof *(a))
#define MAX_NAMES 256

struct names {
    struct glint_cryptomatte_rank rank[MAX_NAMES];
    uint32_t count;
};

struct truth {
    uint32_t width, height;
    struct names *of[2]; // [types][height][width]
};

struct line {
    double worst, best, left;
    uint32_t written, pixels;
};

static glint_render *render(const struct offline *o, const struct glint_posed *scene,
                            const struct glint_job *job)
{
    struct glint_error err = {0};
    glint_render *r = NULL;
    if (glint_render_create(&r, o->devices, scene->resident, scene->pose, job, &err))
        offline_die("render", &err);
    offline_render(o, r);
    return r;
}

static struct glint_job *job_of(const char *size, int samples, const char *mattes)
{
    char text[400];
    int w, h;
    if (sscanf(size, "%dx%d", &w, &h) != 2)
        exit(64);
    snprintf(text, sizeof text,
             "{\"scene\":\"s\",\"resolution\":[%d,%d],\"stop\":{\"samples\":%d},"
             "\"outputs\":[\"beauty\",\"crypto_object\"],\"mattes\":{\"through\":\"glossy\",%s}}",
             w, h, samples, mattes);
    return offline_job(text);
}

static void take_names(const struct glint_film_info *info, uint32_t class_of_it, uint32_t samples,
                       struct glint_film_ranks *ranks, struct names *out)
{
    const struct glint_matte_type type = {"", GLINT_MATTE_OBJECT, class_of_it};
    out->count = glint_film_rank(info, &type, samples, ranks);
    if (out->count > MAX_NAMES)
        abort();
    memcpy(out->rank, ranks->rank, out->count * sizeof *out->rank);
}

static void take_tile(const glint_render *r, uint32_t tile, struct glint_film_ranks *ranks,
                      struct truth *t)
{
    const struct glint_film_info *info = &r->view->info;
    const uint32_t columns = glint_film_columns(r->film);
    struct glint_film_tile at;
    glint_film_tile(r->film, tile, &at);
    const uint64_t *table = (const uint64_t *)glint_buffer_host(at.tables) + at.tables_offset;
    for (uint32_t i = 0; i < GK_TILE_PIXELS; i++) {
        const uint32_t x = tile % columns * GK_TILE_SIDE + i % GK_TILE_SIDE;
        const uint32_t y = tile / columns * GK_TILE_SIDE + i / GK_TILE_SIDE;
        if (x >= t->width || y >= t->height)
            continue;
        glint_film_held_read(info, table, i, &ranks->held);
        for (uint32_t c = 0; c < 2; c++)
            take_names(info, c, r->job.stop.samples, ranks, &t->of[c][y * t->width + x]);
    }
}

static struct truth truth_of(const struct offline *o, const struct glint_posed *scene,
                             const struct glint_job *job)
{
    struct truth t = {job->width, job->height, {NULL, NULL}};
    struct glint_film_ranks ranks = {0};
    glint_render *r = render(o, scene, job);
    for (int c = 0; c < 2; c++)
        t.of[c] = calloc((size_t)t.width * t.height, sizeof *t.of[c]);
    if (!t.of[0] || !t.of[1] || glint_film_ranks_create(&ranks, &r->view->info, NULL))
        abort();
    for (uint32_t i = 0; i < glint_film_columns(r->film) * glint_film_rows(r->film); i++)
        take_tile(r, i, &ranks, &t);
    glint_film_ranks_finish(&ranks);
    glint_render_destroy(&r);
    return t;
}

static const float *plane(const struct glint_frame *f, const char *type, uint32_t rank, char letter)
{
    char name[40];
    snprintf(name, sizeof name, "%s%02u.%c", type, rank / 2, letter);
    return glint_frame_find(f, name);
}

static double coverage_in(const struct glint_frame *f, const char *type, uint32_t written,
                          uint32_t id, size_t pixel)
{
    double sum = 0.0;
    for (uint32_t k = 0; k < written; k++) {
        const float coverage = plane(f, type, k, k % 2 ? 'A' : 'G')[pixel];
        uint32_t bits;
        memcpy(&bits, &plane(f, type, k, k % 2 ? 'B' : 'R')[pixel], sizeof bits);
        sum += bits == id ? coverage : 0.0;
    }
    return sum;
}

static void add_pixel(struct line *l, const struct names *n, const struct glint_frame *f,
                      const char *type, size_t pixel)
{
    double left = 0.0;
    for (uint32_t k = 0; k < n->count; k++) {
        const double is = coverage_in(f, type, l->written, n->rank[k].id, pixel);
        l->worst = fmax(l->worst, fabs(is - n->rank[k].coverage));
        left += k >= l->written ? n->rank[k].coverage : 0.0;
    }
    l->left = fmax(l->left, left);
    l->pixels += n->count > l->written;
    if (n->count > l->written)
        l->best = fmax(l->best, n->rank[l->written].coverage);
}

static void print_frame(const char *scene, const char *asked, const struct glint_frame *f,
                        const struct truth *t)
{
    for (size_t c = 0; c < COUNT(types); c++) {
        struct line l = {0};
        while (plane(f, types[c], l.written, 'R'))
            l.written += 2;
        for (size_t i = 0; i < (size_t)t->width * t->height; i++)
            add_pixel(&l, &t->of[c][i], f, types[c], i);
        printf("%s,%s,%s,%u,%.4f,%.4f,%.4f,%u\n", scene, types[c], *asked == '"' ? "auto" : asked,
               l.written, l.worst, l.best, l.left, l.pixels);
    }
}

static void run_levels(const struct offline *o, const struct glint_posed *scene, char **argv,
                       const char *name, const char *asked, const struct truth *t)
{
    char mattes[64];
    struct glint_frame *f;
    struct glint_error err = {0};
    snprintf(mattes, sizeof mattes, "\"levels\":%s", asked);
    struct glint_job *job = job_of(argv[2], atoi(argv[3]), mattes);
    glint_render *r = render(o, scene, job);
    if (glint_render_frame(r, job->outputs, &f, NULL, &err))
        offline_die("frame", &err);
    print_frame(name, asked, f, t);
    glint_frame_destroy(&f);
    glint_render_destroy(&r);
    glint_job_destroy(&job);
}

int main(int argc, char **argv)
{
    struct offline o;
    char name[64];
    if (argc != 4)
        return fprintf(stderr, "usage: ranks SCENE.json WxH SAMPLES\n"), 64;
    const char *slash = strrchr(argv[1], '/');
    snprintf(name, sizeof name, "%s", slash ? slash + 1 : argv[1]);
    name[strcspn(name, ".")] = '\0';
    offline_start(&o, 0);
    struct glint_posed scene = offline_load_posed(&o, argv[1]);
    struct glint_job *exact = job_of(argv[2], atoi(argv[3]), "\"eviction\":\"exact\"");
    struct truth t = truth_of(&o, &scene, exact);
    puts("scene,type,levels,written,worst,best,left,pixels");
    for (size_t i = 0; i < COUNT(levels); i++)
        run_levels(&o, &scene, argv, name, levels[i], &t);
    free(t.of[0]);
    free(t.of[1]);
    glint_job_destroy(&exact);
    glint_resident_release(&scene.resident);
    offline_finish(&o);
    return 0;
}
