#include "jobs/checkpoint_parts.h"

#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>

bool glint_checkpoints_say(struct glint_checkpoints *c, char **at, const char *format, ...)
{
    char *text = NULL;
    va_list args;
    va_start(args, format);
    if (format && vasprintf(&text, format, args) < 0)
        text = NULL;
    va_end(args);
    pthread_mutex_lock(&c->table->mutex);
    char *old = *at;
    *at = text;
    pthread_mutex_unlock(&c->table->mutex);
    const bool said = old != NULL;
    free(old);
    return said;
}

struct glint_checkpoint_file glint_checkpoints_file(const struct glint_checkpoints *c,
                                                    const struct glint_entry *e, uint64_t number)
{
    return (struct glint_checkpoint_file){c->folder, e->id, number};
}

struct glint_entry **glint_checkpoints_hold(struct glint_checkpoints *c, size_t *count)
{
    struct glint_job_table *table = c->table;
    pthread_mutex_lock(&table->mutex);
    *count = table->count;
    struct glint_entry **all = malloc((table->count + 1) * sizeof *all);
    for (size_t i = 0; all && i < table->count; i++)
        all[i] = glint_entry_retain(table->entry[i]);
    pthread_mutex_unlock(&table->mutex);
    if (!all)
        *count = 0;
    return all;
}
