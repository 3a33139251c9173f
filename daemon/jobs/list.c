// list.c - GET /v1/jobs: which jobs are shown, and from which on.
#include "jobs/describe.h"

#include <stdlib.h>
#include <string.h>

struct page {
    struct glint_entry **entry; // retained
    size_t count;
    bool more; // the limit has cut the list
};

static bool chosen(const struct glint_entry *e, const struct glint_jobs_filter *filter)
{
    return (!filter->states || filter->states >> e->state & 1) &&
           (!filter->client || !strcmp(filter->client, e->client));
}

// With the mutex. The index behind the job `after`, SIZE_MAX: there is no such job.
static size_t start_of(const struct glint_job_table *table, const char *after)
{
    if (!after)
        return 0;
    for (size_t i = 0; i < table->count; i++)
        if (!strcmp(table->entry[i]->id, after))
            return i + 1;
    return SIZE_MAX;
}

// With the mutex.
static void fill(struct page *page, const struct glint_job_table *table, size_t start,
                 const struct glint_jobs_filter *filter)
{
    for (size_t i = start; i < table->count; i++) {
        if (!chosen(table->entry[i], filter))
            continue;
        page->more = filter->limit && page->count == filter->limit;
        if (page->more)
            return;
        page->entry[page->count++] = glint_entry_retain(table->entry[i]);
    }
}

static glint_status hold(struct page *page, struct glint_job_table *table,
                         const struct glint_jobs_filter *filter, struct glint_error *err)
{
    pthread_mutex_lock(&table->mutex);
    const size_t start = start_of(table, filter->after);
    page->entry = malloc((table->count + 1) * sizeof *page->entry);
    if (page->entry)
        fill(page, table, start, filter);
    pthread_mutex_unlock(&table->mutex);
    if (!page->entry)
        return glint_fail(err, GLINT_E_NOMEM, "", "no memory for a list of jobs");
    if (start != SIZE_MAX)
        return GLINT_OK;
    free(page->entry);
    return glint_fail(err, GLINT_E_RANGE, "", "after: there is no job \"%.64s\"", filter->after);
}

cJSON *glint_entries_describe(struct glint_job_table *table, const struct glint_jobs_filter *filter,
                              struct glint_error *err)
{
    static const struct glint_jobs_filter all;
    struct page page = {0};
    if (hold(&page, table, filter ? filter : &all, err))
        return NULL;
    cJSON *object = cJSON_CreateObject();
    cJSON *list = cJSON_AddArrayToObject(object, "jobs");
    if (page.more)
        cJSON_AddStringToObject(object, "next", page.entry[page.count - 1]->id);
    else
        cJSON_AddNullToObject(object, "next");
    for (size_t i = 0; i < page.count; i++) {
        cJSON_AddItemToArray(list, glint_entry_describe(table, page.entry[i]));
        glint_entry_release(&page.entry[i]);
    }
    free(page.entry);
    return object;
}
