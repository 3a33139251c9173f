// main.c - glint, the command-line client.
#include "command.h"
#include "interrupt.h"
#include "problem.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sysexits.h>

#define EXIT_CANCELLED 130 // as a shell reports a program that Ctrl-C ended

static const struct glint_command *const commands[] = {
    &glint_command_render,   &glint_command_submit,  &glint_command_put,    &glint_command_scenes,
    &glint_command_update,   &glint_command_jobs,    &glint_command_watch,  &glint_command_top,
    &glint_command_get,      &glint_command_cancel,  &glint_command_mattes, &glint_command_matte,
    &glint_command_pick,     &glint_command_recolor, &glint_command_plan,   &glint_command_merge,
    &glint_command_accuracy,
};
#define COMMANDS (sizeof commands / sizeof *commands)

static const struct glint_option common[] = {
    {"server", 's', "URL", "the daemon ($GLINT_SERVER, else " GLINT_DEFAULT_SERVER ")"},
    {"token-file", 0, "FILE", "who you are: a file with the daemon's token ($GLINT_TOKEN)"},
    {"ca-file", 0, "FILE", "certificates to trust, instead of the system's ($GLINT_CA_FILE)"},
    {"json", 'j', NULL, "print one JSON document"},
    {"help", 'h', NULL, "print this help"},
    {"version", 'V', NULL, "print the version"},
    {0},
};

static const struct glint_option none[] = {{0}};

static void print_version(void)
{
    puts(PACKAGE_STRING);
}

static void print_overview(FILE *out)
{
    fputs("Usage: glint COMMAND [OPTION]...\n"
          "Renders scenes with a glintd daemon.\n\nCommands:\n",
          out);
    for (size_t i = 0; i < COMMANDS; i++)
        fprintf(out, "  %-8s %s\n", commands[i]->name, commands[i]->summary);
    fputs("\n'glint COMMAND --help' tells more of each.\n"
          "Exit status: 0 done, 1 failed, 64 wrong usage, 69 no daemon, 75 try again\n"
          "later, 130 cancelled.\n",
          out);
}

static void print_help(const struct glint_command *c)
{
    printf("Usage: glint %s [OPTION]...%s%s\n%s.\n", c->name, *c->operands ? " " : "", c->operands,
           c->summary);
    if (c->detail)
        printf("\n%s\n", c->detail);
    puts("\nOptions:");
    if (c->options)
        glint_options_help(c->options);
    glint_options_help(common);
}

static const struct glint_command *find(const char *name)
{
    for (size_t i = 0; i < COMMANDS; i++)
        if (strcmp(commands[i]->name, name) == 0)
            return commands[i];
    return NULL;
}

static glint_status check(const struct glint_command *c, const struct glint_arguments *a,
                          struct glint_error *err)
{
    if (a->count < c->least)
        return glint_fail(err, GLINT_E_RANGE, "", "%s wants %s", c->name, c->operands);
    if (a->count > c->most)
        return glint_fail(err, GLINT_E_RANGE, "", "%s: one argument too many: '%s'", c->name,
                          a->text[c->most]);
    return GLINT_OK;
}

// Only what a script would act upon differently has a code of its own.
static int exit_code(const struct glint_session *s, glint_status status)
{
    if (glint_interrupt_seen() || s->cancelled)
        return EXIT_CANCELLED;
    if (s->usage)
        return EX_USAGE;
    const int code = status ? glint_status_exit(status) : EXIT_SUCCESS;
    return !code || code == EX_UNAVAILABLE || code == EX_TEMPFAIL ? code : EXIT_FAILURE;
}

static void report(const struct glint_session *s, const struct glint_command *c,
                   const struct glint_error *err)
{
    glint_problem_print(stderr, err);
    if (s->usage)
        fprintf(stderr, "Try 'glint %s --help'.\n", c->name);
    if (s->json)
        glint_session_print(glint_problem_write(err));
}

static int run(const struct glint_command *c, const struct glint_arguments *a, bool parsed,
               struct glint_error *err)
{
    struct glint_session s = {.json = glint_options_flag(a, "json")};
    glint_progress_init(&s.progress, NULL, s.json);
    glint_status status = parsed ? check(c, a, err) : GLINT_E_RANGE;
    s.usage = status != GLINT_OK;
    if (!status && !glint_interrupt_watch())
        status = glint_fail(err, GLINT_E_INTERNAL, "", "signals cannot be watched");
    if (!status)
        status = c->run(&s, a, err);
    glint_session_close(&s, status ? err : NULL);
    if (status)
        report(&s, c, err);
    return exit_code(&s, status);
}

// A full disk behind stdout is a failure.
static int flushed(int code)
{
    const bool failed = ferror(stdout) || fflush(stdout) != 0;
    if (failed && !code) {
        perror("glint: stdout");
        return EXIT_FAILURE;
    }
    return code;
}

int main(int argc, char **argv)
{
    if (argc < 2) {
        print_overview(stderr);
        return EX_USAGE;
    }
    if (strcmp(argv[1], "--help") == 0 || strcmp(argv[1], "-h") == 0)
        return print_overview(stdout), flushed(EXIT_SUCCESS);
    if (strcmp(argv[1], "--version") == 0 || strcmp(argv[1], "-V") == 0)
        return print_version(), flushed(EXIT_SUCCESS);
    const struct glint_command *c = find(argv[1]);
    if (!c) {
        fprintf(stderr, "glint: unknown command '%s'\nTry 'glint --help'.\n", argv[1]);
        return EX_USAGE;
    }

    struct glint_error err = {0};
    struct glint_arguments a = {.table = {c->options ? c->options : none, common}};
    const bool parsed = glint_options_parse(&a, argc - 1, argv + 1, &err) == GLINT_OK;
    int code = EXIT_SUCCESS;
    if (parsed && glint_options_flag(&a, "help"))
        print_help(c);
    else if (parsed && glint_options_flag(&a, "version"))
        print_version();
    else
        code = run(c, &a, parsed, &err);
    glint_error_finish(&err);
    return flushed(code);
}
