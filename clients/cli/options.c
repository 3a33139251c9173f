#include "options.h"

#include <assert.h>
#include <errno.h>
#include <getopt.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define MAX_OPTIONS 40
#define HELP_COLUMN 28
#define HELP_WIDTH 79

struct long_options {
    struct option option[MAX_OPTIONS + 1];
    char letters[2 * MAX_OPTIONS + 2];
    const struct glint_option *row[MAX_OPTIONS];
    int count;
};

static void add_table(struct long_options *l, const struct glint_option *table)
{
    for (const struct glint_option *o = table; o->name; o++) {
        assert(l->count < MAX_OPTIONS);
        l->row[l->count] = o;
        l->option[l->count] = (struct option){o->name, o->value ? required_argument : no_argument,
                                              NULL, 256 + l->count};
        l->count++;
        if (!o->letter)
            continue;
        char *end = l->letters + strlen(l->letters);
        *end++ = o->letter;
        if (o->value)
            *end = ':';
    }
}

static const struct glint_option *row_of(const struct long_options *l, int code)
{
    if (code >= 256)
        return l->row[code - 256];
    for (int i = 0; i < l->count; i++)
        if (l->row[i]->letter == code)
            return l->row[i];
    return NULL;
}

static void refuse(char **argv, int code, const struct long_options *l, struct glint_error *err)
{
    const struct glint_option *row = optopt ? row_of(l, optopt) : NULL;
    if (code == ':' && row)
        glint_fail(err, GLINT_E_RANGE, "", "option '--%s' wants %s", row->name, row->value);
    else if (row)
        glint_fail(err, GLINT_E_RANGE, "", "option '--%s' takes no value", row->name);
    else if (optopt)
        glint_fail(err, GLINT_E_RANGE, "", "unknown option '-%c'", optopt);
    else
        glint_fail(err, GLINT_E_RANGE, "", "unknown or ambiguous option '%s'", argv[optind - 1]);
}

glint_status glint_options_parse(struct glint_arguments *out, int argc, char **argv,
                                 struct glint_error *err)
{
    struct long_options l = {.letters = ":"};
    for (size_t i = 0; i < 2; i++)
        add_table(&l, out->table[i]);

    glint_status status = GLINT_OK;
    opterr = 0;
    optind = 0; // glibc: start over, with a fresh permutation
    for (int code; (code = getopt_long(argc, argv, l.letters, l.option, NULL)) != -1;) {
        const struct glint_option *row = row_of(&l, code);
        if (!row) {
            refuse(argv, code, &l, err);
            status = GLINT_E_RANGE;
        } else if (out->given == GLINT_MAX_GIVEN) {
            return glint_fail(err, GLINT_E_RANGE, "", "more than %d options", GLINT_MAX_GIVEN);
        } else {
            out->option[out->given].name = row->name;
            out->option[out->given++].value = optarg;
        }
    }
    out->count = argc - optind;
    out->text = argv + optind;
    return status;
}

// From the help column on, broken between words.
static void print_help(const char *text)
{
    const size_t room = HELP_WIDTH - HELP_COLUMN;
    while (strlen(text) > room) {
        size_t n = room;
        while (n && text[n] != ' ')
            n--;
        if (!n) // a word without end
            break;
        printf("%.*s\n%*s", (int)n, text, HELP_COLUMN, "");
        text += n + 1;
    }
    puts(text);
}

void glint_options_help(const struct glint_option *table)
{
    for (const struct glint_option *o = table; o->name; o++) {
        char left[80];
        snprintf(left, sizeof left, "  %c%c%s --%s%s%s", o->letter ? '-' : ' ',
                 o->letter ? o->letter : ' ', o->letter ? "," : " ", o->name, o->value ? " " : "",
                 o->value ? o->value : "");
        if (strlen(left) > HELP_COLUMN - 2)
            printf("%s\n%*s", left, HELP_COLUMN, "");
        else
            printf("%-*s", HELP_COLUMN, left);
        print_help(o->help);
    }
}

bool glint_options_flag(const struct glint_arguments *a, const char *name)
{
    for (int i = 0; i < a->given; i++)
        if (strcmp(a->option[i].name, name) == 0)
            return true;
    return false;
}

const char *glint_options_text(const struct glint_arguments *a, const char *name)
{
    const char *value = NULL;
    for (int i = 0; i < a->given; i++)
        if (strcmp(a->option[i].name, name) == 0)
            value = a->option[i].value;
    return value;
}

size_t glint_options_all(const struct glint_arguments *a, const char *name, const char **value,
                         size_t capacity)
{
    size_t count = 0;
    for (int i = 0; i < a->given && count < capacity; i++)
        if (strcmp(a->option[i].name, name) == 0)
            value[count++] = a->option[i].value;
    return count;
}

// strtoull takes signs and white space, which no number of ours has.
static bool read_prefix(const char **text, uint64_t *out)
{
    if (**text < '0' || **text > '9')
        return false;
    char *end;
    errno = 0;
    *out = strtoull(*text, &end, 10);
    *text = end;
    return errno == 0;
}

bool glint_read_unsigned(const char *text, uint64_t least, uint64_t most, uint64_t *out)
{
    return read_prefix(&text, out) && !*text && *out >= least && *out <= most;
}

bool glint_read_number(const char *text, double *out)
{
    char *end;
    *out = strtod(text, &end);
    return end != text && !*end && isfinite(*out);
}

bool glint_read_unsigneds(const char *text, char separator, uint32_t *out, size_t count)
{
    for (size_t i = 0; i < count; i++) {
        uint64_t value;
        if (!read_prefix(&text, &value) || value > UINT32_MAX)
            return false;
        out[i] = (uint32_t)value;
        if (i + 1 < count && *text++ != separator)
            return false;
    }
    return !*text;
}
