// The form of a new job: fields for what is set often, JSON for all there is. Both show one job.
import { request, uniqueKey } from "./api.js";
import { h, id, say } from "./dom.js";
import { showProblem } from "./problems.js";

const get = (job, path) => path.reduce((at, key) => at?.[key], job);

function set(job, path, value) {
    const [key, ...rest] = path;
    if (rest.length) {
        const inner = job[key] ?? (typeof rest[0] === "number" ? [] : {});
        set(inner, rest, value);
        if (Object.keys(inner).length) job[key] = inner;
        else delete job[key];
    } else if (value === undefined) delete job[key];
    else job[key] = value;
}

const asNumber = (text) => (text.trim() === "" ? undefined : Number(text));
const asText = (text) => text || undefined;

export class JobForm {
    // on: {submitted(job)}; capabilities: of GET /v1.
    constructor(capabilities, on) {
        Object.assign(this, { capabilities, on, fields: [] });
        this.dialog = id("job-dialog");
        id("job-cancel").addEventListener("click", () => this.dialog.close());
        id("job-form").addEventListener("submit", (event) => {
            event.preventDefault();
            this.#submit();
        });
    }

    open(job, scenes) {
        this.job = structuredClone(job);
        this.scenes = scenes;
        this.key = uniqueKey();
        this.#build();
        id("job-problem").replaceChildren();
        this.dialog.showModal();
        this.fields.find((f) => f.pointer === "/stop/samples").input.focus();
    }

