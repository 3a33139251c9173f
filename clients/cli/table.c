#include "table.h"
#include "problem.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define MAX_COLUMNS 16
#define CELL_BYTES 400

static const char nothing[] = "-";

static const cJSON *find(const cJSON *row, const char *member)
{
    char name[64];
    const char *slash = strchr(member, '/');
    snprintf(name, sizeof name, "%.*s", slash ? (int)(slash - member) : 60, member);
    row = cJSON_GetObjectItemCaseSensitive(row, name);
    return slash ? find(row, slash + 1) : row;
}

static void format_bytes(char *cell, double bytes)
{
    static const char *const unit[] = {"B", "KiB", "MiB", "GiB", "TiB"};
    int u = 0;
    for (; bytes >= 1024 && u < 4; u++)
        bytes /= 1024;
    snprintf(cell, CELL_BYTES, u ? "%.1f %s" : "%.0f %s", bytes, unit[u]);
}

static void format_number(char *cell, enum glint_column_kind kind, double value)
{
    if (kind == GLINT_COLUMN_PERCENT)
        snprintf(cell, CELL_BYTES, "%.1f%%", 100 * value);
    else if (kind == GLINT_COLUMN_BYTES)
        format_bytes(cell, value);
    else if (kind == GLINT_COLUMN_SECONDS)
        snprintf(cell, CELL_BYTES, "%.1f s", value);
    else if (kind == GLINT_COLUMN_NUMBER)
        snprintf(cell, CELL_BYTES, "%.4g", value);
    else
        snprintf(cell, CELL_BYTES, "%.15g", value);
}

static void format_cell(char *cell, const struct glint_column *c, const cJSON *row)
{
    const cJSON *item = find(row, c->member);
    if (cJSON_IsString(item) && item->valuestring[0])
        snprintf(cell, c->kind == GLINT_COLUMN_HASH ? 13 : CELL_BYTES, "%s", item->valuestring);
    else if (cJSON_IsBool(item))
        snprintf(cell, CELL_BYTES, "%s", cJSON_IsTrue(item) ? "yes" : "no");
    else if (cJSON_IsNumber(item))
        format_number(cell, c->kind, item->valuedouble);
    else
        strcpy(cell, nothing);
}

// Characters of UTF-8, near enough to columns of a terminal.
static size_t width_of(const char *text)
{
    size_t width = 0;
    for (; *text; text++)
        width += (*text & 0xc0) != 0x80;
    return width;
}

static void print_cell(const char *text, size_t width)
{
    glint_print_plain(stdout, text);
    for (size_t n = width_of(text); n < width; n++)
        putchar(' ');
}

void glint_table_print(const struct glint_column *column, const cJSON *rows)
{
    size_t width[MAX_COLUMNS] = {0}, columns = 0;
    char cell[CELL_BYTES];
    const cJSON *row;
    for (; column[columns].title && columns < MAX_COLUMNS; columns++) {
        width[columns] = strlen(column[columns].title);
        cJSON_ArrayForEach(row, rows) {
            format_cell(cell, &column[columns], row);
            const size_t w = width_of(cell);
            width[columns] = w > width[columns] ? w : width[columns];
        }
    }
    for (size_t i = 0; i < columns; i++)
        print_cell(column[i].title, i + 1 < columns ? width[i] + 2 : 0);
    putchar('\n');
    cJSON_ArrayForEach(row, rows) {
        for (size_t i = 0; i < columns; i++) {
            format_cell(cell, &column[i], row);
            print_cell(cell, i + 1 < columns ? width[i] + 2 : 0);
        }
        putchar('\n');
    }
}

void glint_table_print_one(const struct glint_column *column, const cJSON *object)
{
    char cell[CELL_BYTES];
    for (; column->title; column++) {
        format_cell(cell, column, object);
        if (strcmp(cell, nothing) == 0)
            continue;
        printf("%s: ", column->title);
        glint_print_plain(stdout, cell);
        putchar('\n');
    }
}

void glint_table_print_texts(const char *title, const cJSON *texts)
{
    const cJSON *text;
    cJSON_ArrayForEach(text, texts) {
        const char *name = cJSON_GetStringValue(text);
        if (!name)
            name = cJSON_GetStringValue(cJSON_GetObjectItemCaseSensitive(text, "name"));
        printf("%s: ", title);
        glint_print_plain(stdout, name ? name : "-");
        putchar('\n');
    }
}
