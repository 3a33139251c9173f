// glint - our side of the bench `peers`: scenes for every renderer, and renders of them.
//
//   glint export FILE DIR                       FILE (.glb or native) as canonical native JSON in
//                                               DIR/scene.json, its assets beside it by hash
//   glint serve DIR WIDTH HEIGHT BOUNCES        renders DIR: each line "SAMPLES SEED OUT" of stdin
//                                               writes OUT, rows of R, G, B as 32-bit floats, and
//                                               answers {"user": CPU seconds} on stdout
#include "tests/render/offline.h"

#include <dirent.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>

#define MAX_ASSETS 4096

static void fail(const char *path)
{
    perror(path);
    exit(1);
}

static void write_bytes(const char *folder, const char *name, const void *bytes, size_t size)
{
    char path[4096];
    snprintf(path, sizeof path, "%s/%s", folder, name);
    FILE *f = fopen(path, "wb");
    if (!f || fwrite(bytes, 1, size, f) != size || fclose(f))
        fail(path);
}

// ---- export

static int export(const char *file, const char *folder)
{
    glint_importer *importer = NULL;
    struct glint_error err = {0};
    struct glint_import *import = NULL;
    size_t size;
    const size_t length = strlen(file);
    const bool glb = length > 4 && strcmp(file + length - 4, ".glb") == 0;
    const struct glint_import_limits limits = {(size_t)8 << 30, 60.0};
    uint8_t *bytes = offline_read_file(file, &size);
    if (glint_importer_create(&importer, &err) ||
        glint_import_run(
            importer,
            &(struct glint_import_source){
                .type = glb ? GLINT_SCENE_GLB : GLINT_SCENE_NATIVE, .bytes = bytes, .size = size},
            &limits, &import, &err))
        offline_die(file, &err);
    write_bytes(folder, "scene.json", import->text, import->length);
    for (size_t i = 0; i < import->assets; i++)
        write_bytes(folder, import->asset[i].sha256, import->asset[i].bytes, import->asset[i].size);
    glint_import_destroy(&import);
    glint_importer_destroy(&importer);
    free(bytes);
    return 0;
}

// ---- serve

struct scene {
    struct offline o;
    struct glint_posed posed;
    unsigned width, height, bounces;
};

// Every file of the folder that is named as an asset is.
static size_t read_assets(const char *folder, struct glint_asset *asset)
{
    size_t n = 0;
    DIR *d = opendir(folder);
    if (!d)
        fail(folder);
    for (struct dirent *e; (e = readdir(d)) && n < MAX_ASSETS;) {
        if (strlen(e->d_name) != sizeof asset->sha256 - 1)
            continue;
        char path[4096];
        snprintf(path, sizeof path, "%s/%s", folder, e->d_name);
        memcpy(asset[n].sha256, e->d_name, sizeof asset->sha256);
        asset[n].bytes = offline_read_file(path, &asset[n].size);
        n++;
    }
    closedir(d);
    return n;
}

static void load(struct scene *s, const char *folder)
{
    static struct glint_asset asset[MAX_ASSETS];
    struct glint_error err = {0};
    struct glint_scene *scene = NULL;
    char path[4096];
    size_t length;
    offline_start(&s->o, 0);
    snprintf(path, sizeof path, "%s/scene.json", folder);
    char *text = (char *)offline_read_file(path, &length);
    const size_t assets = read_assets(folder, asset);
    if (glint_scene_parse(&scene, text, length, asset, assets, &err) ||
        glint_posed_create(&s->posed, s->o.devices,
                           &(struct glint_resident_order){scene, NULL, NULL, NULL, NULL}, &err))
        offline_die(path, &err);
    free(text);
}

static double user_seconds(void)
{
    struct rusage usage;
    getrusage(RUSAGE_SELF, &usage);
    return (double)usage.ru_utime.tv_sec + 1e-6 * (double)usage.ru_utime.tv_usec;
}

static void write_picture(const struct glint_frame *frame, const char *path)
{
    const size_t pixels = (size_t)frame->width * frame->height;
    const float *plane[3] = {glint_frame_find(frame, "R"), glint_frame_find(frame, "G"),
                             glint_frame_find(frame, "B")};
    float *rows = malloc(3 * pixels * sizeof *rows);
    FILE *f = fopen(path, "wb");
    if (!f || !rows)
        fail(path);
    for (size_t i = 0; i < 3 * pixels; i++)
        rows[i] = plane[i % 3][i / 3];
    if (fwrite(rows, 3 * sizeof *rows, pixels, f) != pixels || fclose(f))
        fail(path);
    free(rows);
}

// One reflection per microfacet and no estimate of its own error, as the peers have it. Samples keep
// their full radiance. A bounce of theirs is one after the first surface, which ours counts too.
static struct glint_job *job_of(const struct scene *s, unsigned samples, unsigned seed)
{
    char text[512];
    snprintf(text, sizeof text,
             "{\"scene\":\"peers\",\"resolution\":[%u,%u],\"outputs\":[\"beauty\"],"
             "\"filter\":{\"kind\":\"box\",\"width\":1},\"max_bounces\":%u,"
             "\"accuracy\":{\"microfacet\":\"single\"},\"estimate\":\"none\",\"seed\":%u,\"stop\":{"
             "\"samples\":%u}}",
             s->width, s->height, s->bounces + 1, seed, samples);
    return offline_job(text);
}

static void render(const struct scene *s, unsigned samples, unsigned seed, const char *out)
{
    struct glint_error err = {0};
    glint_render *r = NULL;
    struct glint_frame *frame = NULL;
    struct glint_job *job = job_of(s, samples, seed);
    const double start = user_seconds();
    if (glint_render_create(&r, s->o.devices, s->posed.resident, s->posed.pose, job, &err))
        offline_die("render", &err);
    offline_render(&s->o, r);
    const double user = user_seconds() - start;
    if (glint_render_frame(r, job->outputs, &frame, NULL, &err))
        offline_die("frame", &err);
    write_picture(frame, out);
    printf("{\"user\": %.6f}\n", user);
    fflush(stdout);
    glint_frame_destroy(&frame);
    glint_render_destroy(&r);
    glint_job_destroy(&job);
}

static int serve(char **argument)
{
    struct scene s = {.width = (unsigned)atoi(argument[1]),
                      .height = (unsigned)atoi(argument[2]),
                      .bounces = (unsigned)atoi(argument[3])};
    char line[4096], out[4096];
    unsigned samples, seed;
    load(&s, argument[0]);
    while (fgets(line, sizeof line, stdin))
        if (sscanf(line, "%u %u %4095s", &samples, &seed, out) == 3)
            render(&s, samples, seed, out);
    glint_resident_release(&s.posed.resident);
    offline_finish(&s.o);
    return 0;
}

int main(int argc, char **argv)
{
    if (argc == 4 && strcmp(argv[1], "export") == 0)
        return export(argv[2], argv[3]);
    if (argc == 6 && strcmp(argv[1], "serve") == 0)
        return serve(argv + 2);
    fprintf(stderr, "usage: glint export FILE DIR | serve DIR WIDTH HEIGHT BOUNCES\n");
    return 64;
}
