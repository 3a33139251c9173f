// table.h - JSON objects as the rows of a table to read.
#ifndef GLINT_CLI_TABLE_H
#define GLINT_CLI_TABLE_H

#include <cjson/cJSON.h>

enum glint_column_kind {
    GLINT_COLUMN_TEXT,    // strings, and numbers and truth values as they are
    GLINT_COLUMN_HASH,    // the first 12 digits
    GLINT_COLUMN_PERCENT, // of 0..1
    GLINT_COLUMN_BYTES,   // 12.3 MiB
    GLINT_COLUMN_SECONDS, // 12.3 s
    GLINT_COLUMN_NUMBER,  // four digits
};

struct glint_column {
    const char *title;  // NULL ends a table
    const char *member; // "a" or "a/b": a in the row, b in that
    enum glint_column_kind kind;
};

// One line for each member of `rows`, an array or an object, under a line of titles; "-" for what
// a row has not.
void glint_table_print(const struct glint_column *column, const cJSON *rows);

// "title: value" for each column that the object has.
void glint_table_print_one(const struct glint_column *column, const cJSON *object);

// "title: text" for each member of an array of texts, or of objects with a "name".
void glint_table_print_texts(const char *title, const cJSON *texts);

#endif
