// asset_set.c - which assets a native text names.
#include "scene/assets.h"

#include <stdlib.h>
#include <string.h>

#define NAME_DIGITS 64u

const char *glint_assets_next_name(const char *text, size_t length, size_t *at)
{
    const char *quote;
    while (*at < length && (quote = memchr(text + *at, '"', length - *at))) {
        const size_t from = (size_t)(quote - text) + 1;
        size_t digits = 0;
        while (digits < NAME_DIGITS && from + digits < length &&
               memchr("0123456789abcdef", text[from + digits], 16))
            digits++;
        *at = from + digits;
        if (digits == NAME_DIGITS && *at < length && text[*at] == '"')
            return text + from;
    }
    *at = length;
    return NULL;
}

static bool grow(struct glint_asset_set *set, size_t *capacity)
{
    const size_t more = *capacity ? 2 * *capacity : 64;
    struct glint_asset *asset = realloc(set->asset, more * sizeof *asset);
    if (asset)
        set->asset = asset;
    glint_asset_ref **ref = asset ? realloc(set->ref, more * sizeof *ref) : NULL;
    if (ref)
        set->ref = ref;
    if (asset && ref)
        *capacity = more;
    return asset && ref;
}

static int by_address(const void *a, const void *b)
{
    const uintptr_t x = (uintptr_t) * (glint_asset_ref *const *)a;
    const uintptr_t y = (uintptr_t) * (glint_asset_ref *const *)b;
    return (x > y) - (x < y);
}

// An asset may be named more than once.
static void sort_out(struct glint_asset_set *set)
{
    size_t kept = 0;
    qsort(set->ref, set->count, sizeof *set->ref, by_address);
    for (size_t i = 0; i < set->count; i++)
        if (kept && set->ref[kept - 1] == set->ref[i])
            glint_asset_ref_release(&set->ref[i]);
        else
            set->ref[kept++] = set->ref[i];
    set->count = kept;
    for (size_t i = 0; i < kept; i++)
        set->asset[i] = *glint_asset_ref_bytes(set->ref[i]);
}

glint_status glint_assets_gather(glint_assets *assets, const char *text, size_t length,
                                 struct glint_asset_set *out, struct glint_error *err)
{
    size_t at = 0, capacity = 0;
    const char *name;
    *out = (struct glint_asset_set){0};
    while ((name = glint_assets_next_name(text, length, &at))) {
        glint_asset_ref *ref = glint_assets_find(assets, name);
        if (!ref)
            continue;
        if (out->count == capacity && !grow(out, &capacity)) {
            glint_asset_ref_release(&ref);
            glint_asset_set_release(out);
            return glint_fail(err, GLINT_E_NOMEM, "", "no memory for the assets of a scene");
        }
        out->ref[out->count++] = ref;
    }
    if (out->count)
        sort_out(out);
    return GLINT_OK;
}

void glint_asset_set_release(struct glint_asset_set *set)
{
    for (size_t i = 0; i < set->count; i++)
        glint_asset_ref_release(&set->ref[i]);
    free(set->ref);
    free(set->asset);
    *set = (struct glint_asset_set){0};
}
