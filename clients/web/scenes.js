// The list of scenes.
import { request, scenePath } from "./api.js";
import { ask, h, id, put, Rows, say } from "./dom.js";
import { bytes, plural, short } from "./format.js";
import { showProblem } from "./problems.js";

function facts(scene) {
    const parts = [`${short(scene.triangles)} triangles`];
    if (scene.objects) parts.push(plural(scene.objects, "object"));
    parts.push(bytes(scene.resident_bytes));
    return parts.join(" · ");
}

function more(scene) {
    const many = { instance: scene.instances, material: scene.materials, light: scene.lights,
        camera: scene.cameras.length, animation: scene.animations?.length };
    return Object.entries(many).filter(([, n]) => n).map(([what, n]) => plural(n, what)).join(", ");
}

export class Scenes {
    // on: {choose(scene), render(scene), live(scene), changed()}.
    constructor(on) {
        this.on = on;
        this.all = [];
        this.chosen = null;
        this.rows = new Rows(id("scenes"), (scene) => scene.name, (scene) => this.#row(scene));
    }

    find(name) {
        return this.all.find((scene) => scene.name === name);
    }

    show(scenes) {
        this.all = scenes;
        if (!this.find(this.chosen)) this.chosen = scenes[0]?.name ?? null;
        id("no-scenes").hidden = scenes.length > 0;
        this.rows.show(scenes);
    }

    choose(name) {
        this.chosen = name;
        this.show(this.all);
    }

    #row({ name }) {
        const find = () => this.find(name);
        const title = h("button.title", { type: "button", onclick: () => this.choose(name) }, name);
        const lines = [h("p.facts", {}), h("p.facts", {})];
        const summary = h("summary", {}), list = h("ul", {}), warnings = h("details", {}, summary, list);
        const actions = h("div.actions", {},
            h("button.small", { type: "button", onclick: () => this.on.live(find()) }, "Live"),
            h("button.small", { type: "button", onclick: () => this.on.render(find()) }, "Render…"),
            h("button.small.bad", { type: "button", onclick: () => this.#remove(name),
                "aria-label": `Delete scene ${name}` }, "Delete"));
        const element = h("li.card", {}, title, lines, warnings, actions);
        const update = (scene) => {
            const chosen = scene.name === this.chosen;
            element.classList.toggle("chosen", chosen);
            title.setAttribute("aria-pressed", chosen);
            put(lines[0], facts(scene));
            put(lines[1], more(scene));
            lines[1].hidden = actions.hidden = !chosen;
            warnings.hidden = !scene.warnings.length;
            put(summary, plural(scene.warnings.length, "warning"));
            if (list.children.length !== scene.warnings.length)
                list.replaceChildren(...scene.warnings.map((text) => h("li", {}, text)));
        };
        return { element, update };
    }

    async #remove(name) {
        if (!(await ask({ title: `Delete ${name}?`, text: "Frames that were rendered of it stay.", yes: "Delete" })))
            return;
        try {
            await request("DELETE", scenePath(name)).catch(async (error) => {
                const force = error.status === 409 && (await ask({ title: `${name} is in use`,
                    text: `${error.message} They keep their revision of it.`, yes: "Delete all the same" }));
                if (!force) throw error.status === 409 ? new DOMException("kept", "AbortError") : error;
                await request("DELETE", scenePath(name, "?force=true"));
            });
            say(`Scene ${name} deleted`);
        } catch (error) {
            showProblem(`${name} was not deleted`, error);
        }
        this.on.changed();
    }
}
