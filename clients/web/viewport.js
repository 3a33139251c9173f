// Where the picture is looked at: zoom and pan, the tools, what pointers and keys do there.
//
// on: {hover(x, y) of the pixel or null, pick(x, y), camera(kind, dx, dy) in shares of the height,
// zoomed()}.
const BACKDROP = 0.157; // neutral, a little lighter than the page's panels
const CLICK = 4; // pixels that a click may slip
const ZOOMS = [1 / 16, 1 / 8, 1 / 4, 1 / 3, 1 / 2, 2 / 3, 1, 2, 3, 4, 6, 8, 12, 16, 24, 32, 64];

export class Viewport {
    constructor(element, cross, picture, on) {
        Object.assign(this, { element, cross, picture, on });
        this.tool = "pan";
        this.fit = true;
        this.scale = 1; // screen pixels of a pixel
        this.x = this.y = 0; // of the picture's corner, screen pixels
        this.cursor = null; // {x, y} of the keyboard's pixel
        this.drag = null;
        picture.changed = () => this.redraw();
        new ResizeObserver(() => this.resize()).observe(element);
        this.#listen();
        this.resize();
    }

    get ratio() {
        return window.devicePixelRatio || 1;
    }

    resize() {
        const { clientWidth, clientHeight } = this.element;
        const width = Math.max(1, Math.round(clientWidth * this.ratio));
        const height = Math.max(1, Math.round(clientHeight * this.ratio));
        this.x += Math.round((width - (this.width ?? width)) / 2); // the middle stays in the middle
        this.y += Math.round((height - (this.height ?? height)) / 2);
        Object.assign(this, { width, height });
        this.place();
    }

    place() {
        if (this.fit) this.#fit();
        this.redraw();
        this.on.zoomed(this.scale);
    }

