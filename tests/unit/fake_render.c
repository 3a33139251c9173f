#include "fake_render.h"

#include "base/clock.h"
#include "render/hold.h"

#include <math.h>
#include <pthread.h>
#include <stdio.h>
#include <stdlib.h>
#include <unistd.h>

#define MAX_WORKERS 16
#define MAX_SEED 8192
#define MAX_BEGUN 65536

struct glint_worker {
    uint32_t index;
    bool entered;
};

struct glint_devices {
    uint32_t workers;
    struct glint_worker worker[MAX_WORKERS];
};

enum block_state { BLOCK_FREE, BLOCK_TAKEN, BLOCK_RUN, BLOCK_BACK };

struct glint_view {
    struct glint_job job;
};

struct glint_render {
    struct glint_job job;
    uint32_t sample, back; // the pass, its blocks given back
    unsigned char *block;  // [width] enum block_state
    bool interrupted;
    bool sketch, shown; // all blocks of a sketch are back
    unsigned running;   // slices at workers
};

// How the job with a seed behaves.
struct behaviour {
    bool fail_slice, stuck, fail_move, sketch;
    glint_status create_status;
    unsigned create_failures;
    double seconds;
};

static pthread_mutex_t mutex = PTHREAD_MUTEX_INITIALIZER;
static pthread_cond_t changed = PTHREAD_COND_INITIALIZER;
static struct glint_devices devices;
static struct behaviour behaviour[MAX_SEED];
static bool gate_closed, create_held, deaf;
static unsigned let, creates_waiting;
static uint32_t begun[MAX_BEGUN], creates;
static size_t begins;
static int renders, broken, views;
static bool move_held;
static uint32_t moves, restarts;
static float fov;

static void lock(void)
{
    pthread_mutex_lock(&mutex);
}

static void unlock(void)
{
    pthread_cond_broadcast(&changed);
    pthread_mutex_unlock(&mutex);
}

static void must(bool holds, const char *rule)
{
    if (holds)
        return;
    if (broken++ < 5) // one is enough, a thousand drown it
        fprintf(stderr, "# broken: %s\n", rule);
}

glint_devices *fake_devices(uint32_t workers)
{
    devices = (struct glint_devices){.workers = workers};
    for (uint32_t i = 0; i < workers; i++)
        devices.worker[i].index = i;
    return &devices;
}

void fake_reset(void)
{
    lock();
    must(!renders, "a render outlives its test");
    for (size_t i = 0; i < MAX_SEED; i++)
        behaviour[i] = (struct behaviour){0};
    must(!views, "a view outlives its test");
    gate_closed = create_held = move_held = deaf = false;
    moves = restarts = 0;
    let = 0;
    creates = 0;
    begins = 0;
    unlock();
}

void fake_close_gate(void)
{
    lock();
    gate_closed = true;
    unlock();
}

void fake_open_gate(void)
{
    lock();
    gate_closed = false;
    unlock();
}

void fake_deafen(void)
{
    lock();
    deaf = true;
    unlock();
}

void fake_let(unsigned slices)
{
    lock();
    let += slices;
    unlock();
}

void fake_hold_create(bool held)
{
    lock();
    create_held = held;
    unlock();
}

void fake_wait_create(void)
{
    lock();
    while (!creates_waiting)
        pthread_cond_wait(&changed, &mutex);
    unlock();
}

void fake_fail_slice(uint32_t seed)
{
    lock();
    behaviour[seed].fail_slice = true;
    unlock();
}

void fake_fail_create(uint32_t seed, glint_status status, unsigned times)
{
    lock();
    behaviour[seed].create_status = status;
    behaviour[seed].create_failures = times;
    unlock();
}

void fake_fail_move(uint32_t seed)
{
    lock();
    behaviour[seed].fail_move = true;
    unlock();
}

void fake_hold_move(bool held)
{
    lock();
    move_held = held;
    unlock();
}

void fake_wait_moves(uint32_t count)
{
    lock();
    while (moves < count)
        pthread_cond_wait(&changed, &mutex);
    unlock();
}

uint32_t fake_moves(void)
{
    lock();
    const uint32_t count = moves;
    unlock();
    return count;
}

