// film.c - a job's film, whole or of a part of its samples.
#include "http/answer.h"
#include "http/pixels.h"
#include "http/resources.h"
#include "protocol/film_file.h"

#include <errno.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

// Films that are being sent. Each is in memory until its reader has it, however slow he is.
#define MAX_FILMS 4
static atomic_uint films;

static void gone(void)
{
    atomic_fetch_sub_explicit(&films, 1, memory_order_relaxed); // a count and nothing else
}

static struct glint_blob *map(int fd, bool final, struct glint_error *err)
{
    struct stat about;
    struct glint_blob *blob = NULL;
    if (fstat(fd, &about) == 0)
        blob = glint_blob_map(fd, (size_t)about.st_size, final, gone);
    else
        gone();
    if (!blob)
        glint_fail(err, GLINT_E_NOMEM, "", "no memory for a film");
    return blob;
}

static struct glint_blob *spool(const struct glint_job_view *view, struct glint_error *err)
{
    const int fd = memfd_create("film", MFD_CLOEXEC);
    struct glint_blob *blob = NULL;
    if (fd < 0)
        glint_fail(err, GLINT_E_IO, "", "no file for a film: %s", strerror(errno));
    if (fd >= 0 && !glint_render_film(view->render, fd, err))
        blob = map(fd, glint_pixels_final(view), err);
    else
        gone();
    if (fd >= 0)
        close(fd);
    return blob;
}

static void answer(struct glint_request *r, const struct glint_job_view *view)
{
    struct glint_error err = {0};
    if (atomic_fetch_add_explicit(&films, 1, memory_order_relaxed) >= MAX_FILMS) {
        gone();
        glint_fail(&err, GLINT_E_BUSY, "", "%d films are being sent already", MAX_FILMS);
        glint_answer_error(r, &err);
        return;
    }
    struct glint_blob *blob = spool(view, &err);
    if (!blob) {
        glint_answer_error(r, &err);
        return;
    }
    glint_answer_blob(r, MHD_HTTP_OK, GLINT_FILM_MEDIA_TYPE, blob);
    if (r->status >= 300)
        return;
    glint_answer_header(r, "Content-Disposition", "attachment; filename=\"%s.film\"",
                        r->argument[0]);
    glint_answer_header(r, "Glint-Revision", "%s", view->revision);
    glint_answer_header(r, "Cache-Control", "%s",
                        glint_pixels_final(view) ? "no-cache" : "no-store");
}

void glint_http_film(struct glint_request *r)
{
    struct glint_error err = {0};
    struct glint_job_view view;
    glint_query_check(r, &err);
    if (!glint_pixels_open(r, &view, &err))
        return;
    answer(r, &view);
    glint_jobs_release(r->http->jobs, &view);
}
