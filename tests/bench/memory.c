// memory - what a resident scene costs: bytes by kind for a triangle, a texel and an instance, the
// time of loading, whether 16 million triangles fit in 8 GiB and what of them stays when they are
// released; and what a job costs: bytes of a film's pixel by outputs, and of a job beside its film.
//
//   memory [MILLIONS]   of triangles, by default 16
#include "base/clock.h"
#include "tests/render/offline.h"

#include <malloc.h>
#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>
#include <unistd.h>

#define LIMIT_BYTES (8.0 * (1ull << 30))

struct bench {
    struct offline o;
    struct glint_asset asset;
};

static double peak_bytes(void)
{
    struct rusage usage;
    getrusage(RUSAGE_SELF, &usage);
    return (double)usage.ru_maxrss * 1024.0;
}

// Resident now, with what the allocator keeps for later given back.
static double resident_bytes(void)
{
    unsigned long pages = 0;
    malloc_trim(0);
    FILE *f = fopen("/proc/self/statm", "r");
    if (!f || fscanf(f, "%*s %lu", &pages) != 1)
        pages = 0;
    if (f)
        fclose(f);
    return (double)pages * (double)sysconf(_SC_PAGESIZE);
}

static void *allocated(size_t bytes)
{
    void *p = malloc(bytes);
    if (!p) {
        fprintf(stderr, "memory: no %zu bytes\n", bytes);
        exit(1);
    }
    return p;
}

// A hilly sheet of 2 side^2 triangles with normals and texture coordinates, as a mesh's asset.
static void make_sheet(struct glint_asset *out, uint32_t side)
{
    const size_t n = (size_t)(side + 1) * (side + 1);
    out->size = n * 32 + (size_t)side * side * 24;
    float *position = allocated(out->size);
    float *normal = position + 3 * n, *uv = normal + 3 * n;
    uint32_t *index = (uint32_t *)(uv + 2 * n);
    out->bytes = (const uint8_t *)position;
    for (uint32_t y = 0, v = 0; y <= side; y++)
        for (uint32_t x = 0; x <= side; x++, v++) {
            const float a = (float)x / (float)side, b = (float)y / (float)side;
            const float p[3] = {a * 10 - 5, 0.3f * sinf(40 * a) * cosf(31 * b), b * 10 - 5};
            const float up[3] = {0, 1, 0}, t[2] = {a, b};
            memcpy(position + 3 * (size_t)v, p, sizeof p);
            memcpy(normal + 3 * (size_t)v, up, sizeof up);
            memcpy(uv + 2 * (size_t)v, t, sizeof t);
        }
    for (uint32_t y = 0; y < side; y++)
        for (uint32_t x = 0; x < side; x++, index += 6) {
            const uint32_t i = y * (side + 1) + x, j = i + side + 1;
            const uint32_t t[6] = {i, j, i + 1, i + 1, j, j + 1};
            memcpy(index, t, sizeof t);
        }
    if (!glint_asset_name(out->bytes, out->size, out->sha256))
        exit(1);
}

static void make_picture(struct glint_asset *out, uint32_t side)
{
    out->size = (size_t)side * side * 4;
    uint32_t *texel = allocated(out->size);
    for (size_t i = 0; i < out->size / 4; i++)
        texel[i] = (uint32_t)i * 2654435761u | 0xff000000u;
    out->bytes = (const uint8_t *)texel;
    if (!glint_asset_name(out->bytes, out->size, out->sha256))
        exit(1);
}

// Takes the asset's bytes; the text is freed.
static glint_resident *load(const struct bench *b, char *text, const glint_resident *from)
{
    struct glint_error err = {0};
    struct glint_scene *scene = NULL;
    glint_resident *r = NULL;
    const struct glint_asset *a = b->asset.bytes ? &b->asset : NULL;
    if (glint_scene_parse(&scene, text, strlen(text), a, a ? 1 : 0, &err) ||
        glint_resident_create(&r, b->o.devices,
                              &(struct glint_resident_order){.scene = scene, .from = from}, &err))
        offline_die("load", &err);
    free(text);
    return r;
}

// What the first job has built.
static void build_flat(glint_resident *r)
{
    struct glint_error err = {0};
    const struct glint_geometry *g;
    if (glint_resident_geometry(r, GLINT_GEOMETRY_FLAT, false, &g, &err))
        offline_die("flat", &err);
}

