#include "progress.h"
#include "problem.h"

#include <math.h>
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>
#include <sys/ioctl.h>
#include <unistd.h>

#define NARROWEST_BAR 10
#define WIDEST_BAR 60

static const struct {
    const char *name;
    enum glint_progress_style style;
} styles[] = {
    {"none", GLINT_PROGRESS_NONE},
    {"bar", GLINT_PROGRESS_BAR},
    {"plain", GLINT_PROGRESS_PLAIN},
    {"openjd", GLINT_PROGRESS_OPENJD},
};

bool glint_progress_init(struct glint_progress *out, const char *style, bool quiet)
{
    *out = (struct glint_progress){.style = quiet ? GLINT_PROGRESS_NONE : GLINT_PROGRESS_PLAIN,
                                   .percent = -1};
    bool known = !style || strcmp(style, "auto") == 0;
    if (known && isatty(STDERR_FILENO))
        out->style = GLINT_PROGRESS_BAR;
    for (size_t i = 0; style && i < sizeof styles / sizeof *styles; i++)
        if (strcmp(style, styles[i].name) == 0) {
            out->style = styles[i].style;
            known = true;
        }
    out->out = out->style == GLINT_PROGRESS_BAR || quiet ? stderr : stdout;
    return known;
}

const char *glint_progress_duration(double seconds, char text[24])
{
    const unsigned long s = (unsigned long)fmin(fmax(ceil(seconds), 0), 1e9);
    if (s < 3600)
        snprintf(text, 24, "%lu:%02lu", s / 60, s % 60);
    else
        snprintf(text, 24, "%lu:%02lu:%02lu", s / 3600, s / 60 % 60, s % 60);
    return text;
}

static int terminal_width(void)
{
    struct winsize size;
    return ioctl(STDERR_FILENO, TIOCGWINSZ, &size) == 0 && size.ws_col ? size.ws_col : 80;
}

static int describe(char *text, size_t size, const struct glint_progress_state *s)
{
    char duration[24];
    int n = snprintf(text, size, " %3d%%  %u", (int)(100 * s->fraction), s->samples);
    if (s->target_samples)
        n += snprintf(text + n, size - (size_t)n, "/%u", s->target_samples);
    n += snprintf(text + n, size - (size_t)n, " %s", s->unit ? s->unit : "samples");
    if (isfinite(s->error))
        n += snprintf(text + n, size - (size_t)n, "  error %.4f", s->error);
    if (*s->outlook)
        n += snprintf(text + n, size - (size_t)n, " (%s)", s->outlook);
    if (isfinite(s->eta_seconds))
        n += snprintf(text + n, size - (size_t)n, "  ETA %s",
                      glint_progress_duration(s->eta_seconds, duration));
    return n;
}

static void draw_bar(struct glint_progress *p, const struct glint_progress_state *s)
{
    char text[220], bar[WIDEST_BAR + 1];
    const int length = describe(text, sizeof text, s);
    int width = terminal_width() - length - 3;
    width = width > WIDEST_BAR ? WIDEST_BAR : width;
    if (width < NARROWEST_BAR) {
        fprintf(p->out, "\r\033[K%s", text + 1);
    } else {
        const int full = (int)(s->fraction * width);
        memset(bar, ' ', (size_t)width);
        memset(bar, '=', (size_t)full);
        if (full < width)
            bar[full] = '>';
        fprintf(p->out, "\r\033[K[%.*s]%s", width, bar, text);
    }
    p->drawn = true;
    fflush(p->out);
}

void glint_progress_show(struct glint_progress *p, const struct glint_progress_state *state)
{
    struct glint_progress_state s = *state;
    s.fraction = fmin(fmax(s.fraction, 0), 1); // NAN becomes 0
    const int percent = (int)(100 * s.fraction);
    if (p->style == GLINT_PROGRESS_BAR) {
        draw_bar(p, &s);
        return;
    }
    if (percent <= p->percent)
        return;
    p->percent = percent;
    if (p->style == GLINT_PROGRESS_PLAIN)
        fprintf(p->out, "Progress: %d%%\n", percent);
    else if (p->style == GLINT_PROGRESS_OPENJD)
        fprintf(p->out, "openjd_progress: %.1f\n", 100 * s.fraction);
    fflush(p->out);
}

void glint_progress_note(struct glint_progress *p, const char *format, ...)
{
    char *text = NULL;
    va_list args;
    va_start(args, format);
    if (vasprintf(&text, format, args) < 0)
        text = NULL;
    va_end(args);
    if (!text)
        return;
    glint_progress_finish(p);
    fputs("glint: ", stderr);
    glint_print_plain(stderr, text);
    fputc('\n', stderr);
    free(text);
}

void glint_progress_finish(struct glint_progress *p)
{
    if (p->drawn)
        fputc('\n', p->out);
    p->drawn = false;
}
