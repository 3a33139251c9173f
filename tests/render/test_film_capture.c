// A film that is captured while workers render into it, and while views come and go, is of one
// moment: it holds what a render has that stopped there.
#include "tests/render/filmed.h"

#include <pthread.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#define MAX_TILES 64
#define MOVES 12
#define COUNTS 8 // of samples between passes, with none

static const uint32_t count_of[COUNTS] = {0, 1, 2, 4, 8, 12, 16, 24};
static const char *const jobs[2] = {"'stop':{'samples':24},'live':true,",
                                    "'stop':{'samples':24},'live':true,'camera':'side',"};

// Tiles of renders that stopped between passes, of both cameras.
struct reference {
    uint32_t tiles;
    size_t bytes;
    uint8_t *tile[2][COUNTS][MAX_TILES];
};

static glint_film_file *open_film(int fd)
{
    glint_film_file *file;
    struct glint_error err = {0};
    assert_int_equal(lseek(fd, 0, SEEK_SET), 0);
    if (glint_film_file_open(&file, fd, &err))
        offline_die("film", &err);
    close(fd);
    return file;
}

static void add_reference(struct reference *r, int camera, int count, glint_render *render)
{
    glint_film_file *file = open_film(filmed_write(render));
    const struct glint_film_info *info = &glint_film_file_header(file)->info;
    r->tiles = glint_film_info_columns(info) * glint_film_info_rows(info);
    r->bytes = glint_film_file_tile_bytes(file);
    assert_in_range(r->tiles, 1, MAX_TILES);
    for (uint32_t t = 0; t < r->tiles; t++) {
        assert_int_equal(glint_film_file_samples(file, t), count_of[count]);
        r->tile[camera][count][t] = malloc(r->bytes);
        assert_int_equal(glint_film_file_tile(file, t, r->tile[camera][count][t], NULL), GLINT_OK);
    }
    glint_film_file_close(&file);
}

static struct reference make_reference(void)
{
    struct reference r = {0};
    for (int camera = 0; camera < 2; camera++) {
        glint_render *render = filmed_render(&offline_crew, &filmed, jobs[camera]);
        struct glint_render_state now = {0};
        for (int count = 1; count < COUNTS; count++) {
            while (now.samples < count_of[count]) {
                filmed_run(&offline_crew, render, 1);
                glint_render_state(render, &now);
            }
            add_reference(&r, camera, count, render);
        }
        glint_render_destroy(&render);
    }
    return r;
}

static void drop_reference(struct reference *r)
{
    for (int camera = 0; camera < 2; camera++)
        for (int count = 1; count < COUNTS; count++)
            for (uint32_t t = 0; t < r->tiles; t++)
                free(r->tile[camera][count][t]);
}

static int index_of(uint32_t samples)
{
    for (int i = 0; i < COUNTS; i++)
        if (count_of[i] == samples)
            return i;
    return -1;
}

// Every tile is as before or after the pass under way, and has the bytes of a render there.
static void check_film(const struct reference *r, glint_film_file *file)
{
    const struct glint_film_header *h = glint_film_file_header(file);
    const int camera = h->info.job->camera_name && !strcmp(h->info.job->camera_name, "side");
    uint8_t *memory = malloc(r->bytes);
    uint32_t least = UINT32_MAX, most = 0;
    for (uint32_t t = 0; t < r->tiles; t++) {
        const uint32_t samples = glint_film_file_samples(file, t);
        const int count = index_of(samples);
        assert_true(count >= 0);
        least = samples < least ? samples : least;
        most = samples > most ? samples : most;
        if (!samples)
            continue;
        assert_int_equal(glint_film_file_tile(file, t, memory, NULL), GLINT_OK);
        assert_memory_equal(memory, r->tile[camera][count][t], r->bytes);
    }
    assert_true(least >= h->moment.sample && most <= h->moment.sample + h->moment.samples);
    free(memory);
}

// What the scheduler does, and its workers: one lock around taking, giving back and moving on.
struct house {
    glint_render *render;
    pthread_mutex_t mutex;
    bool halted;       // no more slices are handed out
    uint32_t slices;   // given back
    uint32_t out;      // slices
    uint32_t restarts; // still wanted: one after every few slices
};

static glint_view *view_of(struct house *h, int camera)
{
    struct glint_error err = {0};
    struct glint_job job = h->render->job;
    job.camera_name = camera ? (char *)"side" : NULL;
    struct glint_posed posed;
    glint_view *view = NULL;
    if (glint_posed_for(&posed, offline_crew.devices, &filmed, &job, &err) ||
        glint_render_move(&view, h->render, posed.resident, posed.pose, &job, &err))
        offline_die("view", &err);
    glint_resident_release(&posed.resident);
    return view;
}

struct hand {
    struct house *house;
    uint32_t index;
};

static bool next_slice(struct house *h, struct glint_slice *slice)
{
    pthread_mutex_lock(&h->mutex);
    const bool any = !h->halted && glint_render_take(h->render, slice);
    h->out += any;
    pthread_mutex_unlock(&h->mutex);
    return any;
}

