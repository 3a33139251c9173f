// inside.c - which solids the camera is in: those that a ray from it leaves without having entered.
#define GK_INSTANCES // rows may be placed
#include "kernels/gk_light.h"
#include "kernels/gk_solid.h"
#include "kernels/gk_wave.h"
#include "render/internal.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#define STRIDE 16u
#define MAX_SURFACES 65536 // on one ray

// The ray that looks for the way out, and what it has met.
struct walk {
    const struct glint_geometry *geometry;
    struct gk_resident scene;
    float wave[GK_COLUMNS * STRIDE];
    struct gk_vec o, d;
    uint32_t *entered; // [materials], not left again
};

static float *column(struct walk *w, int c)
{
    return &w->wave[(size_t)c * STRIDE];
}

static uint32_t word(struct walk *w, int c)
{
    uint32_t bits;
    memcpy(&bits, column(w, c), sizeof bits);
    return bits;
}

static void set_word(struct walk *w, int c, uint32_t bits)
{
    memcpy(column(w, c), &bits, sizeof bits);
}

// The next surface, false: there is none.
static bool meet(struct walk *w, struct gk_hit *hit)
{
    const float o[3] = {w->o.x, w->o.y, w->o.z}, d[3] = {w->d.x, w->d.y, w->d.z};
    for (int k = 0; k < 3; k++) {
        *column(w, GK_COL_OX + k) = o[k];
        *column(w, GK_COL_DX + k) = d[k];
    }
    *column(w, GK_COL_T) = INFINITY;
    set_word(w, GK_COL_MASK, UINT32_MAX);
    set_word(w, GK_COL_GEOMETRY, GK_NONE);
    set_word(w, GK_COL_INSTANCE, GK_NONE);
    glint_geometry_trace_wave(w->geometry, w->wave, STRIDE, 1);
    if (word(w, GK_COL_GEOMETRY) == GK_NONE)
        return false;
    const struct gk_raw_hit raw = {
        .primitive = word(w, GK_COL_PRIMITIVE),
        .geometry = word(w, GK_COL_GEOMETRY),
        .instance = word(w, GK_COL_INSTANCE),
        .u = *column(w, GK_COL_U),
        .v = *column(w, GK_COL_V),
        .ng = gk_vec(*column(w, GK_COL_NX), *column(w, GK_COL_NY), *column(w, GK_COL_NZ))};
    *hit = gk_hit_decode(&w->scene, raw, w->d);
    const float t = *column(w, GK_COL_T);
    const struct gk_vec p = gk_along(w->o, w->d, t);
    w->o = gk_along(p, hit->ng, -gk_point_error(p, t));
    return true;
}

static void add_rank(struct gk_frame *f, uint32_t rank)
{
    gk_i32 found;
    struct gk_nested s = {f->nested[0], f->nested[1], f->nested[2], f->nested[3]};
    s = gk_nested_replace(s, 0, rank, &found);
    f->nested[0] = s.a;
    f->nested[1] = s.b;
    f->nested[2] = s.c;
    f->nested[3] = s.d;
}

static void note(struct walk *w, const struct gk_hit *hit, struct gk_frame *f)
{
    const struct gk_material *m = w->scene.material + hit->material;
    if (m->transmission == 0.0f || m->flags & GK_MATERIAL_THIN)
        return;
    if (hit->cos_g <= 0.0f)
        w->entered[hit->material]++;
    else if (w->entered[hit->material])
        w->entered[hit->material]--;
    else if (m->interior)
        add_rank(f, m->interior);
    else if (!f->solid)
        f->solid = hit->material + 1; // the innermost
}

// Refractive index of where the camera is.
static float index_at(const struct gk_resident *r, const struct gk_frame *f)
{
    const struct gk_nested s = {f->nested[0], f->nested[1], f->nested[2], f->nested[3]};
    const uint32_t top = gk_nested_top(s);
    return top ? gk_rank_index(r, top) : f->solid ? r->material[f->solid - 1].ior : 1.0f;
}

static void open_tables(const glint_resident *r, struct gk_resident *out)
{
    out->triangle = glint_buffer_host(glint_resident_table(r, GLINT_TABLE_TRIANGLES));
    out->uv1 = glint_buffer_host(glint_resident_table(r, GLINT_TABLE_UV1));
    out->instance = glint_buffer_host(glint_resident_table(r, GLINT_TABLE_INSTANCES));
    out->material = glint_buffer_host(glint_resident_table(r, GLINT_TABLE_MATERIALS));
}

glint_status glint_render_inside(const struct glint_view *v, struct gk_frame *f,
                                 struct glint_error *err)
{
    const struct glint_scene_facts *facts = glint_resident_facts(v->scene);
    if (!facts->solids && !facts->nested)
        return GLINT_OK;
    const size_t materials =
        glint_buffer_bytes(glint_resident_table(v->scene, GLINT_TABLE_MATERIALS)) /
        sizeof(struct gk_material);
    struct walk *w = calloc(1, sizeof *w);
    uint32_t *entered = calloc(materials + 1, sizeof *entered);
    if (w && entered) {
        w->geometry = v->wave_job.geometry;
        w->entered = entered;
        w->o = gk_vec(f->origin[0], f->origin[1], f->origin[2]);
        w->d = gk_normalise(gk_vec(0.5376f, 0.7813f, 0.3171f)); // along no axis
        open_tables(v->scene, &w->scene);
        struct gk_hit hit;
        for (int i = 0; i < MAX_SURFACES && meet(w, &hit); i++)
            note(w, &hit, f);
        f->weight = 1.0f / (index_at(&w->scene, f) * index_at(&w->scene, f));
    }
    const bool made = w && entered;
    free(entered);
    free(w);
    return made ? GLINT_OK : glint_fail(err, GLINT_E_NOMEM, "", "no memory to find the camera");
}
