#include "session.h"
#include "problem.h"
#include "uri.h"

#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define PROBE_MS 3000L

// Anything that speaks HTTP is an answer: whether it is a daemon that can serve shows later.
static bool answers(glint_client *client)
{
    struct glint_error err = {0};
    const struct glint_request probe = {
        .method = "GET", .path = "/healthz", .connect_ms = PROBE_MS};
    glint_client_send(client, &probe, NULL, &err);
    const bool silent = err.count && err.status == GLINT_E_UNAVAILABLE;
    glint_error_finish(&err);
    return !silent;
}

// The first line of the file of --token-file, else $GLINT_TOKEN; malloc'd, or NULL.
static glint_status read_token(const struct glint_arguments *a, char **token,
                               struct glint_error *err)
{
    const char *file = glint_options_text(a, "token-file"), *given = getenv("GLINT_TOKEN");
    struct glint_blob text;
    *token = NULL;
    if (!file) {
        *token = given && *given ? strdup(given) : NULL;
        return GLINT_OK;
    }
    const glint_status status = glint_uri_read_file(file, &text, "", err);
    if (status)
        return status;
    *token = (char *)text.bytes;
    (*token)[strcspn(*token, "\r\n")] = '\0';
    return GLINT_OK;
}

static glint_status identify(struct glint_session *s, const struct glint_arguments *a,
                             struct glint_error *err)
{
    const char *certificates = glint_options_text(a, "ca-file");
    char *token;
    if (!certificates)
        certificates = getenv("GLINT_CA_FILE");
    glint_status status = read_token(a, &token, err);
    if (!status)
        status = glint_client_identify(s->client, token,
                                       certificates && *certificates ? certificates : NULL, err);
    s->usage = s->usage || status == GLINT_E_RANGE;
    free(token);
    return status;
}

static glint_status use_private(struct glint_session *s, struct glint_error *err)
{
    glint_progress_note(&s->progress, "no daemon at %s, starting a private one",
                        glint_client_url(s->client));
    const glint_status status = glint_spawn_start(&s->daemon, err);
    if (status)
        return status;
    glint_client_destroy(&s->client);
    return glint_client_create(&s->client, glint_spawn_url(s->daemon), err);
}

glint_status glint_session_open(struct glint_session *s, const struct glint_arguments *a,
                                bool spawn, struct glint_error *err)
{
    const char *server = glint_options_text(a, "server");
    if (!server)
        server = getenv("GLINT_SERVER");
    glint_status status =
        glint_client_create(&s->client, server && *server ? server : GLINT_DEFAULT_SERVER, err);
    if (!status)
        status = identify(s, a, err);
    if (status || !spawn || answers(s->client))
        return status;
    return use_private(s, err);
}

void glint_session_close(struct glint_session *s, struct glint_error *err)
{
    glint_progress_finish(&s->progress);
    if (s->daemon && err)
        glint_spawn_explain(s->daemon, err);
    glint_spawn_stop(&s->daemon);
    glint_client_destroy(&s->client);
}

glint_status glint_session_usage(struct glint_session *s, struct glint_error *err,
                                 const char *format, ...)
{
    char text[300];
    va_list args;
    va_start(args, format);
    vsnprintf(text, sizeof text, format, args);
    va_end(args);
    s->usage = true;
    return glint_fail(err, GLINT_E_RANGE, "", "%s", text);
}

void glint_session_print(cJSON *document)
{
    char *text = cJSON_Print(document);
    if (text)
        puts(text);
    free(text);
    cJSON_Delete(document);
}
