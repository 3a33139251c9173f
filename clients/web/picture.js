// The frame on the page: values as they came, for the inspector, and a display that draws them.
import { FlatDisplay } from "./display-2d.js";
import { GlDisplay } from "./display-gl.js";
import { fromHalf } from "./half.js";

export const SHOW = ["picture", "overlay", "isolate", "matte"];

export class Picture {
    constructor(canvas) {
        this.width = this.height = 0;
        this.looks = { exposure: 0, tone: "clip", show: 0, change: null }; // change: of recolour.js
        this.mask = null;
        this.#open(canvas, false);
    }

    #open(canvas, flat) {
        this.canvas = canvas;
        try {
            if (flat) throw new Error("WebGL2 cannot hold the picture");
            this.display = new GlDisplay(canvas, () => this.#reopen());
        } catch {
            this.display = new FlatDisplay(canvas);
        }
    }

    // The graphics driver has dropped what it had, or cannot hold it: a fresh canvas, the same values.
    #reopen(flat = false) {
        const canvas = this.canvas.cloneNode();
        this.canvas.replaceWith(canvas);
        this.#open(canvas, flat);
        this.#resend();
        this.changed?.();
    }

    #resend() {
        if (!this.width) return;
        try {
            this.display.setSize(this.width, this.height);
        } catch (error) {
            if (this.display instanceof FlatDisplay) throw error;
            this.#reopen(true);
            return;
        }
        this.display.update(0, 0, this.width, this.height, this.values);
        this.setMask(this.mask);
    }

    clear() {
        this.width = this.height = 0;
        this.values = this.mask = null;
        this.seen = false;
    }

    setSize(width, height) {
        Object.assign(this, { width, height, values: new Uint16Array(4 * width * height), mask: null, seen: false });
        this.#resend();
    }

    update(x, y, width, height, pixels) {
        if (x < 0 || y < 0 || x + width > this.width || y + height > this.height) return;
        for (let row = 0; row < height; row++)
            this.values.set(pixels.subarray(4 * row * width, 4 * (row + 1) * width),
                4 * ((y + row) * this.width + x));
        this.display.update(x, y, width, height, pixels);
        this.seen = true;
    }

    // coverage: one byte for each pixel, or null.
    setMask(coverage) {
        this.mask = coverage;
        if (coverage) this.display.setMask(this.width, this.height, coverage);
    }

    value(x, y) {
        const at = 4 * (y * this.width + x);
        return [0, 1, 2, 3].map((c) => fromHalf[this.values[at + c]]);
    }

    draw(place, backdrop) {
        const { exposure, tone, show, change } = this.looks, { mask } = this;
        this.display.draw({ place: this.width ? place : null, exposure, tone, backdrop,
            show: mask ? show : 0, change: mask ? change : null });
    }
}
