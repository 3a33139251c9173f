#include "accuracy_plot.h"

#include <math.h>
#include <string.h>

#define WIDTH 400
#define HEIGHT 300
#define LEFT 62
#define TOP 34
#define GAP 78
#define LEGEND 190

// Okabe and Ito 2008: told apart by everybody. The first line is the exact twin.
static const char *const colours[] = {"#000000", "#e69f00", "#56b4e9", "#009e73",
                                      "#d55e00", "#0072b2", "#cc79a7", "#888888"};
#define COLOURS (sizeof colours / sizeof *colours)

struct axis {
    double low, high; // decimal logarithms
};

struct panel {
    const struct glint_accuracy_plot *plot;
    enum glint_accuracy_cost cost;
    struct axis x, y;
    double left;
};

void glint_accuracy_escape(struct glint_text *out, const char *text)
{
    for (const char *p = text; *p; p++) {
        const char *code = *p == '&'   ? "&amp;"
                           : *p == '<' ? "&lt;"
                           : *p == '>' ? "&gt;"
                           : *p == '"' ? "&quot;"
                                       : NULL;
        if (code)
            glint_text_add(out, code);
        else
            glint_text_print(out, "%c", *p);
    }
}

// ---- axes

static void widen(struct axis *a, double value)
{
    if (!(value > 0))
        return;
    a->low = fmin(a->low, log10(value));
    a->high = fmax(a->high, log10(value));
}

static bool is_drawn(const struct panel *p, const struct glint_accuracy_point *at)
{
    return at->cost[p->cost] > 0 && at->error.middle > 0;
}

static void measure(struct panel *p)
{
    p->x = p->y = (struct axis){INFINITY, -INFINITY};
    for (size_t l = 0; l < p->plot->lines; l++)
        for (size_t i = 0; i < p->plot->line[l].points; i++) {
            const struct glint_accuracy_point *at = &p->plot->line[l].point[i];
            if (!is_drawn(p, at))
                continue;
            widen(&p->x, at->cost[p->cost]);
            widen(&p->y, at->error.middle);
        }
    struct axis *both[] = {&p->x, &p->y};
    for (int i = 0; i < 2; i++) {
        if (!(both[i]->high >= both[i]->low))
            *both[i] = (struct axis){-1, 1};
        const double room = fmax(0.06 * (both[i]->high - both[i]->low), 0.05);
        both[i]->low -= room;
        both[i]->high += room;
    }
}

static double at_x(const struct panel *p, double value)
{
    return p->left + WIDTH * (log10(value) - p->x.low) / (p->x.high - p->x.low);
}

static double at_y(const struct panel *p, double value)
{
    const double share = (log10(value) - p->y.low) / (p->y.high - p->y.low);
    return TOP + HEIGHT * (1 - fmin(fmax(share, 0), 1));
}

// The least of each decade, or some of it where there is room for them.
static void draw_ticks(struct glint_text *t, const struct panel *p, bool upright)
{
    const struct axis *a = upright ? &p->y : &p->x;
    static const double steps[] = {1, 2, 5, 3, 1.5, 4, 7};
    const double decades = a->high - a->low;
    const int count = decades > 2.2 ? 1 : decades > 0.9 ? 3 : 7;
    for (int e = (int)floor(a->low); e <= (int)ceil(a->high); e++)
        for (int s = 0; s < count; s++) {
            const double value = steps[s] * pow(10, e);
            if (log10(value) < a->low || log10(value) > a->high)
                continue;
            if (upright)
                glint_text_print(t,
                                 "<path class=\"g\" d=\"M%.1f %.1fh%d\"/><text x=\"%.1f\" "
                                 "y=\"%.1f\" text-anchor=\"end\">%g</text>\n",
                                 p->left, at_y(p, value), WIDTH, p->left - 6, at_y(p, value) + 4,
                                 value);
            else
                glint_text_print(t,
                                 "<path class=\"g\" d=\"M%.1f %dv%d\"/><text x=\"%.1f\" y=\"%d\" "
                                 "text-anchor=\"middle\">%g</text>\n",
                                 at_x(p, value), TOP, HEIGHT, at_x(p, value), TOP + HEIGHT + 16,
                                 value);
        }
}

static void draw_frame(struct glint_text *t, const struct panel *p)
{
    static const char *const name[] = {
        [GLINT_COST_RAYS] = "rays", [GLINT_COST_CPU] = "CPU seconds"};
    draw_ticks(t, p, false);
    draw_ticks(t, p, true);
    glint_text_print(t, "<rect x=\"%.1f\" y=\"%d\" width=\"%d\" height=\"%d\" class=\"f\"/>\n",
                     p->left, TOP, WIDTH, HEIGHT);
    glint_text_print(t, "<text x=\"%.1f\" y=\"%d\" text-anchor=\"middle\">%s</text>\n",
                     p->left + WIDTH / 2.0, TOP + HEIGHT + 34, name[p->cost]);
}

// ---- lines

static void draw_path(struct glint_text *t, const struct panel *p,
                      const struct glint_accuracy_line *line, const char *colour)
{
    bool begun = false;
    glint_text_print(t, "<path fill=\"none\" stroke=\"%s\" stroke-opacity=\"0.6\" d=\"", colour);
    for (size_t i = 0; i < line->points; i++) {
        if (!is_drawn(p, &line->point[i]))
            continue;
        glint_text_print(t, "%s%.1f %.1f", begun ? "L" : "M", at_x(p, line->point[i].cost[p->cost]),
                         at_y(p, line->point[i].error.middle));
        begun = true;
    }
    glint_text_print(t, "\"/>\n");
}

