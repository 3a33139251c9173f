// GET / and GET /viewer/{}: the web viewer. Its page and what that loads come from here alone; the
// policy lets nothing else in, whatever a scene or a name may contain.
#include "http/viewer.h"

#include "http/answer.h"
#include "http/resources.h"

#include <stdlib.h>
#include <string.h>

#define POLICY                                                                        \
    "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self' blob:; " \
    "connect-src 'self'; base-uri 'none'; form-action 'none'; frame-ancestors 'none'"

static const struct {
    const char *suffix, *type;
} media_types[] = {
    {".html", "text/html; charset=utf-8"},
    {".css", "text/css; charset=utf-8"},
    {".js", "text/javascript; charset=utf-8"},
    {".svg", "image/svg+xml"},
};

static const char *media_type(const char *name)
{
    const char *suffix = strrchr(name, '.');
    for (size_t i = 0; suffix && i < sizeof media_types / sizeof *media_types; i++)
        if (!strcmp(suffix, media_types[i].suffix))
            return media_types[i].type;
    return "application/octet-stream";
}

static void answer_file(struct glint_request *r, const struct glint_source *file)
{
    uint8_t *copy = malloc(file->length);
    if (copy)
        memcpy(copy, file->text, file->length);
    glint_answer_blob(r, MHD_HTTP_OK, media_type(file->name),
                      copy ? glint_blob_digest(copy, file->length) : NULL);
    glint_answer_header(r, "Cache-Control", "no-cache"); // asked for each time, answered 304
    glint_answer_header(r, "Content-Security-Policy", "%s", POLICY);
    glint_answer_header(r, "Referrer-Policy", "no-referrer");
    glint_answer_header(r, "Cross-Origin-Opener-Policy", "same-origin");
    glint_answer_header(r, "Cross-Origin-Resource-Policy", "same-origin");
}

static void answer_name(struct glint_request *r, const char *name)
{
    for (const struct glint_source *file = glint_viewer; file->name; file++)
        if (!strcmp(file->name, name)) {
            answer_file(r, file);
            return;
        }
    struct glint_error err = {0};
    glint_fail(&err, GLINT_E_NOT_FOUND, "", "the viewer has no file of that name");
    glint_answer_error(r, &err);
}

void glint_http_viewer_index(struct glint_request *r)
{
    answer_name(r, "index.html");
}

void glint_http_viewer_file(struct glint_request *r)
{
    answer_name(r, r->argument[0]);
}
