// mattes.c - the keys that rows deposit coverage under, and the names behind them.
#include "kernels/gk_matte.h"
#include "protocol/cryptomatte.h"
#include "scene/internal.h"

#include <stdlib.h>
#include <string.h>

// A key and a row that has it. Area lights are objects of their own, with their own name as material.
struct named {
    struct glint_matte_key key;
    uint32_t row; // GLINT_NONE: nothing is drawn
};

static int by_name(const void *a, const void *b)
{
    const struct glint_matte_key *p = &((const struct named *)a)->key,
                                 *q = &((const struct named *)b)->key;
    int order = 0;
    for (int k = 0; !order && k < 3; k++)
        order = (p->id[k] > q->id[k]) - (p->id[k] < q->id[k]);
    for (int k = 0; !order && k < 3; k++)
        order = strcmp(p->name[k], q->name[k]);
    return order;
}

// NULL for what is not there: no ID.
static struct glint_matte_key key_of(const char *object, const char *material, const char *asset)
{
    struct glint_matte_key key = {.name = {object, material, asset}};
    for (int k = 0; k < 3; k++) {
        if (k < 2 && key.name[k] && !*key.name[k])
            key.name[k] = "default"; // CONVENTIONS a
        key.id[k] = !key.name[k] || !*key.name[k] ? 0 : glint_cryptomatte_id(key.name[k]);
    }
    return key;
}

static uint32_t name_rows(const struct glint_resident *r, struct named *out)
{
    const struct glint_scene *s = r->scene;
    uint32_t n = 0, row = 0;
    for (uint32_t i = 0; i < s->instances; i++) {
        const struct glint_instance *in = &s->instance[i];
        const struct glint_object *o = &s->object[in->object];
        out[n++] = (struct named){key_of(o->name, s->material[in->material].name, o->asset),
                                  glint_resident_draws(r, i) ? row++ : GLINT_NONE};
    }
    for (uint32_t i = 0; i < s->lights; i++)
        if (s->light[i].kind == GLINT_LIGHT_AREA)
            out[n++] = (struct named){key_of(s->light[i].name, s->light[i].name, ""),
                                      glint_resident_shows(r, i) ? row++ : GLINT_NONE};
    return n;
}

// One key for all rows whose three names are the same: a slot of a pixel holds all of them.
static void assign_keys(struct glint_resident *r, struct named *named)
{
    const uint32_t n = name_rows(r, named);
    qsort(named, n, sizeof *named, by_name);
    r->mattes = 2;
    for (uint32_t i = 0; i < n; i++) {
        if (i == 0 || by_name(&named[i - 1], &named[i]) != 0)
            r->matte[r->mattes++] = named[i].key;
        if (named[i].row != GLINT_NONE)
            r->row[named[i].row].matte = r->mattes - 1;
    }
}

// Manifests have the names of what no instance uses, too.
static void append_unused(struct glint_resident *r, bool *used)
{
    const struct glint_scene *s = r->scene;
    bool *used_material = used + s->objects;
    for (uint32_t i = 0; i < s->instances; i++)
        used[s->instance[i].object] = used_material[s->instance[i].material] = true;
    for (uint32_t i = 0; i < s->objects; i++)
        if (!used[i])
            r->matte[r->mattes++] = key_of(s->object[i].name, NULL, s->object[i].asset);
    for (uint32_t i = 0; i < s->materials; i++)
        if (!used_material[i])
            r->matte[r->mattes++] = key_of(NULL, s->material[i].name, NULL);
}

glint_status glint_resident_build_mattes(struct glint_resident *r, struct glint_error *err)
{
    const size_t capacity = (size_t)r->scene->instances + r->scene->lights;
    const size_t things = (size_t)r->scene->objects + r->scene->materials;
    struct named *named = calloc(capacity + 1, sizeof *named);
    bool *used = calloc(things + 1, sizeof *used);
    r->matte = calloc(capacity + things + 2, sizeof *r->matte);
    glint_status st = GLINT_OK;
    if (!named || !used || !r->matte)
        st = glint_fail(err, GLINT_E_NOMEM, "", "no memory for the names of %zu instances",
                        capacity);
    if (!st)
        assign_keys(r, named);
    if (!st && r->mattes - 1 > GK_MATTE_BASE_KEY)
        st = glint_fail(err, GLINT_E_RANGE, "/instances",
                        "%u combinations of object, material and asset are "
                        "more than the %u that mattes tell apart",
                        r->mattes - 2, GK_MATTE_BASE_KEY - 1);
    if (!st)
        append_unused(r, used);
    if (!st)
        st = glint_resident_tell_mattes_apart(r, err);
    r->facts.mattes = r->mattes;
    free(named);
    free(used);
    return st;
}