    #fit() {
        const { width, height } = this.picture;
        if (!width) return;
        const edge = 12 * this.ratio;
        this.scale = Math.min((this.width - 2 * edge) / width, (this.height - 2 * edge) / height);
        if (this.scale > 1) this.scale = Math.max(1, Math.floor(this.scale));
        this.scale = Math.max(this.scale, 0.01);
        this.x = Math.round((this.width - width * this.scale) / 2);
        this.y = Math.round((this.height - height * this.scale) / 2);
    }

    redraw() {
        this.pending ??= requestAnimationFrame(() => {
            this.pending = null;
            this.#draw();
        });
    }

    #draw() {
        const { picture, scale } = this, { canvas } = picture;
        if (canvas.width !== this.width || canvas.height !== this.height)
            Object.assign(canvas, { width: this.width, height: this.height });
        picture.draw({ x: this.x, y: this.y, width: picture.width * scale, height: picture.height * scale,
            smooth: scale < 1 }, BACKDROP);
        this.element.dataset.place = `${this.x} ${this.y} ${scale}`;
        this.#placeCross();
    }

    #placeCross() {
        const { cross, cursor } = this;
        const there = cursor && this.tool === "pick" && document.activeElement === this.element;
        cross.setAttribute("visibility", there ? "visible" : "hidden");
        if (!there) return;
        const at = (corner, pixel) => (corner + (pixel + 0.5) * this.scale) / this.ratio;
        cross.setAttribute("transform", `translate(${at(this.x, cursor.x)} ${at(this.y, cursor.y)})`);
    }

    // Around a point of the screen, or the middle.
    zoom(scale, x = this.width / 2, y = this.height / 2) {
        const next = Math.min(64, Math.max(1 / 16, scale)), ratio = next / this.scale;
        this.fit = false;
        this.x = Math.round(x - (x - this.x) * ratio);
        this.y = Math.round(y - (y - this.y) * ratio);
        this.scale = next;
        this.place();
    }

    step(up) {
        const near = up ? ZOOMS.find((z) => z > this.scale * 1.001) : ZOOMS.findLast((z) => z < this.scale * 0.999);
        if (near) this.zoom(near);
    }

    fitAgain() {
        this.fit = true;
        this.place();
    }

    pan(dx, dy) {
        this.fit = false;
        this.x += Math.round(dx);
        this.y += Math.round(dy);
        this.place();
    }

    setTool(tool) {
        this.tool = tool;
        this.element.dataset.tool = tool;
        if (tool === "pick") this.cursor ??= { x: this.picture.width >> 1, y: this.picture.height >> 1 };
        this.redraw();
    }

    // The pixel under a pointer, or null.
    #pixel(event) {
        const box = this.element.getBoundingClientRect();
        const x = Math.floor(((event.clientX - box.left) * this.ratio - this.x) / this.scale);
        const y = Math.floor(((event.clientY - box.top) * this.ratio - this.y) / this.scale);
        return x >= 0 && y >= 0 && x < this.picture.width && y < this.picture.height ? { x, y } : null;
    }

    #listen() {
        const e = this.element;
        e.addEventListener("pointerdown", (event) => this.#down(event));
        e.addEventListener("pointermove", (event) => this.#move(event));
        for (const name of ["pointerup", "pointercancel"]) e.addEventListener(name, (event) => this.#up(event));
        e.addEventListener("pointerleave", () => this.on.hover(null));
        e.addEventListener("wheel", (event) => this.#wheel(event), { passive: false });
        e.addEventListener("keydown", (event) => this.#key(event));
        e.addEventListener("contextmenu", (event) => event.preventDefault());
        for (const name of ["focus", "blur"]) e.addEventListener(name, () => this.redraw());
    }

    #down(event) {
        if (!this.picture.width || event.button > 2) return;
        this.element.setPointerCapture(event.pointerId);
        const camera = this.tool === "camera" && !event.ctrlKey;
        const kind = !camera ? "picture" : event.button || event.shiftKey ? "track" : "orbit";
        this.drag = { kind, x: event.clientX, y: event.clientY, moved: 0, button: event.button };
    }

    #move(event) {
        this.on.hover(this.#pixel(event));
        const { drag } = this;
        if (!drag) return;
        const dx = event.clientX - drag.x, dy = event.clientY - drag.y;
        drag.moved += Math.abs(dx) + Math.abs(dy);
        if (drag.moved <= CLICK) return;
        Object.assign(drag, { x: event.clientX, y: event.clientY });
        if (drag.kind === "picture") this.pan(dx * this.ratio, dy * this.ratio);
        else this.on.camera(drag.kind, dx / this.element.clientHeight, dy / this.element.clientHeight);
    }

    #up(event) {
        const { drag } = this, pixel = this.#pixel(event);
        this.drag = null;
        if (!drag || drag.moved > CLICK || event.type === "pointercancel" || drag.button || !pixel) return;
        this.cursor = pixel;
        this.on.pick(pixel.x, pixel.y, event.shiftKey);
        this.redraw();
    }

    #wheel(event) {
        if (!this.picture.width) return;
        event.preventDefault();
        const notches = event.deltaY * (event.deltaMode === 1 ? 1 / 3 : event.deltaMode === 2 ? 1 : 1 / 100);
        if (this.tool === "camera" && !event.ctrlKey) {
            this.on.camera("dolly", 0, notches * 0.1);
            return;
        }
        const box = this.element.getBoundingClientRect();
        this.zoom(this.scale * 1.25 ** -notches, (event.clientX - box.left) * this.ratio,
            (event.clientY - box.top) * this.ratio);
    }

    #key(event) {
        const way = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1] }[event.key];
        if (event.altKey || event.ctrlKey || event.metaKey || !this.picture.width) return;
        if (way) this.#arrow(way, event.shiftKey);
        else if (event.key === "Enter" && this.cursor) this.on.pick(this.cursor.x, this.cursor.y);
        else if (this.tool === "camera" && (event.key === "PageUp" || event.key === "PageDown"))
            this.on.camera("dolly", 0, event.key === "PageUp" ? -0.1 : 0.1);
        else return;
        event.preventDefault();
    }

    #arrow([dx, dy], shift) {
        if (this.tool === "camera") this.on.camera(shift ? "track" : "orbit", dx * 0.04, dy * 0.04);
        else if (this.tool === "pan") this.pan(-dx * 40 * this.ratio, -dy * 40 * this.ratio);
        else {
            const { width, height } = this.picture, step = shift ? 10 : 1;
            const clamp = (v, end) => Math.max(0, Math.min(end - 1, v));
            this.cursor = { x: clamp((this.cursor?.x ?? 0) + dx * step, width),
                y: clamp((this.cursor?.y ?? 0) + dy * step, height) };
            this.on.hover(this.cursor);
            this.redraw();
        }
    }
}
