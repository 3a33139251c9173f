#include "jobs/price.h"

#include <pthread.h>
#include <stdlib.h>
#include <string.h>

#define MAX_FRONTS 4096u

struct priced {
    char *scene, *text;
};

struct glint_prices {
    glint_journal *journal; // NULL: nothing is kept
    pthread_mutex_t order;  // of writers, held while the disk works; before `mutex`
    pthread_mutex_t mutex;  // guards the list; nothing is called under it
    struct priced *front;   // [fronts]
    size_t fronts, capacity;
    bool failed; // to read all of what was kept
};

const char *glint_price_class(const struct glint_scene_facts *facts)
{
    if (facts->light_grid)
        return "lights";
    if (facts->transmission)
        return "glass";
    return facts->textures ? "textured" : "plain";
}

// ---- the list, with the mutex

static struct priced *find(glint_prices *p, const char *scene)
{
    for (size_t i = 0; i < p->fronts; i++)
        if (!strcmp(p->front[i].scene, scene))
            return &p->front[i];
    return NULL;
}

static bool grow(glint_prices *p)
{
    if (p->fronts < p->capacity)
        return true;
    const size_t more = p->capacity ? 2 * p->capacity : 16;
    struct priced *front = realloc(p->front, more * sizeof *front);
    if (!front)
        return false;
    p->front = front;
    p->capacity = more;
    return true;
}

// Takes the texts.
static bool set(glint_prices *p, char *scene, char *text)
{
    struct priced *known = scene && text ? find(p, scene) : NULL;
    if (known) {
        free(known->text);
        known->text = text;
        free(scene);
        return true;
    }
    if (scene && text && grow(p)) {
        p->front[p->fronts++] = (struct priced){scene, text};
        return true;
    }
    free(scene);
    free(text);
    return false;
}

static void drop(glint_prices *p, const char *scene)
{
    struct priced *known = find(p, scene);
    if (!known)
        return;
    free(known->scene);
    free(known->text);
    *known = p->front[--p->fronts];
}

// ---- the disk

static void take_row(void *user, const struct glint_row *row)
{
    glint_prices *p = user;
    const char *scene = glint_row_text(row, 0), *text = glint_row_text(row, 1);
    if (scene && text)
        p->failed |= !set(p, strdup(scene), strdup(text));
}

static glint_status recall(glint_prices *p, struct glint_error *err)
{
    const struct glint_statement all = {.sql = "SELECT scene, text FROM front"};
    if (!p->journal)
        return GLINT_OK;
    const glint_status st = glint_journal_read(p->journal, &all, take_row, p, err);
    return !st && p->failed ? glint_fail(err, GLINT_E_NOMEM, "", "no memory for the fronts") : st;
}

static glint_status keep(glint_prices *p, const char *scene, const char *text,
                         struct glint_error *err)
{
    const struct glint_statement row = {.sql =
                                            "INSERT INTO front(scene, text) VALUES(?,?) "
                                            "ON CONFLICT(scene) DO UPDATE SET text=excluded.text",
                                        .value = {glint_value_text(scene), glint_value_text(text)},
                                        .values = 2};
    return p->journal ? glint_journal_commit(p->journal, &row, 1, err) : GLINT_OK;
}

static glint_status forget(glint_prices *p, const char *scene, struct glint_error *err)
{
    const struct glint_statement row = {
        .sql = "DELETE FROM front WHERE scene=?", .value = {glint_value_text(scene)}, .values = 1};
    return p->journal ? glint_journal_commit(p->journal, &row, 1, err) : GLINT_OK;
}

// ---- the module

glint_status glint_prices_create(glint_prices **out, glint_keeper *keeper, struct glint_error *err)
{
    glint_prices *p = calloc(1, sizeof *p);
    *out = NULL;
    if (!p)
        return glint_fail(err, GLINT_E_NOMEM, "", "no memory for fronts");
    p->journal = keeper ? glint_keeper_journal(keeper) : NULL;
    pthread_mutex_init(&p->order, NULL);
    pthread_mutex_init(&p->mutex, NULL);
    const glint_status st = recall(p, err);
    if (st)
        glint_prices_destroy(&p);
    *out = p;
    return st;
}

void glint_prices_destroy(glint_prices **prices)
{
    glint_prices *p = *prices;
    if (!p)
        return;
    for (size_t i = 0; i < p->fronts; i++) {
        free(p->front[i].scene);
        free(p->front[i].text);
    }
    free(p->front);
    pthread_mutex_destroy(&p->order);
    pthread_mutex_destroy(&p->mutex);
    free(p);
    *prices = NULL;
}

// One that is there, or room for one more.
static glint_status has_room(glint_prices *p, const char *scene, bool *known,
                             struct glint_error *err)
{
    pthread_mutex_lock(&p->mutex);
    *known = find(p, scene) != NULL;
    const bool room = *known || p->fronts < MAX_FRONTS;
    pthread_mutex_unlock(&p->mutex);
    return room ? GLINT_OK
                : glint_fail(err, GLINT_E_CAPACITY, "", "%u scenes have a front already",
                             MAX_FRONTS);
}

glint_status glint_prices_put(glint_prices *p, const char *scene, const char *text, size_t length,
                              bool *created, struct glint_error *err)
{
    struct glint_front *front;
    bool known = false;
    glint_status st = glint_front_parse(&front, text, length, err);
    free(front);
    if (st)
        return st;
    char *copy = strndup(text, length);
    if (!copy)
        return glint_fail(err, GLINT_E_NOMEM, "", "no memory for a front");
    pthread_mutex_lock(&p->order);
    st = has_room(p, scene, &known, err);
    if (!st)
        st = keep(p, scene, copy, err);
    if (!st) {
        pthread_mutex_lock(&p->mutex);
        if (!set(p, strdup(scene), copy))
            st = glint_fail(err, GLINT_E_NOMEM, "", "no memory for a front");
        pthread_mutex_unlock(&p->mutex);
        copy = NULL; // taken either way
    }
    pthread_mutex_unlock(&p->order);
    free(copy);
    *created = !known;
    return st;
}

glint_status glint_prices_remove(glint_prices *p, const char *scene, struct glint_error *err)
{
    pthread_mutex_lock(&p->order);
    const glint_status st = forget(p, scene, err);
    pthread_mutex_lock(&p->mutex);
    if (!st)
        drop(p, scene);
    pthread_mutex_unlock(&p->mutex);
    pthread_mutex_unlock(&p->order);
    return st;
}

static char *class_front(const char *of_class)
{
    const size_t n = strlen(of_class);
    for (const struct glint_source *s = glint_class_fronts; s->name; s++)
        if (!strncmp(s->name, of_class, n) && s->name[n] == '.')
            return strndup(s->text, s->length);
    return NULL;
}

char *glint_prices_find(glint_prices *p, const char *scene, const char *of_class, bool *own)
{
    pthread_mutex_lock(&p->mutex);
    const struct priced *known = find(p, scene);
    *own = known != NULL;
    char *text = known ? strdup(known->text) : NULL;
    pthread_mutex_unlock(&p->mutex);
    return *own ? text : class_front(of_class);
}