float fake_wait_restarts(uint32_t count)
{
    lock();
    while (restarts < count)
        pthread_cond_wait(&changed, &mutex);
    const float last = fov;
    unlock();
    return last;
}

uint32_t fake_restarts(void)
{
    lock();
    const uint32_t count = restarts;
    unlock();
    return count;
}

int fake_views(void)
{
    lock();
    const int count = views;
    unlock();
    return count;
}

void fake_stick(uint32_t seed)
{
    lock();
    behaviour[seed].stuck = true;
    unlock();
}

void fake_sketch(uint32_t seed)
{
    lock();
    behaviour[seed].sketch = true;
    unlock();
}

void fake_slice_seconds(uint32_t seed, double seconds)
{
    lock();
    behaviour[seed].seconds = seconds;
    unlock();
}

void fake_begun(size_t count, uint32_t *seed)
{
    lock();
    while (begins < count)
        pthread_cond_wait(&changed, &mutex);
    for (size_t i = 0; seed && i < count; i++)
        seed[i] = begun[i];
    unlock();
}

size_t fake_begun_now(void)
{
    lock();
    const size_t count = begins;
    unlock();
    return count;
}

uint32_t fake_creates(void)
{
    lock();
    const uint32_t count = creates;
    unlock();
    return count;
}

void fake_wait_creates(uint32_t count)
{
    lock();
    while (creates < count)
        pthread_cond_wait(&changed, &mutex);
    unlock();
}

int fake_renders(void)
{
    lock();
    const int count = renders;
    unlock();
    return count;
}

int fake_broken(void)
{
    lock();
    const int count = broken;
    unlock();
    return count;
}

uint32_t glint_devices_workers(const glint_devices *d)
{
    return d->workers;
}

glint_worker *glint_devices_worker(glint_devices *d, uint32_t index)
{
    return &d->worker[index];
}

void glint_worker_enter(glint_worker *worker)
{
    worker->entered = true;
}

// With the mutex.
static glint_status create_failure(uint32_t seed)
{
    struct behaviour *b = &behaviour[seed];
    creates++;
    creates_waiting++;
    pthread_cond_broadcast(&changed);
    while (create_held)
        pthread_cond_wait(&changed, &mutex);
    creates_waiting--;
    if (!b->create_failures)
        return GLINT_OK;
    b->create_failures--;
    return b->create_status;
}

enum glint_geometry_kind glint_render_structure(const struct glint_job *job, bool *robust)
{
    (void)job;
    *robust = false;
    return GLINT_GEOMETRY_FLAT;
}

uint64_t glint_render_film_bytes(const struct glint_resident *scene, const struct glint_job *job)
{
    (void)scene;
    return (uint64_t)job->width * job->height;
}

uint64_t glint_render_wave_bytes(const struct glint_resident *scene, const struct glint_job *job,
                                 uint32_t workers)
{
    (void)scene;
    (void)job;
    (void)workers;
    return 0;
}

glint_status glint_render_create(glint_render **out, struct glint_devices *d,
                                 struct glint_resident *scene, const struct glint_pose *pose,
                                 const struct glint_job *job, struct glint_error *err)
{
    (void)d;
    (void)scene;
    (void)pose;
    *out = NULL;
    lock();
    const glint_status failure = create_failure(job->seed);
    renders += !failure;
    unlock();
    if (failure)
        return glint_fail(err, failure, "", "job %u cannot be prepared", job->seed);
    *out = calloc(1, sizeof **out);
    (*out)->job = *job;
    (*out)->block = calloc(job->width, 1);
    return GLINT_OK;
}

glint_status glint_render_sketch(glint_render **out, struct glint_devices *d,
                                 struct glint_resident *scene, const struct glint_pose *pose,
                                 const struct glint_job *job, struct glint_error *err)
{
    const glint_status st = glint_render_create(out, d, scene, pose, job, err);
    if (!st) {
        lock();
        (*out)->sketch = behaviour[job->seed].sketch;
        unlock();
    }
    return st;
}

bool glint_render_is_sketch(const glint_render *r)
{
    lock();
    const bool is = r->sketch;
    unlock();
    return is;
}

