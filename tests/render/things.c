#include "tests/render/things.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>

#include <cmocka.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

const struct thing crowd[CROWD] = {
    {"a", "red", "set", -6, 3, 1, 7, 5, NULL, false},
    {"b", "green", "", -3, 2, 2, 6, 6, NULL, false},
    {"c", "blue", "set", 0, 1, -3, 9, 7, NULL, false},
    {"d", "red", "", 3, 0, 3, 5, 5, NULL, false},
    {"e", "green", "set", 5, -2, 0, 8, 4, NULL, false},
    {"f", "blue", "", -5, -4, 1.5, 6, 5, NULL, false},
    {"g", "red", "set", 0.4, -3, 2.5, 3, 8, NULL, false},
    {"h", "green", "", 7, 4, -2, 6, 6, NULL, false},
    {"twin", "blue", "set", 8, -5, 4, 4, 3, NULL, false},
    {"twin", "red", "", -8, 6, 4, 4, 3, NULL, false},
};

struct offline things_crew;

int things_start(void **state)
{
    (void)state;
    offline_start(&things_crew, offline_workers());
    return 0;
}

int things_finish(void **state)
{
    (void)state;
    offline_finish(&things_crew);
    return 0;
}

static void put_thing(FILE *to, const struct thing *t, size_t i, const char *part)
{
    const char *const comma = i ? "," : "";
    if (strcmp(part, "images") == 0 && t->image)
        fprintf(to, "\"p\":{\"data\":\"%s\"}", t->image);
    else if (strcmp(part, "materials") == 0)
        fprintf(to, "%s\"m%zu\":{\"name\":\"%s\"%s}", comma, i, t->material,
                t->image ? ",\"alpha_mode\":\"mask\",\"base_color_texture\":{\"image\":\"p\"}"
                         : "");
    else if (strcmp(part, "meshes") == 0)
        fprintf(to, "%s\"q%zu\":{\"primitive\":\"quad\",\"size\":[%.17g,%.17g]}", comma, i, t->w,
                t->h);
    else if (strcmp(part, "objects") == 0)
        fprintf(to, "%s\"o%zu\":{\"name\":\"%s\",\"asset\":\"%s\"}", comma, i, t->name,
                t->asset ? t->asset : "");
    else if (strcmp(part, "instances") == 0)
        fprintf(to,
                "%s\"i%zu\":{\"mesh\":\"q%zu\",\"material\":\"m%zu\",\"object\":\"o%zu\","
                "\"visible\":%s,"
                "\"transform\":{\"translation\":[%.17g,%.17g,%.17g]}}",
                comma, i, i, i, i, t->hidden ? "false" : "true", t->x, t->y, t->z);
}

glint_resident *load_things(const struct thing *t, size_t n, const char *lens)
{
    static const char *const part[] = {"images", "materials", "meshes", "objects", "instances"};
    char *text;
    size_t length;
    FILE *to = open_memstream(&text, &length);
    putc('{', to);
    for (size_t p = 0; p < COUNT(part); p++) {
        fprintf(to, "\"%s\":{", part[p]);
        for (size_t i = 0; i < n; i++)
            put_thing(to, &t[i], i, part[p]);
        fputs("},", to);
    }
    // 2 atan(1/2): at distance 16 the frame is 16 high.
    fprintf(to,
            "\"environment\":{},\"cameras\":{\"eye\":{\"yfov\":0.92729521800161219%s,"
            "\"transform\":{\"translation\":[0,0,16]}}}}",
            lens);
    fclose(to);
    glint_resident *scene = offline_load_text(&things_crew, text);
    free(text);
    return scene;
}

// ---- renders

void shoot(struct shot *s, glint_resident *scene, const char *job)
{
    struct glint_error err = {0};
    s->job = offline_job(job);
    if (glint_render_create(&s->render, things_crew.devices, scene, NULL, s->job, &err))
        offline_die("render", &err);
    offline_render(&things_crew, s->render);
    if (glint_render_frame(s->render, s->job->outputs, &s->frame, NULL, &err))
        offline_die("frame", &err);
}

void finish_shot(struct shot *s)
{
    glint_frame_destroy(&s->frame);
    glint_render_destroy(&s->render);
    glint_job_destroy(&s->job);
}

void shoot_things(struct shot *s, const struct thing *t, size_t n, const char *lens,
                  const char *members, uint32_t samples)
{
    char job[512];
    snprintf(
        job, sizeof job,
        "{\"scene\":\"s\",\"resolution\":[%d,%d],%s\"max_bounces\":0,\"stop\":{\"samples\":%u}}",
        WIDTH, HEIGHT, members, samples);
    glint_resident *scene = load_things(t, n, lens);
    shoot(s, scene, job);
    glint_resident_release(&scene);
}

double lost_in(const struct shot *s)
{
    struct glint_matte_totals totals;
    assert_int_equal(glint_render_mattes(s->render, 1u << GLINT_MATTE_OBJECT, &totals, NULL),
                     GLINT_OK);
    const double lost = totals.lost[0] + totals.lost[1];
    glint_matte_totals_finish(&totals);
    return lost;
}

// ---- a decoder of its own

const float *layer_plane(const struct glint_frame *f, const char *type, uint32_t rank,
                         bool coverage)
{
    char name[40];
    snprintf(name, sizeof name, "%s%02u.%c", type, rank / 2, "RGBA"[rank % 2 * 2 + coverage]);
    return glint_frame_find(f, name);
}

uint32_t rank_id(const struct glint_frame *f, const char *type, uint32_t rank, size_t pixel)
{
    uint32_t id;
    memcpy(&id, layer_plane(f, type, rank, false) + pixel, 4);
    return id;
}

float rank_coverage(const struct glint_frame *f, const char *type, uint32_t rank, size_t pixel)
{
    return layer_plane(f, type, rank, true)[pixel];
}

double coverage_of_id(const struct glint_frame *f, const char *type, uint32_t id, size_t pixel)
{
    double sum = 0.0;
    for (uint32_t k = 0; layer_plane(f, type, k, true); k++)
        sum += rank_id(f, type, k, pixel) == id ? rank_coverage(f, type, k, pixel) : 0.0f;
    return sum;
}

double coverage_of(const struct glint_frame *f, const char *type, const char *name, size_t pixel)
{
    return coverage_of_id(f, type, glint_cryptomatte_id(name), pixel);
}

size_t pixels(const struct glint_frame *f)
{
    return (size_t)f->width * f->height;
}
