// energy_usual.c - writes the tables of a white reflector and of the usual interfaces as C.
#include "scene/energy_rows.h"

#include <stdio.h>

static void write_numbers(const float *number, size_t count)
{
    for (size_t i = 0; i < count; i++)
        printf("%af,%c", (double)number[i], i % 8 == 7 ? '\n' : ' ');
}

static void write_glass(float wanted)
{
    static float glass[GK_ENERGY_PARTS * GK_ENERGY_PART];
    float ior;
    glint_energy_step(wanted, &ior);
    for (int y = 0; y < GK_ENERGY_SIDE; y++) {
        glint_energy_part_row(glass, ior, y);
        glint_energy_glass_row(glass, ior, y);
    }
    printf("{\n");
    write_numbers(glass, sizeof glass / sizeof *glass);
    printf("},\n");
}

int main(void)
{
    static float white[GK_ENERGY_PART];
    for (int y = 0; y < GK_ENERGY_SIDE; y++)
        glint_energy_part_row(white, 0.0f, y);
    printf("#include \"scene/energy_rows.h\"\n"
           "const float glint_energy_usual_white[] = {\n");
    write_numbers(white, GK_ENERGY_PART);
    printf("};\nconst float glint_energy_usual_glass[][GK_ENERGY_PARTS * GK_ENERGY_PART] = {\n");
    for (int i = 0; i < GLINT_ENERGY_USUALS; i++)
        write_glass(glint_energy_usual_ior[i]);
    printf("};\n");
    return fflush(stdout) || ferror(stdout);
}
