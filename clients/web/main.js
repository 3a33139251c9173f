// The viewer: puts its parts together.
import { getJson, jobPath, onTokenNeeded, request } from "./api.js";
import { ask, id, put, rove, say } from "./dom.js";
import { count, number, percent, plural, seconds, signed } from "./format.js";
import { JobForm, submitJob } from "./job-form.js";
import { JobPanel } from "./job-panel.js";
import { ended, Jobs, jobTitle } from "./jobs.js";
import { showCurve } from "./curve.js";
import { listen } from "./keys.js";
import { Mattes } from "./mattes.js";
import { queryOf, viewsOf } from "./outputs.js";
import { Picture } from "./picture.js";
import { showPlan } from "./plan.js";
import { showProblem } from "./problems.js";
import { Scenes } from "./scenes.js";
import { Session } from "./session.js";
import { Uploads } from "./upload.js";
import { Viewport } from "./viewport.js";

const LIST_EVERY = 1000; // milliseconds
const PANEL_EVERY = 1500;
const LIVE_OUTPUTS = ["beauty", "crypto_object", "crypto_material", "crypto_asset", "depth", "albedo"];

class Viewer {
    constructor() {
        this.picture = new Picture(id("canvas"));
        this.viewport = new Viewport(id("viewport"), id("cross"), this.picture, {
            hover: (at) => this.#read(at), pick: (x, y, several) => this.#pick(x, y, several),
            camera: (kind, dx, dy) => this.session.camera?.move(kind, dx, dy),
            zoomed: (scale) => this.#zoomed(scale),
        });
        this.mattes = new Mattes(this.picture, () => this.viewport.redraw());
        this.session = new Session(this.picture, this.viewport, {
            job: (job) => this.#jobTold(job), gone: (job) => this.#forgotten(job),
            pixels: () => this.#pixels(), link: (text, lost) => this.#link(text, lost),
        });
        this.scenes = new Scenes({ render: (scene) => this.newJob(scene), live: (scene) => this.live(scene),
            changed: () => this.refresh() });
        this.jobs = new Jobs({ choose: (job) => this.open(job) });
        this.panel = new JobPanel(id("panel-job"), { changed: (job) => this.#changed(job),
            forgotten: (job) => this.#forgotten(job), again: (job) => this.#again(job) });
        new Uploads(id("uploads"), (scene) => {
            this.scenes.chosen = scene.name;
            this.refresh();
        });
        onTokenNeeded((refused) => ask({ title: "Who are you?", name: "Token", yes: "Go on",
            text: refused ? "The daemon refused that token. Another one?"
                : "This daemon asks for a token. It is kept until this tab is closed." }));
        this.#listen();
        listen(this);
    }

    async start() {
        try {
            this.capabilities = await getJson("/v1");
            const device = this.capabilities.devices[0];
            put(id("machine"), `${this.capabilities.version} · ${plural(device.workers, "worker")} · ${device.name}`);
            id("tonemap").replaceChildren(...this.capabilities.tonemaps.map((t) => new Option(t, t)));
            this.form = new JobForm(this.capabilities, { submitted: (job) => this.#submitted(job) });
        } catch (error) {
            showProblem("The daemon cannot be asked", error);
            if (error.status !== 401) setTimeout(() => this.start(), 3000);
            return;
        }
        await this.refresh();
        const wanted = location.hash.slice(1);
        const first = this.jobs.find(decodeURIComponent(wanted)) ?? this.jobs.all.at(-1);
        if (first) this.open(first.id);
        this.#poll();
    }

    async #poll() {
        if (!document.hidden) await this.refresh();
        setTimeout(() => this.#poll(), LIST_EVERY);
    }

    async refresh() {
        try {
            const [{ scenes }, { jobs }] = await Promise.all([getJson("/v1/scenes"), getJson("/v1/jobs")]);
            this.scenes.show(scenes);
            this.jobs.show(jobs);
            const shown = jobs.find((j) => j.id === this.session.job?.id);
            if (shown) this.session.changed(shown);
            this.#welcome();
            this.#link("", false);
        } catch (error) {
            this.#link(error.message, true);
        }
    }

    #welcome() {
        id("welcome").hidden = this.picture.width > 0;
        put(id("welcome").firstElementChild, this.scenes.all.length ? "Choose a job, or start one" : "Drop a scene here");
    }

    #link(text, lost) {
        id("link").classList.toggle("lost", lost);
        put(id("link"), text);
    }

    // Jobs

    open(job) {
        if (this.session.job?.id === job) return;
        this.jobs.choose(job);
        history.replaceState(null, "", `#${encodeURIComponent(job)}`);
        this.mattesOf = null;
        this.session.open(job);
    }

    step(by) {
        const all = [...this.jobs.all].reverse(), at = all.findIndex((j) => j.id === this.jobs.chosen);
        const next = all[Math.max(0, Math.min(all.length - 1, at + by))];
        if (next) this.open(next.id);
    }

    #submitted(job) {
        this.jobs.update(job);
        this.open(job.id);
    }

    #changed(job) {
        this.jobs.update(job);
        this.session.changed(job);
    }

