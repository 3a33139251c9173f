// archive.c - renders and films in files.
#include "render/internal.h"

glint_status glint_render_film(glint_render *r, int fd, struct glint_error *err)
{
    (void)r;
    return glint_fail(err, GLINT_E_IO, "", "no film can be written to descriptor %d", fd);
}

glint_status glint_render_restore(glint_render *r, int fd, struct glint_error *err)
{
    (void)r;
    return glint_fail(err, GLINT_E_IO, "", "no film can be read from descriptor %d", fd);
}

glint_status glint_render_open(glint_render **out, int fd, struct glint_error *err)
{
    *out = NULL;
    return glint_fail(err, GLINT_E_IO, "", "no film can be read from descriptor %d", fd);
}

bool glint_render_extend(glint_render *r, uint32_t samples, double error)
{
    (void)r;
    return samples == 0 && error == 0.0;
}
