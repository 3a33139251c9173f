// The mattes of the chosen job: names with what they cover, picking, the overlay, another colour.
import { getBytes, getJson, jobPath } from "./api.js";
import { bar, h, id, put, Rows, say } from "./dom.js";
import { readExr } from "./exr.js";
import { percent } from "./format.js";
import { fromHalf } from "./half.js";
import { classesOf, readFrame } from "./outputs.js";
import { SHOW } from "./picture.js";
import { showProblem } from "./problems.js";
import { makeTransform, meanOfPicture, meanUnder } from "./recolour.js";
import { linear } from "./tone.js";

const LAYERS = ["object", "material", "asset"];
const MAX_NAMES = 36; // of one request
const AGAIN = 1500; // milliseconds between looks at a job that renders

export class Mattes {
    constructor(picture, redraw) {
        Object.assign(this, { picture, redraw, job: null, names: [], chosen: new Set(), serial: 0, asked: 0,
            boxes: [] });
        this.rows = new Rows(id("matte-names"), (n) => n.name, (n) => this.#row(n));
        id("matte-layer").addEventListener("change", () => this.#layerChanged());
        id("matte-find").addEventListener("input", () => this.#showNames());
        id("matte-clear").addEventListener("click", () => this.clear());
        for (const name of ["matte-show", "recolour", "recolour-colour"])
            id(name).addEventListener("input", () => this.#looks());
    }

    get layer() {
        return id("matte-layer").value;
    }

    // The classes of which mattes are made, as the daemon calls them; all of the job's at first.
    get through() {
        return this.boxes.filter((b) => b.checked).map((b) => b.value);
    }

    #offerClasses(classes) {
        const whole = id("matte-through");
        this.boxes.forEach((b) => b.parentElement.remove());
        this.boxes = classes.map((value) => h("input", { type: "checkbox", value, checked: true,
            onchange: (event) => this.#throughChanged(event.target) }));
        whole.append(...this.boxes.map((b) => h("label.check", {}, b, b.value)));
        whole.hidden = classes.length < 2;
    }

    // Something stays chosen.
    #throughChanged(box) {
        if (!this.through.length) box.checked = true;
        this.old = null;
        this.#showNames();
        this.#loadMask();
    }

    // All classes, or what is seen directly alone.
    nextThrough() {
        if (this.boxes.length < 2) return;
        const all = this.through.length < this.boxes.length;
        this.boxes.forEach((b) => (b.checked = all || b.value === "primary"));
        this.#throughChanged(this.boxes[0]);
        say(all ? "Mattes through bounces" : "Mattes of what is seen directly");
    }

    // Of what the daemon tells of a name, by class. Where reflection and refraction are apart, nothing
    // of theirs is seen directly; other classes hold that too, and the larger counts.
    #covered(of) {
        const { through } = this, direct = through.includes("primary") ? of("primary") : 0;
        const bounced = through.filter((c) => c !== "primary").reduce((sum, c) => sum + of(c), 0);
        return through.some((c) => c.startsWith("refl") || c.startsWith("refr")) ? direct + bounced
            : Math.max(direct, bounced);
    }

    open(job) {
        const layers = job ? LAYERS.filter((l) => job.job.outputs?.includes(`crypto_${l}`)) : [];
        this.close();
        this.job = layers.length ? job : null;
        id("mattes").hidden = !layers.length;
        put(id("no-mattes"), job ? "This job has no mattes among its outputs." : "No job with mattes is chosen.");
        id("no-mattes").hidden = layers.length > 0;
        id("matte-layer").replaceChildren(...layers.map((l) => h("option", {}, l)));
        this.#offerClasses(layers.length ? classesOf(job.job) : []);
        this.refresh(true);
    }

    close() {
        this.job = null;
        this.names = [];
        this.picked = null;
        this.chosen.clear();
        this.old = null;
        this.serial++;
        this.asked++;
        this.rows.show([]);
        this.#applyMask(null);
    }

    // The pixels have changed: names and matte are looked at again, not more often than is useful.
    refresh(now = false) {
        if (!this.job || (this.timer && !now)) return;
        clearTimeout(this.timer);
        this.timer = setTimeout(async () => {
            this.timer = null;
            await Promise.all([this.#loadNames(), this.#loadMask()]);
        }, now ? 0 : AGAIN);
    }

    async #loadNames() {
        const { job, layer } = this, asked = ++this.asked;
        if (!job || id("panel-mattes").hidden) return;
        try {
            const { layers } = await getJson(jobPath(job.id, `/mattes?layer=${layer}`));
            if (asked !== this.asked) return;
            this.names = layers[layer].names;
            this.lost = layers[layer].lost;
            this.#showNames();
        } catch (error) {
            if (error.status !== 503 && error.status !== 404) showProblem("The names were not read", error);
        }
    }

    #showNames() {
        const wanted = id("matte-find").value.toLowerCase();
        const [w, d] = this.job?.job.resolution ?? [1, 1];
        this.pixels = w * d;
        const of = (n) => this.#covered((c) => (c === "primary" ? n.coverage : n[c] ?? 0));
        const sorted = this.names.map((n) => ({ name: n.name, coverage: of(n) }))
            .sort((a, b) => b.coverage - a.coverage || (a.name < b.name ? -1 : 1));
        const named = new Map(sorted.map((n) => [n.name, n])); // equal names are one matte
        const picked = named.get(this.picked); // first, so that it is seen
        const order = picked ? [picked, ...[...named.values()].filter((n) => n !== picked)] : [...named.values()];
        this.rows.show(order.filter((n) => n.name.toLowerCase().includes(wanted)));
    }

    #row({ name }) {
        const box = h("input", { type: "checkbox", onchange: () => this.choose(name, true) });
        const much = h("span.much", {}), bars = h("div.bars", {});
        const element = h("li", {}, h("label", {}, box, h("span.name", { title: name }, name), much, bars));
        const update = (n) => {
            const share = n.coverage / this.pixels;
            box.checked = this.chosen.has(name);
            put(much, share ? percent(share, share < 0.01 ? 2 : 1) : "–");
            if (bars.dataset.share !== String(share)) bars.replaceChildren(bar(share));
            bars.dataset.share = share;
        };
        return { element, update };
    }

    // Toggles one of several, or chooses it alone.
    choose(name, several) {
        if (!several) {
            const alone = this.chosen.size === 1 && this.chosen.has(name);
            this.chosen.clear();
            if (!alone) this.chosen.add(name);
        } else if (!this.chosen.delete(name)) {
            if (this.chosen.size < MAX_NAMES) this.chosen.add(name);
        }
        this.old = null;
        this.#showNames();
        this.#loadMask();
        this.#tell();
    }

    clear() {
        this.chosen.clear();
        this.#showNames();
        this.#loadMask();
        this.#tell();
    }

    #tell() {
        const text = this.chosen.size ? `Chosen: ${[...this.chosen].join(", ")}`
            : "Click a thing in the picture, or choose names here.";
        put(id("matte-selection"), text);
        id("save-matte").disabled = !this.chosen.size;
    }

    #layerChanged() {
        this.chosen.clear();
        this.names = [];
        this.old = null;
        this.refresh(true);
        this.#tell();
    }

    // What covers a pixel most, through the classes that are chosen: {name, coverage} of a layer, sorted.
    #merge(classes, layer) {
        const of = (name) => (c) => classes[c]?.[layer]?.find((n) => n.name === name)?.coverage ?? 0;
        const names = new Set(this.through.flatMap((c) => classes[c]?.[layer] ?? []).map((n) => n.name));
        return [...names].map((name) => ({ name, coverage: this.#covered(of(name)) }))
            .sort((a, b) => b.coverage - a.coverage);
    }

    // What is under a pixel, by every layer of the job; chooses it in the layer that is shown.
    async pick(x, y, several) {
        if (!this.job) return null;
        put(id("matte-selection"), `Looking at pixel ${x}, ${y} …`);
        try {
            const classes = await getJson(jobPath(this.job.id, `/pick?x=${x}&y=${y}`));
            const found = Object.fromEntries(LAYERS.map((l) => [l, this.#merge(classes, l)]));
            const first = found[this.layer]?.[0];
            this.picked = first?.name;
            if (first) this.choose(first.name, several);
            else if (!several) this.clear();
            const words = LAYERS.filter((l) => found[l].length)
                .map((l) => `${l} ${found[l][0].name} ${percent(found[l][0].coverage)}`);
            say(words.length ? `Pixel ${x}, ${y}: ${words.join(", ")}` : `Pixel ${x}, ${y}: nothing`);
            return found;
        } catch (error) {
            this.#tell();
            showProblem("Nothing was picked", error);
            return null;
        }
    }

    query(through = this.through) {
        return [...this.chosen].map((n) => `&name=${encodeURIComponent(n)}`).join("") +
            (this.boxes.length > 1 ? `&through=${through}` : "");
    }

    async #loadMask() {
        const { job } = this, serial = ++this.serial;
        if (!job || !this.chosen.size) {
            this.#applyMask(null);
            return;
        }
        try {
            const path = jobPath(job.id, `/matte.exr?layer=${this.layer}${this.query()}`);
            const exr = await readExr(new Uint8Array(await getBytes(path)));
            if (serial !== this.serial) return;
            this.#applyMask(this.#spread(exr));
            await this.#findOld(serial);
        } catch (error) {
            if (error.status !== 503 && error.status !== 404) showProblem("The matte was not read", error);
        }
    }

    // The data window's coverage as bytes of the whole picture.
    #spread({ x, y, width, height, channels: { A } }) {
        const { width: w, height: d } = this.picture, out = new Uint8Array(w * d);
        const value = A instanceof Uint16Array ? (v) => fromHalf[v] : (v) => v;
        for (let row = 0; row < height; row++)
            for (let column = 0; column < width; column++)
                out[(y + row) * w + x + column] =
                    Math.round(255 * Math.min(1, Math.max(0, value(A[row * width + column]))));
        return out;
    }

    #applyMask(mask) {
        this.picture.setMask(mask);
        this.#looks();
    }

    // The matte of what is seen directly: where mirrors and glass show a thing the albedo is theirs.
    async #directMask() {
        if (this.boxes.length < 2) return this.picture.mask;
        const path = jobPath(this.job.id, `/matte.exr?layer=${this.layer}${this.query("primary")}`);
        return this.#spread(await readExr(new Uint8Array(await getBytes(path))));
    }

    // The colour that is there now: of the albedo where the job has one.
    async #findOld(serial) {
        if (!id("recolour").checked || !this.job.job.outputs.includes("albedo")) return;
        const [frame, mask] = await Promise.all([readFrame(this.job.id, "albedo"), this.#directMask()]);
        const { x, y, width, height, channels } = frame, w = this.picture.width;
        const planes = ["R", "G", "B"].map((c) => channels[`albedo.${c}`]);
        if (serial !== this.serial || !mask || !mask.some(Boolean)) return;
        const value = planes[0] instanceof Uint16Array ? (v) => fromHalf[v] : (v) => v;
        this.old = meanUnder(mask, (i) => {
            const at = (Math.floor(i / w) - y) * width + (i % w) - x;
            return i % w >= x && i % w < x + width && at >= 0 && at < width * height
                ? planes.map((p) => value(p[at])) : [NaN, NaN, NaN];
        });
        this.#looks();
    }

    #looks() {
        const { picture } = this, { looks, mask } = picture;
        looks.show = SHOW.indexOf(document.querySelector("[name=matte-show]:checked").value);
        looks.change = null;
        if (id("recolour").checked && mask && this.job) {
            const colour = linear(id("recolour-colour").value);
            if (looks.show === 1) looks.show = 0; // a tint over it would hide the colour
            const usesAlbedo = this.job.job.outputs.includes("albedo");
            if (usesAlbedo && !this.old) this.#findOld(this.serial).catch(() => {});
            looks.change = usesAlbedo && this.old ? makeTransform(this.old, colour, false)
                : makeTransform(meanOfPicture(mask, picture.values), colour, true);
        }
        this.redraw();
    }
}
