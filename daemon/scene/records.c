// records.c - shading records of every kept triangle, in the space of its mesh: once for each mesh,
// however many rows draw it, and once for each key of one that bends.
#include "scene/records.h"

#include "base/thread.h"
#include "scene/curvature.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

// ---- what the records of a mesh hold

static uint32_t flags_of_material(const struct glint_material *m)
{
    uint32_t flags = 0;
    for (uint32_t set = 0; set < 2; set++) {
        bool ends[2] = {false, false};
        glint_material_note_ends(m, set, ends);
        for (int axis = 0; axis < 2; axis++)
            flags |= ends[axis] ? GLINT_RECORD_FIXED(set, axis) : 0u;
    }
    if (m->normal_texture.image != GLINT_NONE || m->clearcoat_normal_texture.image != GLINT_NONE)
        flags |= GLINT_RECORD_TANGENTS;
    return flags;
}

// By every instance, hidden ones too: showing one changes no record.
static glint_status find_flags(struct glint_resident *r, struct glint_error *err)
{
    const struct glint_scene *s = r->scene;
    uint32_t *of_material = calloc((size_t)s->materials + 1, sizeof *of_material);
    uint32_t *of_mesh = calloc((size_t)s->meshes + 1, sizeof *of_mesh);
    const bool fine = of_material && of_mesh;
    for (uint32_t i = 0; fine && i < s->materials; i++)
        of_material[i] = flags_of_material(&s->material[i]);
    for (uint32_t i = 0; fine && i < s->instances; i++)
        of_mesh[s->instance[i].mesh] |= of_material[s->instance[i].material];
    for (uint32_t i = 0; fine && i < r->kepts; i++) {
        struct glint_kept *k = &r->kept[i];
        const bool quad = k->mesh == &r->quad;
        k->flags = quad ? 0 : of_mesh[k->mesh - s->mesh];
        k->flags |= k->mesh->uv1 ? GLINT_RECORD_UV1 : 0u;
        k->flags |= k->mesh->color ? GLINT_RECORD_COLOURS : 0u;
    }
    free(of_material);
    free(of_mesh);
    return fine ? GLINT_OK : glint_fail(err, GLINT_E_NOMEM, "", "no memory for records");
}

// ---- filling

// Takes whole periods off the three coordinates of an axis: far from 0 a float has no digits left
// for the fraction. In pairs, which a mirroring wrap does not see either.
static void centre_periods(float *uv)
{
    const double lo = fmin(uv[0], fmin(uv[2], uv[4])), hi = fmax(uv[0], fmax(uv[2], uv[4]));
    const double periods = 2.0 * rint((lo + hi) / 4.0);
    for (int c = 0; c < 3; c++)
        uv[2 * c] = (float)(uv[2 * c] - periods);
}

// uv of the three vertices of a triangle in texture coordinate set `set`.
static void fill_coordinates(float out[6], const float *uv, const uint32_t *t, uint32_t flags,
                             int set)
{
    for (int c = 0; c < 3; c++)
        memcpy(out + 2 * c, uv + 2 * (size_t)t[c], 8);
    for (int axis = 0; axis < 2; axis++)
        if (!(flags & GLINT_RECORD_FIXED(set, axis)))
            centre_periods(out + axis);
}

// Triangles of a mesh at a key, those of one place of work.
struct part_of_mesh {
    const struct glint_kept *k;
    uint32_t key, from, to;
};

static void fill_triangles(struct gk_triangle *out, const struct part_of_mesh *p)
{
    const struct glint_kept *k = p->k;
    const size_t first = 3 * (size_t)p->key * k->mesh->vertices;
    const float *normal = k->normal ? k->normal + first : NULL;
    const uint32_t flags = (k->flags & GLINT_RECORD_UV1 ? GK_TRIANGLE_UV1 : 0u) |
                           (k->flags & GLINT_RECORD_COLOURS ? GK_TRIANGLE_COLOURED : 0u);
    for (uint32_t i = p->from; i < p->to; i++) {
        const uint32_t *t = k->index + 3 * (size_t)i;
        for (int c = 0; normal && c < 3; c++)
            memcpy(out[i].normal + 3 * c, normal + 3 * (size_t)t[c], 12);
        if (k->mesh->uv)
            fill_coordinates(out[i].uv, k->mesh->uv, t, k->flags, 0);
        out[i].flags = flags;
        if (normal)
            out[i].flags |= glint_curvature_bits(glint_curvature(k->position + first, normal, t));
    }
}

