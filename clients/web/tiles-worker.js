// Reads a job's stream of tiles and decodes them beside the page. In: {path, headers, since}, then
// "ack" for each batch. Out: {tiles: [{x, y, width, height, samples, revision, worldToCamera,
// pixels}]}, {ended}, {failed: text}, {connected}. A page that does not keep up gets no further batch;
// the daemon then sends fewer, newer tiles.
import { interleave, readExr } from "./exr.js";
import { readParts } from "./multipart.js";

const BATCH = 64;
let acknowledge = () => {};
let since = 0;

async function decode(part) {
    const exr = await readExr(part.body);
    const { x, y, width, height, worldToCamera } = exr;
    return { x, y, width, height, worldToCamera, pixels: interleave(exr),
        samples: Number(part.headers.get("glint-samples")),
        revision: part.headers.get("glint-revision") };
}

// What has arrived is one batch; the next is collected while the page draws it.
async function follow(response) {
    let batch = [], waiting = false;
    const flush = () => {
        if (!batch.length || waiting) return;
        postMessage({ tiles: batch }, batch.map((tile) => tile.pixels.buffer));
        batch = [];
        waiting = true;
    };
    let room = () => {};
    acknowledge = () => {
        waiting = false;
        flush();
        room();
    };
    const parts = readParts(response);
    let part;
    while (!(part = await parts.next()).done) {
        batch.push(await decode(part.value));
        since = Number(part.value.headers.get("glint-seq")) || since;
        if (waiting && batch.length >= BATCH) await new Promise((resolve) => (room = resolve));
        flush();
    }
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
