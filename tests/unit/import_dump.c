// import_dump - imports scene files through the sandbox and says what came of each.
//
//   import_dump [--native] [--verbose] [--memory MIB] [--cpu SECONDS] FILE...
//
// One line of JSON for each file: {"file", "status", "detail"} or counts of the scene that the
// answer parses to. The importer and its helper serve all files, one after the other.
#include "base/clock.h"
#include "protocol/text.h"
#include "scene/import.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

struct options {
    bool native; // whatever the extension
    bool verbose;
    struct glint_import_limits limits;
};

// By the extension, GLB where that tells nothing.
static enum glint_scene_type type_of(const char *file)
{
    static const struct {
        const char *extension;
        enum glint_scene_type type;
    } kinds[] = {{".gltf", GLINT_SCENE_GLTF},
                 {".obj", GLINT_SCENE_OBJ},
                 {".ply", GLINT_SCENE_PLY},
                 {".stl", GLINT_SCENE_STL}};
    const char *dot = strrchr(file, '.');
    for (size_t i = 0; dot && i < sizeof kinds / sizeof *kinds; i++)
        if (strcmp(dot, kinds[i].extension) == 0)
            return kinds[i].type;
    return GLINT_SCENE_GLB;
}

static uint8_t *read_file(const char *path, size_t *size)
{
    FILE *f = fopen(path, "rb");
    if (!f || fseek(f, 0, SEEK_END))
        return NULL;
    *size = (size_t)ftell(f);
    rewind(f);
    uint8_t *bytes = malloc(*size + 1);
    if (bytes && fread(bytes, 1, *size, f) != *size) {
        free(bytes);
        bytes = NULL;
    }
    fclose(f);
    return bytes;
}

static uint64_t drawn(const struct glint_scene *s)
{
    uint64_t n = 0;
    for (uint32_t i = 0; i < s->instances; i++)
        n += s->mesh[s->instance[i].mesh].triangles;
    return n;
}

static uint64_t stored(const struct glint_scene *s)
{
    uint64_t n = 0;
    for (uint32_t i = 0; i < s->meshes; i++)
        n += s->mesh[i].triangles;
    return n;
}

static void put_string(struct glint_text *t, const char *key, const char *value)
{
    glint_text_key(t, key);
    glint_text_string(t, value);
}

static void put_number(struct glint_text *t, const char *key, double value)
{
    glint_text_key(t, key);
    glint_text_double(t, value);
}

static void print_line(struct glint_text *t)
{
    glint_text_add(t, "}");
    char *line = glint_text_take(t, NULL);
    puts(line ? line : "{}");
    free(line);
}

// imported: it is the text that the import gave which does not parse.
static void print_fault(const char *file, glint_status st, const struct glint_error *err,
                        double seconds, bool imported)
{
    struct glint_text t = {0};
    glint_text_add(&t, "{");
    put_string(&t, "file", file);
    put_number(&t, "status", st);
    put_number(&t, "faults", (double)err->count);
    put_string(&t, "pointer", err->count ? err->fault[0].pointer : "");
    put_string(&t, "detail", glint_error_text(err));
    put_number(&t, "seconds", seconds);
    glint_text_key(&t, "imported");
    glint_text_add(&t, imported ? "true" : "false");
    print_line(&t);
}

static void print_more(const struct glint_import *im, const struct glint_scene *s)
{
    for (size_t i = 0; i < im->warnings; i++)
        fprintf(stderr, "  warning: %s\n", im->warning[i]);
    for (uint32_t i = 0; i < s->objects; i++)
        fprintf(stderr, "  object %s: \"%s\" of \"%s\"\n", s->object[i].id, s->object[i].name,
                s->object[i].asset);
    fprintf(stderr, "%.*s\n", im->length < 20000 ? (int)im->length : 20000, im->text);
}

static void print_scene(const char *file, const struct glint_import *im,
                        const struct glint_scene *s, double seconds, double parse)
{
    size_t bytes = 0;
    for (size_t i = 0; i < im->assets; i++)
        bytes += im->asset[i].size;
    const struct {
        const char *key;
        double value;
    } numbers[] = {{"status", 0},
                   {"triangles", (double)stored(s)},
                   {"drawn", (double)drawn(s)},
                   {"meshes", s->meshes},
                   {"objects", s->objects},
                   {"instances", s->instances},
                   {"materials", s->materials},
                   {"images", s->images},
                   {"lights", s->lights},
                   {"cameras", s->cameras},
                   {"warnings", (double)im->warnings},
                   {"scene_warnings", s->warnings},
                   {"asset_bytes", (double)bytes},
                   {"child_seconds", im->seconds},
                   {"seconds", seconds},
                   {"parse_seconds", parse}};
    struct glint_text t = {0};
    glint_text_add(&t, "{");
    put_string(&t, "file", file);
    for (size_t i = 0; i < sizeof numbers / sizeof *numbers; i++)
        put_number(&t, numbers[i].key, numbers[i].value);
    print_line(&t);
}

static void dump(glint_importer *importer, const struct options *o, const char *file)
{
    size_t size = 0;
    struct glint_error err = {0};
    struct glint_import *im = NULL;
    struct glint_scene *scene = NULL;
    uint8_t *bytes = read_file(file, &size);
    if (!bytes) {
        fprintf(stderr, "import_dump: cannot read %s\n", file);
        exit(1);
    }
    const enum glint_scene_type type = o->native ? GLINT_SCENE_NATIVE : type_of(file);
    const double start = glint_now();
    glint_status st = glint_import_run(
        importer, &(struct glint_import_source){.type = type, .bytes = bytes, .size = size},
        &o->limits, &im, &err);
    const double run = glint_now() - start;
    const bool imported = st == GLINT_OK;
    if (imported)
        st = glint_scene_parse(&scene, im->text, im->length, im->asset, im->assets, &err);
    if (st)
        print_fault(file, st, &err, run, imported);
    else
        print_scene(file, im, scene, run, glint_now() - start - run);
    if (!st && o->verbose)
        print_more(im, scene);
    fflush(stdout);
    glint_scene_destroy(&scene);
    glint_import_destroy(&im);
    glint_error_finish(&err);
    free(bytes);
}

int main(int argc, char **argv)
{
    struct options o = {0};
    glint_importer *importer = NULL;
    struct glint_error err = {0};
    if (glint_importer_create(&importer, &err)) {
        fprintf(stderr, "import_dump: %s\n", glint_error_text(&err));
        return 1;
    }
    for (int i = 1; i < argc; i++) {
        if (strcmp(argv[i], "--native") == 0)
            o.native = true;
        else if (strcmp(argv[i], "--verbose") == 0)
            o.verbose = true;
        else if (strcmp(argv[i], "--memory") == 0 && i + 1 < argc)
            o.limits.memory_bytes = (size_t)strtoull(argv[++i], NULL, 10) << 20;
        else if (strcmp(argv[i], "--cpu") == 0 && i + 1 < argc)
            o.limits.cpu_seconds = strtod(argv[++i], NULL);
        else
            dump(importer, &o, argv[i]);
    }
    glint_importer_destroy(&importer);
    return 0;
}
