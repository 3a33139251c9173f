// fields.h - the members of a JSON object that are plain fields of a struct, as a table.
//
// One table reads them, refuses what it does not list and writes them back in its order.
//
// Thread-safety: reentrant.
#ifndef GLINT_PROTOCOL_FIELDS_H
#define GLINT_PROTOCOL_FIELDS_H

#include "json.h"
#include "text.h"

enum glint_field_kind {
    GLINT_FIELD_END,
    GLINT_FIELD_FLOAT,  // float, or an array of `count` where that is not 0
    GLINT_FIELD_DOUBLE, // double
    GLINT_FIELD_UINT,   // uint32_t, likewise
    GLINT_FIELD_COUNT,  // uint32_t, 0 by the only one of `choices`
    GLINT_FIELD_INT,    // int32_t
    GLINT_FIELD_BOOL,   // bool
    GLINT_FIELD_CHOICE, // an enum that counts from 0
    GLINT_FIELD_STRING, // char * in the arena; NULL is not written
    GLINT_FIELD_OTHER,  // known, but read and written by the caller
};

struct glint_field {
    const char *name;
    enum glint_field_kind kind;
    size_t offset;
    size_t count;
    double low, high;           // of numbers, both allowed
    const char *const *choices; // NULL-terminated
};

// For tables: GLINT_FIELD(FLOAT, struct x, member, .high = 1).
#define GLINT_FIELD(KIND, TYPE, MEMBER, ...)                                                       \
    {                                                                                              \
        .name = #MEMBER, .kind = GLINT_FIELD_##KIND, .offset = offsetof(TYPE, MEMBER), __VA_ARGS__ \
    }
#define GLINT_FIELD_KNOWN(NAME)                 \
    {                                           \
        .name = NAME, .kind = GLINT_FIELD_OTHER \
    }

// Faults for unknown members and for values out of range; absent members leave `record` as it was.
bool glint_fields_read(const struct glint_json *object, const struct glint_field *fields,
                       struct glint_arena *arena, void *record);

// The same where others look for unknown members.
bool glint_fields_read_listed(const struct glint_json *object, const struct glint_field *fields,
                              struct glint_arena *arena, void *record);

// A member that was found already.
bool glint_fields_read_one(const struct glint_json *at, const struct glint_field *field,
                           struct glint_arena *arena, void *record);

// The members in the order of the table, without braces.
void glint_fields_write(struct glint_text *text, const struct glint_field *fields,
                        const void *record);

#endif
