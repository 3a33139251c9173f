#include "client.h"
#include "interrupt.h"
#include "problem.h"

#include <ctype.h>
#include <curl/curl.h>
#include <pwd.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>
#include <unistd.h>

#define STREAM_SILENCE_S 60L
#define POLL_MS 1000
#define IDLE_MS 100

// One request on its way.
struct transfer {
    const struct glint_request *request;
    CURL *easy;
    struct curl_slist *headers; // owned
    struct glint_answer answer;
    size_t capacity;
    uint64_t sent;
    bool ended;      // by `receive`
    bool too_large;  // the answer does not fit
    bool file_short; // the body's file ended early
};

struct glint_client {
    CURLM *multi;
    CURL *easy;
    struct transfer beside; // runs while it has an `easy`
    char *url;
    char *token, *certificates; // or NULL
    char user[65];              // what the daemon shares its workers by, "": nameless
};

// The login name, as far as a Glint-Client header takes it.
static void name_user(char user[65])
{
    const struct passwd *entry = getpwuid(geteuid());
    const char *name = entry ? entry->pw_name : "";
    size_t length = 0;
    for (; *name && length < 64; name++)
        if (isascii((unsigned char)*name) &&
            (isalnum((unsigned char)*name) || strchr("._@-", *name)))
            user[length++] = *name;
    user[length] = '\0';
}

glint_status glint_client_create(glint_client **out, const char *url, struct glint_error *err)
{
    *out = NULL;
    size_t length = strlen(url);
    while (length && url[length - 1] == '/')
        length--;
    const char *scheme = strstr(url, "://") ? "" : "http://";
    glint_client *c = calloc(1, sizeof *c);
    if (!c || asprintf(&c->url, "%s%.*s", scheme, (int)length, url) < 0 ||
        curl_global_init(CURL_GLOBAL_DEFAULT) != CURLE_OK || !(c->easy = curl_easy_init()) ||
        !(c->multi = curl_multi_init())) {
        glint_client_destroy(&c);
        return glint_fail(err, GLINT_E_NOMEM, "", "no memory for the HTTP client");
    }
    name_user(c->user);
    *out = c;
    return GLINT_OK;
}

// Where what is sent stays on this machine or is encrypted.
static bool is_private(const char *url)
{
    static const char *const safe[] = {"https://", "http://127.", "http://[::1]",
                                       "http://localhost:", "http://localhost/"};
    for (size_t i = 0; i < sizeof safe / sizeof *safe; i++)
        if (strncasecmp(url, safe[i], strlen(safe[i])) == 0)
            return true;
    return strcasecmp(url, "http://localhost") == 0;
}

static bool is_token(const char *token)
{
    size_t length = 0;
    while (isgraph((unsigned char)token[length]))
        length++;
    return length && length <= 4096 && !token[length];
}

glint_status glint_client_identify(glint_client *client, const char *token,
                                   const char *certificates, struct glint_error *err)
{
    if (token && !is_token(token))
        return glint_fail(err, GLINT_E_RANGE, "", "a token is visible ASCII without white space");
    if (token && !is_private(client->url))
        return glint_fail(err, GLINT_E_RANGE, "",
                          "%s: a token is sent to https:// or to this machine only", client->url);
    if ((token && !(client->token = strdup(token))) ||
        (certificates && !(client->certificates = strdup(certificates))))
        return glint_fail(err, GLINT_E_NOMEM, "", "no memory for the HTTP client");
    return GLINT_OK;
}

void glint_client_destroy(glint_client **client)
{
    glint_client *c = *client;
    *client = NULL;
    if (!c)
        return;
    glint_client_end(c);
    curl_easy_cleanup(c->easy);
    curl_multi_cleanup(c->multi);
    free(c->url);
    free(c->token);
    free(c->certificates);
    free(c);
}

const char *glint_client_url(const glint_client *client)
{
    return client->url;
}

static bool keep(struct transfer *t, const void *bytes, size_t size)
{
    struct glint_answer *a = &t->answer;
    if (size > GLINT_MAX_ANSWER - a->size) {
        t->too_large = true;
        return false;
    }
    if (a->size + size + 1 > t->capacity) {
        const size_t capacity = 2 * (a->size + size) + 1024;
        char *grown = realloc(a->body, capacity);
        if (!grown)
            return false;
        a->body = grown;
        t->capacity = capacity;
    }
    memcpy(a->body + a->size, bytes, size);
    a->size += size;
    a->body[a->size] = '\0';
    return true;
}

