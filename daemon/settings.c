#include "settings.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#define GIB ((double)((uint64_t)1 << 30))
#define MAX_THREADS 256

enum kind { TEXT, COUNT, BYTES, SECONDS, CHOICE };

struct choice {
    const char *name;
    int value;
};

static const struct choice formats[] = {
    {"auto", GLINT_LOG_AUTO}, {"text", GLINT_LOG_TEXT}, {"json", GLINT_LOG_JSON}, {0}};
static const struct choice levels[] = {{"error", GLINT_LOG_ERROR},
                                       {"warning", GLINT_LOG_WARNING},
                                       {"info", GLINT_LOG_INFO},
                                       {"debug", GLINT_LOG_DEBUG},
                                       {0}};
_Static_assert(sizeof(enum glint_log_format) == sizeof(int) &&
                   sizeof(enum glint_log_level) == sizeof(int),
               "a choice is written as an int");
_Static_assert(sizeof(size_t) == sizeof(uint64_t), "bytes are written as 64 bits");

#define AT(member) offsetof(struct glint_settings, member)

static const struct row {
    const char *name;
    enum kind kind;
    size_t offset;
    double low, high; // COUNT, BYTES, SECONDS
    const struct choice *choice;
    bool fixed; // while the daemon runs
} table[] = {
    {"listen", TEXT, AT(listen), .fixed = true},
    {"state", TEXT, AT(state), .fixed = true},
    {"threads", COUNT, AT(threads), .low = 1, .high = MAX_THREADS, .fixed = true},
    {"log_format", CHOICE, AT(log_format), .choice = formats, .fixed = true},
    {"log_level", CHOICE, AT(log_level), .choice = levels},
    {"debug", TEXT, AT(debug), .fixed = false},
    {"token_file", TEXT, AT(token_file), .fixed = false},
    {"tls_cert", TEXT, AT(tls_cert), .fixed = false},
    {"tls_key", TEXT, AT(tls_key), .fixed = false},
    {"checkpoint_seconds", SECONDS, AT(checkpoint_seconds), .low = 0.1, .high = 86400},
    {"drain_seconds", SECONDS, AT(drain_seconds), .low = 0, .high = 3600},
    {"film_bytes", BYTES, AT(film_bytes), .low = 1 << 20, .high = 1024 * 1024 * GIB},
    {"memory_bytes", BYTES, AT(jobs.memory_bytes), .low = 1 << 20, .high = 1024 * 1024 * GIB},
    {"live_jobs", COUNT, AT(jobs.live_jobs), .low = 1, .high = 4096},
    {"ended_jobs", COUNT, AT(jobs.ended_jobs), .low = 1, .high = 1e6},
    {"side_by_side", COUNT, AT(jobs.side_by_side), .low = 1, .high = 4096},
    {"job_bytes", BYTES, AT(http.job_bytes), .low = 1 << 10, .high = GIB},
    {"scene_bytes", BYTES, AT(http.scene_bytes), .low = 1 << 10, .high = 1024 * GIB},
    {"spool_bytes", BYTES, AT(http.spool_bytes), .low = 1 << 10, .high = 1024 * GIB},
    {"connections", COUNT, AT(http.connections), .low = 1, .high = 65536},
    {"streams", COUNT, AT(http.streams), .low = 1, .high = 65536},
    {"header_seconds", SECONDS, AT(http.header_seconds), .low = 0.1, .high = 3600},
    {"idle_seconds", SECONDS, AT(http.idle_seconds), .low = 1, .high = 86400},
    {0},
};

const char *glint_settings_name(size_t index)
{
    return table[index].name;
}

static const struct row *find(const char *name)
{
    for (const struct row *row = table; row->name; row++)
        if (!strcmp(row->name, name))
            return row;
    return NULL;
}

static bool set_text(char **member, const char *value)
{
    char *copy = strdup(value);
    if (!copy || !*value) {
        free(copy);
        return false;
    }
    free(*member);
    *member = copy;
    return true;
}

static bool set_count(uint32_t *member, const struct row *row, const char *value)
{
    uint64_t whole;
    if (!glint_config_whole(value, (uint64_t)row->low, (uint64_t)row->high, &whole))
        return false;
    *member = (uint32_t)whole;
    return true;
}

static bool set_choice(int *member, const struct row *row, const char *value)
{
    for (const struct choice *c = row->choice; c->name; c++)
        if (!strcmp(c->name, value)) {
            *member = c->value;
            return true;
        }
    return false;
}

static bool set(struct glint_settings *s, const struct row *row, const char *value)
{
    void *member = (char *)s + row->offset;
    switch (row->kind) {
    case TEXT:
        return set_text(member, value);
    case COUNT:
        return set_count(member, row, value);
    case BYTES:
        return glint_config_bytes(value, (uint64_t)row->low, (uint64_t)row->high, member);
    case SECONDS:
        return glint_config_seconds(value, row->low, row->high, member);
    case CHOICE:
        return set_choice(member, row, value);
    }
    return false;
}

