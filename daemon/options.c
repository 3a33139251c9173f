#include "options.h"

#include "base/tokens.h"

#include <getopt.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define MAX_SETTINGS 64
#define NAME_BYTES 32

enum { OPT_SETTING = 256, OPT_CONFIG, OPT_NEW_TOKEN, OPT_HELP, OPT_VERSION };

static const char help[] =
    "Usage: glintd [OPTION]...\n"
    "Keep scenes resident and render jobs for clients over HTTP.\n"
    "\n"
    "      --listen=ADDR:PORT   serve there; port 0 picks a free one (default\n"
    "                           127.0.0.1:7745); other addresses than loopback need\n"
    "                           tokens and TLS\n"
    "      --state=DIR          keep state in DIR (default $XDG_STATE_HOME/glint)\n"
    "      --threads=N          render on N threads, 1 to 256 (default: one per core)\n"
    "      --config=FILE        read settings from FILE; those given here count more\n"
    "      --token-file=FILE    serve only bearers of the tokens in FILE\n"
    "      --new-token=NAME:SCOPE\n"
    "                           make a token to read, to submit or for an admin: its line\n"
    "                           of the file to standard output, the token to standard\n"
    "                           error; then exit\n"
    "      --tls-cert=FILE, --tls-key=FILE\n"
    "                           serve HTTPS with this certificate chain and key (PEM)\n"
    "      --log-format=FORMAT  text or json to standard error (default auto: the\n"
    "                           journal, where it listens, or else text)\n"
    "      --log-level=LEVEL    error, warning, info (default) or debug\n"
    "      --help               show this and exit\n"
    "      --version            show the version and exit\n"
    "\n"
    "Every setting of glintd.conf(5) is an option.\n"
    "The first line on standard output says where it listens, once it does.\n"
    "SIGTERM and SIGINT end it in good order, a second one at once; SIGHUP has it read its\n"
    "files again; SIGUSR1 has it write checkpoints.\n";

static int tell_faults(struct glint_error *err)
{
    for (size_t i = 0; i < err->count; i++)
        fprintf(stderr, "glintd: %s\n", err->fault[i].detail);
    const int code =
        err->status == GLINT_E_RANGE ? GLINT_EXIT_USAGE : glint_status_exit(err->status);
    glint_error_finish(err);
    return code;
}

static int new_token(const char *text)
{
    struct glint_error err = {0};
    char name[GLINT_CLIENT_BYTES] = "", secret[GLINT_TOKEN_BYTES], line[GLINT_TOKEN_LINE_BYTES];
    const char *colon = strchr(text, ':');
    enum glint_scope scope = GLINT_SCOPE_NONE;
    if (colon && (size_t)(colon - text) < sizeof name)
        memcpy(name, text, (size_t)(colon - text));
    if (!colon || !glint_scope_find(colon + 1, &scope))
        glint_fail(&err, GLINT_E_RANGE, "",
                   "--new-token takes NAME:read, NAME:submit or NAME:admin, not \"%.200s\"", text);
    else
        glint_token_draw(secret, line, name, scope, &err);
    if (err.count)
        return tell_faults(&err);
    puts(line);
    fprintf(stderr, "%s\n", secret);
    return 0;
}

static bool add(struct glint_config *given, const char *name, const char *value)
{
    struct glint_config_line *more = realloc(given->line, (given->count + 1) * sizeof *given->line);
    if (!more)
        return false;
    given->line = more;
    more[given->count] = (struct glint_config_line){strdup(name), strdup(value), 0};
    given->count++;
    return more[given->count - 1].key && more[given->count - 1].value;
}

// A setting by its option's name.
static int take_setting(struct glint_config *given, const char *option, const char *value)
{
    char name[NAME_BYTES], label[NAME_BYTES + 2];
    struct glint_settings scratch = {0};
    struct glint_error err = {0};
    snprintf(label, sizeof label, "--%s", option);
    snprintf(name, sizeof name, "%s", option);
    for (char *c = name; *c; c++)
        *c = *c == '-' ? '_' : *c;
    glint_settings_set(&scratch, name, value, label, &err);
    glint_settings_finish(&scratch);
    if (!err.count && !add(given, name, value))
        glint_fail(&err, GLINT_E_NOMEM, "", "no memory for options");
    return err.count ? tell_faults(&err) : -1;
}

// As glint_options_parse, for one option.
static int take(struct glint_settings_source *out, int option, const char *name)
{
    switch (option) {
    case OPT_SETTING:
        return take_setting(&out->given, name, optarg);
    case OPT_CONFIG:
        out->file = optarg;
        return -1;
    case OPT_NEW_TOKEN:
        return new_token(optarg);
    case OPT_HELP:
        fputs(help, stdout);
        return 0;
    case OPT_VERSION:
        puts("glintd " PACKAGE_VERSION);
        return 0;
    default: // getopt_long has named the fault
        fputs("Try 'glintd --help'.\n", stderr);
        return GLINT_EXIT_USAGE;
    }
}

static int parse(struct glint_settings_source *out, int argc, char **argv,
                 const struct option *options)
{
    for (int option, index; (option = getopt_long(argc, argv, "", options, &index)) != -1;) {
        const int code = take(out, option, option == '?' ? NULL : options[index].name);
        if (code >= 0)
            return code;
    }
    if (optind == argc)
        return -1;
    fprintf(stderr, "glintd: \"%s\" is no option\nTry 'glintd --help'.\n", argv[optind]);
    return GLINT_EXIT_USAGE;
}

int glint_options_parse(struct glint_settings_source *out, int argc, char **argv)
{
    struct option options[MAX_SETTINGS + 5] = {
        {"config", required_argument, NULL, OPT_CONFIG},
        {"new-token", required_argument, NULL, OPT_NEW_TOKEN},
        {"help", no_argument, NULL, OPT_HELP},
        {"version", no_argument, NULL, OPT_VERSION},
    };
    char name[MAX_SETTINGS][NAME_BYTES];
    for (size_t i = 0; i < MAX_SETTINGS && glint_settings_name(i); i++) {
        snprintf(name[i], NAME_BYTES, "%s", glint_settings_name(i));
        for (char *c = name[i]; *c; c++)
            *c = *c == '_' ? '-' : *c;
        options[4 + i] = (struct option){name[i], required_argument, NULL, OPT_SETTING};
    }
    *out = (struct glint_settings_source){0};
    const int code = parse(out, argc, argv, options);
    if (code >= 0)
        glint_options_finish(out);
    return code;
}

void glint_options_finish(struct glint_settings_source *source)
{
    glint_config_finish(&source->given);
}
