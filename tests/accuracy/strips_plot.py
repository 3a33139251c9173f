#!/usr/bin/python3
"""strips_plot.py - from the rows of tests/accuracy/strips to a figure and a table:

    tests/accuracy/strips_plot.py strips.csv strips-error.svg > table.md

The figure: total variation between mattes and brute force over roughness, for each alpha, Eq. 6 solid
and Eq. 5 dashed, by both readings of brute force; and over the distance of what is reflected, at the
default alpha. The table: pixels of which some matte is off by more than 0.1.
"""
import csv
import sys

COLOURS = {0.0: "#7a7a7a", 0.05: "#1b8a5a", 0.1: "#c8442e", 0.3: "#2f6fd0", 1.0: "#8a4fbf"}
DISTANCES = ["0-0.25", "0.25-0.5", "0.5-1", "1-2", "2-"]
WIDTH, HEIGHT, LEFT, TOP, GAP = 250, 190, 46, 34, 58


def read(path):
    with open(path, newline="", encoding="utf-8") as file:
        return [{k: v if k in ("reading", "bend", "distance") else float(v) for k, v in row.items()}
                for row in csv.DictReader(file)]


def pick(rows, **wanted):
    return [r for r in rows if all(r[k] == v for k, v in wanted.items())]


class Panel:
    """Axes from 0 to 1 at column `at`."""

    def __init__(self, at, title, x_label, ticks):
        self.x, self.out = LEFT + at * (WIDTH + GAP), []
        for v in (0, 0.2, 0.4, 0.6, 0.8):
            y = self.y(v)
            self.out.append(f'<path class="grid" d="M{self.x} {y:.1f}h{WIDTH}"/>')
            self.out.append(f'<text x="{self.x - 6}" y="{y + 4:.1f}" text-anchor="end">{v:g}</text>')
        for share, text in ticks:
            self.out.append(f'<text x="{self.px(share):.1f}" y="{TOP + HEIGHT + 16}" '
                            f'text-anchor="middle">{text}</text>')
        middle = self.x + WIDTH / 2
        self.out.append(f'<text x="{middle}" y="{TOP - 12}" text-anchor="middle" class="title">{title}</text>')
        self.out.append(f'<text x="{middle}" y="{TOP + HEIGHT + 34}" text-anchor="middle">{x_label}</text>')

    def px(self, share):
        return self.x + share * WIDTH

    @staticmethod
    def y(value):
        return TOP + HEIGHT * (1 - value / 0.8)

    def line(self, points, colour, dashed):
        path = " ".join(f"{self.px(x):.1f},{self.y(min(v, 0.8)):.1f}" for x, v in points)
        dash = ' stroke-dasharray="5 4"' if dashed else ""
        self.out.append(f'<polyline points="{path}" stroke="{colour}"{dash}/>')


def over_roughness(rows, at, reading, title):
    panel = Panel(at, title, "roughness", [(r / 7, f"0.{r}") for r in range(8)])
    for alpha, colour in COLOURS.items():
        for clamp in (1.0, 0.0):
            of = pick(rows, reading=reading, alpha=alpha, clamp=clamp, cut=0.0, bend="any", distance="any")
            panel.line([(r["roughness"] / 0.7, r["tv"]) for r in of], colour, not clamp)
    return panel.out


def over_distance(rows, at):
    panel = Panel(at, "sub-ray coverage, alpha 0.1", "metres to what is reflected",
                  [((i + 0.5) / 5, d) for i, d in enumerate(DISTANCES)])
    for rough, colour in ((0.1, "#1b8a5a"), (0.2, "#2f6fd0"), (0.4, "#c8442e"), (0.7, "#8a4fbf")):
        for clamp in (1.0, 0.0):
            of = pick(rows, reading="coverage", alpha=0.1, clamp=clamp, cut=0.0, bend="any", roughness=rough)
            points = [((DISTANCES.index(r["distance"]) + 0.5) / 5, r["tv"]) for r in of
                      if r["distance"] != "any" and r["pixels"] >= 20]
            panel.line(points, colour, not clamp)
    return panel.out


def legend():
    out = []
    for i, (alpha, colour) in enumerate(COLOURS.items()):
        x = LEFT + 108 * i
        out.append(f'<polyline points="{x},268 {x + 22},268" stroke="{colour}"/>')
        out.append(f'<text x="{x + 28}" y="272">alpha {alpha:g}</text>')
    x = LEFT + 2 * (WIDTH + GAP)
    for i, (rough, colour) in enumerate((("0.1", "#1b8a5a"), ("0.2", "#2f6fd0"), ("0.4", "#c8442e"), ("0.7", "#8a4fbf"))):
        out.append(f'<polyline points="{x + 64 * i},268 {x + 64 * i + 18},268" stroke="{colour}"/>')
        out.append(f'<text x="{x + 64 * i + 22}" y="272">r {rough}</text>')
    return out


def figure(rows, path):
    width = LEFT + 3 * WIDTH + 2 * GAP + 12
    parts = [f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width} 284" font-family="sans-serif" '
             'font-size="11"><style>polyline{fill:none;stroke-width:1.8}.grid{stroke:#ddd}'
             '.title{font-size:12.5px;font-weight:600}</style><rect width="100%" height="100%" fill="#fff"/>',
             *over_roughness(rows, 0, "coverage", "total variation to sub-ray coverage"),
             *over_roughness(rows, 1, "share", "to the share of equal sub-rays"),
             *over_distance(rows, 2), *legend(), "</svg>"]
    with open(path, "w", encoding="utf-8") as file:
        file.write("\n".join(parts) + "\n")


def table(rows):
    print("| reading | alpha | bend | pixels | off, Eq. 6 | off, Eq. 5 | total variation, Eq. 6 | Eq. 5 |")
    print("| --- | --- | --- | --- | --- | --- | --- | --- |")
    for reading in ("coverage", "share"):
        for alpha in (0.05, 0.1, 0.3, 1.0):
            for bend in ("bulging", "hollow"):
                cells = []
                for clamp in (1.0, 0.0):
                    of = pick(rows, reading=reading, alpha=alpha, clamp=clamp, cut=0.0, bend=bend, distance="any")
                    pixels = sum(r["pixels"] for r in of)
                    cells.append((pixels, sum(r["off"] for r in of), sum(r["tv"] * r["pixels"] for r in of) / pixels))
                (n, off6, tv6), (_, off5, tv5) = cells
                print(f"| {reading} | {alpha:g} | {bend} | {n:.0f} | {off6:.0f} | {off5:.0f} | {tv6:.3f} | {tv5:.3f} |")


def main():
    rows = read(sys.argv[1])
    figure(rows, sys.argv[2])
    table(rows)


if __name__ == "__main__":
    main()
