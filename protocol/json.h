// json.h - strict reading of JSON that somebody else wrote.
//
// Stricter than the library underneath: the text must be RFC 8259 to the letter and UTF-8, without
// U+0000 and without anything after the value; a key may appear once; limits hold before memory is
// spent. Every reader appends a fault with the JSON pointer of the value and goes on, so that one
// pass names everything that is wrong.
//
// Thread-safety: reentrant.
#ifndef GLINT_PROTOCOL_JSON_H
#define GLINT_PROTOCOL_JSON_H

#include "arena.h"
#include "status.h"

#include <cjson/cJSON.h>
#include <stdbool.h>
#include <stdint.h>

#define GLINT_MAX_NAME 4096u // bytes of an id, a name or a key

struct glint_json_limits {
    size_t bytes;
    size_t depth;  // of arrays and objects in each other, at most 64
    size_t values; // of all kinds; each costs about 80 bytes while it is read
    // NULL-terminated keys whose arrays of numbers the tree keeps as their text (json_lists.h), or
    // NULL. Only what this header has for arrays of numbers reads them.
    const char *const *lists;
};

// For requests: 1 MiB, 16 deep, 20000 values.
extern const struct glint_json_limits glint_json_request;

// Reads a whole text; *out is freed by cJSON_Delete().
//   GLINT_E_SYNTAX     not JSON; says line and column
//   GLINT_E_RANGE      a key appears twice; at its pointer. U+0000 in a string; says where
//   GLINT_E_TOO_LARGE  a limit
glint_status glint_json_parse(cJSON **out, const char *text, size_t length,
                              const struct glint_json_limits *limits, struct glint_error *err);

// The grammar and the limits alone.
glint_status glint_json_check(const char *text, size_t length,
                              const struct glint_json_limits *limits, struct glint_error *err);

// A value and the way to it. Lives on the stack and points at its parent there.
struct glint_json {
    const cJSON *value;              // NULL: absent
    const struct glint_json *parent; // NULL: the root
    const char *key;                 // NULL: the element `index` of an array
    size_t index;
    struct glint_error *err; // takes the faults
};

struct glint_json glint_json_root(const cJSON *value, struct glint_error *err);
// Absent when `object` is no object or has no such member.
struct glint_json glint_json_member(const struct glint_json *object, const char *key);
// For walks along cJSON's child list.
struct glint_json glint_json_item(const struct glint_json *parent, const cJSON *child,
                                  size_t index);

// Appends a GLINT_E_RANGE fault at the value; returns false.
bool glint_json_fault(const struct glint_json *at, const char *format, ...)
    __attribute__((format(printf, 2, 3)));
// Appends a fault if the value is absent, unless its parent is no object: that is another fault.
bool glint_json_require(const struct glint_json *at);

// Appends a fault for each member that is not in the NULL-terminated list, and one if the value is
// no object. An absent value passes.
bool glint_json_only(const struct glint_json *at, const char *const *known);

// Each leaves *out as it was when the value is absent, or when it is at fault (false).
// A bound belongs to the range. Text is copied into `arena`.
bool glint_json_bool(const struct glint_json *at, bool *out);
bool glint_json_double(const struct glint_json *at, double low, double high, double *out);
bool glint_json_float(const struct glint_json *at, float low, float high, float *out);
bool glint_json_uint(const struct glint_json *at, uint32_t low, uint32_t high, uint32_t *out);
bool glint_json_int(const struct glint_json *at, int32_t low, int32_t high, int32_t *out);
bool glint_json_string(const struct glint_json *at, struct glint_arena *arena, char **out);
// *out: index in the NULL-terminated list of names.
bool glint_json_choice(const struct glint_json *at, const char *const *names, int *out);
// Arrays of exactly `count` numbers.
bool glint_json_floats(const struct glint_json *at, size_t count, float low, float high,
                       float *out);
bool glint_json_uints(const struct glint_json *at, size_t count, uint32_t low, uint32_t high,
                      uint32_t *out);
// The same of an array whose length is known: out has as many.
bool glint_json_all_floats(const struct glint_json *at, float low, float high, float *out);
bool glint_json_all_uints(const struct glint_json *at, uint32_t low, uint32_t high, uint32_t *out);
// Number of elements; a fault if it is no array. Absent: 0.
bool glint_json_length(const struct glint_json *at, size_t *out);

#endif
