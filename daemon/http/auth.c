#include "http/auth.h"

#include "http/answer.h"
#include "http/routes.h"

#include <stdio.h>
#include <string.h>
#include <strings.h>

#define JOB_PATTERN "/v1/jobs/{}"

// What a client needs before it has a token, or what tells nothing.
static bool is_open(const struct glint_route *route)
{
    static const char *const open[] = {"/", "/calls", "/healthz", "/readyz", "/openapi.yaml"};
    for (size_t i = 0; i < sizeof open / sizeof *open; i++)
        if (!strcmp(route->pattern, open[i]))
            return true;
    return !strncmp(route->pattern, "/viewer/", 8) || !strncmp(route->pattern, "/problems/", 10);
}

static enum glint_scope needed(const struct glint_route *route)
{
    if (is_open(route))
        return GLINT_SCOPE_NONE;
    return strcmp(route->method, "GET") ? GLINT_SCOPE_SUBMIT : GLINT_SCOPE_READ;
}

// The token of `Authorization: Bearer TOKEN` (RFC 6750, 2.1), or NULL.
static const char *bearer(struct glint_request *r)
{
    const char *given = glint_request_header(r, "Authorization");
    if (!given || strncasecmp(given, "Bearer ", 7))
        return NULL;
    return given + 7 + strspn(given + 7, " ");
}

static bool refuse(struct glint_request *r, struct glint_error *err, const char *challenge)
{
    glint_answer_error(r, err);
    glint_answer_header(r, "WWW-Authenticate", "Bearer realm=\"glint\"%s", challenge);
    return false;
}

static bool check_scope(struct glint_request *r, const char *secret)
{
    const enum glint_scope scope = needed(r->route);
    struct glint_error err = {0};
    char challenge[64];
    if (r->scope >= scope)
        return true;
    if (!secret) {
        glint_fail(&err, GLINT_E_UNAUTHORIZED, "",
                   "this call needs a token: Authorization: Bearer TOKEN");
        return refuse(r, &err, "");
    }
    if (!r->scope) {
        glint_fail(&err, GLINT_E_UNAUTHORIZED, "", "the token is not known");
        return refuse(r, &err, ", error=\"invalid_token\"");
    }
    glint_fail(&err, GLINT_E_FORBIDDEN, "", "this call needs the scope %s, the token has %s",
               glint_scope_name(scope), glint_scope_name(r->scope));
    snprintf(challenge, sizeof challenge, ", error=\"insufficient_scope\", scope=\"%s\"",
             glint_scope_name(scope));
    return refuse(r, &err, challenge);
}

// Somebody else's job is answered like one that does not exist.
static bool check_job(struct glint_request *r)
{
    const char *tenant = glint_auth_tenant(r);
    if (!tenant || strncmp(r->route->pattern, JOB_PATTERN, strlen(JOB_PATTERN)) ||
        glint_jobs_belongs(r->http->jobs, r->argument[0], tenant))
        return true;
    struct glint_error err = {0};
    glint_fail(&err, GLINT_E_NOT_FOUND, "", "there is no job \"%.64s\"", r->argument[0]);
    glint_answer_error(r, &err);
    return false;
}

void glint_auth_check_name(struct glint_request *r, struct glint_error *err)
{
    if (r->bad_client)
        glint_fail(err, GLINT_E_RANGE, "",
                   "Glint-Client: 1 to %d of A-Z a-z 0-9 . _ @ - are needed",
                   GLINT_CLIENT_BYTES - 1);
}

// What else is wrong with a job is told by who reads it, with this.
static bool take_name(struct glint_request *r)
{
    const char *name = glint_request_header(r, "Glint-Client");
    r->bad_client = name && !glint_client_name_valid(name);
    strcpy(r->client_text, name && !r->bad_client ? name : "");
    if (!r->bad_client || r->route->body == GLINT_BODY_JOB)
        return true;
    struct glint_error err = {0};
    glint_auth_check_name(r, &err);
    glint_answer_error(r, &err);
    return false;
}

bool glint_auth_request(struct glint_request *r)
{
    r->client_name = r->client_text;
    if (!r->http->tokens) {
        r->scope = GLINT_SCOPE_ADMIN;
        return take_name(r);
    }
    const char *secret = bearer(r);
    if (secret)
        r->scope = glint_tokens_find(r->http->tokens, secret, r->client_text);
    return check_scope(r, secret) && check_job(r);
}

const char *glint_auth_tenant(const struct glint_request *r)
{
    return r->scope < GLINT_SCOPE_ADMIN ? r->client_name : NULL;
}
