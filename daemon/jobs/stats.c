// stats.c - numbers about all jobs and workers.
#include "jobs/table.h"

#include "base/clock.h"

// With the mutex.
static void count(const struct glint_job_table *table, struct glint_jobs_stats *out)
{
    for (size_t i = 0; i < table->count; i++) {
        const struct glint_entry *e = table->entry[i];
        out->by_state[e->state]++;
        if (e->state == GLINT_JOB_QUEUED)
            out->by_wait[e->wait]++;
        if (e->render)
            *(glint_state_ended(e->state) ? &out->ended_film_bytes : &out->film_bytes) +=
                e->need.film;
    }
}

void glint_job_table_stats(struct glint_job_table *table, struct glint_jobs_stats *out)
{
    *out = (struct glint_jobs_stats){0};
    pthread_mutex_lock(&table->mutex);
    count(table, out);
    out->submitted = table->submitted;
    out->slices = table->slices;
    out->started = table->started;
    out->wait_seconds = table->wait_seconds;
    out->worker_busy_seconds = table->busy_seconds;
    out->limits = table->limits;
    pthread_mutex_unlock(&table->mutex);
}

uint32_t glint_job_table_workers(struct glint_job_table *table, struct glint_worker_use *out,
                                 uint32_t capacity)
{
    const double now = glint_now();
    pthread_mutex_lock(&table->mutex);
    for (uint32_t w = 0; w < table->workers && w < capacity; w++)
        out[w] = glint_use_look(&table->worker[w], now);
    pthread_mutex_unlock(&table->mutex);
    return table->workers;
}
