// options.h - GNU long options of one command: a table that is parsed and printed as help.
//
// Thread-safety: one thread; parsing uses getopt_long.
#ifndef GLINT_CLI_OPTIONS_H
#define GLINT_CLI_OPTIONS_H

#include "protocol/status.h"

#include <stdbool.h>
#include <stdint.h>

struct glint_option {
    const char *name;  // without the dashes; NULL ends a table
    char letter;       // short form, or 0
    const char *value; // what the help calls its value, NULL for a flag
    const char *help;
};

#define GLINT_MAX_GIVEN 64

// The command line of one command. Texts borrow argv.
struct glint_arguments {
    const struct glint_option *table[2]; // the command's, and those that all commands have
    int count;                           // arguments that are no options
    char **text;
    int given;
    struct {
        const char *name, *value;
    } option[GLINT_MAX_GIVEN]; // in the order given
};

// Reads argv[1..]. Both tables are set by the caller; the rest is filled in.
// GLINT_E_RANGE: unknown, ambiguous or incomplete options, each a fault.
glint_status glint_options_parse(struct glint_arguments *out, int argc, char **argv,
                                 struct glint_error *err);

void glint_options_help(const struct glint_option *table);

bool glint_options_flag(const struct glint_arguments *a, const char *name);

// The last value given, or NULL.
const char *glint_options_text(const struct glint_arguments *a, const char *name);

// Every value given; returns their number, at most `capacity`.
size_t glint_options_all(const struct glint_arguments *a, const char *name, const char **value,
                         size_t capacity);

// Numbers as text. False where `text` is anything else, or out of the range.
bool glint_read_unsigned(const char *text, uint64_t least, uint64_t most, uint64_t *out);
bool glint_read_number(const char *text, double *out); // finite

// `count` unsigned numbers with `separator` between them.
bool glint_read_unsigneds(const char *text, char separator, uint32_t *out, size_t count);

#endif
