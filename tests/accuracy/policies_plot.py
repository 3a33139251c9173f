#!/usr/bin/python3
"""policies_plot.py - a figure from the rows of tests/accuracy/policies:

    tests/accuracy/policies_plot.py policies.csv policies.svg

Over the number of slots, for each policy: what the forty stripes lose, the bias and the variance of
their mattes, and the share of the pixels of three demo scenes whose mattes are off by more than 1/255.
"""
import csv
import math
import sys

COLOURS = {"drop": "#7a7a7a", "direct_first": "#b08a2e", "uss": "#2f6fd0", "uss_direct_first": "#8a4fbf",
           "chao": "#c8442e", "best": "#444444", "spill": "#1b8a5a"}
DASHES = {"best": "2 3", "direct_first": "7 4", "uss_direct_first": "7 4"}
SLOTS = [4, 6, 8, 12, 16, 24, 32]
WIDTH, HEIGHT, LEFT, TOP, GAP = 230, 190, 56, 34, 62
STYLE = ("text{font:12px sans-serif;fill:#333}.title{font-weight:bold}.grid{stroke:#ddd;fill:none}"
         "polyline{fill:none;stroke-width:2}")


class Panel:
    """A logarithmic axis from `low` to `high`; what is below, 0 too, lies on the axis."""

    def __init__(self, at, title, low, high):
        self.x, self.low, self.high, self.out = LEFT + at * (WIDTH + GAP), low, high, []
        for decade in range(round(math.log10(low)), round(math.log10(high)) + 1):
            y = self.y(10.0 ** decade)
            label = f"1e{decade}" if decade > round(math.log10(low)) else f"≤1e{decade}"
            self.out.append(f'<path class="grid" d="M{self.x} {y:.1f}h{WIDTH}"/>'
                            f'<text x="{self.x - 6}" y="{y + 4:.1f}" text-anchor="end">{label}</text>')
        for n in SLOTS:
            self.out.append(f'<text x="{self.px(n):.1f}" y="{TOP + HEIGHT + 16}" '
                            f'text-anchor="middle">{n}</text>')
        middle = self.x + WIDTH / 2
        self.out.append(f'<text x="{middle}" y="{TOP - 12}" text-anchor="middle" class="title">{title}'
                        f'</text><text x="{middle}" y="{TOP + HEIGHT + 34}" text-anchor="middle">slots'
                        '</text>')

    def px(self, n):
        return self.x + WIDTH * math.log(n / SLOTS[0]) / math.log(SLOTS[-1] / SLOTS[0])

    def y(self, value):
        share = math.log(max(value, self.low) / self.low) / math.log(self.high / self.low)
        return TOP + HEIGHT * (1 - min(share, 1))

    def line(self, points, policy):
        path = " ".join(f"{self.px(n):.1f},{self.y(v):.1f}" for n, v in points)
        dash = f' stroke-dasharray="{DASHES[policy]}"' if policy in DASHES else ""
        self.out.append(f'<polyline points="{path}" stroke="{COLOURS[policy]}"{dash}/>')


def rows_of(rows, scene, policy):
    return [r for r in rows if r["scene"] == scene and r["policy"] == policy and r["kind"] == "bounced"]


def draw(rows):
    panels = [Panel(0, "forty: coverage lost", 1e-4, 1e-1), Panel(1, "forty: bias", 1e-4, 1e-1),
              Panel(2, "forty: variance", 1e-8, 1e-2)]
    for panel, column in zip(panels, ("lost", "bias", "var")):
        for policy in COLOURS:
            panel.line([(int(r["slots"]), float(r[column])) for r in rows_of(rows, "forty", policy)],
                       policy)
    for at, scene in enumerate(("plant", "shelves", "cluster"), 3):
        panels.append(Panel(at, f"{scene}: pixels off by 1/255", 1e-4, 1))
        for policy in COLOURS:
            panels[-1].line([(int(r["slots"]), 1 - float(r["within"]))
                             for r in rows_of(rows, scene, policy)], policy)
    return panels


def legend(y):
    out = []
    for i, (policy, colour) in enumerate(COLOURS.items()):
        x = LEFT + i * 190
        dash = f' stroke-dasharray="{DASHES[policy]}"' if policy in DASHES else ""
        out.append(f'<polyline points="{x},{y} {x + 30},{y}" stroke="{colour}"{dash}/>'
                   f'<text x="{x + 36}" y="{y + 4}">{policy}</text>')
    return out


def main(source, target):
    with open(source, newline="", encoding="utf-8") as file:
        rows = [r for r in csv.DictReader(file) if r["kind"]]
    panels = draw(rows)
    width, height = LEFT + len(panels) * (WIDTH + GAP), TOP + HEIGHT + 74
    body = [line for panel in panels for line in panel.out] + legend(height - 16)
    with open(target, "w", encoding="utf-8") as file:
        file.write(f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width} {height}"><style>{STYLE}'
                   f'</style><rect width="{width}" height="{height}" fill="#fff"/>' + "\n".join(body)
                   + "</svg>\n")


if __name__ == "__main__":
    main(*sys.argv[1:3])