static size_t on_receive(char *bytes, size_t unit, size_t count, void *user)
{
    struct transfer *t = user;
    const size_t size = unit * count;
    long http = 0;
    curl_easy_getinfo(t->easy, CURLINFO_RESPONSE_CODE, &http);
    if (!t->request->receive || glint_problem_status(http) != GLINT_OK)
        return keep(t, bytes, size) ? size : CURL_WRITEFUNC_ERROR;
    if (t->request->receive(t->request->user, bytes, size))
        return size;
    t->ended = true;
    return CURL_WRITEFUNC_ERROR;
}

static size_t on_send(char *bytes, size_t unit, size_t count, void *user)
{
    struct transfer *t = user;
    const struct glint_body *body = t->request->body;
    size_t size = unit * count;
    if (size > body->size - t->sent)
        size = (size_t)(body->size - t->sent);
    if (body->bytes) {
        memcpy(bytes, body->bytes + t->sent, size);
    } else if (size) {
        const ssize_t got = pread(body->fd, bytes, size, (off_t)t->sent);
        if (got <= 0) {
            t->file_short = true;
            return CURL_READFUNC_ABORT;
        }
        size = (size_t)got;
    }
    t->sent += size;
    return size;
}

// libcurl rewinds when it has to send a body again on a fresh connection.
static int on_seek(void *user, curl_off_t offset, int origin)
{
    struct transfer *t = user;
    if (origin != SEEK_SET || offset < 0 || (uint64_t)offset > t->request->body->size)
        return CURL_SEEKFUNC_FAIL;
    t->sent = (uint64_t)offset;
    return CURL_SEEKFUNC_OK;
}

static bool add_header(struct curl_slist **list, const char *name, const char *value)
{
    char *line;
    if (!value)
        return true;
    if (asprintf(&line, "%s: %s", name, value) < 0)
        return false;
    struct curl_slist *longer = curl_slist_append(*list, line);
    free(line);
    if (longer)
        *list = longer;
    return longer != NULL;
}

static bool add_token(const glint_client *c, struct curl_slist **list)
{
    char *value = NULL;
    if (!c->token)
        return true;
    const bool added =
        asprintf(&value, "Bearer %s", c->token) >= 0 && add_header(list, "Authorization", value);
    free(value);
    return added;
}

static bool make_headers(const glint_client *c, const struct glint_request *r,
                         struct curl_slist **list)
{
    return add_token(c, list) && add_header(list, "Glint-Client", c->user[0] ? c->user : NULL) &&
           add_header(list, "Content-Type", r->body ? r->body->type : NULL) &&
           add_header(list, "Idempotency-Key", r->idempotency_key) &&
           add_header(list, "Last-Event-ID", r->last_event_id) &&
           add_header(list, "If-Match", r->if_match) &&
           add_header(list, "Accept", r->stream ? "text/event-stream" : "*/*");
}

static void set_body(CURL *easy, struct transfer *t)
{
    curl_easy_setopt(easy, CURLOPT_UPLOAD, 1L);
    curl_easy_setopt(easy, CURLOPT_INFILESIZE_LARGE, (curl_off_t)t->request->body->size);
    curl_easy_setopt(easy, CURLOPT_READFUNCTION, on_send);
    curl_easy_setopt(easy, CURLOPT_READDATA, t);
    curl_easy_setopt(easy, CURLOPT_SEEKFUNCTION, on_seek);
    curl_easy_setopt(easy, CURLOPT_SEEKDATA, t);
}

