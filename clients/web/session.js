// The job that is looked at: its tiles, its events, its camera.
import { events, getJson, headers, jobPath, scenePath } from "./api.js";
import { Camera, findCamera } from "./camera.js";
import { ended } from "./jobs.js";
import { readFrame, readOutput, viewsOf } from "./outputs.js";
import { showProblem } from "./problems.js";

const AGAIN = 1000; // milliseconds between frames of an output that has no stream
const DEPTH_AFTER = 400; // of rest, before the depth under the middle is asked for

export class Session {
    // on: {job(job), pixels(), link(text, lost), gone(id)}. stats(tiles): for measurements.
    constructor(picture, viewport, on) {
        Object.assign(this, { picture, viewport, on, job: null, output: "beauty", camera: null, stats: null });
    }

    async open(id) {
        this.close();
        const abort = (this.abort = new AbortController());
        try {
            const job = await getJson(jobPath(id), abort.signal);
            if (abort.signal.aborted) return;
            this.#start(job);
        } catch (error) {
            if (error.status === 404) this.on.gone(id);
            else showProblem("The job cannot be opened", error);
        }
    }

    close() {
        this.abort?.abort();
        this.worker?.terminate();
        clearTimeout(this.depthTimer);
        clearTimeout(this.outputTimer);
        Object.assign(this, { job: null, camera: null, worker: null, shown: null, beauty: null, outputTimer: null });
        this.picture.clear();
        this.viewport.fitAgain();
    }

    #start(job) {
        const [width, height] = job.job.resolution;
        this.job = job;
        this.picture.setSize(width, height);
        this.beauty = new Uint16Array(4 * width * height);
        this.viewport.fitAgain();
        if (!viewsOf(job.job).includes(this.output)) this.output = job.job.outputs[0];
        this.#follow();
        if (job.job.live && !ended(job.state)) this.#openCamera();
        this.on.job(job);
        this.#refreshOutput();
    }

    // Streams of tiles and events, until they end with the job.
    #follow() {
        const { job, abort } = this;
        this.#stream();
        events(jobPath(job.id, "/events"), { signal: abort.signal, status: (up, error) =>
            this.on.link(up ? "" : (error?.message ?? "The daemon does not answer."), !up),
        on: (name, data) => {
            if (this.job?.id !== job.id) return;
            if (name === "warning") this.job.warnings = [...(this.job.warnings ?? []), data.detail];
            else this.#tell(data);
        } });
    }

    #tell(data) {
        this.job = { ...this.job, ...data };
        this.on.job(this.job);
    }

    // What somebody changed: a job that had ended may go on.
    changed(job) {
        if (job.id !== this.job?.id) return;
        const resumed = ended(this.job.state) && !ended(job.state);
        this.#tell(job);
        if (resumed) {
            this.abort.abort();
            this.abort = new AbortController();
            this.#follow();
        }
    }

    #stream() {
        const { id } = this.job;
        this.worker?.terminate();
        const worker = (this.worker = new Worker("/viewer/tiles-worker.js", { type: "module" }));
        worker.onmessage = ({ data }) => {
            if (this.worker !== worker) return;
            if (data.tiles) {
                this.#draw(data.tiles);
                requestAnimationFrame(() => worker.postMessage("ack"));
            }
            if (data.failed && this.job?.id === id) this.on.link(data.failed, true);
            if (data.connected) this.on.link("", false);
        };
        worker.postMessage({ path: jobPath(id, "/tiles"), headers: headers({}) });
    }

    #draw(tiles) {
        const { picture } = this;
        for (const tile of tiles) {
            for (let row = 0; row < tile.height; row++)
                this.beauty.set(tile.pixels.subarray(4 * row * tile.width, 4 * (row + 1) * tile.width),
                    4 * ((tile.y + row) * picture.width + tile.x));
            if (this.output === "beauty") picture.update(tile.x, tile.y, tile.width, tile.height, tile.pixels);
        }
        this.stats?.(tiles);
        this.on.pixels();
        this.viewport.redraw();
        this.#wantDepth();
        if (this.output !== "beauty") this.#refreshOutput();
    }

    choose(output) {
        this.output = output;
        this.shown = null;
        if (output === "beauty" && this.beauty) {
            this.picture.update(0, 0, this.picture.width, this.picture.height, this.beauty);
            this.viewport.redraw();
        } else this.#refreshOutput(0);
    }

    #refreshOutput(wait = AGAIN) {
        if (this.output === "beauty" || !this.job || (this.outputTimer && wait)) return;
        clearTimeout(this.outputTimer);
        const { job, output } = this;
        this.outputTimer = setTimeout(async () => {
            try {
                const shown = await readOutput(job.id, output);
                if (this.job?.id !== job.id || this.output !== output) return;
                this.shown = shown;
                this.picture.update(shown.x, shown.y, shown.width, shown.height, shown.pixels);
                this.viewport.redraw();
            } catch (error) {
                if (error.status !== 503) showProblem(`The output ${output} was not read`, error);
            }
            this.outputTimer = null;
        }, wait);
    }

    async #openCamera() {
        const { job } = this;
        try {
            const wanted = job.job.camera;
            const scene = wanted && typeof wanted === "object" ? {}
                : await getJson(scenePath(job.scene, "?format=native"), this.abort.signal);
            const camera = findCamera(scene, wanted);
            if (this.job?.id !== job.id || !camera) return;
            this.camera = new Camera(job.id, camera, (error) => showProblem("The camera was not moved", error));
            this.on.job(this.job);
        } catch (error) {
            showProblem("The camera of the scene cannot be read", error);
        }
    }

    // Turns go around what the middle of the picture shows; asked for when the camera rests.
    #wantDepth() {
        if (!this.camera || !this.job.job.outputs.includes("depth")) return;
        clearTimeout(this.depthTimer);
        this.depthTimer = setTimeout(() => this.#aim(), DEPTH_AFTER);
    }

    async #aim() {
        const { job, camera } = this, moves = camera?.sent;
        if (!camera || camera.aimed === moves) return;
        try {
            const { x, y, width, height, channels: { Z } } = await readFrame(job.id, "depth");
            const at = (this.picture.height / 2 - y | 0) * width + (this.picture.width / 2 - x | 0);
            if (this.camera !== camera || camera.sent !== moves || at < 0 || at >= width * height) return;
            camera.aimed = moves;
            if (Z[at] < 1e29) camera.aim(Z[at]);
        } catch { /* no pixels yet; the next rest asks again */ }
    }
}
