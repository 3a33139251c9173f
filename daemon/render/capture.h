// capture.h - a render at one moment: its view, its film and how far it was.
//
// Threads: any but the scheduler and workers; one capture of a render at a time, by one thread from
// begin to end.
#ifndef GLINT_RENDER_CAPTURE_H
#define GLINT_RENDER_CAPTURE_H

#include "render/internal.h"

struct glint_capture {
    glint_render *render;
    struct glint_view *view; // NULL: of a file
    struct glint_film_moment moment;
    struct glint_job job; // the view's, with its end at that moment
    double seconds[GLINT_PASSES];
    struct glint_film_source source; // whose info is the view's; each tile may begin once
    uint32_t *memory;                // of a tile
};

// Waits for the capture before and for slices out: about as long as one slice takes.
glint_status glint_capture_begin(struct glint_capture *out, glint_render *render,
                                 struct glint_error *err);
void glint_capture_end(struct glint_capture *capture);

#endif
