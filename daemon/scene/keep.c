#include "scene/keep.h"

#include "base/clock.h"
#include "base/journal_schema.h"
#include "base/log.h"
#include "base/sha256.h"
#include "scene/keep_parts.h"

#include <cjson/cJSON.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>

#define SHORT_TEXT ((size_t)64 << 10) // bytes that the journal takes
#define DEEPEST 32u                   // differences up to a whole text

// ---- what is held in memory

// With the mutex. The held revision, or NULL.
struct glint_held *glint_keep_find(const glint_keep *k, const char *id)
{
    for (size_t i = 0; i < k->helds; i++)
        if (!strcmp(k->held[i].id, id))
            return &k->held[i];
    return NULL;
}

void glint_keep_hold(glint_keep *k, const char *id, uint32_t depth)
{
    pthread_mutex_lock(&k->mutex);
    struct glint_held *held = glint_keep_find(k, id);
    if (!held && k->helds == k->held_capacity) {
        const size_t more = k->held_capacity ? 2 * k->held_capacity : 64;
        struct glint_held *grown = realloc(k->held, more * sizeof *grown);
        if (grown) {
            k->held = grown;
            k->held_capacity = more;
        } else {
            k->collects = false; // what is not on the list must not be taken away
        }
    }
    if (held) {
        held->count++;
    } else if (k->helds < k->held_capacity) {
        held = &k->held[k->helds++];
        *held = (struct glint_held){.count = 1, .depth = depth};
        memcpy(held->id, id, sizeof held->id);
    }
    pthread_mutex_unlock(&k->mutex);
}

void glint_keep_release(glint_keep *k, const char *id)
{
    pthread_mutex_lock(&k->mutex);
    struct glint_held *held = glint_keep_find(k, id);
    if (held && !--held->count) {
        *held = k->held[--k->helds];
        k->dirty = true;
        pthread_cond_signal(&k->changed);
    }
    pthread_mutex_unlock(&k->mutex);
}

static uint32_t depth_of(glint_keep *k, const char *id)
{
    pthread_mutex_lock(&k->mutex);
    const struct glint_held *held = glint_keep_find(k, id);
    const uint32_t depth = held ? held->depth : DEEPEST;
    pthread_mutex_unlock(&k->mutex);
    return depth;
}

static void set_depth(glint_keep *k, const char *id, uint32_t depth)
{
    pthread_mutex_lock(&k->mutex);
    struct glint_held *held = glint_keep_find(k, id);
    if (held)
        held->depth = depth;
    pthread_mutex_unlock(&k->mutex);
}

// ---- the difference of two texts: what is between their common begin and their common end

struct delta {
    uint64_t prefix, suffix; // bytes
    char middle[];
};

static struct delta *make_delta(const struct glint_import *from, const struct glint_import *to,
                                size_t *bytes)
{
    const size_t shorter = from->length < to->length ? from->length : to->length;
    size_t prefix = 0, suffix = 0;
    while (prefix < shorter && from->text[prefix] == to->text[prefix])
        prefix++;
    while (suffix < shorter - prefix &&
           from->text[from->length - 1 - suffix] == to->text[to->length - 1 - suffix])
        suffix++;
    const size_t middle = to->length - prefix - suffix;
    if (middle > SHORT_TEXT && middle > to->length / 2)
        return NULL;
    *bytes = sizeof(struct delta) + middle;
    struct delta *d = malloc(*bytes);
    if (!d)
        return NULL;
    d->prefix = prefix;
    d->suffix = suffix;
    memcpy(d->middle, to->text + prefix, middle);
    return d;
}

// The text that the delta leads to, malloc'd; NULL: it does not fit to the text before, or memory.
static char *apply_delta(const char *text, size_t length, const void *bytes, size_t size,
                         size_t *out_length)
{
    struct delta d;
    if (size < sizeof d)
        return NULL;
    memcpy(&d, bytes, sizeof d);
    if (d.prefix > length || d.suffix > length - d.prefix)
        return NULL;
    const size_t middle = size - sizeof d;
    char *out = malloc(d.prefix + middle + d.suffix + 1);
    if (!out)
        return NULL;
    memcpy(out, text, d.prefix);
    memcpy(out + d.prefix, (const char *)bytes + sizeof d, middle);
    memcpy(out + d.prefix + middle, text + length - d.suffix, d.suffix);
    *out_length = d.prefix + middle + d.suffix;
    out[*out_length] = '\0';
    return out;
}

// ---- keeping

