// energy_usual.c - writes the tables of a white reflector and of the usual interface as C.
#include "scene/energy_rows.h"

#include <stdio.h>
#include <string.h>

static void write_table(const char *name, const float *number, size_t count)
{
    printf("const float %s[] = {\n", name);
    for (size_t i = 0; i < count; i++)
        printf("%af,%c", (double)number[i], i % 8 == 7 ? '\n' : ' ');
    printf("};\n");
}

int main(void)
{
    static float white[GK_ENERGY_PART], glass[GK_ENERGY_PARTS * GK_ENERGY_PART];
    float ior;
    glint_energy_step(GLINT_ENERGY_USUAL, &ior);
    for (int y = 0; y < GK_ENERGY_SIDE; y++) {
        glint_energy_part_row(white, 0.0f, y);
        glint_energy_part_row(glass, ior, y);
        glint_energy_glass_row(glass, ior, y);
    }
    printf("#include \"scene/energy_rows.h\"\n");
    write_table("glint_energy_usual_white", white, GK_ENERGY_PART);
    write_table("glint_energy_usual_glass", glass, GK_ENERGY_PARTS * GK_ENERGY_PART);
    return fflush(stdout) || ferror(stdout);
}
