// source.c - puts the embedded files together into one text that needs no include path.
#include "device/program.h"

#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define MAX_SOURCES 128

struct expansion {
    const struct glint_source *table;
    bool seen[MAX_SOURCES];
    FILE *out;
    struct glint_error *err;
};

static const char directive[] = "#include \"kernels/";

static glint_status expand_file(struct expansion *e, size_t index);

// `name` runs to the closing quote.
static glint_status expand_include(struct expansion *e, const char *name, size_t length)
{
    for (size_t i = 0; e->table[i].name; i++)
        if (strlen(e->table[i].name) == length && !memcmp(e->table[i].name, name, length))
            return e->seen[i] ? GLINT_OK : expand_file(e, i);
    return glint_fail(e->err, GLINT_E_INTERNAL, "", "kernel source \"%.*s\" is not embedded",
                      (int)length, name);
}

static glint_status expand_line(struct expansion *e, const char *line, size_t length)
{
    const size_t prefix = sizeof directive - 1;
    if (length <= prefix || memcmp(line, directive, prefix)) {
        fwrite(line, 1, length, e->out);
        return GLINT_OK;
    }
    const char *name = strchr(directive, '"') - directive + 1 + line;
    const char *quote = memchr(name, '"', length - (size_t)(name - line));
    return expand_include(e, name, quote ? (size_t)(quote - name) : 0);
}

static glint_status expand_file(struct expansion *e, size_t index)
{
    const struct glint_source *s = &e->table[index];
    const char *line = s->text, *end = s->text + s->length;
    e->seen[index] = true;
    fprintf(e->out, "#line 1 \"%s\"\n", s->name);
    for (unsigned number = 1; line < end; number++) {
        const char *newline = memchr(line, '\n', (size_t)(end - line));
        const size_t length = newline ? (size_t)(newline - line) : (size_t)(end - line);
        const long before = ftell(e->out);
        glint_status st = expand_line(e, line, length);
        if (st)
            return st;
        const bool included = ftell(e->out) != before + (long)length;
        fputc('\n', e->out);
        if (included)
            fprintf(e->out, "#line %u \"%s\"\n", number + 1, s->name);
        line += length + 1;
    }
    return GLINT_OK;
}

static bool is_entry(const char *name)
{
    const size_t length = strlen(name);
    return length > 3 && !strcmp(name + length - 3, ".cl");
}

glint_status glint_source_expand(char **out, const struct glint_source *table,
                                 struct glint_error *err)
{
    size_t size;
    *out = NULL;
    struct expansion e = {.table = table, .err = err, .out = open_memstream(out, &size)};
    if (!e.out)
        return glint_fail(err, GLINT_E_NOMEM, "", "no memory for kernel sources");
    fputs("#pragma OPENCL FP_CONTRACT OFF\n", e.out);
    glint_status st = GLINT_OK;
    for (size_t i = 0; !st && table[i].name; i++)
        if (i >= MAX_SOURCES)
            st = glint_fail(err, GLINT_E_INTERNAL, "", "over %d kernel sources", MAX_SOURCES);
        else if (is_entry(table[i].name) && !e.seen[i])
            st = expand_file(&e, i);
    if (fclose(e.out) && !st)
        st = glint_fail(err, GLINT_E_NOMEM, "", "no memory for kernel sources");
    if (st) {
        free(*out);
        *out = NULL;
    }
    return st;
}