glint_status glint_keep_content(glint_keep *k, const char *id, const struct glint_import *import,
                                struct glint_error *err)
{
    struct glint_content *blob = calloc(import->assets + 1, sizeof *blob);
    size_t count = 0;
    if (!blob)
        return glint_fail(err, GLINT_E_NOMEM, "", "no memory to keep a scene");
    for (; count < import->assets; count++) {
        const struct glint_asset *a = &import->asset[count];
        memcpy(blob[count].name, a->sha256, sizeof blob[count].name);
        blob[count].bytes = a->bytes;
        blob[count].size = a->size;
    }
    // A patch of a long text is told by its difference, unless it is the one too many.
    if (import->length > SHORT_TEXT && id) {
        memcpy(blob[count].name, id, sizeof blob[count].name);
        blob[count].bytes = import->text;
        blob[count++].size = import->length;
    }
    const glint_status st = glint_vault_put(k->vault, blob, count, err);
    free(blob);
    return st;
}

static char *warnings_text(const struct glint_import *import)
{
    cJSON *list = cJSON_CreateArray();
    for (size_t i = 0; i < import->warnings; i++)
        cJSON_AddItemToArray(list, cJSON_CreateString(import->warning[i]));
    char *text = cJSON_PrintUnformatted(list);
    cJSON_Delete(list);
    return text;
}

static struct glint_statement insert_revision(const struct glint_kept_scene *s, uint32_t depth,
                                              enum glint_text_form form, struct glint_value data)
{
    return (struct glint_statement){
        .sql = "INSERT INTO revision(id, parent, depth, form, data) VALUES(?,?,?,?,?) "
               "ON CONFLICT(id) DO NOTHING",
        .value = {glint_value_text(s->id),
                  glint_value_text(form == GLINT_TEXT_DELTA ? s->parent_id : NULL),
                  glint_value_integer(depth), glint_value_integer(form), data},
        .values = 5};
}

static glint_status commit_scene(glint_keep *k, const struct glint_kept_scene *s,
                                 const struct glint_statement *revision, const char *warnings,
                                 struct glint_error *err)
{
    const struct glint_statement both[2] = {
        *revision,
        {.sql = "INSERT INTO scene(name, revision, warnings, resource) VALUES(?,?,?,?) "
                "ON CONFLICT(name) DO UPDATE SET revision=excluded.revision, "
                "warnings=excluded.warnings, resource=excluded.resource",
         .value = {glint_value_text(s->name), glint_value_text(s->id), glint_value_text(warnings),
                   glint_value_text(s->resource)},
         .values = 4}};
    return glint_journal_commit(k->journal, both, 2, err);
}

// The row of a revision that is not told by a difference.
static glint_status whole(glint_keep *k, const struct glint_kept_scene *s,
                          struct glint_statement *out, struct glint_error *err)
{
    const struct glint_import *im = s->import;
    if (im->length <= SHORT_TEXT) {
        *out = insert_revision(s, 0, GLINT_TEXT_WHOLE, glint_value_blob(im->text, im->length));
        return GLINT_OK;
    }
    struct glint_content blob = {.bytes = im->text, .size = im->length};
    memcpy(blob.name, s->id, sizeof blob.name);
    *out = insert_revision(s, 0, GLINT_TEXT_FILE, (struct glint_value){0});
    return glint_vault_put(k->vault, &blob, 1, err);
}

glint_status glint_keep_publish(glint_keep *k, const struct glint_kept_scene *s,
                                struct glint_error *err)
{
    size_t bytes = 0;
    uint32_t depth = s->parent_id ? depth_of(k, s->parent_id) + 1 : DEEPEST + 1;
    struct delta *delta = depth <= DEEPEST ? make_delta(s->parent, s->import, &bytes) : NULL;
    struct glint_statement revision;
    glint_status st = GLINT_OK;
    if (delta) {
        revision = insert_revision(s, depth, GLINT_TEXT_DELTA, glint_value_blob(delta, bytes));
    } else {
        depth = 0;
        st = whole(k, s, &revision, err);
    }
    char *warnings = warnings_text(s->import);
    if (!st && !warnings)
        st = glint_fail(err, GLINT_E_NOMEM, "", "no memory to keep a scene");
    if (!st)
        st = commit_scene(k, s, &revision, warnings, err);
    if (!st)
        set_depth(k, s->id, depth);
    free(warnings);
    free(delta);
    return st;
}

glint_status glint_keep_remove(glint_keep *k, const char *name, struct glint_error *err)
{
    const struct glint_statement gone = {
        .sql = "DELETE FROM scene WHERE name=?", .value = {glint_value_text(name)}, .values = 1};
    return glint_journal_commit(k->journal, &gone, 1, err);
}

