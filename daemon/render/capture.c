#include "render/capture.h"

#include "kernels/gk_film.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

static glint_status begin_tile(void *user, uint32_t tile, struct glint_film_pixels *out,
                               struct glint_error *err)
{
    (void)err; // memory cannot fail
    const struct glint_capture *c = user;
    const struct glint_film_info *info = &c->view->info;
    const uint32_t first = glint_render_first(c->render);
    const struct glint_film_state state = glint_film_capture_take(c->view->film, tile, c->memory);
    out->planes = (const float *)c->memory;
    out->table = info->coverage
                     ? (const uint64_t *)(const void *)((const char *)c->memory +
                                                        glint_film_info_plane_bytes(info))
                     : NULL;
    out->step = state.step;
    for (uint32_t h = 0; h < 2; h++)
        out->half[h] = glint_film_half(first, state.step ? 1 : state.samples, h);
    return GLINT_OK;
}

static void end_tile(void *user, uint32_t tile)
{
    (void)user;
    (void)tile;
}

// What slices out have spent until now goes into the moment, and what they will.
static void mark(struct glint_capture *c)
{
    glint_render *r = c->render;
    pthread_mutex_lock(&r->mutex);
    c->view = r->view;
    atomic_fetch_add_explicit(&c->view->references, 1, memory_order_relaxed);
    glint_render_moment(r, &c->moment);
    c->job = c->view->job;
    c->job.stop = r->job.stop;
    memcpy(c->seconds, r->stats.seconds, sizeof c->seconds);
    r->captures = glint_film_capture_mark(r->film);
    r->late = c;
    pthread_mutex_unlock(&r->mutex);
}

static void settle(struct glint_capture *c)
{
    glint_film_capture_settle(c->render->film);
    pthread_mutex_lock(&c->render->mutex);
    c->render->late = NULL;
    pthread_mutex_unlock(&c->render->mutex);
}

glint_status glint_capture_begin(struct glint_capture *c, glint_render *r, struct glint_error *err)
{
    *c = (struct glint_capture){.render = r};
    c->memory = malloc(glint_film_tile_bytes(r->film));
    if (!c->memory)
        return glint_fail(err, GLINT_E_NOMEM, "", "no memory for a tile");
    glint_film_capture_begin(r->film);
    mark(c);
    settle(c);
    c->source = (struct glint_film_source){.info = &c->view->info,
                                           .complete = c->moment.complete,
                                           .user = c,
                                           .begin = begin_tile,
                                           .end = end_tile};
    return GLINT_OK;
}

void glint_capture_end(struct glint_capture *c)
{
    glint_film_capture_end(c->render->film);
    glint_view_release(&c->view);
    free(c->memory);
}