static void drop(struct bench *b, glint_resident **r)
{
    glint_resident_release(r);
    free((void *)b->asset.bytes);
    b->asset = (struct glint_asset){0};
}

static char *text_of(const char *format, ...)
{
    char *text;
    va_list args;
    va_start(args, format);
    if (vasprintf(&text, format, args) < 0)
        exit(1);
    va_end(args);
    return text;
}

// ---- the three counts

static bool triangles(struct bench *b, uint32_t millions)
{
    const uint32_t side = (uint32_t)lrint(sqrt(millions * 5e5));
    const double before = resident_bytes();
    make_sheet(&b->asset, side);
    const double start = glint_now();
    glint_resident *r = load(
        b,
        text_of("{\"materials\":{\"m\":{}},\"meshes\":{\"s\":{\"asset\":\"%s\",\"vertices\":%u,"
                "\"triangles\":%u,\"attributes\":[\"normal\",\"uv\"]}},"
                "\"instances\":{\"s\":{\"mesh\":\"s\",\"material\":\"m\"}}}",
                b->asset.sha256, (side + 1) * (side + 1), 2 * side * side),
        NULL);
    build_flat(r);
    const double seconds = glint_now() - start;
    struct glint_resident_stats s;
    glint_resident_stats(r, &s);
    const double n = (double)s.triangles, peak = peak_bytes();
    const bool fits = peak <= LIMIT_BYTES;
    printf("triangle: %.1f bytes: geometry %.1f, traversal %.1f, records %.1f\n",
           (double)(s.geometry_bytes + s.bvh_bytes + s.record_bytes) / n,
           (double)s.geometry_bytes / n, (double)s.bvh_bytes / n, (double)s.record_bytes / n);
    printf("load: %.3f s a million triangles: records %.3f, traversal %.3f\n", seconds / n * 1e6,
           s.geometry_seconds / n * 1e6, s.bvh_seconds / n * 1e6);
    printf("%.0f million triangles: %.2f GiB at the peak\n", n / 1e6, peak / (1ull << 30));
    printf("{\"bench\":\"memory\",\"triangles\":%.0f,\"bytes_per_triangle\":%.1f,"
           "\"seconds_per_million\":%.3f,\"peak_gib\":%.2f,",
           n, (double)(s.geometry_bytes + s.bvh_bytes + s.record_bytes) / n, seconds / n * 1e6,
           peak / (1ull << 30));
    const double loaded = resident_bytes();
    drop(b, &r);
    printf("\"resident_mib\":{\"before\":%.1f,\"loaded\":%.1f,\"released\":%.1f},",
           before / (1 << 20), loaded / (1 << 20), resident_bytes() / (1 << 20));
    return fits;
}

static void texels(struct bench *b)
{
    const uint32_t side = 4096;
    make_picture(&b->asset, side);
    glint_resident *r =
        load(b,
             text_of("{\"images\":{\"p\":{\"asset\":\"%s\",\"width\":%u,\"height\":%u,"
                     "\"format\":\"rgba8\"}},\"materials\":{\"m\":{\"base_color_texture\":{"
                     "\"image\":\"p\"}}},\"meshes\":{\"q\":{\"primitive\":\"quad\"}},"
                     "\"instances\":{\"q\":{\"mesh\":\"q\",\"material\":\"m\"}}}",
                     b->asset.sha256, side, side),
             NULL);
    struct glint_resident_stats s;
    glint_resident_stats(r, &s);
    printf("\"bytes_per_texel\":%.2f,\"seconds_per_gigatexel\":%.2f,",
           (double)s.texture_bytes / ((double)side * side),
           s.texture_seconds / ((double)side * side) * 1e9);
    drop(b, &r);
}

static char *crowd(uint32_t count, double shift)
{
    char *text;
    size_t length;
    FILE *to = open_memstream(&text, &length);
    fprintf(to, "{\"materials\":{\"m\":{}},\"meshes\":{\"s\":{\"primitive\":\"sphere\","
                "\"segments\":32}},\"instances\":{");
    for (uint32_t i = 0; i < count; i++)
        fprintf(to,
                "%s\"i%u\":{\"mesh\":\"s\",\"material\":\"m\",\"transform\":{"
                "\"translation\":[%u,%g,%u]}}",
                i ? "," : "", i, i % 100 * 3, i ? 0.0 : shift, i / 100 * 3);
    fprintf(to, "}}");
    fclose(to);
    return text;
}

