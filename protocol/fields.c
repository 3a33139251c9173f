// fields.c - tables of members, read and written.
#include "protocol/fields.h"

#include <assert.h>
#include <string.h>

#define MAX_FIELDS 40

static bool known_only(const struct glint_json *object, const struct glint_field *fields)
{
    const char *names[MAX_FIELDS + 1];
    size_t n = 0;
    for (; fields[n].kind; n++) {
        assert(n < MAX_FIELDS);
        names[n] = fields[n].name;
    }
    names[n] = NULL;
    return glint_json_only(object, names);
}

static bool read_choice(const struct glint_json *at, const struct glint_field *f, void *to)
{
    _Static_assert(sizeof(enum glint_field_kind) == sizeof(int), "enums are as wide as int");
    int choice;
    memcpy(&choice, to, sizeof choice);
    const bool fine = glint_json_choice(at, f->choices, &choice);
    memcpy(to, &choice, sizeof choice);
    return fine;
}

static bool read_count(const struct glint_json *at, const struct glint_field *f, uint32_t *to)
{
    if (!cJSON_IsString(at->value))
        return glint_json_uint(at, (uint32_t)f->low, (uint32_t)f->high, to);
    int choice;
    const bool fine = glint_json_choice(at, f->choices, &choice);
    *to = fine ? 0 : *to;
    return fine;
}

static bool read_field(const struct glint_json *at, const struct glint_field *f,
                       struct glint_arena *arena, void *to)
{
    const float low = (float)f->low, high = (float)f->high;
    switch (f->kind) {
    case GLINT_FIELD_FLOAT:
        return f->count ? glint_json_floats(at, f->count, low, high, to)
                        : glint_json_float(at, low, high, to);
    case GLINT_FIELD_DOUBLE:
        return glint_json_double(at, f->low, f->high, to);
    case GLINT_FIELD_UINT:
        return f->count ? glint_json_uints(at, f->count, (uint32_t)f->low, (uint32_t)f->high, to)
                        : glint_json_uint(at, (uint32_t)f->low, (uint32_t)f->high, to);
    case GLINT_FIELD_COUNT:
        return read_count(at, f, to);
    case GLINT_FIELD_INT:
        return glint_json_int(at, (int32_t)f->low, (int32_t)f->high, to);
    case GLINT_FIELD_BOOL:
        return glint_json_bool(at, to);
    case GLINT_FIELD_CHOICE:
        return read_choice(at, f, to);
    case GLINT_FIELD_STRING:
        return glint_json_string(at, arena, to);
    default:
        return true;
    }
}

bool glint_fields_read_one(const struct glint_json *at, const struct glint_field *f,
                           struct glint_arena *arena, void *record)
{
    return read_field(at, f, arena, (char *)record + f->offset);
}

bool glint_fields_read_listed(const struct glint_json *object, const struct glint_field *fields,
                              struct glint_arena *arena, void *record)
{
    bool fine = true;
    for (const struct glint_field *f = fields; f->kind; f++) {
        const struct glint_json at = glint_json_member(object, f->name);
        fine &= glint_fields_read_one(&at, f, arena, record);
    }
    return fine;
}

bool glint_fields_read(const struct glint_json *object, const struct glint_field *fields,
                       struct glint_arena *arena, void *record)
{
    const bool known = known_only(object, fields);
    return glint_fields_read_listed(object, fields, arena, record) && known;
}

static void write_uints(struct glint_text *t, const uint32_t *value, size_t count)
{
    glint_text_add(t, "[");
    for (size_t i = 0; i < count; i++) {
        glint_text_item(t);
        glint_text_print(t, "%u", value[i]);
    }
    glint_text_add(t, "]");
}

static void write_value(struct glint_text *t, const struct glint_field *f, const void *from)
{
    int choice = 0;
    switch (f->kind) {
    case GLINT_FIELD_FLOAT:
        if (f->count)
            glint_text_floats(t, from, f->count);
        else
            glint_text_float(t, *(const float *)from);
        break;
    case GLINT_FIELD_DOUBLE:
        glint_text_double(t, *(const double *)from);
        break;
    case GLINT_FIELD_UINT:
        if (f->count)
            write_uints(t, from, f->count);
        else
            glint_text_print(t, "%u", *(const uint32_t *)from);
        break;
    case GLINT_FIELD_COUNT:
        if (*(const uint32_t *)from)
            glint_text_print(t, "%u", *(const uint32_t *)from);
        else
            glint_text_string(t, *f->choices);
        break;
    case GLINT_FIELD_INT:
        glint_text_print(t, "%d", *(const int32_t *)from);
        break;
    case GLINT_FIELD_BOOL:
        glint_text_add(t, *(const bool *)from ? "true" : "false");
        break;
    case GLINT_FIELD_CHOICE:
        memcpy(&choice, from, sizeof choice);
        glint_text_string(t, f->choices[choice]);
        break;
    default:
        glint_text_string(t, *(char *const *)from);
        break;
    }
}

void glint_fields_write(struct glint_text *text, const struct glint_field *fields,
                        const void *record)
{
    for (const struct glint_field *f = fields; f->kind; f++) {
        const char *from = (const char *)record + f->offset;
        if (f->kind == GLINT_FIELD_OTHER ||
            (f->kind == GLINT_FIELD_STRING && !*(char *const *)from))
            continue;
        glint_text_key(text, f->name);
        write_value(text, f, from);
    }
}
