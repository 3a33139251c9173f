#include "http/request.h"

#include "base/clock.h"
#include "http/answer.h"
#include "http/auth.h"
#include "http/routes.h"
#include "protocol/utf8.h"

#include <errno.h>
#include <math.h>
#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/random.h>

// The client's own name for the request if it is a short token, so that it can find it in the logs.
static void name_request(struct glint_request *r)
{
    static const char token[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789._-";
    const char *given = glint_request_header(r, "X-Request-Id");
    if (given && *given && strlen(given) < sizeof r->id && !given[strspn(given, token)]) {
        strcpy(r->id, given);
        return;
    }
    static atomic_uint_least64_t fallback; // relaxed: only distinct
    uint64_t number;
    if (getrandom(&number, sizeof number, GRND_NONBLOCK) != sizeof number)
        number = atomic_fetch_add_explicit(&fallback, 1, memory_order_relaxed);
    snprintf(r->id, sizeof r->id, "%016llx", (unsigned long long)number);
}

static enum MHD_Result count_trace(void *user, enum MHD_ValueKind kind, const char *name,
                                   const char *value)
{
    (void)kind;
    (void)value;
    *(unsigned *)user += !strcasecmp(name, "traceparent");
    return MHD_YES;
}

// Of two that contradict each other neither is believed.
static void read_trace(struct glint_request *r)
{
    unsigned count = 0;
    MHD_get_connection_values(r->connection, MHD_HEADER_KIND, count_trace, &count);
    glint_trace_continue(r->trace, count == 1 ? glint_request_header(r, "traceparent") : NULL);
}

static int hex_digit(char c)
{
    if (c >= '0' && c <= '9')
        return c - '0';
    c |= 0x20;
    return c >= 'a' && c <= 'f' ? c - 'a' + 10 : -1;
}

static bool is_utf8(const char *text)
{
    for (size_t left = strlen(text), n; left; left -= n, text += n)
        if (!(n = glint_utf8_sequence(text, left)))
            return false;
    return true;
}

// Replaces %XX in place. False: malformed, %00, or not UTF-8.
static bool decode(char *text)
{
    char *out = text;
    for (const char *p = text; *p; p++) {
        if (*p != '%') {
            *out++ = *p;
            continue;
        }
        const int high = hex_digit(p[1]), low = high < 0 ? -1 : hex_digit(p[2]);
        if (low < 0 || !(high | low))
            return false;
        *out++ = (char)(high << 4 | low);
        p += 2;
    }
    *out = 0;
    return is_utf8(text);
}

// Cuts the path at its slashes. False: malformed. A path of too many segments matches no route.
static bool cut_path(struct glint_request *r, const char *url)
{
    const char *scheme = strstr(url, "://"); // absolute form, RFC 9112 3.2.2
    if (*url != '/' && scheme)
        url = scheme + 3 + strcspn(scheme + 3, "/");
    r->path = strdup(*url == '/' ? url + 1 : url);
    if (!r->path)
        return false;
    char *rest = r->path;
    while (rest && r->segments < GLINT_MAX_SEGMENTS)
        r->segment[r->segments++] = strsep(&rest, "/");
    for (size_t i = 0; i < r->segments; i++)
        if (!decode(r->segment[i]))
            return false;
    return true;
}

static enum MHD_Result add_parameter(void *user, enum MHD_ValueKind kind, const char *name,
                                     const char *value)
{
    (void)kind;
    struct glint_request *r = user;
    if (r->parameters == GLINT_MAX_PARAMETERS) {
        r->bad_query = true;
        return MHD_NO;
    }
    struct glint_parameter *p = &r->parameter[r->parameters];
    p->name = strdup(name);
    p->value = strdup(value ? value : "");
    r->parameters++;
    if (!p->name || !p->value || !decode(p->name) || !decode(p->value))
        r->bad_query = true;
    return MHD_YES;
}

// '*' follows the name of a parameter that may repeat.
static bool allowed(const char *query, const char *name, bool *repeats)
{
    const size_t length = strlen(name);
    for (const char *p = query; *p; p += strcspn(p, " ") + 1) {
        const size_t n = strcspn(p, " *");
        *repeats = p[n] == '*';
        if (n == length && !strncmp(p, name, n))
            return true;
    }
    return false;
}

// A page in a browser can be pointed at this machine by a name that its owner controls; then the
// Host is that name.
static bool local_host(const char *host)
{
    const size_t digits = strspn(host, "0123456789.");
    const size_t n = !strncasecmp(host, "localhost", 9) ? 9
                     : !strncmp(host, "[::1]", 5)       ? 5
                     : !strncmp(host, "127.", 4)        ? digits
                                                        : 0;
    return n && (!host[n] || host[n] == ':');
}

// Who frames a body in two ways, or in one that the library reads to the end of the connection, may
// mean to hide a request in it.
static bool framed_well(struct glint_request *r)
{
    const char *coding = glint_request_header(r, "Transfer-Encoding");
    return !coding ||
           (!strcasecmp(coding, "chunked") && !glint_request_header(r, "Content-Length"));
}

static void refuse_query(const struct glint_request *r, struct glint_error *err)
{
    if (r->parameters == GLINT_MAX_PARAMETERS)
        glint_fail(err, GLINT_E_SYNTAX, "", "the query has over %d parameters",
                   GLINT_MAX_PARAMETERS);
    else
        glint_fail(err, GLINT_E_SYNTAX, "",
                   "the query has a malformed %% escape, or one that is no UTF-8");
}

static void check_header(struct glint_request *r, const char *url, const char *method,
                         const char *version)
{
    struct glint_error err = {0};
    const char *host = glint_request_header(r, "Host");
    if (!host && strcmp(version, MHD_HTTP_VERSION_1_0))
        glint_fail(&err, GLINT_E_SYNTAX, "", "there is no Host");
    if (!framed_well(r))
        glint_fail(&err, GLINT_E_SYNTAX, "",
                   "a body has a Content-Length or the Transfer-Encoding chunked");
    if (err.count) {
        glint_answer_error(r, &err);
        return;
    }
    if (r->http->loopback && host && !local_host(host)) {
        glint_answer_problem(r, 421, "Misdirected request",
                             "this server answers to localhost, not to %.100s", host);
        return;
    }
    MHD_get_connection_values(r->connection, MHD_GET_ARGUMENT_KIND, add_parameter, r);
    if (!cut_path(r, url)) {
        glint_fail(&err, GLINT_E_SYNTAX, "", "the path is malformed");
        glint_answer_error(r, &err);
        return;
    }
    glint_route_find(r, method);
    if (r->status || !glint_auth_request(r))
        return;
    if (r->bad_query)
        refuse_query(r, &err);
    else if (!*r->route->query) // otherwise the handler tells it with what else is wrong
        glint_query_check(r, &err);
    if (err.count)
        glint_answer_error(r, &err);
    else
        glint_body_accept(r);
}

struct glint_request *glint_request_create(glint_http *http, struct MHD_Connection *connection,
                                           const char *url, const char *method, const char *version)
{
    struct glint_request *r = calloc(1, sizeof *r);
    if (!r)
        return NULL;
    r->http = http;
    r->connection = connection;
    r->started = glint_now();
    r->head = !strcmp(method, "HEAD");
    r->http10 = !strcmp(version, MHD_HTTP_VERSION_1_0);
    snprintf(r->method, sizeof r->method, "%s", method);
    r->body.fd = -1;
    r->client_name = "";
    r->url = strdup(url);
    const union MHD_ConnectionInfo *info =
        MHD_get_connection_info(connection, MHD_CONNECTION_INFO_SOCKET_CONTEXT);
    r->client = info && info->socket_context ? (uint64_t)(uintptr_t)info->socket_context : 0;
    name_request(r);
    read_trace(r);
    check_header(r, url, method, version);
    return r;
}

void glint_request_destroy(struct glint_request **request)
{
    struct glint_request *r = *request;
    *request = NULL;
    if (!r)
        return;
    for (size_t i = 0; i < r->parameters; i++) {
        free(r->parameter[i].name);
        free(r->parameter[i].value);
    }
    if (r->response)
        MHD_destroy_response(r->response);
    glint_body_free(r);
    free(r->url);
    free(r->path);
    free(r);
}

const char *glint_request_header(struct glint_request *r, const char *name)
{
    return MHD_lookup_connection_value(r->connection, MHD_HEADER_KIND, name);
}

bool glint_request_matches(struct glint_request *r, const char *header, const char *etag)
{
    const char *list = glint_request_header(r, header);
    const size_t length = strlen(etag);
    for (const char *p = list; p && *p; p += strcspn(p, ",")) {
        p += strspn(p, ", \t");
        if (*p == '*')
            return true;
        if (!strncmp(p, "W/", 2))
            p += 2;
        if (!strncmp(p, etag, length) && strchr(", \t", p[length]))
            return true;
    }
    return false;
}

const char *glint_request_query(const struct glint_request *r, const char *name)
{
    for (size_t i = 0; i < r->parameters; i++)
        if (!strcmp(r->parameter[i].name, name))
            return r->parameter[i].value;
    return NULL;
}

void glint_query_check(const struct glint_request *r, struct glint_error *err)
{
    for (size_t i = 0; i < r->parameters; i++) {
        const char *name = r->parameter[i].name;
        bool repeats;
        if (!allowed(r->route->query, name, &repeats))
            glint_fail(err, GLINT_E_RANGE, "", "%.64s: no such parameter here", name);
        else if (!repeats && glint_request_query(r, name) != r->parameter[i].value)
            glint_fail(err, GLINT_E_RANGE, "", "%.64s: given more than once", name);
    }
}

void glint_query_number(const struct glint_request *r, const char *name, double low, double high,
                        double *out, struct glint_error *err)
{
    const char *text = glint_request_query(r, name);
    if (!text)
        return;
    char *end;
    const double value = strtod(text, &end);
    if (end == text || *end || !(value >= low && value <= high))
        glint_fail(err, GLINT_E_RANGE, "", "%s: %.40s is no number from %g to %g", name, text, low,
                   high);
    else
        *out = value;
}

void glint_query_integer(const struct glint_request *r, const char *name, uint64_t high,
                         uint64_t *out, struct glint_error *err)
{
    const char *text = glint_request_query(r, name);
    if (!text)
        return;
    errno = 0;
    const unsigned long long value = strtoull(text, NULL, 10);
    if (!*text || text[strspn(text, "0123456789")] || errno || value > high)
        glint_fail(err, GLINT_E_RANGE, "", "%s: %.40s is no whole number from 0 to %llu", name,
                   text, (unsigned long long)high);
    else
        *out = value;
}

void glint_query_choice(const struct glint_request *r, const char *name, const char *const *choices,
                        int *out, struct glint_error *err)
{
    const char *text = glint_request_query(r, name);
    if (!text)
        return;
    char known[256] = "";
    for (int i = 0; choices[i]; i++) {
        if (!strcmp(text, choices[i])) {
            *out = i;
            return;
        }
        const size_t used = strlen(known);
        snprintf(known + used, sizeof known - used, "%s%s", used ? ", " : "", choices[i]);
    }
    glint_fail(err, GLINT_E_RANGE, "", "%s: %.40s is not one of %s", name, text, known);
}

void glint_request_wait(struct glint_request *r)
{
    r->park = true;
}
