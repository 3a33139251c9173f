// cmd_top.c - top: jobs, workers and memory of a daemon, over and over.
#include "command.h"
#include "house.h"
#include "interrupt.h"
#include "screen.h"
#include "table.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#define DEFAULT_DELAY 2.0
#define FIRST_DELAY 0.5 // before the first table, which tells what happened meanwhile
#define HEAD_LINES 7    // and the line of titles

static const struct glint_column row[] = {
    {"JOB", "id", GLINT_COLUMN_TEXT},
    {"CLIENT", "client", GLINT_COLUMN_TEXT},
    {"PRI", "priority", GLINT_COLUMN_TEXT},
    {"STATE", "state", GLINT_COLUMN_TEXT},
    {"WORKERS", "workers", GLINT_COLUMN_NUMBER},
    {"DONE", "progress", GLINT_COLUMN_PERCENT},
    {"SAMPLES", "samples", GLINT_COLUMN_TEXT},
    {"ERROR", "error", GLINT_COLUMN_NUMBER},
    {"TIME", "seconds", GLINT_COLUMN_SECONDS},
    {"LEFT", "eta_seconds", GLINT_COLUMN_SECONDS},
    {"SCENE", "scene", GLINT_COLUMN_TEXT},
    {"NAME", "name", GLINT_COLUMN_TEXT},
    {0},
};

static const char *const states[] = {"rendering", "queued", "paused",
                                     "failed",    "done",   "cancelled"};
#define STATES (sizeof states / sizeof *states)

static bool is_in(const cJSON *job, const char *state)
{
    const char *text = cJSON_GetStringValue(cJSON_GetObjectItemCaseSensitive(job, "state"));
    return text && strcmp(text, state) == 0;
}

// Those at work first, in each state the youngest; at most `most`. The list refers to `jobs`.
static cJSON *choose(const cJSON *jobs, int most)
{
    cJSON *list = cJSON_CreateArray();
    const int count = cJSON_GetArraySize(jobs);
    const cJSON **all = calloc((size_t)count + 1, sizeof *all), *job;
    int n = 0, chosen = 0;
    cJSON_ArrayForEach(job, jobs)
        if (all)
            all[n++] = job;
    for (size_t s = 0; s < STATES; s++)
        for (int i = n; i-- > 0 && chosen < most;)
            if (is_in(all[i], states[s])) {
                cJSON_AddItemReferenceToArray(list, (cJSON *)(uintptr_t)all[i]);
                chosen++;
            }
    free(all);
    return list;
}

static const cJSON *jobs_of(const struct glint_house *house)
{
    return cJSON_GetObjectItemCaseSensitive(house->jobs, "jobs");
}

static void print_count(const cJSON *counts, const char *name, const char *before)
{
    const cJSON *count = cJSON_GetObjectItemCaseSensitive(counts, name);
    printf("%s%.0f %s", before, cJSON_IsNumber(count) ? count->valuedouble : 0, name);
}

static const struct glint_column memory[] = {
    {"RESIDENT", "resident_bytes", GLINT_COLUMN_BYTES},
    {"SCENES", "scene_bytes", GLINT_COLUMN_BYTES},
    {"FILMS", "film_bytes", GLINT_COLUMN_BYTES},
    {"OF ENDED JOBS", "ended_film_bytes", GLINT_COLUMN_BYTES},
    {"LIMIT", "limit_bytes", GLINT_COLUMN_BYTES},
    {0},
};

static void print_head(const struct glint_session *s, const struct glint_house *now)
{
    const cJSON *counts = cJSON_GetObjectItemCaseSensitive(now->stats, "jobs");
    const cJSON *workers = cJSON_GetObjectItemCaseSensitive(now->stats, "workers");
    printf("%s: %.1f of %d workers at work; jobs:", glint_client_url(s->client),
           glint_house_busy(now), cJSON_GetArraySize(workers));
    for (size_t i = 0; i < STATES; i++)
        print_count(counts, states[i], i ? ", " : " ");
    fputs("\n\n", stdout);
    cJSON *rows = cJSON_CreateArray();
    cJSON_AddItemReferenceToArray(rows, cJSON_GetObjectItemCaseSensitive(now->stats, "memory"));
    glint_table_print(memory, rows);
    cJSON_Delete(rows);
    putchar('\n');
}

