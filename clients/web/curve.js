// The convergence plot: error over samples, both logarithmic, with where it is to end.
import { getJson, jobPath } from "./api.js";
import { h } from "./dom.js";
import { count, forecast, seconds, short } from "./format.js";
import { describeProblem } from "./problems.js";

const W = 310, H = 230, LEFT = 44, RIGHT = 10, TOP = 12, BOTTOM = 30;

function scale(values, from, to) {
    const low = Math.log10(Math.min(...values)), high = Math.log10(Math.max(...values));
    const span = Math.max(high - low, 0.5), middle = (low + high) / 2;
    const [a, b] = [middle - span * 0.54, middle + span * 0.54];
    const at = (v) => from + ((Math.log10(v) - a) / (b - a)) * (to - from);
    return { at, low: 10 ** a, high: 10 ** b };
}

// The coarsest steps of a decade that give four marks.
function ticks({ low, high }) {
    let all = [];
    for (const steps of [[1], [1, 2, 5], [1, 1.5, 2, 3, 4, 5, 6, 8]]) {
        all = [];
        for (let e = Math.floor(Math.log10(low)); 10 ** e <= high; e++)
            all.push(...steps.map((m) => m * 10 ** e).filter((v) => v >= low && v <= high));
        if (all.length >= 4) break;
    }
    return all;
}

const figure = (v) => String(Number(v.toPrecision(3)));

const tick = (v) => (v >= 10 ? short(v).replace(".0", "") : String(Number(v.toPrecision(2))));

function axes(x, y) {
    return [
        ...ticks(x).map((v) => h("g", {}, h("line.grid", { x1: x.at(v), x2: x.at(v), y1: TOP, y2: H - BOTTOM }),
            h("text", { x: x.at(v), y: H - BOTTOM + 13, "text-anchor": "middle" }, tick(v)))),
        ...ticks(y).map((v) => h("g", {}, h("line.grid", { x1: LEFT, x2: W - RIGHT, y1: y.at(v), y2: y.at(v) }),
            h("text", { x: LEFT - 5, y: y.at(v) + 3.5, "text-anchor": "end" }, tick(v)))),
        h("path.axis", { d: `M${LEFT} ${TOP}V${H - BOTTOM}H${W - RIGHT}`, fill: "none" }),
        h("text", { x: (LEFT + W - RIGHT) / 2, y: H - 2, "text-anchor": "middle" }, "samples per pixel"),
    ];
}

// The ends of the interval around an error that holds in nine cases of ten.
const ends = (p) => [-1, 1].map((sign) => p.error * Math.exp(sign * 0.8224 * p.spread));

function bars(points, aim, x, y) {
    const bar = (x1, x2, y1, y2) => h("line.bar", { x1, x2, y1, y2 });
    return [...points.filter((p) => p.spread).map((p) => {
        const [low, high] = ends(p).map(y.at);
        return bar(x.at(p.samples), x.at(p.samples), low, high);
    }), aim?.range?.[1] ? bar(x.at(aim.range[0]), x.at(aim.range[1]), y.at(aim.error), y.at(aim.error)) : null];
}

function plot(points, { requested_error: wanted, predicted_samples: predicted, estimate }) {
    const last = points.at(-1), aim = wanted && predicted ? { samples: predicted, error: wanted, range: estimate.forecast?.interval } : null;
    const xs = points.map((p) => p.samples), ys = points.map((p) => p.error);
    const x = scale(aim ? [...xs, aim.samples, ...(aim.range?.[1] ? aim.range : [])] : xs, LEFT, W - RIGHT);
    const y = scale(wanted ? [...ys, wanted] : ys, H - BOTTOM, TOP);
    const to = (p) => `${x.at(p.samples).toFixed(1)} ${y.at(p.error).toFixed(1)}`;
    const far = Math.min(x.high, last.samples * (last.error / y.low) ** 2); // where it leaves the plot
    const ideal = { samples: far, error: last.error * Math.sqrt(last.samples / far) };
    const summary = `Error ${figure(last.error)} after ${count(last.samples)} samples` +
        (aim ? `; ${figure(wanted)} predicted at ${count(predicted)} samples` : "");
    return h("svg.plot", { viewBox: `0 0 ${W} ${H}`, role: "img", "aria-label": summary },
        axes(x, y),
        h("path.ideal", { d: `M${to(last)}L${to(ideal)}`, fill: "none" }),
        wanted ? h("line.target", { x1: LEFT, x2: W - RIGHT, y1: y.at(wanted), y2: y.at(wanted) }) : null,
        bars(points, aim, x, y),
        h("path.curve", { d: `M${points.map(to).join("L")}` }),
        points.map((p) => h("circle.dot", { cx: x.at(p.samples), cy: y.at(p.error), r: 2.6 })),
        aim ? h("circle.aim", { cx: x.at(aim.samples), cy: y.at(aim.error), r: 5 }) : null);
}

function table(curve) {
    return h("table", {}, h("thead", {}, h("tr", {}, ["samples", "error", "time", "rays"].map((t) =>
        h("th", { scope: "col" }, t)))),
    h("tbody", {}, curve.map((p) => h("tr", {}, h("td", {}, count(p.samples)),
        h("td", {}, p.error === null ? "–" : figure(p.error)), h("td", {}, seconds(p.seconds)),
        h("td", {}, short(p.rays ?? 0))))));
}

function draw(data) {
    const now = { samples: data.samples, error: data.error };
    const points = data.curve.filter((p) => p.error > 0 && p.samples > 0);
    if (now.error > 0 && now.samples > (points.at(-1)?.samples ?? 0)) points.push(now);
    const words = [data.error > 0 ? `Error ${figure(data.error)} after ${count(data.samples)} samples.` : null,
        data.requested_error ? `Wanted: ${figure(data.requested_error)}.` : null,
        data.estimate.rare_events ? "Rare events dominate the noise: it may be larger." : null,
        forecast(data.estimate.forecast)?.replace(/^/, "Forecast: ").concat(".")];
    return [
        points.length > 1 ? plot(points, data) : h("p.hint", {}, "There is a curve from four samples on."),
        h("p.hint", {}, words.filter(Boolean).join(" ")),
        points.length > 1 ? h("p.hint", {}, "Dotted: one over the square root of the samples.") : null,
        data.curve.length ? table(data.curve) : null,
    ].filter(Boolean);
}

export async function showCurve(panel, job) {
    if (panel.dataset.job !== (job?.id ?? ""))
        panel.replaceChildren(h("p.hint", {}, job ? "…" : "No job is chosen."));
    panel.dataset.job = job?.id ?? "";
    if (!job) return;
    try {
        panel.replaceChildren(...draw(await getJson(jobPath(job.id, "/convergence"))));
    } catch (error) {
        panel.replaceChildren(...(error.status === 503 ? [h("p.hint", {}, "The job has not been prepared yet.")]
            : describeProblem(error)));
    }
}