    #forgotten(job) {
        this.jobs.show(this.jobs.all.filter((j) => j.id !== job));
        if (this.jobs.chosen !== job) return;
        this.session.close();
        this.mattes.open(null);
        this.panel.show(null);
        this.#showPanel();
        this.#welcome();
    }

    newJob(scene = this.scenes.find(this.scenes.chosen)) {
        if (!this.form) return;
        if (!scene) say("Upload a scene first");
        else this.form.open({ scene: scene.name, resolution: [1280, 720], stop: { samples: 256 } }, this.scenes.all);
    }

    #again({ job }) {
        this.form.open(job, this.scenes.all);
    }

    async live(scene = this.scenes.find(this.scenes.chosen)) {
        if (!scene || !this.capabilities) return;
        const known = LIVE_OUTPUTS.filter((o) => this.capabilities.outputs.includes(o));
        try {
            this.#submitted(await submitJob({ scene: scene.name, live: true, resolution: [960, 540],
                outputs: known, stop: { samples: 4096 }, priority: 10 }));
            id("viewport").focus();
        } catch (error) {
            showProblem("The live job was not taken", error);
        }
    }

    toggle() {
        this.panel.toggle();
    }

    resetCamera() {
        this.session.camera?.reset();
    }

    #jobTold(job) {
        const state = `${job.id} ${job.state}`, changed = state !== this.toldState;
        this.toldState = state;
        if (changed) say(`${jobTitle(job)}: ${job.state}`);
        this.jobs.update(job);
        this.panel.show(job);
        this.#welcome();
        const rate = job.seconds && job.samples ? `${number(job.samples / job.seconds)} samples/s` : "";
        put(id("job-line"), [job.state, `${count(job.samples)} samples`, job.error ? `error ${number(job.error)}` : "",
            seconds(job.seconds), rate].filter(Boolean).join(" · "));
        id("job-progress").value = job.progress;
        this.#controls(job);
        if (this.mattesOf !== job.id) {
            this.mattesOf = job.id;
            this.mattes.open(job);
            this.#showPanel();
        }
        this.mattes.job &&= job;
        if (changed && ended(job.state)) {
            this.#showPanel();
            this.mattes.refresh(true);
        }
    }

    #controls(job) {
        const select = id("output"), views = viewsOf(job.job);
        if ([...select.options].map((o) => o.value).join() !== views.join())
            select.replaceChildren(...views.map((o) => new Option(o.replaceAll("_", " ").replace(":", ": "), o)));
        select.value = this.session.output;
        const canMove = !!this.session.camera;
        id("tool-camera").disabled = !canMove;
        if (canMove && this.cameraOf !== job.id) {
            this.cameraOf = job.id;
            this.tool("camera");
        } else if (!canMove && this.viewport.tool === "camera") this.tool("pan");
    }

    #pixels() {
        this.mattes.refresh();
        this.panelTimer ??= setTimeout(() => {
            this.panelTimer = null;
            this.#showPanel();
        }, PANEL_EVERY);
    }

    // Inspector

    #showPanel() {
        const { job } = this.session;
        if (!id("panel-plan").hidden) showPlan(id("panel-plan"), job);
        if (!id("panel-curve").hidden) showCurve(id("panel-curve"), job);
    }

    tab(tab) {
        for (const button of id("tabs").children) {
            const chosen = button === tab;
            button.setAttribute("aria-selected", chosen);
            button.tabIndex = chosen ? 0 : -1;
            id(button.getAttribute("aria-controls")).hidden = !chosen;
        }
        if (tab.id === "tab-mattes") this.mattes.refresh(true);
        this.#showPanel();
    }

    // Picture

    tool(name) {
        for (const tool of ["pan", "pick", "camera"]) {
            id(`tool-${tool}`).setAttribute("aria-checked", tool === name);
            id(`tool-${tool}`).tabIndex = tool === name ? 0 : -1;
        }
        this.viewport.setTool(name);
    }

    async #pick(x, y, several) {
        this.#read({ x, y });
        if (!this.mattes.job) return;
        const found = await this.mattes.pick(x, y, several);
        if (id("panel-mattes").hidden) this.tab(id("tab-mattes"));
        this.under = found && { x, y, text: Object.values(found).map((l) => l[0]?.name).filter(Boolean).join(" / ") };
        this.#read({ x, y });
    }

    #read(at) {
        const { picture, session } = this;
        if (!at || !picture.width) {
            put(id("readout"), "\u00a0");
            return;
        }
        const { x, y } = at;
        const [r, g, b, a] = picture.value(x, y).map(number);
        const text = session.shown?.value(x, y) ?? `R ${r}  G ${g}  B ${b}  A ${a}`;
        const name = this.under && this.under.x === x && this.under.y === y ? `  ·  ${this.under.text}` : "";
        put(id("readout"), `${x}, ${y}  ·  ${text}${name}`);
    }

    #zoomed(scale) {
        const text = percent(scale, scale < 0.1 ? 1 : 0);
        put(id("zoom-text"), text);
        id("zoom-text").setAttribute("aria-label", `Zoom ${text}`);
    }

    expose(by) {
        const input = id("exposure");
        input.value = by ? Number(input.value) + by : 0;
        this.#looks();
    }

    #looks() {
        const { looks } = this.picture, stops = Number(id("exposure").value);
        looks.exposure = stops;
        looks.tone = id("tonemap").value;
        put(id("exposure-text"), signed(stops));
        id("exposure").setAttribute("aria-valuetext", `${signed(stops)} stops`);
        this.viewport.redraw();
    }

    zoom(up) {
        this.viewport.step(up);
    }

    actual() {
        this.viewport.zoom(1);
    }

    fit() {
        this.viewport.fitAgain();
    }

    nextShow() {
        const all = [...document.querySelectorAll("[name=matte-show]")];
        const next = all[(all.findIndex((r) => r.checked) + 1) % all.length];
        next.checked = true;
        next.dispatchEvent(new Event("input", { bubbles: true }));
        say(`Matte shown as ${next.value}`);
    }

    nextThrough() {
        this.mattes.nextThrough();
    }

    async #save(path, name) {
        id("save").open = false;
        try {
            const blob = await (await request("GET", path)).blob();
            const link = document.createElement("a");
            link.href = URL.createObjectURL(blob);
            link.download = name;
            link.click();
            setTimeout(() => URL.revokeObjectURL(link.href), 10000);
        } catch (error) {
            showProblem(`${name} was not saved`, error);
        }
    }

    click(name) {
        const button = id(name);
        if (!button.disabled) button.click();
    }

    #listen() {
        const on = (name, type, f) => id(name).addEventListener(type, f);
        const file = (ending) => `${(jobTitle(this.session.job) || "frame").replace(/[^\w.-]+/g, "-")}.${ending}`;
        on("new-job", "click", () => this.newJob());
        on("show-keys", "click", () => id("keys-dialog").showModal());
        on("exposure", "input", () => this.#looks());
        on("tonemap", "change", () => this.#looks());
        on("output", "change", () => this.session.choose(id("output").value));
        on("zoom-in", "click", () => this.zoom(true));
        on("zoom-out", "click", () => this.zoom(false));
        on("zoom-text", "click", () => this.actual());
        on("zoom-fit", "click", () => this.fit());
        on("ask-no", "click", () => id("ask-dialog").close(""));
        for (const tool of ["pan", "pick", "camera"]) on(`tool-${tool}`, "click", () => this.tool(tool));
        for (const button of id("tabs").children) button.addEventListener("click", () => this.tab(button));
        rove(id("tabs"), "[role=tab]");
        rove(id("tool-pan").parentElement, "[role=radio]");
        const path = (rest) => jobPath(this.session.job.id, rest);
        on("save-exr", "click", () => this.session.job && this.#save(path("/frame.exr"), file("exr")));
        on("save-png", "click", () => this.session.job && this.#save(path(`/frame.png?${queryOf(this.session.output)}` +
            `&exposure=${id("exposure").value}&tonemap=${id("tonemap").value}`), file("png")));
        on("save-matte", "click", () => this.#save(
            path(`/matte.exr?layer=${this.mattes.layer}${this.mattes.query()}`), file("matte.exr")));
        addEventListener("beforeunload", () => this.session.close());
    }
}

export const viewer = new Viewer(); // for measurements of what it draws
viewer.start();