static void print_house(const struct glint_session *s, const struct glint_house *now, int most)
{
    cJSON *list = choose(jobs_of(now), most);
    print_head(s, now);
    glint_table_print(row, list);
    cJSON_Delete(list);
}

static void print_document(const struct glint_house *now)
{
    cJSON *document = cJSON_CreateObject();
    cJSON_AddItemToObject(document, "stats", cJSON_Duplicate(now->stats, true));
    cJSON_AddItemToObject(document, "jobs", cJSON_Duplicate(jobs_of(now), true));
    glint_session_print(document);
}

// How often and how many times: of a terminal until somebody wants no more, elsewhere once.
struct pace {
    double delay;
    uint64_t times; // 0: without an end
    bool screen;
};

static glint_status read_pace(struct pace *out, struct glint_session *s,
                              const struct glint_arguments *a, struct glint_error *err)
{
    const char *delay = glint_options_text(a, "delay"), *times = glint_options_text(a, "times");
    *out = (struct pace){.delay = DEFAULT_DELAY, .screen = !s->json && isatty(STDOUT_FILENO)};
    out->times = out->screen ? 0 : 1;
    glint_status status = GLINT_OK;
    if (delay && (!glint_read_number(delay, &out->delay) || out->delay < 0.1 || out->delay > 3600))
        status = glint_session_usage(s, err, "--delay wants 0.1 to 3600 seconds, not '%s'", delay);
    if (times && !glint_read_unsigned(times, 1, UINT32_MAX, &out->times))
        status =
            glint_session_usage(s, err, "--times wants a whole number from 1 on, not '%s'", times);
    if (times && s->json)
        status = glint_session_usage(s, err, "--json prints one document: it goes without --times");
    return status;
}

static void show(const struct glint_session *s, const struct pace *p, struct glint_screen *screen,
                 struct glint_house *before, struct glint_house *now)
{
    glint_house_compare(before, now);
    if (s->json) {
        print_document(now);
        return;
    }
    if (p->screen)
        glint_screen_clear(screen);
    print_house(s, now, p->screen ? glint_screen_lines() - HEAD_LINES : INT32_MAX);
    fflush(stdout);
}

static glint_status watch(struct glint_session *s, const struct pace *p,
                          struct glint_screen *screen, struct glint_error *err)
{
    struct glint_house before, now;
    glint_status status = glint_house_look(s, &before, err);
    bool ends = !status && glint_screen_wait(screen, FIRST_DELAY);
    for (uint64_t n = 1; !status && !ends; n++) {
        status = glint_interrupt_pending() ? glint_fail(err, GLINT_E_BUSY, "", "interrupted")
                                           : glint_house_look(s, &now, err);
        if (status)
            break;
        show(s, p, screen, &before, &now);
        glint_house_finish(&before);
        before = now;
        ends = n == p->times || glint_screen_wait(screen, p->delay);
        if (!p->screen && !ends)
            putchar('\n');
    }
    glint_house_finish(&before);
    return status;
}

static glint_status run_top(struct glint_session *s, const struct glint_arguments *a,
                            struct glint_error *err)
{
    struct pace pace;
    struct glint_screen screen = {0};
    glint_status status = read_pace(&pace, s, a, err);
    if (!status)
        status = glint_session_open(s, a, false, err);
    if (status)
        return status;
    if (pace.screen)
        glint_screen_open(&screen);
    status = watch(s, &pace, &screen, err);
    glint_screen_close(&screen);
    return status;
}

static const struct glint_option options[] = {
    {"delay", 'd', "SECONDS", "between two looks (2)"},
    {"times", 'n', "N",
     "look N times, then end; by default without an end on a terminal, once "
     "elsewhere"},
    {0},
};

const struct glint_command glint_command_top = {
    .name = "top",
    .operands = "",
    .summary = "Show the jobs, workers and memory of a daemon",
    .detail = "On a terminal it is drawn anew until q is typed. WORKERS is how many worked on\n"
              "a job since the last look.",
    .options = options,
    .run = run_top,
};
