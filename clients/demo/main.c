// main.c - glint-demo-scene: writes the scene of the README as native JSON to stdout.
#include "compose.h"
#include "palette.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static int usage(const char *argument)
{
    if (strcmp(argument, "--help") == 0)
        return puts("Usage: glint-demo-scene > scene.json"), EXIT_SUCCESS;
    if (strcmp(argument, "--version") == 0)
        return puts(PACKAGE_STRING), EXIT_SUCCESS;
    fprintf(stderr, "glint-demo-scene: takes no arguments, not '%s'\n", argument);
    return 64;
}

int main(int argc, char **argv)
{
    if (argc > 1)
        return usage(argv[1]);
    struct glint_document d;
    glint_document_init(&d);
    glint_palette_write(&d);
    glint_compose_shelves(&d);
    glint_compose_still_life(&d);
    glint_compose_light(&d);
    char *text = cJSON_PrintUnformatted(d.root);
    const int failed = !text || puts(text) < 0 || fflush(stdout) != 0;
    free(text);
    glint_document_finish(&d);
    if (failed)
        perror("glint-demo-scene");
    return failed ? EXIT_FAILURE : EXIT_SUCCESS;
}