static void set_options(CURL *easy, struct transfer *t, const char *url,
                        const struct curl_slist *headers)
{
    const struct glint_request *r = t->request;
    curl_easy_reset(easy);
    curl_easy_setopt(easy, CURLOPT_URL, url);
    curl_easy_setopt(easy, CURLOPT_PROTOCOLS_STR, "http,https");
    curl_easy_setopt(easy, CURLOPT_PATH_AS_IS, 1L); // a scene named ".." stays a name
    curl_easy_setopt(easy, CURLOPT_PROXY, "");      // a render daemon stands behind no web proxy
    curl_easy_setopt(easy, CURLOPT_NOSIGNAL, 1L);
    curl_easy_setopt(easy, CURLOPT_TCP_KEEPALIVE, 1L);
    curl_easy_setopt(easy, CURLOPT_USERAGENT, PACKAGE_NAME "/" PACKAGE_VERSION);
    curl_easy_setopt(easy, CURLOPT_CONNECTTIMEOUT_MS, r->connect_ms ? r->connect_ms : 10000L);
    curl_easy_setopt(easy, CURLOPT_HTTPHEADER, headers);
    curl_easy_setopt(easy, CURLOPT_WRITEFUNCTION, on_receive);
    curl_easy_setopt(easy, CURLOPT_WRITEDATA, t);
    if (r->body)
        set_body(easy, t);
    if (r->stream) {
        curl_easy_setopt(easy, CURLOPT_LOW_SPEED_LIMIT, 1L);
        curl_easy_setopt(easy, CURLOPT_LOW_SPEED_TIME, STREAM_SILENCE_S);
    }
    curl_easy_setopt(easy, CURLOPT_CUSTOMREQUEST, r->method); // after UPLOAD, which means PUT
}

static void finish_beside(glint_client *c)
{
    struct transfer *t = &c->beside;
    curl_multi_remove_handle(c->multi, t->easy);
    curl_easy_cleanup(t->easy);
    curl_slist_free_all(t->headers);
    free(t->answer.body);
    *t = (struct transfer){0};
}

// Takes what has ended. True if the main transfer is among it.
static bool take_ended(glint_client *c, CURLcode *result)
{
    int left;
    bool ended = false;
    for (CURLMsg *m; (m = curl_multi_info_read(c->multi, &left));) {
        if (m->msg != CURLMSG_DONE)
            continue;
        if (m->easy_handle == c->easy) {
            *result = m->data.result;
            ended = true;
        } else {
            finish_beside(c);
        }
    }
    return ended;
}

static void wait_for_bytes(glint_client *c, bool steady, int milliseconds)
{
    const struct glint_request *beside = c->beside.request;
    struct curl_waitfd signal = {.fd = glint_interrupt_fd(), .events = CURL_WAIT_POLLIN};
    const bool idles = beside && beside->idle;
    if (idles && milliseconds > IDLE_MS)
        milliseconds = IDLE_MS;
    curl_multi_poll(c->multi, &signal, steady ? 0 : 1, milliseconds, NULL);
    if (idles)
        beside->idle(beside->user);
}

// Runs the transfer; false if a signal ended it.
static bool drive(glint_client *c, bool steady, CURLcode *result)
{
    *result = CURLE_FAILED_INIT;
    for (int running;;) {
        if (curl_multi_perform(c->multi, &running) != CURLM_OK || take_ended(c, result))
            return true;
        if (!steady && glint_interrupt_pending())
            return false;
        wait_for_bytes(c, steady, POLL_MS);
    }
}

static glint_status judge(const glint_client *c, const struct transfer *t, CURLcode result,
                          struct glint_error *err)
{
    const struct glint_answer *a = &t->answer;
    if (t->file_short)
        return glint_fail(err, GLINT_E_IO, "", "the file became shorter while it was sent");
    if (t->too_large)
        return glint_fail(err, GLINT_E_TOO_LARGE, "", "%s answers with more than %zu bytes", c->url,
                          GLINT_MAX_ANSWER);
    // An answer that came before the body was sent (413) ends the transfer with an error as well.
    if (a->http >= 300)
        return glint_problem_read(a->http, a->body ? a->body : "", a->size, err);
    if (result != CURLE_OK && !t->ended)
        return glint_fail(err, GLINT_E_UNAVAILABLE, "", "%s: %s %s: %s", c->url, t->request->method,
                          t->request->path, curl_easy_strerror(result));
    if (a->http < 200)
        return glint_fail(err, GLINT_E_INTERNAL, "", "%s answers %ld", c->url, a->http);
    return GLINT_OK;
}

static glint_status perform(glint_client *c, struct transfer *t, struct glint_error *err)
{
    CURLcode result;
    curl_multi_add_handle(c->multi, c->easy);
    const bool finished = drive(c, t->request->steady, &result);
    curl_easy_getinfo(c->easy, CURLINFO_RESPONSE_CODE, &t->answer.http);
    curl_multi_remove_handle(c->multi, c->easy);
    if (!finished)
        return glint_fail(err, GLINT_E_BUSY, "", "interrupted");
    return judge(c, t, result, err);
}

