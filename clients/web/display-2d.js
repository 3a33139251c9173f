// The same picture without WebGL2: each half becomes an 8-bit code through a table.
import { recolour } from "./recolour.js";
import { code, codesOfHalves } from "./tone.js";

export class FlatDisplay {
    constructor(canvas) {
        this.canvas = canvas;
        this.context = canvas.getContext("2d", { alpha: false });
        this.sheet = document.createElement("canvas");
        this.looks = "";
        this.setSize(1, 1);
    }

    setSize(width, height) {
        Object.assign(this.sheet, { width, height });
        this.page = this.sheet.getContext("2d");
        this.image = this.page.createImageData(width, height);
        this.values = new Uint16Array(4 * width * height);
        this.mask = null;
        this.stale = [[0, 0, width, height]];
    }

    update(x, y, width, height, pixels) {
        for (let row = 0; row < height; row++)
            this.values.set(pixels.subarray(4 * row * width, 4 * (row + 1) * width),
                4 * ((y + row) * this.sheet.width + x));
        this.stale.push([x, y, width, height]);
    }

    setMask(width, height, coverage) {
        this.mask = width === this.sheet.width && height === this.sheet.height ? coverage : null;
        this.looks = "";
    }

    #pixel(i, { exposure, tone, show, change }) {
        const { data } = this.image, { values, codes, mask } = this, m = mask ? mask[i] / 255 : 0;
        let rgb = [codes[values[4 * i]], codes[values[4 * i + 1]], codes[values[4 * i + 2]]];
        if (m && change)
            rgb = recolour(change, mask, values, this.sheet.width, this.sheet.height, i)
                .map((v) => code(v, exposure, tone));
        const grey = 0.35 * (0.3 * rgb[0] + 0.6 * rgb[1] + 0.1 * rgb[2]);
        for (let c = 0; c < 3; c++)
            data[4 * i + c] = show === 1 ? rgb[c] + (255 * [1, 0.42, 0.25][c] - rgb[c]) * 0.55 * m
                : show === 2 ? grey + (rgb[c] - grey) * m : show === 3 ? 255 * m : rgb[c];
        data[4 * i + 3] = 255;
    }

    #refresh(options) {
        const { width, height } = this.sheet, { exposure, tone, show, change } = options;
        const looks = JSON.stringify([exposure, tone, show, change]);
        if (looks !== this.looks) {
            this.codes = codesOfHalves(exposure, tone);
            this.stale = [[0, 0, width, height]];
        }
        this.looks = looks;
        for (const [x, y, w, h] of this.stale) {
            for (let row = y; row < y + h; row++)
                for (let i = row * width + x, end = i + w; i < end; i++) this.#pixel(i, options);
            this.page.putImageData(this.image, 0, 0, x, y, w, h);
        }
        this.stale = [];
    }

    draw(options) {
        const { context, canvas } = this, grey = Math.round(255 * options.backdrop), { place } = options;
        context.fillStyle = `rgb(${grey} ${grey} ${grey})`;
        context.fillRect(0, 0, canvas.width, canvas.height);
        if (!place) return;
        this.#refresh(options);
        context.imageSmoothingEnabled = place.smooth;
        context.drawImage(this.sheet, place.x, place.y, place.width, place.height);
    }
}
