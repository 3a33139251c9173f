// Reads a job's stream of tiles and decodes them beside the page. In: {path, headers}, then
// "ack" for each batch. Out: {tiles: [{x, y, width, height, samples, revision, worldToCamera,
// pixels}]}, {ended}, {failed: text}, {connected}. A page that does not keep up gets no further batch;
// the daemon then sends fewer, newer tiles.
import { interleave, readExr } from "./exr.js";
import { readParts } from "./multipart.js";

const AT_ONCE = 8; // decoded side by side
const BATCH = 64;
let acknowledge = () => {};
let since = 0;

async function decode({ headers, body }) {
    const exr = await readExr(body);
    const { x, y, width, height, worldToCamera } = exr;
    return { x, y, width, height, worldToCamera, pixels: interleave(exr),
        samples: Number(headers.get("glint-samples")), sequence: Number(headers.get("glint-seq")),
        revision: headers.get("glint-revision") };
}

// What is decoded and not yet with the page: the newest of each tile.
class Batch {
    constructor() {
        this.tiles = new Map();
        this.sent = new Map(); // sequences
        this.waiting = false;
        acknowledge = () => {
            this.waiting = false;
            this.flush();
            this.room?.();
        };
    }

    add(tile) {
        const key = `${tile.x} ${tile.y}`, known = Math.max(this.tiles.get(key)?.sequence ?? 0, this.sent.get(key) ?? 0);
        if (tile.sequence < known) return;
        this.tiles.set(key, tile);
        this.flush();
    }

    flush() {
        if (!this.tiles.size || this.waiting) return;
        const tiles = [...this.tiles.values()];
        for (const [key, { sequence }] of this.tiles) this.sent.set(key, sequence);
        postMessage({ tiles }, tiles.map((tile) => tile.pixels.buffer));
        this.tiles.clear();
        this.waiting = true;
    }

    // Until the page has caught up.
    async space() {
        if (this.waiting && this.tiles.size >= BATCH) await new Promise((resolve) => (this.room = resolve));
    }
}

async function follow(response) {
    const batch = new Batch(), parts = readParts(response), busy = new Set();
    let part, failed = null;
    while (!(part = await parts.next()).done && !failed) {
        const work = decode(part.value).then((tile) => batch.add(tile), (error) => (failed = error))
            .finally(() => busy.delete(work));
        busy.add(work);
        since = Number(part.value.headers.get("glint-seq")) || since;
        if (busy.size >= AT_ONCE) await Promise.race(busy);
        await batch.space();
    }
    await Promise.all(busy);
    if (failed) since = 0; // all of them again
    if (failed) throw failed;
    if (!part.value) throw new Error("the tiles were cut off");
}

async function run({ path, headers }) {
    for (let wait = 500; ; wait = Math.min(wait * 2, 8000)) {
        try {
            const response = await fetch(`${path}?since=${since}`, { headers, cache: "no-store" });
            if (response.status === 404 || response.status === 401) {
                postMessage({ failed: `the tiles are answered ${response.status}`, status: response.status });
                return;
            }
            if (!response.ok) throw new Error(`the tiles are answered ${response.status}`);
            postMessage({ connected: true });
            wait = 500;
            await follow(response);
            postMessage({ ended: true });
            return;
        } catch (error) {
            postMessage({ failed: String(error?.message ?? error) });
        }
        await new Promise((resolve) => setTimeout(resolve, wait));
    }
}

onmessage = ({ data }) => (data === "ack" ? acknowledge() : run(data));
