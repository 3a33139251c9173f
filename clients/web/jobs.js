// The list of jobs.
import { h, id, put, Rows } from "./dom.js";
import { count, percent, seconds } from "./format.js";

export const ended = (state) => ["done", "failed", "cancelled"].includes(state);

export const jobTitle = (job) => job.name || job.scene;

function jobFacts(job) {
    const parts = [];
    if (job.job?.live) parts.push("live");
    parts.push(job.target_samples ? `${count(job.samples)} of ${count(job.target_samples)} samples`
        : `${count(job.samples)} samples`);
    if (job.state === "rendering" && job.job?.live) return parts.join(" · ");
    if (job.state === "rendering" && job.eta_seconds) parts.push(`${seconds(job.eta_seconds)} left`);
    else if (job.state === "rendering") parts.push(percent(job.progress));
    else if (job.seconds) parts.push(seconds(job.seconds));
    return parts.join(" · ");
}

export class Jobs {
    // on: {choose(id)}.
    constructor(on) {
        this.on = on;
        this.all = [];
        this.chosen = null;
        this.rows = new Rows(id("jobs"), (job) => job.id, (job) => this.#row(job));
    }

    find(job) {
        return this.all.find((j) => j.id === job);
    }

    // Newest first.
    show(jobs) {
        this.all = jobs;
        id("no-jobs").hidden = jobs.length > 0;
        this.rows.show([...jobs].reverse());
    }

    choose(job) {
        this.chosen = job;
        this.show(this.all);
    }

    // What an event told sooner than the list.
    update(job) {
        this.show(this.all.some((j) => j.id === job.id)
            ? this.all.map((j) => (j.id === job.id ? { ...j, ...job } : j)) : [...this.all, job]);
    }

    #row(first) {
        const title = h("button.title", { type: "button", onclick: () => this.on.choose(first.id) });
        const state = h("span.state", {}), facts = h("p.facts", {}), who = h("span", {});
        const progress = h("progress", { max: 1, "aria-label": "Progress" });
        const element = h("li.card", {}, title, h("p.facts", {}, state, who), facts, progress);
        const update = (job) => {
            const chosen = job.id === this.chosen;
            element.classList.toggle("chosen", chosen);
            title.setAttribute("aria-pressed", chosen);
            put(title, jobTitle(job));
            put(state, job.state);
            state.setAttribute("class", `state ${job.state}`);
            put(who, [job.priority ? ` · priority ${job.priority}` : "", job.client ? ` · ${job.client}` : ""].join(""));
            put(facts, jobFacts(job));
            progress.value = job.progress;
            progress.hidden = ended(job.state);
        };
        return { element, update };
    }
}
