// progress.h - how far a job is, for people: a bar on a terminal, plain lines elsewhere.
//
// Thread-safety: one owner.
#ifndef GLINT_CLI_PROGRESS_H
#define GLINT_CLI_PROGRESS_H

#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>

enum glint_progress_style {
    GLINT_PROGRESS_NONE,
    GLINT_PROGRESS_BAR,   // one line on the terminal, drawn over and over
    GLINT_PROGRESS_PLAIN, // "Progress: 42%", a line for each per cent
    GLINT_PROGRESS_OPENJD // "openjd_progress: 42.0"
};

struct glint_progress {
    enum glint_progress_style style;
    FILE *out;
    int percent; // last shown, -1: none
    bool drawn;  // the bar stands on the line
};

struct glint_progress_state {
    double fraction;                  // 0..1
    uint32_t samples, target_samples; // target 0: not known
    const char *unit;                 // of these two, NULL: samples
    double error;                     // NAN: not known
    double eta_seconds;               // NAN: not known
    const char *state;                // of the job
    char outlook[48];                 // when its error will be reached, "": not known
};

// "auto" (or NULL), "bar", "plain", "openjd", "none"; false for another name. auto: the bar if
// stderr is a terminal, else plain lines on stdout, or nothing if `quiet` (stdout has a document).
bool glint_progress_init(struct glint_progress *out, const char *style, bool quiet);

void glint_progress_show(struct glint_progress *p, const struct glint_progress_state *state);

// A sentence for people on stderr, above the bar.
void glint_progress_note(struct glint_progress *p, const char *format, ...)
    __attribute__((format(printf, 2, 3)));

// Leaves the terminal's line.
void glint_progress_finish(struct glint_progress *p);

// "1:02:03" or "2:03"; text holds 24 bytes.
const char *glint_progress_duration(double seconds, char text[24]);

#endif