void glint_render_destroy(glint_render **render)
{
    if (!*render)
        return;
    lock();
    must((*render)->running == 0, "a render goes while a slice of it runs");
    renders--;
    unlock();
    free((*render)->block);
    free(*render);
    *render = NULL;
}

glint_status glint_render_move(glint_view **out, glint_render *r, struct glint_resident *scene,
                               const struct glint_pose *pose, const struct glint_job *job,
                               struct glint_error *err)
{
    (void)scene;
    (void)pose;
    *out = NULL;
    lock();
    must(r->job.live || r->sketch, "only a live job moves, or a sketch");
    moves++;
    pthread_cond_broadcast(&changed);
    while (move_held)
        pthread_cond_wait(&changed, &mutex);
    const bool fails = behaviour[job->seed].fail_move;
    behaviour[job->seed].fail_move = false;
    views += !fails;
    unlock();
    if (fails)
        return glint_fail(err, GLINT_E_RANGE, "/camera", "job %u cannot move", job->seed);
    *out = calloc(1, sizeof **out);
    (*out)->job = *job;
    return GLINT_OK;
}

void glint_view_release(glint_view **view)
{
    lock();
    views -= *view != NULL;
    unlock();
    free(*view);
    *view = NULL;
}

void glint_render_interrupt(glint_render *r, bool on)
{
    lock();
    r->interrupted = on;
    unlock();
}

bool glint_render_extend(glint_render *r, uint32_t samples, double error)
{
    lock();
    bool begun_more = r->back > 0;
    for (uint32_t i = 0; i < r->job.width; i++)
        begun_more |= r->block[i] != BLOCK_FREE;
    const bool possible = r->sample + begun_more <= samples;
    if (possible) {
        r->job.stop.samples = samples;
        r->job.stop.error = error;
    }
    unlock();
    return possible;
}

void glint_render_restart(glint_render *r, glint_view **view)
{
    lock();
    for (uint32_t i = 0; i < r->job.width; i++) {
        must(r->block[i] == BLOCK_FREE || r->block[i] == BLOCK_BACK,
             "a render starts again while no slice is out");
        r->block[i] = BLOCK_FREE;
    }
    r->sample = r->back = 0;
    r->interrupted = r->sketch = r->shown = false;
    restarts++;
    fov = (*view)->job.camera.yfov;
    unlock();
}

bool glint_render_take(glint_render *r, struct glint_slice *out)
{
    lock();
    uint32_t i = 0;
    while (i < r->job.width && r->block[i] != BLOCK_FREE)
        i++;
    const bool any = i < r->job.width && r->sample < r->job.stop.samples &&
                     !behaviour[r->job.seed].stuck && !r->shown;
    if (any)
        r->block[i] = BLOCK_TAKEN;
    *out = (struct glint_slice){.block = i, .sample = r->sample, .samples = 1};
    unlock();
    return any;
}

static void spin(double seconds)
{
    const double end = glint_now() + seconds;
    while (glint_now() < end) {
    }
}

glint_status glint_render_run(glint_render *r, struct glint_worker *worker,
                              const struct glint_slice *slice, struct glint_error *err)
{
    if (!glint_hold_take(slice->hold))
        return GLINT_E_BUSY;
    lock();
    must(worker->entered, "a worker runs a slice before it has set its arithmetic");
    must(r->block[slice->block] == BLOCK_TAKEN, "a slice is run once, by whom it was given to");
    must(slice->sample == r->sample, "a slice belongs to the pass that is under way");
    r->block[slice->block] = BLOCK_RUN;
    if (begins < MAX_BEGUN)
        begun[begins] = r->job.seed;
    begins++;
    r->running++;
    glint_hold_begin(slice->hold);
    pthread_cond_broadcast(&changed);
    while (gate_closed && !let && (deaf || !r->interrupted))
        pthread_cond_wait(&changed, &mutex);
    if (r->interrupted || !glint_hold_keep(slice->hold)) {
        r->running--;
        unlock();
        return GLINT_E_BUSY;
    }
    let -= gate_closed;
    const double seconds = behaviour[r->job.seed].seconds;
    const bool fails = behaviour[r->job.seed].fail_slice;
    behaviour[r->job.seed].fail_slice = false;
    unlock();
    spin(seconds);
    lock();
    r->running--;
    unlock();
    return fails ? glint_fail(err, GLINT_E_DEVICE, "", "a slice of job %u failed", r->job.seed)
                 : GLINT_OK;
}

