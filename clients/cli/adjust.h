// adjust.h - what `glint update JOB` changes of a job that the daemon has.
//
// Thread-safety: one owner.
#ifndef GLINT_CLI_ADJUST_H
#define GLINT_CLI_ADJUST_H

#include "session.h"

// The body of PATCH /v1/jobs/JOB that the options ask for, a new object. What is wrong with them is
// a usage fault, and so is that nothing is asked for.
glint_status glint_adjust_read(struct glint_session *s, const struct glint_arguments *a,
                               cJSON **patch, struct glint_error *err);

// True if an option is given that only jobs have.
bool glint_adjust_is_meant(const struct glint_arguments *a);

#define GLINT_ADJUST_OPTIONS                                                                  \
    {"priority", 0, "N", "of a job: -100..100, higher is first"},                             \
        {"pause", 0, NULL, "a job: give up its workers until it is resumed"},                 \
        {"resume", 0, NULL, "a job: go on"},                                                  \
        {"samples", 'n', "N", "a job: stop at N samples per pixel; goes on if it had ended"}, \
        {"seconds", 't', "S", "a job: stop after S seconds of rendering"},                    \
        {"error", 'e', "E", "a job: stop at an estimated error of E"},                        \
    {                                                                                         \
        "camera", 'c', "NAME|FILE",                                                           \
            "a live job: look through this camera of the scene, or the "                      \
            "one in a JSON file"                                                              \
    }

#endif
