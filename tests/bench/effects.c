// effects - what each row of the effects table costs, CPU time in interleaved pairs: where a picture
// needs it, over the same picture without its cause; where none needs it, forced on over the
// automatic plan; and the automatic plan over another render of it, for the plan of a picture that
// does not need the row is the one without the row: the same program, the same passes, checked here.
//
//     effects [ROW]...    all rows by default; the last line is one JSON object
#include "device/program.h"
#include "tests/bench/waves.h"
#include "tests/render/effect_worlds.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { PAIRS = 11, COLUMNS = 10, ROWS = 6 };

struct bench {
    struct offline o;
    glint_worker *worker;
};

static const uint32_t size[2] = {16 * COLUMNS, 16 * ROWS};

// Scene and job of one render. The render keeps what it needs of both.
static glint_render *make(struct bench *b, const struct effect_world *world,
                          const struct effect_order *order, uint64_t force)
{
    struct glint_error err = {0};
    glint_render *render = NULL;
    char *scene = effect_scene(world), *text = effect_job(order, size, 1024);
    struct glint_posed rest = offline_load_posed_text(&b->o, scene), posed;
    struct glint_job *job = offline_job(text);
    if (glint_posed_for(&posed, b->o.devices, &rest, job, &err) ||
        glint_render_create_forced(&render, b->o.devices, posed.resident, posed.pose, job, force,
                                   &err))
        offline_die("render", &err);
    glint_job_destroy(&job);
    glint_resident_release(&posed.resident);
    glint_resident_release(&rest.resident);
    free(scene);
    free(text);
    return render;
}

// Takes both renders.
static struct bench_ratio compare(struct bench *b, glint_render *first, glint_render *second)
{
    return bench_waves_ratio(b->worker, first, second, COLUMNS, ROWS, PAIRS);
}

static void print_ratio(const char *name, struct bench_ratio r)
{
    printf(",\"%s\":{\"ratio\":%.4f,\"low\":%.4f,\"high\":%.4f}", name, r.median, r.low, r.high);
    fflush(stdout);
}

// Causes that show in a pose alone, compared with the same scene while no shutter is open.
#define MOVING                                                                                \
    "'environment':{'radiance':[1,0.9,0.8]},'nodes':{'n':{}},'animations':{'a':{'channels':{" \
    "'c':{'node':'n','path':'translation','times':[0,1],'values':[0,0,0,1,0,0]}}}},"
static const struct effect_cause moving[] = {
    {"motion",
     {MOVING, "'ior':1", "", "'two':{'mesh':'ball','material':'ball','node':'n'},", 24},
     {"'beauty'", "box", "'shutter':[0,0.5],", 3},
     "motion|constant environment"},
    {"camera motion",
     {MOVING, "'ior':1", ",'node':'n'", "", 24},
     {"'beauty'", "box", "'shutter':[0,0.5],", 3},
     "camera motion|constant environment"},
};

static const struct effect_cause *moving_of(const char *effect)
{
    for (size_t i = 0; i < sizeof moving / sizeof *moving; i++)
        if (!strcmp(moving[i].effect, effect))
            return &moving[i];
    return NULL;
}

static const struct effect_cause *cause_of(const char *effect)
{
    for (size_t i = 0; i < effect_cause_count; i++)
        if (!strcmp(effect_causes[i].effect, effect))
            return &effect_causes[i];
    return NULL;
}

static const struct effect_forcing *forcing_of(const char *effect)
{
    for (size_t i = 0; i < effect_forcing_count; i++)
        if (!strcmp(effect_forcings[i].effect, effect))
            return &effect_forcings[i];
    return NULL;
}

// The automatic plan has the row where it is called for, and nothing of it elsewhere.
static void check_plan(const glint_render *render, const char *effect, bool wanted)
{
    if (!!(render->view->plan.on & effect_bits(effect)) == wanted)
        return;
    fprintf(stderr, "effects: \"%s\" is %s\n", effect, wanted ? "off" : "on");
    exit(1);
}

static void measure_needless(struct bench *b, const struct effect_forcing *f)
{
    const uint64_t rows = effect_bits(f->effect) | effect_bits(f->with);
    glint_render *automatic = make(b, f->world, &effect_beauty, 0);
    check_plan(automatic, f->effect, false);
    glint_render *again = make(b, f->world, &effect_beauty, 0);
    print_ratio("automatic", compare(b, automatic, again));
    automatic = make(b, f->world, &effect_beauty, 0);
    print_ratio("forced", compare(b, automatic, make(b, f->world, &effect_beauty, rows)));
}

static void measure_needed(struct bench *b, const struct effect_cause *c,
                           struct effect_comparison without)
{
    glint_render *base = make(b, without.world, without.order, 0);
    glint_render *with = make(b, &c->world, &c->order, 0);
    check_plan(base, c->effect, false);
    check_plan(with, c->effect, true);
    print_ratio("needed", compare(b, base, with));
    printf(",\"with\":\"%s\"", c->calls);
}

static void measure(struct bench *b, const struct glint_effect *e)
{
    const struct effect_cause *cause = cause_of(e->name), *moves = moving_of(e->name);
    const struct effect_forcing *forcing = forcing_of(e->name);
    fprintf(stderr, "# %s\n", e->name);
    printf("{\"row\":\"%s\"", e->name);
    if (cause)
        measure_needed(b, cause, effect_without(e->name));
    if (moves)
        measure_needed(b, moves,
                       (struct effect_comparison){e->name, &moves->world, &effect_beauty});
    if (forcing)
        measure_needless(b, forcing);
    printf("}");
}

// A setting that leaves out the code of a row, over the picture that does not ask for either.
static const struct {
    const char *of, *name;
    struct effect_cause cause;
} settings[] = {
    {"mattes through glossy lobes",
     "mattes through glossy lobes, alpha 0",
     {"mattes through bounces",
      {"'environment':{'radiance':[1,0.9,0.8]},", "'ior':1", "", "", 24},
      {"'beauty','crypto_object'", "box", "'mattes':{'through':'glossy','alpha':0},", 3},
      "mattes through bounces|ID coverage|constant environment"}},
};

static void measure_settings(struct bench *b, const struct glint_effect *e)
{
    for (size_t i = 0; i < sizeof settings / sizeof *settings; i++) {
        if (strcmp(settings[i].of, e->name) != 0)
            continue;
        printf(",{\"row\":\"%s\"", settings[i].name);
        measure_needed(b, &settings[i].cause, effect_without(e->name));
        printf("}");
    }
}

static int asked(const char *name, int argc, char **argv)
{
    for (int i = 1; i < argc; i++)
        if (!strcmp(argv[i], name))
            return 1;
    return argc == 1;
}

int main(int argc, char **argv)
{
    struct bench b = {0};
    int rows = 0;
    for (int i = 1; i < argc; i++)
        effect_bits(argv[i]); // names that there are
    offline_start(&b.o, 1);
    b.worker = glint_devices_worker(b.o.devices, 0);
    glint_worker_enter(b.worker);
    printf("{\"bench\":\"effects\",\"pairs\":%d,\"rows\":[", PAIRS);
    for (size_t i = 0; i < glint_effect_count; i++)
        if (asked(glint_effect_table[i].name, argc, argv)) {
            fputs(rows++ ? "," : "", stdout);
            measure(&b, &glint_effect_table[i]);
            measure_settings(&b, &glint_effect_table[i]);
        }
    puts("]}");
    offline_finish(&b.o);
    return 0;
}
