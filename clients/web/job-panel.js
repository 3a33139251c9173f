// One job: its figures, and what can be done with it.
import { jobPath, patchJson, request } from "./api.js";
import { h, put, say } from "./dom.js";
import { bytes, choice, count, forecast, number, seconds, short } from "./format.js";
import { ended, jobTitle } from "./jobs.js";
import { describeProblem, showProblem } from "./problems.js";

const WAITS = { turn: "its turn", preparation: "its program and film", memory: "memory that others hold" };

const interval = (ends) => (ends?.[0] && ends[1] ? ` (${number(ends[0])} to ${number(ends[1])})` : "");

const rejected = (invariants) => Object.values(invariants?.rejected ?? {}).reduce((sum, n) => sum + n, 0);

const ROWS = [
    ["State", (j) => (j.waits_for ? `${j.state}, waits for ${WAITS[j.waits_for] ?? j.waits_for}` : j.state)],
    ["Scene", (j) => j.scene],
    ["Samples", (j) => (j.target_samples ? `${count(j.samples)} of ${count(j.target_samples)}` : count(j.samples))],
    ["Error", (j) => (j.error === null ? "–" : number(j.error) + interval(j.estimate?.interval))],
    ["Rare events", (j) => (j.estimate?.rare_events ? "dominate the noise: the error may be larger" : null)],
    ["Forecast", (j) => forecast(j.estimate?.forecast)],
    ["Not in the error", (j) => j.estimate?.biases.map((b) => `${b.name} ${b.setting}`).join(", ") || null],
    ["Known bias", (j) => (j.estimate?.known_bias
        ? `${number(j.estimate.known_bias)}, with the error ${number(Math.hypot(j.estimate.known_bias, j.error))}` : null)],
    ["Chosen", (j) => j.chosen && choice(j.chosen)],
    ["Time", (j) => seconds(j.seconds) + (j.eta_seconds && !j.job?.live && !ended(j.state) ? `, ${seconds(j.eta_seconds)} left` : "")],
    ["Worker time", (j) => seconds(j.worker_seconds)],
    ["Rays", (j) => (j.rays ? short(j.rays.camera + j.rays.bounce + j.rays.shadow) : "–")],
    ["Sound", (j) => (j.invariants?.sound === false ? "no: more than one sample in a million was rejected" : null)],
    ["Rejected samples", (j) => (rejected(j.invariants) ? count(rejected(j.invariants)) : null)],
    ["Coverage without a slot", (j) => (j.invariants?.coverage_lost ? `${number(100 * j.invariants.coverage_lost)} %` : null)],
    ["Coverage without a rank", (j) => (j.ranks?.left_out
        ? `${number(100 * j.ranks.left_out)} % of a pixel at worst, in ${count(j.ranks.pixels)}; ${j.ranks.needed} levels would do` : null)],
    ["Resolution", (j) => (j.job?.resolution ? j.job.resolution.join(" × ") : "–")],
    ["Memory", (j) => (j.memory_bytes ? bytes(j.memory_bytes) : null)],
    ["Client", (j) => j.client || null],
    ["Revision", (j) => j.revision?.slice(0, 12)],
    ["Id", (j) => j.id],
];

export class JobPanel {
    // on: {changed(job), forgotten(id), again(job)}.
    constructor(panel, on) {
        Object.assign(this, { panel, on, job: null });
    }

    show(job) {
        const fresh = job?.id !== this.job?.id;
        this.job = job;
        if (!job) this.panel.replaceChildren(h("p.hint", {}, "No job is chosen."));
        else if (fresh) this.#build();
        if (job) this.#update();
    }

    #build() {
        this.title = h("h2", {});
        this.values = new Map(ROWS.map(([name]) => [name, [h("dt", {}, name), h("dd", {})]]));
        this.pause = h("button", { type: "button", onclick: () => this.#patch({ paused: this.job.state !== "paused" },
            this.job.state === "paused" ? "resumed" : "paused") });
        this.end = h("button.bad", { type: "button", onclick: () => this.#end() });
        this.samples = h("input", { type: "number", min: 1, max: 16777216, "aria-label": "Samples per pixel" });
        this.priority = h("input", { type: "number", min: -100, max: 100, value: this.job.priority,
            "aria-label": "Priority" });
        this.problem = h("div", {});
        this.warnings = h("ul.warnings", {});
        this.panel.replaceChildren(this.title,
            h("div.row", {}, this.pause, this.end,
                h("button", { type: "button", onclick: () => this.on.again(this.job) }, "Again…")),
            this.problem,
            h("dl.facts-list", {}, [...this.values.values()].flat()),
            h("h3", {}, "More"),
            this.#setting("Samples", this.samples, "Go on", () => this.#more()),
            this.#setting("Priority", this.priority, "Set", () =>
                this.#patch({ priority: Number(this.priority.value) }, `has priority ${this.priority.value}`)),
            this.warnings, this.#source());
    }

    #setting(name, input, verb, act) {
        return h("form.row.setting", { onsubmit: (event) => {
            event.preventDefault();
            act();
        } }, h("label.grow", {}, name, " ", input), h("button", {}, verb));
    }

    #source() {
        this.text = h("pre", { tabindex: 0, "aria-label": "The job as JSON" });
        return h("details.source", {}, h("summary", {}, "As JSON"), this.text);
    }

    #suggest() {
        this.samples.value = 2 * Math.max(this.job.target_samples ?? this.job.samples, 1);
    }

    #update() {
        const { job } = this, over = ended(job.state);
        if (!this.samples.value && (job.target_samples || over)) this.#suggest();
        put(this.title, jobTitle(job));
        for (const [name, value] of ROWS) {
            const [term, text] = this.values.get(name), shown = value(job);
            term.hidden = text.hidden = shown === null || shown === undefined;
            put(text, String(shown ?? ""));
        }
        put(this.pause, job.state === "paused" ? "Resume" : "Pause");
        this.pause.disabled = over;
        put(this.end, over ? "Forget" : "Cancel");
        this.problem.replaceChildren(...(job.problem ? [h("div.problem", {}, h("b", {}, job.problem.title),
            ...describeProblem({ ...job.problem, message: job.problem.detail }))] : []));
        const warnings = job.warnings ?? [];
        if (warnings.join("\n") !== [...this.warnings.children].map((li) => li.textContent).join("\n"))
            this.warnings.replaceChildren(...warnings.map((text) => h("li", {}, text)));
        put(this.text, JSON.stringify(job.job, null, 1));
    }

    async #patch(patch, done) {
        try {
            const job = await patchJson(jobPath(this.job.id), patch);
            say(`Job ${jobTitle(job)} ${done}`);
            this.on.changed(job);
        } catch (error) {
            showProblem("The job was not changed", error);
        }
    }

    async #more() {
        await this.#patch({ stop: { samples: Number(this.samples.value) } }, `goes on to ${this.samples.value} samples`);
    }

    async #end() {
        const { id } = this.job, over = ended(this.job.state);
        try {
            const response = await request("DELETE", jobPath(id));
            say(over ? "Job forgotten" : "Job cancelled; what it rendered stays");
            if (response.status === 204) this.on.forgotten(id);
            else this.on.changed(await response.json());
        } catch (error) {
            showProblem(over ? "The job was not forgotten" : "The job was not cancelled", error);
        }
    }

    toggle() {
        if (this.job && !this.pause.disabled) this.pause.click();
    }
}
