#include "options.h"

#include <getopt.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define MAX_THREADS 256

enum { OPT_LISTEN = 256, OPT_STATE, OPT_THREADS, OPT_LOG_FORMAT, OPT_HELP, OPT_VERSION };

static const struct option options[] = {
    {"listen", required_argument, NULL, OPT_LISTEN},
    {"state", required_argument, NULL, OPT_STATE},
    {"threads", required_argument, NULL, OPT_THREADS},
    {"log-format", required_argument, NULL, OPT_LOG_FORMAT},
    {"help", no_argument, NULL, OPT_HELP},
    {"version", no_argument, NULL, OPT_VERSION},
    {0},
};

static const char help[] =
    "Usage: glintd [OPTION]...\n"
    "Keep scenes resident and render jobs for clients over HTTP.\n"
    "\n"
    "      --listen=ADDR:PORT   serve there, a loopback address; port 0 picks a free one\n"
    "                           (default 127.0.0.1:7745)\n"
    "      --state=DIR          keep state in DIR (default $XDG_STATE_HOME/glint)\n"
    "      --threads=N          render on N threads, 1 to 256 (default: one per core)\n"
    "      --log-format=FORMAT  text (default) or json, to standard error\n"
    "      --help               show this and exit\n"
    "      --version            show the version and exit\n"
    "\n"
    "The first line on standard output says where it listens, once it does.\n"
    "SIGTERM and SIGINT end it in good order, a second one at once.\n";

static int wrong(const char *option, const char *value)
{
    fprintf(stderr, "glintd: --%s does not take \"%s\"\n", option, value);
    return GLINT_EXIT_USAGE;
}

static int read_threads(struct glint_options *out, const char *text)
{
    char *end;
    const unsigned long n = strtoul(text, &end, 10);
    if (*end || strspn(text, "0123456789") != strlen(text) || n < 1 || n > MAX_THREADS)
        return wrong("threads", text);
    out->threads = (uint32_t)n;
    return -1;
}

static int read_format(struct glint_options *out, const char *text)
{
    if (strcmp(text, "text") && strcmp(text, "json"))
        return wrong("log-format", text);
    out->format = text[0] == 'j' ? GLINT_LOG_JSON : GLINT_LOG_TEXT;
    return -1;
}

// As glint_options_parse, for one option.
static int take(struct glint_options *out, int option)
{
    switch (option) {
    case OPT_LISTEN:
        out->listen = optarg;
        return -1;
    case OPT_STATE:
        out->state = optarg;
        return *optarg ? -1 : wrong("state", optarg);
    case OPT_THREADS:
        return read_threads(out, optarg);
    case OPT_LOG_FORMAT:
        return read_format(out, optarg);
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

int glint_options_parse(struct glint_options *out, int argc, char **argv)
{
    *out = (struct glint_options){.listen = "127.0.0.1:7745", .format = GLINT_LOG_TEXT};
    for (int option; (option = getopt_long(argc, argv, "", options, NULL)) != -1;) {
        const int code = take(out, option);
        if (code >= 0)
            return code;
    }
    if (optind == argc)
        return -1;
    fprintf(stderr, "glintd: \"%s\" is no option\nTry 'glintd --help'.\n", argv[optind]);
    return GLINT_EXIT_USAGE;
}
