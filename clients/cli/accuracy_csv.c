#include "accuracy_csv.h"

#include "accuracy_files.h"
#include "protocol/text.h"

#include <math.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define MAX_COLUMNS 32
#define ROW struct glint_accuracy_row

// Rays are told to the last, other figures to six digits.
enum kind { TEXT, COUNT, RAYS, NUMBER, EMPTY };

struct column {
    const char *name;
    enum kind kind;
    size_t offset, size;
};

#define TEXT_OF(name, member)                                       \
    {                                                               \
        name, TEXT, offsetof(ROW, member), sizeof((ROW *)0)->member \
    }
#define COUNT_OF(name, member)                \
    {                                         \
        name, COUNT, offsetof(ROW, member), 0 \
    }
#define RAYS_OF(name, member)                \
    {                                        \
        name, RAYS, offsetof(ROW, member), 0 \
    }
#define NUMBER_OF(name, member)                \
    {                                          \
        name, NUMBER, offsetof(ROW, member), 0 \
    }

// flip is measured where a perceptual dial exists: there is none yet.
static const struct column columns[] = {
    TEXT_OF("scene", scene),
    TEXT_OF("method", method),
    TEXT_OF("knob", knob),
    TEXT_OF("value", value),
    TEXT_OF("seed", seed),
    COUNT_OF("spp", spp),
    RAYS_OF("rays_camera", rays[0]),
    RAYS_OF("rays_bounce", rays[1]),
    RAYS_OF("rays_shadow", rays[2]),
    NUMBER_OF("cpu_s", cpu),
    NUMBER_OF("wall_s", wall),
    COUNT_OF("threads", threads),
    NUMBER_OF("rmse61", rmse61),
    NUMBER_OF("relmse", relmse),
    NUMBER_OF("relmse_trim", relmse_trim),
    {"flip", EMPTY, 0, 0},
    NUMBER_OF("matte_mae", matte_mae),
    NUMBER_OF("tv", tv),
    NUMBER_OF("bias", bias),
    NUMBER_OF("sd", sd),
    NUMBER_OF("est_error", est_error),
    NUMBER_OF("pred_cost", pred_cost),
    TEXT_OF("ref_id", ref_id),
    TEXT_OF("build", build),
};

static const struct column matte_columns[] = {
    TEXT_OF("knob", knob),      TEXT_OF("value", value),           TEXT_OF("seed", seed),
    COUNT_OF("spp", spp),       NUMBER_OF("matte_max", matte_max), NUMBER_OF("lost", lost),
    NUMBER_OF("within", within)};

#define COUNT_COLUMNS(table) (sizeof(table) / sizeof *(table))

// ---- rows

struct glint_accuracy_row *glint_accuracy_table_add(struct glint_accuracy_table *table)
{
    if (table->rows == table->capacity) {
        const size_t more = table->capacity ? 2 * table->capacity : 256;
        ROW *grown = realloc(table->row, more * sizeof *grown);
        if (!grown)
            return NULL;
        table->row = grown;
        table->capacity = more;
    }
    ROW *row = &table->row[table->rows++];
    *row = (ROW){.rays = {NAN, NAN, NAN}, .cpu = NAN, .wall = NAN};
    row->rmse61 = row->relmse = row->relmse_trim = row->matte_mae = row->tv = NAN;
    row->bias = row->sd = row->est_error = row->pred_cost = NAN;
    row->matte_max = row->lost = row->within = NAN;
    return row;
}

void glint_accuracy_table_finish(struct glint_accuracy_table *table)
{
    free(table->row);
    *table = (struct glint_accuracy_table){0};
}

const struct glint_accuracy_row *glint_accuracy_table_find(const struct glint_accuracy_table *table,
                                                           const char *knob, const char *value,
                                                           const char *seed, unsigned spp)
{
    for (size_t i = 0; i < table->rows; i++) {
        const ROW *r = &table->row[i];
        if (r->spp == spp && !strcmp(r->seed, seed) && !strcmp(r->value, value) &&
            !strcmp(r->knob, knob))
            return r;
    }
    return NULL;
}

void glint_accuracy_table_drop(struct glint_accuracy_table *table,
                               bool (*drop)(void *user, const struct glint_accuracy_row *row),
                               void *user)
{
    size_t kept = 0;
    for (size_t i = 0; i < table->rows; i++)
        if (!drop(user, &table->row[i]))
            table->row[kept++] = table->row[i];
    table->rows = kept;
}

// ---- writing

static void write_cell(struct glint_text *t, const struct column *c, const ROW *row)
{
    const char *at = (const char *)row + c->offset;
    if (c->kind == TEXT)
        glint_text_add(t, at);
    else if (c->kind == COUNT)
        glint_text_print(t, "%u", *(const unsigned *)at);
    else if (c->kind != EMPTY && isfinite(*(const double *)at))
        glint_text_print(t, c->kind == RAYS ? "%.0f" : "%.6g", *(const double *)at);
}

static void write_row(struct glint_text *t, const struct column *c, size_t count, const ROW *row)
{
    for (size_t i = 0; i < count; i++) {
        glint_text_add(t, i ? "," : "");
        if (row)
            write_cell(t, &c[i], row);
        else
            glint_text_add(t, c[i].name);
    }
    glint_text_add(t, "\n");
}

