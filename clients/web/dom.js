// Small helpers over the page.

export const id = (name) => document.getElementById(name);

const SVG = "http://www.w3.org/2000/svg";
const SVG_TAGS = new Set(["svg", "g", "path", "line", "rect", "circle", "text", "polyline", "title"]);

// h("button.main", {type: "button", onclick: f}, "text", child, ...): an element. Text is text, never
// markup, whatever a name of a scene may contain.
export function h(what, attributes, ...children) {
    const [tag, ...classes] = what.split(".");
    const e = SVG_TAGS.has(tag) ? document.createElementNS(SVG, tag) : document.createElement(tag);
    if (classes.length) e.setAttribute("class", classes.join(" "));
    for (const [name, value] of Object.entries(attributes ?? {})) {
        if (value === null || value === undefined || value === false) continue;
        if (name.startsWith("on")) e.addEventListener(name.slice(2), value);
        else if (name === "value" || name === "checked" || name === "disabled") e[name] = value;
        else e.setAttribute(name, value === true ? "" : value);
    }
    e.append(...children.flat().filter((c) => c !== null && c !== undefined));
    return e;
}

// Tells it to who listens to the page instead of looking at it.
export function say(text) {
    id("said").textContent = text;
}

// Keeps a list of elements in step with data: rows are made once, then updated in place, so that
// focus and pointers stay where they are. make(item) returns {element, update(item)}.
export class Rows {
    constructor(list, key, make) {
        Object.assign(this, { list, key, make, rows: new Map() });
    }

    show(items) {
        const wanted = new Set(items.map(this.key));
        for (const [k, row] of this.rows)
            if (!wanted.has(k)) {
                row.element.remove();
                this.rows.delete(k);
            }
        items.forEach((item, at) => {
            const k = this.key(item);
            if (!this.rows.has(k)) this.rows.set(k, this.make(item));
            const row = this.rows.get(k);
            row.update(item);
            if (this.list.children[at] !== row.element)
                this.list.insertBefore(row.element, this.list.children[at] ?? null);
        });
    }
}

// Sets text only where it changed: screen readers and selections are left alone otherwise.
export function put(element, text) {
    if (element.textContent !== text) element.textContent = text;
}

// A bar of a share from 0 to 1, for the eye: the number is beside it.
export function bar(share, kind = "") {
    const width = Math.max(0, Math.min(1, share || 0)) * 100;
    return h("svg.cost" + (kind && "." + kind), { viewBox: "0 0 100 6", preserveAspectRatio: "none",
        "aria-hidden": "true" },
        h("rect.rail", { width: 100, height: 6 }), h("rect.fill", { width, height: 6 }));
}

// Asks and answers with true, or with the text where one is asked for; null: no.
export function ask({ title, text, yes, name, value }) {
    const dialog = id("ask-dialog"), input = id("ask-input");
    id("ask-title").textContent = title;
    id("ask-text").textContent = text ?? "";
    id("ask-yes").textContent = yes;
    id("ask-label").hidden = !name;
    id("ask-name").textContent = name ?? "";
    input.value = value ?? "";
    input.type = name === "Token" ? "password" : "text";
    dialog.returnValue = "";
    dialog.showModal();
    (name ? input : id("ask-yes")).focus();
    return new Promise((done) => dialog.addEventListener("close", () =>
        done(dialog.returnValue !== "yes" ? null : name ? input.value : true), { once: true }));
}

// Arrow keys move through a group of buttons of which one is in the order of Tab.
export function rove(group, selector) {
    group.addEventListener("keydown", (event) => {
        const step = { ArrowRight: 1, ArrowDown: 1, ArrowLeft: -1, ArrowUp: -1 }[event.key];
        const all = [...group.querySelectorAll(selector)].filter((b) => !b.disabled);
        const at = all.indexOf(document.activeElement);
        if (!step || at < 0) return;
        event.preventDefault();
        const next = all[(at + step + all.length) % all.length];
        next.focus();
        next.click();
    });
}