static bool over(struct house *h)
{
    pthread_mutex_lock(&h->mutex);
    const bool is = !h->restarts && glint_render_complete(h->render);
    pthread_mutex_unlock(&h->mutex);
    return is;
}

static void *work(void *user)
{
    const struct hand *hand = user;
    struct house *h = hand->house;
    glint_worker *worker = glint_devices_worker(offline_crew.devices, hand->index);
    struct glint_error err = {0};
    glint_worker_enter(worker);
    for (;;) {
        struct glint_slice slice;
        if (over(h))
            return NULL;
        if (!next_slice(h, &slice)) {
            usleep(200);
            continue;
        }
        const glint_status st = glint_render_run(h->render, worker, &slice, &err);
        pthread_mutex_lock(&h->mutex);
        glint_render_give_back(h->render, &slice, !st);
        h->out--;
        h->slices++;
        pthread_mutex_unlock(&h->mutex);
    }
}

struct crowd {
    struct house house;
    struct hand hand[2];
    pthread_t thread[2];
};

static void begin(struct crowd *c, const char *job, uint32_t restarts)
{
    *c = (struct crowd){.house = {.restarts = restarts}};
    c->house.render = filmed_render(&offline_crew, &filmed, job);
    pthread_mutex_init(&c->house.mutex, NULL);
    for (uint32_t i = 0; i < 2; i++) {
        c->hand[i] = (struct hand){&c->house, i};
        pthread_create(&c->thread[i], NULL, work, &c->hand[i]);
    }
}

static void end(struct crowd *c)
{
    for (int i = 0; i < 2; i++)
        pthread_join(c->thread[i], NULL);
    pthread_mutex_destroy(&c->house.mutex);
    glint_render_destroy(&c->house.render);
}

static void films_of_a_running_render_hold_one_moment(void **state)
{
    (void)state;
    struct reference r = make_reference();
    struct crowd c;
    begin(&c, jobs[0], 0);
    uint32_t films = 0;
    for (bool last = false; !last; films++) {
        last = glint_render_complete(c.house.render);
        glint_film_file *file = open_film(filmed_write(c.house.render));
        check_film(&r, file);
        glint_film_file_close(&file);
    }
    print_message("# %u films\n", films);
    end(&c);
    drop_reference(&r);
}

static void *write_films(void *user)
{
    struct crowd *c = user;
    for (int i = 0; i < 6; i++) {
        glint_film_file *file = open_film(filmed_write(c->house.render));
        glint_film_file_close(&file);
    }
    return NULL;
}

// Two write films, one asks for frames: the samples plane says what each pixel had.
static void frames_of_a_running_render_hold_one_moment(void **state)
{
    (void)state;
    struct crowd c;
    pthread_t writer[2];
    begin(&c, jobs[0], 0);
    for (int i = 0; i < 2; i++)
        pthread_create(&writer[i], NULL, write_films, &c);
    for (bool last = false; !last;) {
        struct glint_frame *frame;
        uint32_t samples;
        last = glint_render_complete(c.house.render);
        assert_int_equal(
            glint_render_frame(c.house.render, GLINT_OUT_SAMPLES, &frame, &samples, NULL),
            GLINT_OK);
        const float *plane = glint_frame_find(frame, "samples.Y");
        const int count = index_of(samples);
        assert_true(count >= 0);
        const uint32_t next = count + 1 < COUNTS ? count_of[count + 1] : samples;
        for (size_t i = 0; i < (size_t)frame->width * frame->height; i++)
            assert_true(plane[i] == (float)samples || plane[i] == (float)next);
        glint_frame_destroy(&frame);
    }
    for (int i = 0; i < 2; i++)
        pthread_join(writer[i], NULL);
    end(&c);
}

static uint32_t slices_of(struct house *h)
{
    pthread_mutex_lock(&h->mutex);
    const uint32_t slices = h->slices;
    pthread_mutex_unlock(&h->mutex);
    return slices;
}

// A live render that moves between two cameras: a film shows one of them.
static void films_of_a_render_that_moves_hold_one_view(void **state)
{
    (void)state;
    struct reference r = make_reference();
    struct crowd c;
    begin(&c, jobs[0], MOVES);
    for (int camera = 1, moves = 0; moves < MOVES; moves++, camera = !camera) {
        glint_view *view = view_of(&c.house, camera);
        const uint32_t wanted = slices_of(&c.house) + 9;
        bool moved = false;
        while (!moved) {
            pthread_mutex_lock(&c.house.mutex);
            c.house.halted = c.house.slices >= wanted;
            if (c.house.halted && !c.house.out) {
                c.house.restarts--;
                glint_render_restart(c.house.render, &view);
                c.house.halted = false;
                moved = true;
            }
            pthread_mutex_unlock(&c.house.mutex);
            glint_film_file *file = open_film(filmed_write(c.house.render));
            check_film(&r, file);
            glint_film_file_close(&file);
        }
        glint_view_release(&view);
    }
    end(&c);
    drop_reference(&r);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(films_of_a_running_render_hold_one_moment),
        cmocka_unit_test(frames_of_a_running_render_hold_one_moment),
        cmocka_unit_test(films_of_a_render_that_moves_hold_one_view),
    };
    return cmocka_run_group_tests(tests, filmed_start, filmed_stop);
}
