// accuracy_plot.h - error against cost as SVG: rays and CPU seconds side by side, both axes
// logarithmic, 95% bars, the front in bold, what is dominated hollow.
//
// Thread-safety: reentrant.
#ifndef GLINT_CLI_ACCURACY_PLOT_H
#define GLINT_CLI_ACCURACY_PLOT_H

#include "accuracy_stat.h"
#include "protocol/text.h"

struct glint_accuracy_line {
    const char *name;
    const struct glint_accuracy_point *point; // by ascending samples
    size_t points;
};

struct glint_accuracy_plot {
    const char *title, *error; // of the picture, of the y axis
    const struct glint_accuracy_line *line;
    size_t lines;
};

void glint_accuracy_plot(struct glint_text *out, const struct glint_accuracy_plot *plot);

// & < > " of text from elsewhere, for SVG and HTML.
void glint_accuracy_escape(struct glint_text *out, const char *text);

#endif