// As live jobs have them: placed; then one is moved.
static void instances(struct bench *b)
{
    const uint32_t count = 10000;
    struct glint_error err = {0};
    const struct glint_geometry *g;
    struct glint_resident_stats with, without;
    glint_resident *r = load(b, crowd(count, 0), NULL);
    glint_resident_stats(r, &without);
    if (glint_resident_geometry(r, GLINT_GEOMETRY_PLACED, false, &g, &err))
        offline_die("placed", &err);
    glint_resident_stats(r, &with);
    const double start = glint_now();
    glint_resident *moved = load(b, crowd(count, 1), r);
    const double seconds = glint_now() - start;
    const struct glint_resident_change *c = glint_resident_change(moved);
    printf("\"bytes_per_instance\":%.0f,\"moved_ms\":%.2f,\"placement_ms\":%.2f}\n",
           (double)(with.bvh_bytes - without.bvh_bytes + with.record_bytes) / count, 1e3 * seconds,
           1e3 * c->seconds[GLINT_PART_PLACEMENT]);
    for (int p = 0; p < GLINT_PARTS; p++)
        fprintf(stderr, "# %-12s %.2f ms\n", glint_part_name[p], 1e3 * c->seconds[p]);
    glint_resident_release(&moved);
    glint_resident_release(&r);
}

// ---- jobs

// Resident bytes that a render of one sample adds while it is there; *promised: those that its
// budget counts for the film.
static double job_bytes(const struct bench *b, glint_resident *scene, const char *members,
                        uint32_t side, double *promised)
{
    struct glint_error err = {0};
    glint_render *render = NULL;
    char *text = text_of("{\"scene\":\"s\",\"resolution\":[%u,%u],\"stop\":{\"samples\":1},%s}",
                         side, side, members);
    struct glint_job *job = offline_job(text);
    const double before = resident_bytes();
    if (glint_render_create(&render, b->o.devices, scene, NULL, job, &err))
        offline_die("render", &err);
    offline_render(&b->o, render);
    const double bytes = resident_bytes() - before;
    *promised = (double)glint_render_film_bytes(scene, job);
    glint_render_destroy(&render);
    glint_job_destroy(&job);
    free(text);
    return bytes;
}

static void films(struct bench *b)
{
    static const struct {
        const char *name, *members;
    } kind[] = {{"picture", "\"outputs\":[\"beauty\"]"},
                {"variance", "\"outputs\":[\"beauty\",\"variance\"]"},
                {"mattes", "\"outputs\":[\"beauty\",\"crypto_object\",\"crypto_material\","
                           "\"crypto_asset\"],\"mattes\":{\"slots\":12}"}};
    const uint32_t small = 64, large = 1024;
    const double pixels = (double)large * large - (double)small * small;
    glint_resident *scene = load(b, crowd(100, 0), NULL);
    double promised, least;
    job_bytes(b, scene, kind[0].members, small, &promised); // compiles
    printf("\"film\":{");
    for (size_t i = 0; i < sizeof kind / sizeof *kind; i++) {
        const double few = job_bytes(b, scene, kind[i].members, small, &least);
        const double many = job_bytes(b, scene, kind[i].members, large, &promised);
        printf("%s\"%s\":{\"bytes_per_pixel\":%.1f,\"budget\":%.1f,\"bytes_per_job\":%.0f}",
               i ? "," : "", kind[i].name, (many - few) / pixels, (promised - least) / pixels,
               few - (many - few) / pixels * small * small);
    }
    printf("},");
    glint_resident_release(&scene);
}

int main(int argc, char **argv)
{
    struct bench b = {0};
    const uint32_t millions = argc > 1 ? (uint32_t)strtoul(argv[1], NULL, 10) : 16;
    offline_start(&b.o, 1);
    const bool fits = triangles(&b, millions ? millions : 16);
    texels(&b);
    films(&b);
    instances(&b);
    offline_finish(&b.o);
    return fits ? 0 : 1;
}