    // A field over one member. pointer: where the daemon's faults lead.
    #field(label, path, input, read) {
        const write = () => set(this.job, path, read(input.value));
        input.addEventListener("input", () => {
            write();
            this.#changed();
        });
        const field = { pointer: "/" + path.join("/"), input, show: () => {
            const value = get(this.job, path);
            input.value = value === undefined ? "" : typeof value === "object" ? "custom" : value;
        } };
        this.fields.push(field);
        return label ? h("label", {}, label, input) : input;
    }

    #number(label, path, attributes) {
        return this.#field(label, path, h("input", { type: "number", step: "any", ...attributes }), asNumber);
    }

    #select(label, path, options) {
        const all = options.map(([value, text]) => h("option", { value }, text));
        return this.#field(label, path, h("select", {}, all), asText);
    }

    #check(label, path) {
        const input = h("input", { type: "checkbox" });
        input.addEventListener("change", () => {
            set(this.job, path, input.checked || undefined);
            this.#changed();
        });
        this.fields.push({ pointer: "/" + path.join("/"), input, show: () => (input.checked = !!get(this.job, path)) });
        return h("label.check", {}, input, label);
    }

    #outputs() {
        const boxes = this.capabilities.outputs.map((name) => {
            const input = h("input", { type: "checkbox", onchange: () => {
                set(this.job, ["outputs"], boxes.filter((b) => b.input.checked).map((b) => b.name));
                this.#changed();
            } });
            return { name, input, label: h("label.check", {}, input, name.replaceAll("_", " ")) };
        });
        const usual = ["beauty", "crypto_object", "crypto_material", "crypto_asset"];
        this.fields.push({ pointer: "/outputs", input: boxes[0].input, show: () =>
            boxes.forEach((b) => (b.input.checked = (this.job.outputs ?? usual).includes(b.name))) });
        return h("fieldset.wide", {}, h("legend", {}, "Outputs"), h("div.checks", {}, boxes.map((b) => b.label)));
    }

    #cameras() {
        const scene = this.scenes.find((s) => s.name === this.job.scene);
        const names = [...new Set(scene?.cameras ?? [])].map((c) => [c, c]);
        const custom = typeof this.job.camera === "object" ? [["custom", "as it is now"]] : [];
        const held = this.job.camera;
        const select = h("select", {}, [["", "the scene's first"], ...custom, ...names].map(([value, text]) =>
            h("option", { value }, text)));
        return this.#field("Camera", ["camera"], select, (value) => (value === "custom" ? held : asText(value)));
    }

    #dials() {
        const { dials, presets } = this.capabilities;
        const settings = dials.filter((d) => d.parent === "accuracy").map((d) => this.#select(
            d.name, ["accuracy", d.name], [["", "as the preset says"], [d.exact, `${d.exact} (exact)`],
                ...d.approximations.map((a) => [a, a])]));
        return [this.#select("Preset", ["accuracy", "preset"], [["", "production"],
            ...presets.filter((p) => p.name !== "production").map((p) => [p.name, p.name])]), ...settings];
    }

    // How far mattes follow what is seen: as it is, in mirrors and glass, rough ones too.
    #mattes() {
        const { exact, approximations } = this.capabilities.dials.find((d) => d.name === "through");
        const through = [exact, ...approximations].filter((v) => v !== "none").map((v) => [v, v]);
        return [this.#select("Mattes through bounces", ["mattes", "through"], [["", "none"], ...through]),
            this.#check("Reflection and refraction apart", ["mattes", "classes"])];
    }

    #json() {
        this.text = h("textarea", { spellcheck: "false", rows: 9 });
        this.text.addEventListener("input", () => {
            try {
                this.job = JSON.parse(this.text.value);
                this.#mark("", "");
                this.fields.forEach((f) => f.input !== document.activeElement && f.show());
            } catch (error) {
                this.#mark("JSON", error.message);
            }
        });
        return h("label.wide", {}, "All of it, as JSON", this.text);
    }

    #build() {
        this.fields = [];
        const scenes = this.scenes.map((s) => [s.name, s.name]);
        const scene = this.#select("Scene", ["scene"], scenes);
        scene.addEventListener("change", () => this.#build());
        const pair = h("div.field", { role: "group", "aria-label": "Resolution" }, "Resolution", h("div.pair", {},
            this.#number(null, ["resolution", 0], { min: 1, max: 16384, "aria-label": "Width" }), "×",
            this.#number(null, ["resolution", 1], { min: 1, max: 16384, "aria-label": "Height" })));
        id("job-fields").replaceChildren(scene, this.#cameras(), pair,
            this.#number("Samples per pixel", ["stop", "samples"], { min: 1, placeholder: "256" }),
            this.#number("Or until the error is", ["stop", "error"], { min: 0, placeholder: "not asked" }),
            this.#number("Or for seconds", ["stop", "seconds"], { min: 0, placeholder: "not asked" }),
            this.#field("Name", ["name"], h("input", { autocomplete: "off" }), asText),
            this.#number("Priority", ["priority"], { min: -100, max: 100, placeholder: "0" }),
            this.#check("Live: follows edits and camera", ["live"]),
            this.#outputs(),
            h("details", {}, h("summary", {}, "Accuracy, time, sampling"), h("div", {},
                this.#dials(), this.#mattes(), this.#number("Bounces", ["max_bounces"], { min: 0, placeholder: "8" }),
                this.#number("Seed", ["seed"], { min: 0, placeholder: "0" }),
                this.#number("Frame", ["frame"], { min: 0, placeholder: "0" }))),
            h("details", {}, h("summary", {}, "JSON"), h("div", {}, this.#json())));
        this.fields.forEach((f) => f.show());
        this.#changed();
    }

    #changed() {
        this.text.value = JSON.stringify(this.job, null, 2);
        this.key = uniqueKey();
    }

    // What is wrong with the fields themselves.
    #mark(name, detail) {
        this.text.setAttribute("aria-invalid", !!detail);
        id("job-submit").disabled = !!detail;
        id("job-problem").replaceChildren(...(detail ? [h("p.problem", {}, `${name}: ${detail}`)] : []));
    }

    // Each field with a fault is marked, the first has the focus, the text names all.
    #showFaults(error) {
        let first = null;
        for (const { pointer, input } of this.fields) {
            const bad = error.errors?.some((e) => e.pointer && (e.pointer === pointer || e.pointer.startsWith(pointer + "/")));
            input.setAttribute("aria-invalid", !!bad);
            if (bad) first ??= input;
        }
        first?.closest("details")?.setAttribute("open", "");
        first?.focus();
    }

    async #submit() {
        id("job-submit").disabled = true;
        try {
            const response = await request("POST", "/v1/jobs", { body: JSON.stringify(this.job),
                type: "application/json", headers: { "Idempotency-Key": this.key } });
            const job = await response.json();
            this.dialog.close();
            say(`Job ${job.name || job.scene} submitted`);
            this.on.submitted(job);
        } catch (error) {
            showProblem("The job was not taken", error, id("job-problem"));
            this.#showFaults(error);
        }
        id("job-submit").disabled = false;
    }
}

export async function submitJob(job) {
    const response = await request("POST", "/v1/jobs", { body: JSON.stringify(job),
        type: "application/json", headers: { "Idempotency-Key": uniqueKey() } });
    return response.json();
}
