// frame_error HALF HALF FRAME... - how far each frame is from a reference in two halves: the root of
// the mean of (x-r)^2/(r^2+0.01), less the reference's own variance; a line each.
#include "clients/cli/accuracy_files.h"
#include "clients/cli/accuracy_metric.h"

#include <math.h>
#include <stdio.h>

static glint_status load(struct glint_accuracy_image *out, const char *path,
                         struct glint_error *err)
{
    struct glint_frame *frame;
    glint_status st = glint_accuracy_load_frame(&frame, ".", path, err);
    if (!st && !frame)
        st = glint_fail(err, GLINT_E_IO, "", "%s: no such file", path);
    if (!st)
        st = glint_accuracy_image_take(out, frame, false, err);
    glint_frame_destroy(&frame);
    return st;
}

static glint_status compare(const char *path, const struct glint_accuracy_reference *reference,
                            struct glint_error *err)
{
    struct glint_accuracy_image image;
    struct glint_accuracy_error e;
    glint_status st = load(&image, path, err);
    if (st)
        return st;
    st = glint_accuracy_image_align(&image, &reference->mean, err);
    if (!st) {
        glint_accuracy_compare(&e, &image, reference);
        printf("%.9g\n", sqrt(fmax(e.relmse, 0)));
    }
    glint_accuracy_image_finish(&image);
    return st;
}

int main(int argc, char **argv)
{
    struct glint_error err = {0};
    struct glint_accuracy_image half[2] = {{0}};
    struct glint_accuracy_reference reference = {0};
    if (argc < 4)
        return fputs("usage: frame_error HALF HALF FRAME...\n", stderr), 64;
    glint_status st = load(&half[0], argv[1], &err);
    if (!st)
        st = load(&half[1], argv[2], &err);
    if (!st)
        st = glint_accuracy_reference_take(&reference, half, false, &err);
    for (int i = 3; i < argc && !st; i++)
        st = compare(argv[i], &reference, &err);
    if (st)
        fprintf(stderr, "frame_error: %s\n", glint_error_text(&err));
    glint_accuracy_image_finish(&half[0]);
    glint_accuracy_image_finish(&half[1]);
    glint_accuracy_reference_finish(&reference);
    glint_error_finish(&err);
    return st != GLINT_OK;
}
