#include "http/pixels.h"

#include "http/answer.h"

// Whether the job is not where the request wants it; then it has been dealt with.
static bool not_yet(struct glint_request *r, bool wait, const struct glint_job_view *view,
                    struct glint_error *err)
{
    if (wait && !glint_pixels_final(view)) {
        glint_request_wait(r);
        return true;
    }
    if (wait && view->state != GLINT_JOB_DONE)
        glint_fail(err, GLINT_E_CONFLICT, "", "the job is %s: ask without wait for what there is",
                   glint_job_state_name(view->state));
    else if (!view->render)
        glint_fail(err, GLINT_E_CONFLICT, "", "the job is %s and has no pixels",
                   glint_job_state_name(view->state));
    else
        return false;
    glint_answer_error(r, err);
    return true;
}

bool glint_pixels_open(struct glint_request *r, struct glint_job_view *view,
                       struct glint_error *err)
{
    static const char *const waits[] = {"done", NULL};
    int wait = -1;
    glint_query_choice(r, "wait", waits, &wait, err);
    if (err->count) {
        glint_answer_error(r, err);
        return false;
    }
    const glint_status st = glint_jobs_view(r->http->jobs, r->argument[0], view, err);
    if (st == GLINT_E_BUSY && wait >= 0) {
        glint_error_finish(err);
        glint_request_wait(r);
        return false;
    }
    if (st) {
        glint_answer_error(r, err);
        return false;
    }
    if (!not_yet(r, wait >= 0, view, err))
        return true;
    glint_jobs_release(r->http->jobs, view);
    return false;
}
