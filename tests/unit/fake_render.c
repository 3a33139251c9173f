#include "fake_state.h"

#include "base/clock.h"
#include "render/hold.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <unistd.h>

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
    struct behaviour *b = &fake.behaviour[seed];
    fake.creates++;
    fake.creates_waiting++;
    pthread_cond_broadcast(&fake.changed);
    while (fake.create_held)
        pthread_cond_wait(&fake.changed, &fake.mutex);
    fake.creates_waiting--;
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
    fake_lock();
    const glint_status failure = create_failure(job->seed);
    fake.renders += !failure;
    fake_unlock();
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
        fake_lock();
        (*out)->sketch = fake.behaviour[job->seed].sketch;
        fake_unlock();
    }
    return st;
}

bool glint_render_is_sketch(const glint_render *r)
{
    fake_lock();
    const bool is = r->sketch;
    fake_unlock();
    return is;
}

void glint_render_destroy(glint_render **render)
{
    if (!*render)
        return;
    fake_lock();
    fake_must((*render)->running == 0, "a render goes while a slice of it runs");
    fake.renders--;
    fake_unlock();
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
    fake_lock();
    fake_must(r->job.live || r->sketch, "only a live job moves, or a sketch");
    fake.moves++;
    pthread_cond_broadcast(&fake.changed);
    while (fake.move_held)
        pthread_cond_wait(&fake.changed, &fake.mutex);
    const bool fails = fake.behaviour[job->seed].fail_move;
    fake.behaviour[job->seed].fail_move = false;
    fake.views += !fails;
    fake_unlock();
    if (fails)
        return glint_fail(err, GLINT_E_RANGE, "/camera", "job %u cannot move", job->seed);
    *out = calloc(1, sizeof **out);
    (*out)->job = *job;
    return GLINT_OK;
}

void glint_view_release(glint_view **view)
{
    fake_lock();
    fake.views -= *view != NULL;
    fake_unlock();
    free(*view);
    *view = NULL;
}

void glint_render_interrupt(glint_render *r, bool on)
{
    fake_lock();
    r->interrupted = on;
    fake_unlock();
}

bool glint_render_extend(glint_render *r, uint32_t samples, double error)
{
    fake_lock();
    bool begun_more = r->back > 0;
    for (uint32_t i = 0; i < r->job.width; i++)
        begun_more |= r->block[i] != BLOCK_FREE;
    const bool possible = r->sample + begun_more <= samples;
    if (possible) {
        r->job.stop.samples = samples;
        r->job.stop.error = error;
    }
    fake_unlock();
    return possible;
}

void glint_render_restart(glint_render *r, glint_view **view)
{
    fake_lock();
    for (uint32_t i = 0; i < r->job.width; i++) {
        fake_must(r->block[i] == BLOCK_FREE || r->block[i] == BLOCK_BACK,
                  "a render starts again while no slice is out");
        r->block[i] = BLOCK_FREE;
    }
    r->sample = r->back = 0;
    r->interrupted = r->sketch = r->shown = false;
    fake.restarts++;
    fake.fov = (*view)->job.camera.yfov;
    fake_unlock();
}

bool glint_render_take(glint_render *r, struct glint_slice *out)
{
    fake_lock();
    uint32_t i = 0;
    while (i < r->job.width && r->block[i] != BLOCK_FREE)
        i++;
    const bool any = i < r->job.width && r->sample < r->job.stop.samples &&
                     !fake.behaviour[r->job.seed].stuck && !r->shown;
    if (any)
        r->block[i] = BLOCK_TAKEN;
    *out = (struct glint_slice){.block = i, .sample = r->sample, .samples = 1};
    fake_unlock();
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
    fake_lock();
    fake_must(worker->entered, "a worker runs a slice before it has set its arithmetic");
    fake_must(r->block[slice->block] == BLOCK_TAKEN,
              "a slice is run once, by whom it was given to");
    fake_must(slice->sample == r->sample, "a slice belongs to the pass that is under way");
    r->block[slice->block] = BLOCK_RUN;
    if (fake.begins < MAX_BEGUN)
        fake.begun[fake.begins] = r->job.seed;
    fake.begins++;
    r->running++;
    pthread_cond_broadcast(&fake.changed);
    while (fake.prepare_held)
        pthread_cond_wait(&fake.changed, &fake.mutex);
    glint_hold_begin(slice->hold);
    while (fake.gate_closed && !fake.let && (fake.deaf || !r->interrupted))
        pthread_cond_wait(&fake.changed, &fake.mutex);
    if (r->interrupted || !glint_hold_keep(slice->hold)) {
        r->running--;
        fake_unlock();
        return GLINT_E_BUSY;
    }
    fake.let -= fake.gate_closed;
    const double seconds = fake.behaviour[r->job.seed].seconds;
    const bool fails = fake.behaviour[r->job.seed].fail_slice;
    fake.behaviour[r->job.seed].fail_slice = false;
    fake_unlock();
    spin(seconds);
    fake_lock();
    r->running--;
    fake_unlock();
    return fails ? glint_fail(err, GLINT_E_DEVICE, "", "a slice of job %u failed", r->job.seed)
                 : GLINT_OK;
}

void glint_render_give_back(glint_render *r, const struct glint_slice *slice, bool done)
{
    fake_lock();
    const unsigned char state = r->block[slice->block];
    fake_must(done ? state == BLOCK_RUN : state == BLOCK_TAKEN || state == BLOCK_RUN,
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
    fake_unlock();
}

bool glint_render_complete(const glint_render *r)
{
    fake_lock();
    const bool complete = r->sample == r->job.stop.samples;
    fake_unlock();
    return complete;
}

void glint_render_state(const glint_render *r, struct glint_render_state *out)
{
    fake_lock();
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
    fake_unlock();
}

// A film is its numbers between two words.
#define FILM "film 1 %10u %10u %10u end\n"
#define FILM_BYTES 45

glint_status glint_render_film(glint_render *r, int fd, struct glint_error *err)
{
    char text[FILM_BYTES + 1];
    fake_lock();
    snprintf(text, sizeof text, FILM, r->job.seed, r->job.width, r->sample);
    fake_unlock();
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
    fake_lock();
    r->sample = number[2];
    fake_unlock();
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
    fake_lock();
    fake.renders++;
    fake_unlock();
    return GLINT_OK;
}