glint_status glint_keep_asset(glint_keep *k, const struct glint_asset *asset,
                              struct glint_error *err)
{
    struct glint_content blob = {.bytes = asset->bytes, .size = asset->size};
    memcpy(blob.name, asset->sha256, sizeof blob.name);
    const struct glint_statement row = {
        .sql = "INSERT INTO asset(name, bytes) VALUES(?,?) ON CONFLICT(name) DO NOTHING",
        .value = {glint_value_text(asset->sha256), glint_value_integer((int64_t)asset->size)},
        .values = 2};
    const glint_status st = glint_vault_put(k->vault, &blob, 1, err);
    return st ? st : glint_journal_commit(k->journal, &row, 1, err);
}

// ---- reading back

struct scene_row {
    char *name, *revision, *warnings, *resource;
};

struct scene_rows {
    struct scene_row *row;
    size_t count;
    bool failed;
};

static char *copy(const struct glint_row *row, int column)
{
    const char *text = glint_row_text(row, column);
    return text ? strdup(text) : NULL;
}

static void take_scene(void *user, const struct glint_row *row)
{
    struct scene_rows *rows = user;
    struct scene_row *more = realloc(rows->row, (rows->count + 1) * sizeof *more);
    if (!more) {
        rows->failed = true;
        return;
    }
    rows->row = more;
    more[rows->count++] =
        (struct scene_row){copy(row, 0), copy(row, 1), copy(row, 2), copy(row, 3)};
}

glint_status glint_keep_scenes(glint_keep *k,
                               bool (*scene)(void *user, const char *name, const char *revision,
                                             const char *warnings, const char *resource),
                               void *user, struct glint_error *err)
{
    struct scene_rows rows = {0};
    const struct glint_statement all = {
        .sql = "SELECT name, revision, warnings, resource FROM scene ORDER BY name"};
    glint_status st = glint_journal_read(k->journal, &all, take_scene, &rows, err);
    for (size_t i = 0; i < rows.count; i++) {
        const struct scene_row *r = &rows.row[i];
        const bool whole = r->name && r->revision && strlen(r->revision) == 64 && r->resource;
        if (!st && !rows.failed && whole &&
            !scene(user, r->name, r->revision, r->warnings, r->resource))
            rows.failed = true;
        free(r->name);
        free(r->revision);
        free(r->warnings);
        free(r->resource);
    }
    free(rows.row);
    return !st && rows.failed ? glint_fail(err, GLINT_E_NOMEM, "", "no memory for the scenes") : st;
}

struct text_row {
    char parent[65];
    int64_t form, depth;
    void *data;
    size_t length;
    bool found;
};

static void take_text(void *user, const struct glint_row *row)
{
    struct text_row *out = user;
    const char *parent = glint_row_text(row, 0);
    const void *data = glint_row_blob(row, 2, &out->length);
    out->found = true;
    if (parent && strlen(parent) == 64)
        memcpy(out->parent, parent, 65);
    out->form = glint_row_integer(row, 1);
    out->depth = glint_row_integer(row, 3);
    out->data = malloc(out->length + 1);
    if (out->data && data)
        memcpy(out->data, data, out->length);
}

static glint_status read_row(glint_keep *k, const char *id, struct text_row *out,
                             struct glint_error *err)
{
    const struct glint_statement one = {
        .sql = "SELECT parent, form, data, depth FROM revision WHERE id=?",
        .value = {glint_value_text(id)},
        .values = 1};
    *out = (struct text_row){0};
    const glint_status st = glint_journal_read(k->journal, &one, take_text, out, err);
    if (st)
        return st;
    if (!out->found)
        return glint_fail(err, GLINT_E_NOT_FOUND, "", "revision %.64s is not kept any more", id);
    return out->data ? GLINT_OK : glint_fail(err, GLINT_E_NOMEM, "", "no memory for a revision");
}

static glint_status damaged(const char *id, struct glint_error *err)
{
    return glint_fail(err, GLINT_E_IO, "", "the kept text of revision %.64s is damaged", id);
}

static glint_status read_file(glint_keep *k, const char *id, char **text, size_t *length,
                              struct glint_error *err)
{
    const uint8_t *bytes;
    const glint_status st = glint_vault_map(k->vault, id, &bytes, length, err);
    if (st)
        return st;
    *text = malloc(*length + 1);
    if (*text) {
        memcpy(*text, bytes, *length);
        (*text)[*length] = '\0';
    }
    munmap((void *)bytes, *length);
    return *text ? GLINT_OK : glint_fail(err, GLINT_E_NOMEM, "", "no memory for a scene's text");
}

