#include "protocol/json_lists.h"

#include <stdlib.h>
#include <string.h>

bool glint_json_lists_add(struct glint_json_lists *lists, const struct glint_json_list *list)
{
    if (lists->count == lists->capacity) {
        const size_t capacity = lists->capacity ? 2 * lists->capacity : 64;
        struct glint_json_list *more = realloc(lists->list, capacity * sizeof *more);
        if (!more)
            return false;
        lists->list = more;
        lists->capacity = capacity;
    }
    lists->list[lists->count++] = *list;
    return true;
}

void glint_json_lists_finish(struct glint_json_lists *lists)
{
    free(lists->list);
    *lists = (struct glint_json_lists){0};
}

// ---- the tree

// The text with an empty array in the place of each list.
static char *shorten(const char *text, size_t length, const struct glint_json_lists *lists,
                     size_t *out)
{
    char *copy = malloc(length + 1), *to = copy;
    size_t from = 0;
    for (size_t i = 0; copy && i < lists->count; i++) {
        const struct glint_json_list *l = &lists->list[i];
        to = mempcpy(to, text + from, l->begin - from);
        to = mempcpy(to, "[]", 2);
        from = l->end;
    }
    if (copy)
        to = mempcpy(to, text + from, length - from);
    *out = (size_t)(to - copy);
    return copy;
}

struct place {
    const char *text;
    const struct glint_json_lists *lists;
    size_t arrays, next; // met so far; the list that comes next
};

static bool become_list(cJSON *array, const char *text, const struct glint_json_list *list)
{
    array->valuestring = strndup(text + list->begin, list->end - list->begin);
    array->valuedouble = (double)list->numbers;
    array->type = cJSON_Raw;
    return array->valuestring != NULL;
}

// Arrays are met in the order in which they begin in the text. False without memory.
static bool put_back(struct place *p, cJSON *value)
{
    const struct glint_json_lists *l = p->lists;
    if (cJSON_IsArray(value) && p->next < l->count && l->list[p->next].array == p->arrays++)
        return become_list(value, p->text, &l->list[p->next++]);
    bool fine = true;
    for (cJSON *child = value->child; fine && child; child = child->next)
        fine = !(child->type & (cJSON_Array | cJSON_Object)) || put_back(p, child);
    return fine;
}

cJSON *glint_json_tree(const char *text, size_t length, const struct glint_json_lists *lists)
{
    if (!lists->count)
        return cJSON_ParseWithLengthOpts(text, length, NULL, false);
    size_t shorter;
    char *copy = shorten(text, length, lists, &shorter);
    cJSON *tree = copy ? cJSON_ParseWithLengthOpts(copy, shorter, NULL, false) : NULL;
    free(copy);
    struct place p = {.text = text, .lists = lists};
    if (tree && put_back(&p, tree))
        return tree;
    cJSON_Delete(tree);
    return NULL;
}

// ---- numbers

#define MOST_DIGITS 18 // of a number below 2^63
#define EXACT ((uint64_t)1 << 53)
#define MOST_PLACES 22 // 10^22 is a double, 10^23 is not

// Of few digits without an exponent the one division of two exact numbers is all that rounds, so it
// gives what strtod() gives (Clinger 1990); anything else is left to it.
static double number(const char **text)
{
    static const double ten[MOST_PLACES + 1] = {1e0,  1e1,  1e2,  1e3,  1e4,  1e5,  1e6,  1e7,
                                                1e8,  1e9,  1e10, 1e11, 1e12, 1e13, 1e14, 1e15,
                                                1e16, 1e17, 1e18, 1e19, 1e20, 1e21, 1e22};
    const char *c = *text + (**text == '-'), *first = c, *point = NULL;
    uint64_t digits = 0;
    for (; (*c >= '0' && *c <= '9') || *c == '.'; c++)
        if (*c == '.')
            point = c;
        else
            digits = 10 * digits + (uint64_t)(*c - '0');
    const ptrdiff_t places = point ? c - point - 1 : 0;
    if (*c == 'e' || *c == 'E' || c - first > MOST_DIGITS || digits > EXACT)
        return strtod(*text, (char **)text);
    const double x = (double)digits / ten[places];
    const bool negative = **text == '-';
    *text = c;
    return negative ? -x : x;
}

struct glint_json_walk glint_json_walk(const cJSON *value)
{
    return (struct glint_json_walk){.child = value->child,
                                    .text = cJSON_IsRaw(value) ? value->valuestring : NULL,
                                    .number.type = cJSON_Number};
}

// What stands between two numbers: a bracket, a comma, space.
static const char *skip(const char *text)
{
    while (*text == '[' || *text == ',' || *text == ' ' || *text == '\t' || *text == '\n' ||
           *text == '\r')
        text++;
    return text;
}

const cJSON *glint_json_next(struct glint_json_walk *w)
{
    if (!w->text) {
        const cJSON *child = w->child;
        w->child = child ? child->next : NULL;
        return child;
    }
    w->text = skip(w->text);
    if (*w->text == ']')
        return NULL;
    w->number.valuedouble = number(&w->text);
    return &w->number;
}