glint_status glint_accuracy_table_write(const struct glint_accuracy_table *table,
                                        const char *folder, struct glint_error *err)
{
    struct glint_text all = {0}, mattes = {0};
    write_row(&all, columns, COUNT_COLUMNS(columns), NULL);
    write_row(&mattes, matte_columns, COUNT_COLUMNS(matte_columns), NULL);
    for (size_t i = 0; i < table->rows; i++) {
        write_row(&all, columns, COUNT_COLUMNS(columns), &table->row[i]);
        if (isfinite(table->row[i].tv))
            write_row(&mattes, matte_columns, COUNT_COLUMNS(matte_columns), &table->row[i]);
    }
    const glint_status st = glint_accuracy_save(folder, "accuracy.csv", &all, err);
    const glint_status also = glint_accuracy_save(folder, "mattes.csv", &mattes, err);
    return st ? st : also;
}

// ---- reading

// Cuts the line at its commas; the number of cells, at most `most`.
static size_t split(char *line, char **cell, size_t most)
{
    size_t n = 0;
    for (char *p = line; p && n < most; n++) {
        cell[n] = p;
        p = strchr(p, ',');
        if (p)
            *p++ = '\0';
    }
    return n;
}

static bool read_cell(const struct column *c, const char *text, ROW *row)
{
    char *at = (char *)row + c->offset, *end;
    if (c->kind == TEXT) {
        const bool fits = strlen(text) < c->size;
        if (fits)
            strcpy(at, text);
        return fits;
    }
    if (c->kind == EMPTY || !*text)
        return c->kind != COUNT;
    const double number = strtod(text, &end);
    if (*end || !isfinite(number) || (c->kind == COUNT && !(number >= 0 && number <= UINT32_MAX)))
        return false;
    if (c->kind == COUNT)
        *(unsigned *)at = (unsigned)number;
    else
        *(double *)at = number;
    return true;
}

static bool is_header(char **cell, size_t cells, const struct column *c, size_t count)
{
    for (size_t i = 0; i < count && cells == count; i++)
        if (strcmp(cell[i], c[i].name) != 0)
            return false;
    return cells == count;
}

static bool read_row(struct glint_accuracy_table *table, char **cell, const struct column *c,
                     size_t count)
{
    ROW *row = glint_accuracy_table_add(table);
    for (size_t i = 0; row && i < count; i++)
        if (!read_cell(&c[i], cell[i], row))
            return false;
    return row;
}

// Number of the line that is wrong, 0: none.
static size_t read_lines(struct glint_accuracy_table *table, char *text, const struct column *c,
                         size_t count)
{
    char *cell[MAX_COLUMNS], *next;
    size_t number = 0;
    for (char *line = text; line && *line; line = next) {
        next = strchr(line, '\n');
        if (next)
            *next++ = '\0';
        const size_t cells = split(line, cell, MAX_COLUMNS);
        const bool fine = number ? cells == count && read_row(table, cell, c, count)
                                 : is_header(cell, cells, c, count);
        number++;
        if (!fine)
            return number;
    }
    return number ? 0 : 1;
}

static glint_status read_file(struct glint_accuracy_table *out, const char *folder,
                              const char *name, const struct column *c, size_t count,
                              struct glint_error *err)
{
    char *text;
    glint_status st = glint_accuracy_load(&text, folder, name, err);
    if (st || !text)
        return st;
    const size_t wrong = read_lines(out, text, c, count);
    if (wrong)
        st = glint_fail(err, GLINT_E_SYNTAX, "", "%s/%s: line %zu is none of this table", folder,
                        name, wrong);
    free(text);
    return st;
}

// The figures of mattes.csv go to the rows that they belong to.
static void join(struct glint_accuracy_table *table, const struct glint_accuracy_table *mattes)
{
    size_t at = 0;
    for (size_t i = 0; i < mattes->rows; i++) {
        const ROW *m = &mattes->row[i];
        for (size_t n = 0; n < table->rows; n++, at = (at + 1) % table->rows) {
            ROW *r = &table->row[at];
            if (r->spp != m->spp || strcmp(r->seed, m->seed) || strcmp(r->value, m->value) ||
                strcmp(r->knob, m->knob))
                continue;
            r->matte_max = m->matte_max;
            r->lost = m->lost;
            r->within = m->within;
            break;
        }
    }
}

glint_status glint_accuracy_table_read(struct glint_accuracy_table *out, const char *folder,
                                       struct glint_error *err)
{
    struct glint_accuracy_table mattes = {0};
    *out = (struct glint_accuracy_table){0};
    glint_status st = read_file(out, folder, "accuracy.csv", columns, COUNT_COLUMNS(columns), err);
    if (!st)
        st = read_file(&mattes, folder, "mattes.csv", matte_columns, COUNT_COLUMNS(matte_columns),
                       err);
    if (!st)
        join(out, &mattes);
    glint_accuracy_table_finish(&mattes);
    if (st)
        glint_accuracy_table_finish(out);
    return st;
}