// From the row that is told whole down to `id`. levels: what may still be between.
static glint_status read_text(glint_keep *k, const char *id, unsigned levels, char **text,
                              size_t *length, uint32_t *depth, struct glint_error *err)
{
    struct text_row row;
    char *before = NULL;
    size_t before_length = 0;
    uint32_t above = 0;
    *text = NULL;
    glint_status st = read_row(k, id, &row, err);
    if (st) {
        free(row.data);
        return st;
    }
    *depth = (uint32_t)row.depth;
    if (row.form == GLINT_TEXT_FILE) {
        st = read_file(k, id, text, length, err);
    } else if (row.form == GLINT_TEXT_WHOLE) {
        *text = row.data;
        *length = row.length;
        (*text)[*length] = '\0';
        row.data = NULL;
    } else if (row.form != GLINT_TEXT_DELTA || !*row.parent || !levels) {
        st = damaged(id, err);
    } else {
        st = read_text(k, row.parent, levels - 1, &before, &before_length, &above, err);
        if (!st)
            *text = apply_delta(before, before_length, row.data, row.length, length);
        if (!st && !*text)
            st = damaged(id, err);
    }
    free(before);
    free(row.data);
    return st;
}

static glint_status read_checked(glint_keep *k, const char *id, char **text, size_t *length,
                                 uint32_t *depth, struct glint_error *err)
{
    char content[65];
    const glint_status st = read_text(k, id, 4 * DEEPEST, text, length, depth, err);
    if (st)
        return st;
    glint_sha256(*text, *length, content);
    if (!strcmp(content, id))
        return GLINT_OK;
    free(*text);
    *text = NULL;
    return damaged(id, err);
}

// The warnings after the text, in one block with it. Takes the text.
static glint_status make_import(char *text, size_t length, const cJSON *warnings,
                                struct glint_import **out, struct glint_error *err)
{
    size_t bytes = length + 1, count = 0;
    for (const cJSON *w = warnings ? warnings->child : NULL; w; w = w->next)
        if (cJSON_IsString(w)) {
            bytes += strlen(w->valuestring) + 1;
            count++;
        }
    struct glint_import *im = *out = calloc(1, sizeof *im);
    char *block = realloc(text, bytes);
    if (im)
        im->warning = calloc(count + 1, sizeof *im->warning);
    if (im && im->warning && block)
        im->memory = glint_memory_ref_of_block(block, bytes);
    if (!im || !im->memory) {
        free(block ? block : text);
        glint_import_destroy(out);
        return glint_fail(err, GLINT_E_NOMEM, "", "no memory for a revision");
    }
    im->text = block;
    im->length = length;
    char *at = block + length + 1;
    for (const cJSON *w = warnings ? warnings->child : NULL; w; w = w->next)
        if (cJSON_IsString(w)) {
            im->warning[im->warnings++] = at;
            at = stpcpy(at, w->valuestring) + 1;
        }
    return GLINT_OK;
}

glint_status glint_keep_read(glint_keep *k, const char *id, const char *warnings,
                             struct glint_import **out, uint32_t *depth, struct glint_error *err)
{
    const double start = glint_now();
    char *text;
    size_t length;
    *out = NULL;
    glint_status st = read_checked(k, id, &text, &length, depth, err);
    if (st)
        return st;
    cJSON *list = warnings ? cJSON_Parse(warnings) : NULL;
    st = make_import(text, length, list, out, err);
    cJSON_Delete(list);
    if (!st)
        st = glint_keep_gather(k, (*out)->text, length, &(*out)->set, err);
    if (st) {
        glint_import_destroy(out);
        return st;
    }
    (*out)->asset = (*out)->set.asset;
    (*out)->assets = (*out)->set.count;
    (*out)->seconds = glint_now() - start;
    return GLINT_OK;
}

// ---- what is needed though it is not in memory

static void pin_names(glint_keep *k, const char *text, size_t length)
{
    size_t at = 0;
    pthread_mutex_lock(&k->mutex);
    for (const char *name; (name = glint_assets_next_name(text, length, &at));) {
        char(*more)[65] = realloc(k->pinned, (k->pins + 1) * sizeof *more);
        if (!more) {
            k->collects = false;
            break;
        }
        k->pinned = more;
        memcpy(more[k->pins], name, 64);
        more[k->pins++][64] = '\0';
    }
    pthread_mutex_unlock(&k->mutex);
}

void glint_keep_pin(glint_keep *k, const char *id)
{
    char *text;
    size_t length;
    uint32_t depth;
    struct glint_error err = {0};
    if (!read_checked(k, id, &text, &length, &depth, &err)) {
        pin_names(k, text, length);
        free(text);
        return;
    }
    // What it needs cannot be told, so nothing is taken away.
    glint_log(GLINT_LOG_ERROR, "store", NULL, NULL, "%s; no file is collected until it is gone",
              glint_error_text(&err));
    glint_error_finish(&err);
    pthread_mutex_lock(&k->mutex);
    k->collects = false;
    pthread_mutex_unlock(&k->mutex);
}
