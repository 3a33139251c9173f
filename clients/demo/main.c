// main.c - glint-demo-scene: writes a scene as native JSON to stdout, that of the README if none is
// named.
#include "compose.h"
#include "palette.h"
#include "scenes.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static void compose_shelves(struct glint_document *d)
{
    glint_palette_write(d);
    glint_compose_shelves(d);
    glint_compose_still_life(d);
    glint_compose_light(d);
}

static const struct {
    const char *name, *what;
    void (*compose)(struct glint_document *d);
} scenes[] = {
    {"shelves", "the one of the README: glass and metal before many small things", compose_shelves},
    {"strips", "curved strips of roughness 0 to 0.7 over a floor", glint_scene_strips},
    {"plant", "clear and rough glass before a plant of many objects", glint_scene_plant},
    {"water", "a water surface with things behind and above it", glint_scene_water},
    {"forty", "forty stripes of falling width in a rough mirror", glint_scene_forty},
    {"cluster", "a tuft of fine blades, many in each pixel", glint_scene_cluster},
};
#define SCENES (sizeof scenes / sizeof *scenes)

static int help(void)
{
    puts("Usage: glint-demo-scene [SCENE] > scene.json\n");
    for (size_t i = 0; i < SCENES; i++)
        printf("  %-8s  %s\n", scenes[i].name, scenes[i].what);
    return EXIT_SUCCESS;
}

static int write_scene(size_t scene)
{
    struct glint_document d;
    glint_document_init(&d);
    scenes[scene].compose(&d);
    char *text = cJSON_PrintUnformatted(d.root);
    const int failed = !text || puts(text) < 0 || fflush(stdout) != 0;
    free(text);
    glint_document_finish(&d);
    if (failed)
        perror("glint-demo-scene");
    return failed ? EXIT_FAILURE : EXIT_SUCCESS;
}

int main(int argc, char **argv)
{
    const char *name = argc > 1 ? argv[1] : scenes[0].name;
    if (strcmp(name, "--help") == 0)
        return help();
    if (strcmp(name, "--version") == 0)
        return puts(PACKAGE_STRING), EXIT_SUCCESS;
    for (size_t i = 0; argc <= 2 && i < SCENES; i++)
        if (strcmp(name, scenes[i].name) == 0)
            return write_scene(i);
    fprintf(stderr, "glint-demo-scene: takes the name of one scene, not '%s'; try --help\n",
            argv[argc - 1]);
    return 64;
}