// Sets up a transfer whose request and handle are given.
static glint_status prepare(glint_client *c, struct transfer *t, struct glint_error *err)
{
    char *url = NULL;
    const bool ready = asprintf(&url, "%s%s", c->url, t->request->path) >= 0 &&
                       make_headers(c, t->request, &t->headers) && keep(t, "", 0);
    if (ready)
        set_options(t->easy, t, url, t->headers);
    if (ready && c->certificates)
        curl_easy_setopt(t->easy, CURLOPT_CAINFO, c->certificates);
    free(url);
    return ready ? GLINT_OK : glint_fail(err, GLINT_E_NOMEM, "", "no memory for a request");
}

glint_status glint_client_send(glint_client *client, const struct glint_request *request,
                               struct glint_answer *answer, struct glint_error *err)
{
    struct transfer t = {.request = request, .easy = client->easy};
    glint_status status = prepare(client, &t, err);
    if (!status)
        status = perform(client, &t, err);
    curl_easy_setopt(client->easy, CURLOPT_HTTPHEADER, NULL);
    curl_slist_free_all(t.headers);
    if (status == GLINT_OK && answer)
        *answer = t.answer;
    else
        free(t.answer.body);
    return status;
}

glint_status glint_client_begin(glint_client *client, const struct glint_request *request,
                                struct glint_error *err)
{
    glint_client_end(client);
    struct transfer *t = &client->beside;
    *t = (struct transfer){.request = request, .easy = curl_easy_init()};
    const glint_status status = t->easy
                                    ? prepare(client, t, err)
                                    : glint_fail(err, GLINT_E_NOMEM, "", "no memory for a request");
    if (!status)
        curl_multi_add_handle(client->multi, t->easy);
    else
        finish_beside(client);
    return status;
}

bool glint_client_runs(const glint_client *client)
{
    return client->beside.request != NULL;
}

void glint_client_end(glint_client *client)
{
    if (glint_client_runs(client))
        finish_beside(client);
}

void glint_client_wait(glint_client *client, int milliseconds)
{
    CURLcode unused;
    int running;
    wait_for_bytes(client, false, milliseconds);
    curl_multi_perform(client->multi, &running);
    take_ended(client, &unused);
}

glint_status glint_client_json(glint_client *client, const struct glint_request *request,
                               cJSON **out, struct glint_error *err)
{
    struct glint_answer answer;
    *out = NULL;
    const glint_status status = glint_client_send(client, request, &answer, err);
    if (status)
        return status;
    *out = cJSON_ParseWithLength(answer.body, answer.size);
    free(answer.body);
    if (cJSON_IsObject(*out))
        return GLINT_OK;
    cJSON_Delete(*out);
    *out = NULL;
    return glint_fail(err, GLINT_E_INTERNAL, "", "%s%s: the answer is no JSON object", client->url,
                      request->path);
}

char *glint_client_escape(const char *text)
{
    char *escaped = curl_easy_escape(NULL, text, (int)strlen(text));
    char *copy = escaped ? strdup(escaped) : NULL;
    curl_free(escaped);
    return copy;
}

char *glint_client_path(const char *before, const char *name, const char *after)
{
    char *path = NULL, *escaped = glint_client_escape(name);
    if (escaped && asprintf(&path, "%s%s%s", before, escaped, after) < 0)
        path = NULL;
    free(escaped);
    return path;
}

char *glint_client_query(char *path, const char *name, const char *value)
{
    if (!path || !value)
        return path;
    char *longer = NULL, *escaped = glint_client_escape(value);
    if (escaped &&
        asprintf(&longer, "%s%c%s=%s", path, strchr(path, '?') ? '&' : '?', name, escaped) < 0)
        longer = NULL;
    free(escaped);
    free(path);
    return longer;
}

glint_status glint_client_get(glint_client *client, const char *before, const char *name,
                              const char *after, cJSON **out, struct glint_error *err)
{
    char *path = name ? glint_client_path(before, name, after) : strdup(before);
    if (!path)
        return glint_fail(err, GLINT_E_NOMEM, "", "no memory");
    const struct glint_request request = {.method = "GET", .path = path};
    const glint_status status = glint_client_json(client, &request, out, err);
    free(path);
    return status;
}
