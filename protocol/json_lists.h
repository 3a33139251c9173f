// json_lists.h - arrays of numbers that a tree keeps as their text.
//
// As values of the library, the numbers of a mesh would be as many blocks of memory. An array of
// numbers alone, under one of the keys of glint_json_limits, is one value of type cJSON_Raw
// instead, which the library prints, copies and frees like any other; `valuedouble` is how many there
// are. Its text has passed glint_json_check(). The readers of json.h take it as they take an array.
//
// Thread-safety: reentrant.
#ifndef GLINT_PROTOCOL_JSON_LISTS_H
#define GLINT_PROTOCOL_JSON_LISTS_H

#include "json.h"

// Where such arrays are in a text. Zero-initialise before use.
struct glint_json_lists {
    struct glint_json_list {
        size_t begin, end; // bytes of the text from [ to behind ]
        size_t array;      // how many arrays of the text begin before it
        size_t numbers;    // at least 1
    } * list;              // owned, in the order of the text
    size_t count, capacity;
};

// False without memory.
bool glint_json_lists_add(struct glint_json_lists *lists, const struct glint_json_list *list);
void glint_json_lists_finish(struct glint_json_lists *lists);

// glint_json_check(), which adds the lists; a lack of memory for them is GLINT_E_NOMEM.
glint_status glint_json_find_lists(const char *text, size_t length,
                                   const struct glint_json_limits *limits,
                                   struct glint_json_lists *lists, struct glint_error *err);

// The tree of a text that has been checked, freed by cJSON_Delete(); NULL without memory.
cJSON *glint_json_tree(const char *text, size_t length, const struct glint_json_lists *lists);

// The elements of an array, or the numbers of a list, each the double that strtod() gives.
struct glint_json_walk {
    const cJSON *child; // the next of an array
    const char *text;   // the next of a list, NULL: an array
    cJSON number;       // the last of a list
};
struct glint_json_walk glint_json_walk(const cJSON *value);
// The next element, which lives until the next call; NULL: there is none.
const cJSON *glint_json_next(struct glint_json_walk *walk);

#endif