static void fill_uv1(struct gk_uv1 *out, const struct part_of_mesh *p)
{
    const struct glint_kept *k = p->k;
    for (uint32_t i = p->from; i < p->to; i++)
        fill_coordinates(out[i].uv, k->mesh->uv1, k->index + 3 * (size_t)i, k->flags, 1);
}

static void fill_colours(struct gk_colour *out, const struct part_of_mesh *p)
{
    const struct glint_kept *k = p->k;
    for (uint32_t i = p->from; i < p->to; i++)
        for (int c = 0; c < 3; c++)
            memcpy(out[i].rgba + 4 * c, k->mesh->color + 4 * (size_t)k->index[3 * (size_t)i + c],
                   16);
}

// A table of records, and which meshes have theirs in it.
static const struct part {
    enum glint_table table;
    size_t size;
    uint32_t flag; // 0: all
} parts[] = {{GLINT_TABLE_TRIANGLES, sizeof(struct gk_triangle), 0},
             {GLINT_TABLE_TANGENTS, sizeof(struct gk_tangent), GLINT_RECORD_TANGENTS},
             {GLINT_TABLE_UV1, sizeof(struct gk_uv1), GLINT_RECORD_UV1},
             {GLINT_TABLE_COLOURS, sizeof(struct gk_colour), GLINT_RECORD_COLOURS}};
#define PARTS (sizeof parts / sizeof *parts)

static bool has(const struct glint_kept *k, const struct part *p)
{
    return k->shape && (!p->flag || k->flags & p->flag);
}

// What a core takes at a time.
#define SHARE 16384u

struct share {
    const struct glint_kept *k;
    uint32_t key, from;
};

struct filling {
    struct glint_resident *r;
    const struct share *share;
};

static void fill_share(void *user, size_t i)
{
    const struct filling *f = user;
    const struct share *s = &f->share[i];
    const struct glint_kept *k = s->k;
    const size_t first = k->first + (size_t)s->key * k->triangles;
    const uint32_t left = k->triangles - s->from;
    const struct part_of_mesh p = {k, s->key, s->from, s->from + (left < SHARE ? left : SHARE)};
    fill_triangles((struct gk_triangle *)glint_table_host(f->r, GLINT_TABLE_TRIANGLES) + first, &p);
    if (k->flags & GLINT_RECORD_UV1)
        fill_uv1((struct gk_uv1 *)glint_table_host(f->r, GLINT_TABLE_UV1) + first, &p);
    if (k->flags & GLINT_RECORD_COLOURS)
        fill_colours((struct gk_colour *)glint_table_host(f->r, GLINT_TABLE_COLOURS) + first, &p);
}

static void copy_from(struct glint_resident *r, const struct glint_kept *k)
{
    for (size_t p = 0; p < PARTS; p++)
        if (has(k, &parts[p]))
            memcpy((char *)glint_table_host(r, parts[p].table) + k->first * parts[p].size,
                   (const char *)glint_table_host(r->from, parts[p].table) +
                       k->source->first * parts[p].size,
                   k->triangles * parts[p].size);
}

static bool is_copied(const struct glint_kept *k)
{
    return k->source && k->source->flags == k->flags;
}

static bool is_filled(const struct glint_kept *k)
{
    return k->shape && !is_copied(k);
}

static size_t shares_of(const struct glint_kept *k)
{
    return is_filled(k) ? (k->triangles + (size_t)SHARE - 1) / SHARE * k->keys : 0;
}

static void list_shares(const struct glint_kept *k, struct share *out)
{
    for (uint32_t key = 0; key < k->keys; key++)
        for (uint32_t from = 0; from < k->triangles; from += SHARE)
            *out++ = (struct share){k, key, from};
}