// What the setting takes, in words.
static void describe(char out[128], const struct row *row)
{
    static const char *const unit[] = {[COUNT] = "a whole number",
                                       [BYTES] = "bytes, perhaps with K, M, G or T behind,",
                                       [SECONDS] = "seconds"};
    size_t used = 0;
    if (row->kind == TEXT)
        snprintf(out, 128, "something");
    else if (row->kind != CHOICE)
        snprintf(out, 128, "%s from %.15g to %.15g", unit[row->kind], row->low, row->high);
    for (const struct choice *c = row->choice; c && c->name && used < 128; c++)
        used += (size_t)snprintf(out + used, 128 - used, "%s%s", used ? ", " : "", c->name);
}

glint_status glint_settings_set(struct glint_settings *settings, const char *name,
                                const char *value, const char *label, struct glint_error *err)
{
    const struct row *row = find(name);
    if (!row)
        return glint_fail(err, GLINT_E_RANGE, "", "%s is no setting", label);
    if (set(settings, row, value))
        return GLINT_OK;
    char wanted[128];
    describe(wanted, row);
    return glint_fail(err, GLINT_E_RANGE, "", "%s does not take \"%.200s\" but %s", label, value,
                      wanted);
}

static glint_status set_lines(struct glint_settings *s, const struct glint_config *config,
                              const char *file, struct glint_error *err)
{
    glint_status st = GLINT_OK;
    for (size_t i = 0; i < config->count; i++) {
        const struct glint_config_line *line = &config->line[i];
        char label[512];
        if (file)
            snprintf(label, sizeof label, "%.400s:%u: %.64s", file, line->number, line->key);
        else
            snprintf(label, sizeof label, "--%.64s", line->key);
        const glint_status one = glint_settings_set(s, line->key, line->value, label, err);
        st = st ? st : one;
    }
    return st;
}

static glint_status read_file(struct glint_settings *s, const char *file, struct glint_error *err)
{
    struct glint_config config;
    glint_status st = glint_config_read(&config, file, err);
    const glint_status set = set_lines(s, &config, file, err);
    glint_config_finish(&config);
    return st ? st : set;
}

// "FOLDER/NAME" of the folder that the environment names, if the file is there. malloc'd or NULL.
static char *found_in(const char *variable, const char *name)
{
    const char *folder = getenv(variable);
    char *path = NULL;
    if (!folder || !*folder ||
        asprintf(&path, "%.*s/%s", (int)strcspn(folder, ":"), folder, name) < 0)
        return NULL;
    if (access(path, F_OK)) {
        free(path);
        return NULL;
    }
    return path;
}

static void use_credential(char **setting, const char *name)
{
    if (!*setting)
        *setting = found_in("CREDENTIALS_DIRECTORY", name);
}

static glint_status set_defaults(struct glint_settings *s, struct glint_error *err)
{
    *s = (struct glint_settings){.log_format = GLINT_LOG_AUTO,
                                 .log_level = GLINT_LOG_INFO,
                                 .checkpoint_seconds = 30,
                                 .drain_seconds = 10};
    return set_text(&s->listen, "127.0.0.1:7745")
               ? GLINT_OK
               : glint_fail(err, GLINT_E_NOMEM, "", "no memory for settings");
}

glint_status glint_settings_read(struct glint_settings *out,
                                 const struct glint_settings_source *source,
                                 struct glint_error *err)
{
    glint_status st = set_defaults(out, err);
    char *usual = source->file ? NULL : found_in("CONFIGURATION_DIRECTORY", "glintd.conf");
    const char *file = source->file ? source->file : usual;
    if (!st && file)
        st = read_file(out, file, err);
    const glint_status given = set_lines(out, &source->given, NULL, err);
    st = st ? st : given;
    use_credential(&out->token_file, "tokens");
    use_credential(&out->tls_cert, "tls.crt");
    use_credential(&out->tls_key, "tls.key");
    if (!st && !out->tls_cert != !out->tls_key)
        st = glint_fail(err, GLINT_E_RANGE, "", "tls_cert and tls_key go together");
    free(usual);
    if (st)
        glint_settings_finish(out);
    return st;
}

void glint_settings_finish(struct glint_settings *settings)
{
    for (const struct row *row = table; row->name; row++)
        if (row->kind == TEXT)
            free(*(char **)((char *)settings + row->offset));
    *settings = (struct glint_settings){0};
}

static bool same(const struct row *row, const void *a, const void *b)
{
    if (row->kind == TEXT) {
        const char *const x = *(char *const *)a, *const y = *(char *const *)b;
        return x && y ? !strcmp(x, y) : x == y;
    }
    const bool wide = row->kind == BYTES || row->kind == SECONDS;
    return !memcmp(a, b, wide ? sizeof(uint64_t) : sizeof(uint32_t));
}

void glint_settings_compare(const struct glint_settings *old, const struct glint_settings *new,
                            void (*changed)(const char *name))
{
    for (const struct row *row = table; row->name; row++)
        if (row->fixed &&
            !same(row, (const char *)old + row->offset, (const char *)new + row->offset))
            changed(row->name);
    if (!old->token_file != !new->token_file)
        changed("token_file");
    if (!old->tls_cert != !new->tls_cert)
        changed("tls_cert");
}
