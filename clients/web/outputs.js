// Outputs other than the beauty: fetched as one consistent frame, painted as frame.png paints them,
// with the values as they are for the inspector.
import { getBytes, jobPath } from "./api.js";
import { readExr } from "./exr.js";
import { number } from "./format.js";
import { fromHalf, toHalf } from "./half.js";

const MISS = 1e29;
const CHANNELS = {
    albedo: ["albedo.R", "albedo.G", "albedo.B"],
    variance: ["variance.R", "variance.G", "variance.B"],
    normal: ["N.X", "N.Y", "N.Z"],
    depth: ["Z"],
    samples: ["samples.Y"],
    motion: ["forward.u", "forward.v"],
};

const floats = (plane) => (plane instanceof Uint16Array ? Float32Array.from(plane, (h) => fromHalf[h])
    : plane instanceof Uint32Array ? Float32Array.from(plane) : plane);

// Undoes the transfer curve that follows.
function signed(v) {
    const shown = Math.max(0.5 * v + 0.5, 0);
    return shown <= 0.04045 ? shown / 12.92 : ((shown + 0.055) / 1.055) ** 2.4;
}

function paintDepth([z]) {
    let near = Infinity, far = -Infinity;
    for (const v of z)
        if (v < MISS) {
            near = Math.min(near, v);
            far = Math.max(far, v);
        }
    const range = far > near ? far - near : 1;
    return (i) => Array(3).fill(z[i] < MISS ? 1 - (0.9 * (z[i] - near)) / range : 0);
}

const most = (planes, least) => planes.reduce((m, p) => p.reduce((a, v) => Math.max(a, Math.abs(v)), m), least);

const PAINT = {
    depth: paintDepth,
    normal: (planes) => (i) => planes.map((p) => signed(p[i])),
    samples: ([n], top = most([n], 1)) => (i) => Array(3).fill(n[i] / top),
    motion: (planes, top = most(planes, 1e-30)) => (i) => [signed(planes[0][i] / top), signed(planes[1][i] / top), signed(0)],
};

// The colours of the IDs of each rank, as bright as they are covered.
function paintIds(channels, type) {
    const ranks = [];
    for (let rank = 0; ; rank++) {
        const layer = `${type}${String(rank >> 1).padStart(2, "0")}`;
        const [id, coverage] = (rank & 1 ? "BA" : "RG").split("").map((c) => channels[`${layer}.${c}`]);
        if (!id || !coverage) break;
        ranks.push([new Uint32Array(id.buffer), coverage]);
    }
    return (i) => ranks.reduce((rgb, [id, coverage]) => (id[i]
        ? rgb.map((v, c) => v + coverage[i] * (0.05 + ((id[i] >>> (8 * c)) & 255) / 270)) : rgb), [0, 0, 0]);
}

const CRYPTO = { crypto_object: "Object", crypto_material: "Material", crypto_asset: "Asset" };
const CLASSES = { primary: "", glossy: "Gloss", reflection: "Refl", refraction: "Refr" };

// What the job tells apart of its mattes: seen directly, and what bounces bring.
export function classesOf({ mattes: { through = "none", classes, depth_bins = 0 } = {} }) {
    if (through === "none") return ["primary"];
    if (depth_bins) return ["primary", ...Array.from({ length: depth_bins }, (_, i) => `depth${i}`)];
    return classes ? ["primary", "reflection", "refraction"] : ["primary", "glossy"];
}

// All that can be looked at: the outputs, those of mattes once for each class: "crypto_object:glossy".
export function viewsOf(job) {
    const bounced = classesOf(job).slice(1);
    return job.outputs.flatMap((o) => [o, ...(CRYPTO[o] ? bounced.map((c) => `${o}:${c}`) : [])]);
}

export function queryOf(view) {
    const [output, through] = view.split(":");
    return `output=${output}${through ? `&through=${through}` : ""}`;
}

function painter(view, channels) {
    const [output, through = "primary"] = view.split(":");
    const infix = CLASSES[through] ?? through.replace("depth", "D");
    if (CRYPTO[output]) return { at: paintIds(channels, `Crypto${infix}${CRYPTO[output]}`), planes: [] };
    const planes = (CHANNELS[output] ?? []).map((name) => channels[name]).filter(Boolean).map(floats);
    if (!planes.length) throw new Error(`the frame has no ${output}`);
    return { at: PAINT[output]?.(planes) ?? ((i) => planes.map((p) => p[i])), planes };
}

export const readFrame = async (job, output) =>
    readExr(new Uint8Array(await getBytes(jobPath(job, `/frame.exr?outputs=${output}`))));

// output: one of viewsOf(). {x, y, width, height, pixels: halves, value(x, y): text of the values there or null}.
export async function readOutput(job, output) {
    const exr = await readFrame(job, output.split(":")[0]), { x, y, width, height } = exr;
    const { at, planes } = painter(output, exr.channels);
    const pixels = new Uint16Array(4 * width * height);
    for (let i = 0; i < width * height; i++) {
        const rgb = at(i);
        for (let c = 0; c < 3; c++) pixels[4 * i + c] = toHalf(rgb[c]);
        pixels[4 * i + 3] = 0x3c00;
    }
    const value = (px, py) => {
        if (px < x || py < y || px >= x + width || py >= y + height || !planes.length) return null;
        return planes.map((p) => number(p[(py - y) * width + px - x])).join("  ");
    };
    return { x, y, width, height, pixels, value };
}
