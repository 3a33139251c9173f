"""soak_plot.py - the record of soak as one SVG: a panel for each quantity over the minutes."""

WIDTH, PANEL, LEFT, RIGHT, TOP = 900, 110, 110, 20, 30
TITLES = {"rss_bytes": ("resident memory, MiB", 1 << 20),
          "other_bytes": ("of it no film and no scene, MiB", 1 << 20),
          "heap_bytes": ("heap, used and free, MiB", 1 << 20), "descriptors": ("descriptors", 1),
          "threads": ("threads", 1), "disk_bytes": ("state folder, MiB", 1 << 20),
          "cache_bytes": ("kernel cache, MiB", 1 << 20),
          "resident_bytes": ("scenes resident, MiB", 1 << 20), "jobs": ("jobs known", 1)}


def panel(rows, name, top, verdict, judged_from):
    title, unit = TITLES[name]
    values = [row[name] / unit for row in rows]
    end, most = rows[-1]["seconds"] or 1, max(values) * 1.1 or 1
    inner, height = WIDTH - LEFT - RIGHT, PANEL - 34

    def x(seconds):
        return LEFT + inner * seconds / end

    def y(value):
        return top + height - height * value / most

    points = " ".join(f"{x(row['seconds']):.1f},{y(v):.1f}" for row, v in zip(rows, values))
    grew = f"grew {verdict['grew'] / unit:.2f} of {verdict['bound'] / unit:.2f} allowed"
    colour = "#2a6" if verdict["flat"] else "#c22"
    return f"""<text x="{LEFT}" y="{top - 6}" font-weight="bold">{title}</text>
<text x="{WIDTH - RIGHT}" y="{top - 6}" text-anchor="end" fill="{colour}">{grew}</text>
<rect x="{x(judged_from):.1f}" y="{top}" width="{x(end) - x(judged_from):.1f}" height="{height}" \
fill="#eef3f8"/>
<path d="M{LEFT},{top}V{top + height}H{WIDTH - RIGHT}" fill="none" stroke="#888"/>
<text x="{LEFT - 6}" y="{top + 8}" text-anchor="end">{most:.4g}</text>
<text x="{LEFT - 6}" y="{top + height}" text-anchor="end">0</text>
<polyline points="{points}" fill="none" stroke="#1659a5" stroke-width="1.2"/>"""


def draw(rows, verdicts, judged_from):
    """judged_from: seconds from which on the record counts; that part is shaded."""
    height = TOP + PANEL * len(TITLES) + 20
    body = "\n".join(panel(rows, name, TOP + PANEL * i, verdicts[name], judged_from)
                     for i, name in enumerate(TITLES))
    minutes = rows[-1]["seconds"] / 60
    return f"""<svg xmlns="http://www.w3.org/2000/svg" width="{WIDTH}" height="{height}" \
font-family="sans-serif" font-size="12">
<rect width="100%" height="100%" fill="white"/>
{body}
<text x="{LEFT}" y="{height - 12}">0</text>
<text x="{WIDTH - RIGHT}" y="{height - 12}" text-anchor="end">{minutes:.0f} minutes; \
shaded: what is judged</text>
</svg>
"""
