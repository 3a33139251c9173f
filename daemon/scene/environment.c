// environment.c - the image at infinity and the grid that it is sampled by.
#include "scene/alias.h"
#include "scene/internal.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#define CELLS_X 512u
#define CELLS_Y 256u

static float half_to_float(uint16_t h)
{
    _Float16 x;
    memcpy(&x, &h, sizeof x);
    return (float)x;
}

static void read_texel(const struct glint_resident *r, const struct glint_image *image, size_t i,
                       float out[3])
{
    if (image->format == GLINT_IMAGE_RGBA16F) {
        const uint16_t *p = (const uint16_t *)image->pixels + 4 * i;
        for (int k = 0; k < 3; k++)
            out[k] = half_to_float(p[k]);
        return;
    }
    const float *decode = glint_table_host(r, GLINT_TABLE_DECODE);
    const uint8_t *p = (const uint8_t *)image->pixels + 4 * i;
    for (int k = 0; k < 3; k++)
        out[k] = decode[p[k]];
}

static glint_status fill_texels(struct glint_resident *r, const struct glint_image *image,
                                struct glint_error *err)
{
    struct gk_env_texel *texel = glint_table_host(r, GLINT_TABLE_ENV_TEXELS);
    const size_t n = (size_t)image->width * image->height;
    for (size_t i = 0; i < n; i++) {
        read_texel(r, image, i, texel[i].L);
        for (int k = 0; k < 3; k++)
            if (!isfinite(texel[i].L[k]) || texel[i].L[k] < 0.0f)
                return glint_fail(err, GLINT_E_RANGE, "/environment/image",
                                  "pixel %zu,%zu of image \"%s\" is negative or not finite",
                                  i % image->width, i / image->width, image->id);
    }
    return GLINT_OK;
}

// Largest luminance that a bilinear look-up inside the cell can meet, so that no lit direction has
// zero probability; averaged with the mean so that a single hot texel does not own its cell.
static double cell_weight(const struct glint_resident *r, const struct glint_image *image,
                          uint32_t cx, uint32_t cy)
{
    const struct glint_scene_lighting *l = &r->lighting;
    const struct gk_env_texel *texel = glint_table_host(r, GLINT_TABLE_ENV_TEXELS);
    const int64_t x0 = (int64_t)cx * image->width / l->env_cell_width - 1;
    const int64_t x1 =
        ((int64_t)(cx + 1) * image->width + l->env_cell_width - 1) / l->env_cell_width + 1;
    const int64_t y0 = (int64_t)cy * image->height / l->env_cell_height - 1;
    const int64_t y1 =
        ((int64_t)(cy + 1) * image->height + l->env_cell_height - 1) / l->env_cell_height + 1;
    double sum = 0.0, most = 0.0;
    for (int64_t y = y0; y < y1; y++)
        for (int64_t x = x0; x < x1; x++) {
            const int64_t row = y < 0 ? 0 : y >= image->height ? image->height - 1 : y;
            const int64_t column = (x + image->width) % image->width;
            const float *L = texel[row * image->width + column].L;
            const double Y = 0.2126 * L[0] + 0.7152 * L[1] + 0.0722 * L[2];
            sum += Y;
            most = fmax(most, Y);
        }
    return 0.5 * (sum / (double)((x1 - x0) * (y1 - y0)) + most);
}

static glint_status fill_cells(struct glint_resident *r, const struct glint_image *image,
                               struct glint_error *err)
{
    const uint32_t w = r->lighting.env_cell_width, h = r->lighting.env_cell_height, n = w * h;
    struct gk_env_cell *cell = glint_table_host(r, GLINT_TABLE_ENV_CELLS);
    double *weight = malloc(n * sizeof *weight);
    if (!weight)
        return glint_fail(err, GLINT_E_NOMEM, "", "no memory for the environment's cells");
    double total = 0.0;
    for (uint32_t y = 0; y < h; y++)
        for (uint32_t x = 0; x < w; x++) {
            weight[y * w + x] = cell_weight(r, image, x, y) * sin(M_PI * (y + 0.5) / h);
            total += weight[y * w + x];
        }
    for (uint32_t i = 0; i < n; i++) { // a floor keeps 1/pdf bounded where the image is black
        weight[i] = total > 0.0 ? 0.999 * weight[i] / total + 0.001 / n : 1.0 / n;
        cell[i].pdf = (float)(weight[i] * n);
    }
    const bool built = glint_alias_build(weight, n, &cell->keep, &cell->other, 4);
    free(weight);
    return built ? GLINT_OK
                 : glint_fail(err, GLINT_E_NOMEM, "", "no memory for the environment's cells");
}

glint_status glint_resident_build_environment(struct glint_resident *r, struct glint_error *err)
{
    const struct glint_environment *e = &r->scene->environment;
    struct glint_scene_lighting *l = &r->lighting;
    const bool present = r->scene->has_environment &&
                         (e->radiance[0] > 0.0f || e->radiance[1] > 0.0f || e->radiance[2] > 0.0f);
    const struct glint_image *image =
        present && e->image != GLINT_NONE ? &r->scene->image[e->image] : NULL;
    r->facts.environment_image = image != NULL;
    r->facts.environment_constant = present && !image;
    if (present)
        memcpy(l->environment, e->radiance, sizeof l->environment);
    l->env_rotation = e->rotation;
    l->env_width = image ? image->width : 1;
    l->env_height = image ? image->height : 1;
    l->env_cell_width = l->env_width < CELLS_X ? l->env_width : CELLS_X;
    l->env_cell_height = l->env_height < CELLS_Y ? l->env_height : CELLS_Y;
    l->env_choice = image ? (r->lights ? 0.5f : 1.0f) : 0.0f;
    if (glint_share_environment(r))
        return GLINT_OK;
    const size_t texels = (size_t)l->env_width * l->env_height;
    const size_t cells = (size_t)l->env_cell_width * l->env_cell_height;
    glint_status st = glint_buffer_create(&r->table[GLINT_TABLE_ENV_TEXELS], r->devices,
                                          texels * sizeof(struct gk_env_texel), err);
    if (!st)
        st = glint_buffer_create(&r->table[GLINT_TABLE_ENV_CELLS], r->devices,
                                 cells * sizeof(struct gk_env_cell), err);
    if (!st && image)
        st = fill_texels(r, image, err);
    if (!st && image)
        st = fill_cells(r, image, err);
    return st;
}
