// json.c - parse, pointers and typed readers.
#include "protocol/json_lists.h"

#include <assert.h>
#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

const struct glint_json_limits glint_json_request = {
    .bytes = 1u << 20, .depth = 16, .values = 20000};

struct glint_json glint_json_root(const cJSON *value, struct glint_error *err)
{
    return (struct glint_json){.value = value, .err = err};
}

struct glint_json glint_json_member(const struct glint_json *object, const char *key)
{
    const cJSON *value = NULL;
    if (cJSON_IsObject(object->value))
        value = cJSON_GetObjectItemCaseSensitive(object->value, key);
    return (struct glint_json){.value = value, .parent = object, .key = key, .err = object->err};
}

struct glint_json glint_json_item(const struct glint_json *parent, const cJSON *child, size_t index)
{
    return (struct glint_json){.value = child,
                               .parent = parent,
                               .err = parent->err,
                               .index = index,
                               .key = cJSON_IsObject(parent->value) ? child->string : NULL};
}

static size_t escaped_bytes(const char *key)
{
    size_t n = 0;
    for (; *key; key++)
        n += *key == '~' || *key == '/' ? 2 : 1;
    return n;
}

static size_t pointer_bytes(const struct glint_json *at)
{
    size_t n = 1;
    for (; at->parent; at = at->parent)
        n += 1 + (at->key ? escaped_bytes(at->key) : 20);
    return n;
}

static char *put_key(char *out, const char *key)
{
    for (; *key; key++) {
        if (*key == '~' || *key == '/') {
            *out++ = '~';
            *out++ = *key == '~' ? '0' : '1';
        } else {
            *out++ = *key;
        }
    }
    return out;
}

static char *put_pointer(char *out, const struct glint_json *at)
{
    if (!at->parent)
        return out;
    out = put_pointer(out, at->parent);
    *out++ = '/';
    return at->key ? put_key(out, at->key) : out + sprintf(out, "%zu", at->index);
}

bool glint_json_fault(const struct glint_json *at, const char *format, ...)
{
    char *pointer = malloc(pointer_bytes(at)), *detail = NULL;
    va_list args;
    va_start(args, format);
    const int length = vasprintf(&detail, format, args);
    va_end(args);
    if (pointer && length >= 0) {
        *put_pointer(pointer, at) = '\0';
        glint_fail(at->err, GLINT_E_RANGE, pointer, "%s", detail);
    } else {
        glint_fail(at->err, GLINT_E_NOMEM, "", "no memory to say what is wrong");
    }
    free(pointer);
    if (length >= 0)
        free(detail);
    return false;
}

static int by_key(const void *a, const void *b)
{
    return strcmp((*(const cJSON *const *)a)->string, (*(const cJSON *const *)b)->string);
}

static bool twice(const struct glint_json *object, const cJSON *member)
{
    const struct glint_json at = glint_json_item(object, member, 0);
    return glint_json_fault(&at, "the key appears more than once");
}

// Few members are compared with each other, many are sorted.
#define FEW 8

static void check_few(const struct glint_json *object)
{
    for (const cJSON *m = object->value->child; m; m = m->next)
        for (const cJSON *n = object->value->child; n != m; n = n->next)
            if (strcmp(n->string, m->string) == 0) {
                twice(object, m);
                break;
            }
}

static void check_many(const struct glint_json *object, size_t count)
{
    const cJSON **sorted = malloc(count * sizeof *sorted);
    if (!sorted) {
        glint_fail(object->err, GLINT_E_NOMEM, "", "no memory to compare %zu keys", count);
        return;
    }
    size_t n = 0;
    for (const cJSON *m = object->value->child; m; m = m->next)
        sorted[n++] = m;
    qsort(sorted, count, sizeof *sorted, by_key);
    for (size_t i = 1; i < count; i++)
        if (strcmp(sorted[i - 1]->string, sorted[i]->string) == 0)
            twice(object, sorted[i]);
    free(sorted);
}

static void check_keys(const struct glint_json *at)
{
    const bool object = cJSON_IsObject(at->value);
    if (!object && !cJSON_IsArray(at->value))
        return;
    size_t count = 0;
    for (const cJSON *child = at->value->child; child; child = child->next, count++) {
        const struct glint_json item = glint_json_item(at, child, count);
        check_keys(&item);
    }
    if (object && count <= FEW)
        check_few(at);
    else if (object)
        check_many(at, count);
}

glint_status glint_json_parse(cJSON **out, const char *text, size_t length,
                              const struct glint_json_limits *limits, struct glint_error *err)
{
    assert(out && text && limits);
    *out = NULL;
    struct glint_json_lists lists = {0};
    glint_status status = glint_json_find_lists(text, length, limits, &lists, err);
    cJSON *tree = status ? NULL : glint_json_tree(text, length, &lists);
    glint_json_lists_finish(&lists);
    if (status)
        return status;
    if (!tree)
        return glint_fail(err, GLINT_E_NOMEM, "", "no memory for %zu bytes of JSON", length);
    struct glint_error local = {0};
    const struct glint_json root = glint_json_root(tree, &local);
    check_keys(&root);
    status = local.status;
    for (size_t i = 0; i < local.count; i++)
        glint_fail(err, status, local.fault[i].pointer, "%s", local.fault[i].detail);
    glint_error_finish(&local);
    if (status)
        cJSON_Delete(tree);
    else
        *out = tree;
    return status;
}