static void draw_point(struct glint_text *t, const struct panel *p,
                       const struct glint_accuracy_point *at, const char *colour)
{
    const bool front = at->front[p->cost];
    const double x = at_x(p, at->cost[p->cost]), y = at_y(p, at->error.middle);
    if (isfinite(at->error.high) && at->error.high > 0)
        glint_text_print(t, "<path stroke=\"%s\" d=\"M%.1f %.1fV%.1f\"/>\n", colour, x,
                         at_y(p, at->error.high),
                         at->error.low > 0 ? at_y(p, at->error.low) : (double)(TOP + HEIGHT));
    glint_text_print(t, "<circle cx=\"%.1f\" cy=\"%.1f\" r=\"%s\" stroke=\"%s\" fill=\"%s\"/>\n", x,
                     y, front ? "4.5" : "3.5", colour, front ? colour : "#fff");
}

// The points that nothing dominates, by ascending cost.
static size_t collect_front(const struct panel *p, const struct glint_accuracy_point **out,
                            size_t capacity)
{
    size_t n = 0;
    for (size_t l = 0; l < p->plot->lines; l++)
        for (size_t i = 0; i < p->plot->line[l].points; i++) {
            const struct glint_accuracy_point *at = &p->plot->line[l].point[i];
            if (!at->front[p->cost] || !is_drawn(p, at) || n == capacity)
                continue;
            size_t place = n++;
            for (; place && out[place - 1]->cost[p->cost] > at->cost[p->cost]; place--)
                out[place] = out[place - 1];
            out[place] = at;
        }
    return n;
}

static void draw_front(struct glint_text *t, const struct panel *p)
{
    const struct glint_accuracy_point *front[256];
    const size_t n = collect_front(p, front, 256);
    glint_text_add(t, "<path fill=\"none\" stroke=\"#000\" stroke-opacity=\"0.25\" "
                      "stroke-width=\"7\" stroke-linejoin=\"round\" d=\"");
    for (size_t i = 0; i < n; i++)
        glint_text_print(t, "%s%.1f %.1f", i ? "L" : "M", at_x(p, front[i]->cost[p->cost]),
                         at_y(p, front[i]->error.middle));
    glint_text_add(t, "\"/>\n");
}

static void draw_panel(struct glint_text *t, const struct glint_accuracy_plot *plot,
                       enum glint_accuracy_cost cost)
{
    struct panel p = {.plot = plot, .cost = cost, .left = LEFT + (cost ? WIDTH + GAP : 0)};
    measure(&p);
    draw_frame(t, &p);
    draw_front(t, &p);
    for (size_t l = 0; l < plot->lines; l++) {
        draw_path(t, &p, &plot->line[l], colours[l % COLOURS]);
        for (size_t i = 0; i < plot->line[l].points; i++)
            if (is_drawn(&p, &plot->line[l].point[i]))
                draw_point(t, &p, &plot->line[l].point[i], colours[l % COLOURS]);
    }
}

static void draw_legend(struct glint_text *t, const struct glint_accuracy_plot *plot)
{
    const int left = LEFT + 2 * WIDTH + GAP + 16;
    for (size_t l = 0; l < plot->lines; l++) {
        const int y = TOP + 10 + 18 * (int)l;
        glint_text_print(t,
                         "<path stroke=\"%s\" stroke-width=\"2\" d=\"M%d %dh18\"/>"
                         "<text x=\"%d\" y=\"%d\">",
                         colours[l % COLOURS], left, y, left + 24, y + 4);
        glint_accuracy_escape(t, plot->line[l].name);
        glint_text_add(t, "</text>\n");
    }
}

void glint_accuracy_plot(struct glint_text *out, const struct glint_accuracy_plot *plot)
{
    const int width = LEFT + 2 * WIDTH + GAP + LEGEND, height = TOP + HEIGHT + 44;
    glint_text_print(out,
                     "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 %d %d\" "
                     "width=\"%d\" height=\"%d\" font-family=\"sans-serif\" font-size=\"11\">\n"
                     "<style>.g{stroke:#ddd}.f{fill:none;stroke:#444}</style>\n"
                     "<rect width=\"100%%\" height=\"100%%\" fill=\"#fff\"/>\n"
                     "<text x=\"%d\" y=\"20\" font-size=\"14\">",
                     width, height, width, height, LEFT);
    glint_accuracy_escape(out, plot->title);
    glint_text_print(out, "</text>\n<text x=\"14\" y=\"%d\" transform=\"rotate(-90 14 %d)\" ",
                     TOP + HEIGHT / 2, TOP + HEIGHT / 2);
    glint_text_add(out, "text-anchor=\"middle\">");
    glint_accuracy_escape(out, plot->error);
    glint_text_add(out, "</text>\n");
    draw_panel(out, plot, GLINT_COST_RAYS);
    draw_panel(out, plot, GLINT_COST_CPU);
    draw_legend(out, plot);
    glint_text_add(out, "</svg>\n");
}
