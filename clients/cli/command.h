// command.h - the subcommands of glint, one row each.
#ifndef GLINT_CLI_COMMAND_H
#define GLINT_CLI_COMMAND_H

#include "session.h"

struct glint_command {
    const char *name, *operands, *summary;
    const char *detail;                 // more help, or NULL
    const struct glint_option *options; // beside the common ones
    int least, most;                    // operands
    glint_status (*run)(struct glint_session *s, const struct glint_arguments *a,
                        struct glint_error *err);
};

extern const struct glint_command glint_command_accuracy, glint_command_cancel, glint_command_get,
    glint_command_jobs, glint_command_matte, glint_command_mattes, glint_command_merge,
    glint_command_pick, glint_command_plan, glint_command_put, glint_command_recolor,
    glint_command_render, glint_command_scenes, glint_command_submit, glint_command_top,
    glint_command_update, glint_command_watch;

#endif
