// The plan: which effects a job simulates, why, and what each costs.
import { getJson, jobPath } from "./api.js";
import { bar, h } from "./dom.js";
import { bytes, percent, seconds } from "./format.js";
import { describeProblem } from "./problems.js";

const words = (text) => text.replaceAll("_", " ");

function effect(e) {
    const cost = [e.share !== undefined ? percent(e.share, 1) : null, e.bytes ? bytes(e.bytes) : null];
    return h("li", {},
        h("div.head", {}, h("span", {}, words(e.effect)), h("span.much", {}, cost.filter(Boolean).join(" · "))),
        e.share !== undefined ? bar(e.share) : null,
        h("p.why", {}, e.reason, e.dial ? ` (dial ${e.dial})` : ""),
        e.source ? h("p.why", {}, e.source) : null);
}

function pass(p) {
    return h("li", {},
        h("div.head", {}, h("span", {}, words(p.pass)),
            h("span.much", {}, [p.share !== undefined ? percent(p.share, 1) : null,
                p.seconds !== undefined ? seconds(p.seconds) : null].filter(Boolean).join(" · "))),
        bar(p.share, "soft"));
}

function draw(plan) {
    const by = (a, b) => (b.share ?? -1) - (a.share ?? -1);
    const on = plan.effects.filter((e) => e.on).sort(by), off = plan.effects.filter((e) => !e.on);
    return [
        h("h3", {}, "Passes, share of the time"),
        h("ul.plan", {}, plan.passes.map(pass)),
        h("h3", {}, `${on.length} effects that this job simulates`),
        h("ul.plan", {}, on.map(effect)),
        h("details.plan", {}, h("summary", {}, `${off.length} that nothing calls for`), h("ul.plan", {}, off.map(effect))),
        h("h3", {}, "Accuracy"),
        h("dl.facts-list", {}, Object.entries(plan.accuracy).map(([name, value]) =>
            [h("dt", {}, words(name)), h("dd", {}, words(String(value)))]).flat()),
        h("h3", {}, "Film"),
        h("p.hint", {}, `${bytes(plan.film_bytes)}, ${plan.film_bytes_per_pixel} bytes per pixel`),
    ];
}

export async function showPlan(panel, job) {
    if (panel.dataset.job !== (job?.id ?? ""))
        panel.replaceChildren(h("p.hint", {}, job ? "…" : "No job is chosen."));
    panel.dataset.job = job?.id ?? "";
    if (!job) return;
    try {
        const plan = await getJson(jobPath(job.id, "/plan"));
        const open = panel.querySelector("details")?.open, top = panel.parentElement.scrollTop;
        panel.replaceChildren(...draw(plan));
        if (open) panel.querySelector("details").open = true;
        panel.parentElement.scrollTop = top;
    } catch (error) {
        panel.replaceChildren(...(error.status === 503 ? [h("p.hint", {}, "The job has not been prepared yet.")]
            : describeProblem(error)));
    }
}