void glint_render_give_back(glint_render *r, const struct glint_slice *slice, bool done)
{
    lock();
    const unsigned char state = r->block[slice->block];
    must(done ? state == BLOCK_RUN : state == BLOCK_TAKEN || state == BLOCK_RUN,
         "what is given back was taken, and run if it is done");
    r->block[slice->block] = done ? BLOCK_BACK : BLOCK_FREE;
    r->back += done;
    r->shown = r->sketch && r->back == r->job.width;
    if (r->back == r->job.width && !r->sketch) {
        r->sample++;
        r->back = 0;
        for (uint32_t i = 0; i < r->job.width; i++)
            r->block[i] = BLOCK_FREE;
    }
    unlock();
}

bool glint_render_complete(const glint_render *r)
{
    lock();
    const bool complete = r->sample == r->job.stop.samples;
    unlock();
    return complete;
}

void glint_render_state(const glint_render *r, struct glint_render_state *out)
{
    lock();
    const double all = (double)r->job.width * r->job.stop.samples;
    *out = (struct glint_render_state){
        .samples = r->sample,
        .target_samples = r->job.stop.samples,
        .progress = ((double)r->sample * r->job.width + r->back) / all,
        .estimate = {r->sample < 2 ? NAN : 1 / sqrt(r->sample), NAN, NAN, NAN, NAN, NAN},
        .forecast = GLINT_NO_FORECAST,
        .camera_rays = (uint64_t)r->sample * 100,
        .bounce_rays = 7,
        .shadow_rays = 3};
    unlock();
}

// A film is its numbers between two words.
#define FILM "film 1 %10u %10u %10u end\n"
#define FILM_BYTES 45

glint_status glint_render_film(glint_render *r, int fd, struct glint_error *err)
{
    char text[FILM_BYTES + 1];
    lock();
    snprintf(text, sizeof text, FILM, r->job.seed, r->job.width, r->sample);
    unlock();
    if (write(fd, text, FILM_BYTES) == FILM_BYTES)
        return GLINT_OK;
    return glint_fail(err, GLINT_E_IO, "", "the film cannot be written");
}

static glint_status read_film(int fd, unsigned number[3], struct glint_error *err)
{
    char text[FILM_BYTES + 1] = "";
    unsigned version = 0;
    int end = 0;
    const ssize_t n = read(fd, text, FILM_BYTES);
    const int got =
        sscanf(text, "film %u %u %u %u end%n", &version, &number[0], &number[1], &number[2], &end);
    if (got >= 1 && version > 1)
        return glint_fail(err, GLINT_E_VERSION, "", "the film is of version %u", version);
    if (n != FILM_BYTES || !end)
        return glint_fail(err, GLINT_E_SYNTAX, "", "the film is torn");
    return GLINT_OK;
}

glint_status glint_render_restore(glint_render *r, int fd, struct glint_error *err)
{
    unsigned number[3];
    const glint_status st = read_film(fd, number, err);
    if (st)
        return st;
    if (number[0] != r->job.seed)
        return glint_fail(err, GLINT_E_RANGE, "", "it is the film of job %u", number[0]);
    lock();
    r->sample = number[2];
    unlock();
    return GLINT_OK;
}

glint_status glint_render_open(glint_render **out, int fd, struct glint_error *err)
{
    unsigned number[3];
    *out = NULL;
    const glint_status st = read_film(fd, number, err);
    if (st)
        return st;
    *out = calloc(1, sizeof **out);
    (*out)->job.seed = number[0];
    (*out)->job.width = number[1];
    (*out)->job.stop.samples = (*out)->sample = number[2];
    (*out)->block = calloc(number[1], 1);
    lock();
    renders++;
    unlock();
    return GLINT_OK;
}