static glint_status fill_shares(struct glint_resident *r, struct glint_error *err)
{
    size_t count = 0, at = 0;
    for (uint32_t i = 0; i < r->kepts; i++)
        count += shares_of(&r->kept[i]);
    struct share *share = calloc(count + 1, sizeof *share);
    if (!share)
        return glint_fail(err, GLINT_E_NOMEM, "", "no memory for records");
    for (uint32_t i = 0; i < r->kepts; at += shares_of(&r->kept[i++]))
        if (is_filled(&r->kept[i]))
            list_shares(&r->kept[i], share + at);
    glint_thread_each("records", count, fill_share, &(struct filling){r, share});
    free(share);
    return GLINT_OK;
}

static glint_status fill_tangents(struct glint_resident *r, const struct glint_kept *k,
                                  struct glint_error *err)
{
    struct gk_tangent *out = glint_table_host(r, GLINT_TABLE_TANGENTS);
    glint_status st = GLINT_OK;
    for (uint32_t key = 0; !st && key < k->keys; key++)
        st = glint_records_fill_tangents(out + k->first + (size_t)key * k->triangles, k, key, err);
    return st;
}

static glint_status fill(struct glint_resident *r, struct glint_error *err)
{
    glint_status st = fill_shares(r, err);
    for (uint32_t i = 0; !st && i < r->kepts; i++) {
        const struct glint_kept *k = &r->kept[i];
        if (is_copied(k))
            copy_from(r, k);
        else if (is_filled(k) && k->flags & GLINT_RECORD_TANGENTS)
            st = fill_tangents(r, k, err);
    }
    return st;
}

// ---- where records lie

static glint_status lay_out(struct glint_resident *r, struct glint_error *err)
{
    uint64_t next = 0;
    for (uint32_t i = 0; i < r->kepts; i++) {
        struct glint_kept *k = &r->kept[i];
        k->first = (uint32_t)next;
        next += (uint64_t)k->triangles * k->keys;
        r->stats.triangles += k->uses ? k->triangles : 0;
        if (next > UINT32_MAX / 2)
            return glint_fail(err, GLINT_E_CAPACITY, "/meshes", "%llu triangles are too many",
                              (unsigned long long)next);
    }
    r->triangles = (uint32_t)next;
    for (uint32_t i = 0; i < r->rows; i++)
        r->row[i].triangle = r->kept[r->row[i].kept].first;
    return GLINT_OK;
}

static bool same_records(const struct glint_resident *r)
{
    const struct glint_resident *from = r->from;
    if (!from || from->kepts != r->kepts || from->triangles != r->triangles)
        return false;
    for (uint32_t i = 0; i < r->kepts; i++) {
        const struct glint_kept *a = &r->kept[i], *b = &from->kept[i];
        if (a->shape != b->shape || a->first != b->first || a->flags != b->flags)
            return false;
    }
    return true;
}

static glint_status allocate(struct glint_resident *r, struct glint_error *err)
{
    glint_status st = GLINT_OK;
    for (size_t p = 0; !st && p < PARTS; p++) {
        bool any = parts[p].flag == 0;
        for (uint32_t i = 0; !any && i < r->kepts; i++)
            any = has(&r->kept[i], &parts[p]);
        const size_t records = any && r->triangles ? r->triangles : 1;
        st = glint_buffer_create(&r->table[parts[p].table], r->devices, records * parts[p].size,
                                 err);
    }
    return st;
}

static void count(struct glint_resident *r)
{
    for (uint32_t i = 0; i < r->kepts; i++)
        for (size_t p = 0; p < PARTS; p++)
            if (has(&r->kept[i], &parts[p]))
                r->stats.record_bytes +=
                    (uint64_t)r->kept[i].triangles * r->kept[i].keys * parts[p].size;
}

glint_status glint_resident_build_records(struct glint_resident *r, struct glint_error *err)
{
    glint_status st = find_flags(r, err);
    if (!st)
        st = lay_out(r, err);
    if (st)
        return st;
    count(r);
    if (same_records(r)) {
        for (size_t p = 0; p < PARTS; p++)
            glint_share_table(r, parts[p].table);
        return GLINT_OK;
    }
    st = allocate(r, err);
    return st ? st : fill(r, err);
}
