// Reads scanline OpenEXR files of one part: NONE, ZIPS and ZIP; HALF, FLOAT and UINT channels.
// All that the daemon writes; anything else is an Error that says what it is.

const COMPRESSION = { 0: { name: "NONE", rows: 1 }, 2: { name: "ZIPS", rows: 1 }, 3: { name: "ZIP", rows: 16 } };
const SIZES = [4, 2, 4]; // UINT, HALF, FLOAT
const ARRAYS = [Uint32Array, Uint16Array, Float32Array];
const MAX_SIDE = 16384;

class Reader {
    constructor(bytes) {
        this.bytes = bytes;
        this.view = new DataView(bytes.buffer, bytes.byteOffset, bytes.byteLength);
        this.at = 0;
    }

    i32() {
        this.at += 4;
        return this.view.getInt32(this.at - 4, true); // a RangeError past the end
    }

    name() {
        const end = this.bytes.indexOf(0, this.at);
        if (end < 0) throw new Error("the EXR file is cut");
        const text = new TextDecoder().decode(this.bytes.subarray(this.at, end));
        this.at = end + 1;
        return text;
    }
}

function readChannels(r, end) {
    const channels = [];
    while (r.at < end && r.bytes[r.at]) {
        const name = r.name(), type = r.i32();
        r.at += 12; // linearity and sampling, which are 1 in what is written here
        if (!(type in SIZES)) throw new Error(`the EXR channel ${name} has an unknown type`);
        channels.push({ name, type });
    }
    return channels;
}

function readBox(r) {
    const [x0, y0, x1, y1] = [r.i32(), r.i32(), r.i32(), r.i32()];
    const box = { x: x0, y: y0, width: x1 - x0 + 1, height: y1 - y0 + 1 };
    if (!(box.width > 0 && box.height > 0 && box.width <= MAX_SIDE && box.height <= MAX_SIDE))
        throw new Error("the EXR window is out of bounds");
    return box;
}

// What is wanted of the header; other attributes are passed over.
const ATTRIBUTES = {
    channels: (r, end) => readChannels(r, end),
    compression: (r) => r.bytes[r.at],
    dataWindow: readBox,
    displayWindow: readBox,
    worldToCamera: (r) => Array.from({ length: 16 }, (_, i) => r.view.getFloat32(r.at + 4 * i, true)),
};

function readHeader(r) {
    if (r.i32() !== 20000630) throw new Error("this is no EXR file");
    if (r.i32() & 0x1a00) throw new Error("tiled, deep and multi-part EXR files are not read here");
    const header = {};
    while (r.bytes[r.at]) {
        const name = r.name();
        r.name();
        const end = r.i32() + r.at;
        if (name in ATTRIBUTES) header[name] = ATTRIBUTES[name](r, end);
        r.at = end;
    }
    r.at++;
    for (const name of ["channels", "compression", "dataWindow", "displayWindow"])
        if (header[name] === undefined) throw new Error(`the EXR file has no ${name}`);
    if (!(header.compression in COMPRESSION)) throw new Error("the EXR compression is not read here");
    return header;
}

async function inflate(packed, size) {
    const stream = new DecompressionStream("deflate"), writer = stream.writable.getWriter();
    const failed = [writer.write(packed), writer.close()].map((p) => p.catch(() => {})); // reading tells
    const out = new Uint8Array(size), reader = stream.readable.getReader();
    let length = 0;
    for (let part; !(part = await reader.read()).done; length += part.value.length) {
        if (length + part.value.length > size) throw new Error("an EXR block is too long");
        out.set(part.value, length);
    }
    await Promise.all(failed);
    if (length !== size) throw new Error("an EXR block is too short");
    return out;
}

// Undoes the two steps that make bytes compress well: differences, and low bytes before high ones.
function unfilter(t) {
    const out = new Uint8Array(t.length), half = (t.length + 1) >> 1;
    for (let i = 1, before = t[0]; i < t.length; i++)
        t[i] = before = (before + t[i] - 128) & 255;
    for (let i = 0, j = 0; j < half; j++) {
        out[i++] = t[j];
        if (i < out.length) out[i++] = t[half + j];
    }
    return out;
}

function listBlocks(r, header) {
    const { dataWindow: box } = header, { rows } = COMPRESSION[header.compression];
    const blocks = [];
    r.at += 8 * Math.ceil(box.height / rows); // the table of offsets: blocks are read in their order
    for (let n = Math.ceil(box.height / rows); n--; ) {
        const y = r.i32() - box.y, size = r.i32();
        if (y < 0 || y >= box.height || size < 0 || r.at + size > r.bytes.length)
            throw new Error("an EXR block is out of bounds");
        blocks.push({ y, rows: Math.min(rows, box.height - y), bytes: r.bytes.subarray(r.at, r.at + size) });
        r.at += size;
    }
    return blocks;
}

// Copies rows of one block, in which channel follows channel, to the planes.
function spread(block, bytes, width, planes) {
    let at = 0;
    for (let y = block.y; y < block.y + block.rows; y++)
        for (const plane of planes) {
            const size = width * SIZES[plane.type];
            plane.bytes.set(bytes.subarray(at, at + size), y * size);
            at += size;
        }
}

// {x, y, width, height, display, channels: {name: Uint16Array of halves | Float32Array | Uint32Array},
// worldToCamera}.
export async function readExr(bytes) {
    const r = new Reader(bytes), header = readHeader(r);
    const { x, y, width, height } = header.dataWindow;
    const planes = header.channels.map(({ name, type }) =>
        ({ name, type, bytes: new Uint8Array(width * height * SIZES[type]) }));
    const perRow = width * header.channels.reduce((sum, c) => sum + SIZES[c.type], 0);
    await Promise.all(listBlocks(r, header).map(async (block) => {
        const size = perRow * block.rows;
        const raw = block.bytes.length === size ? block.bytes : unfilter(await inflate(block.bytes, size));
        spread(block, raw, width, planes);
    }));
    const channels = Object.fromEntries(planes.map((p) => [p.name, new ARRAYS[p.type](p.bytes.buffer)]));
    return { x, y, width, height, display: header.displayWindow, channels, worldToCamera: header.worldToCamera };
}

// Planes R, G, B, A of halves as pixels of four halves.
export function interleave({ width, height, channels }) {
    const out = new Uint16Array(4 * width * height), { R, G, B, A } = channels;
    for (let i = 0, o = 0; i < width * height; i++, o += 4) {
        out[o] = R[i];
        out[o + 1] = G[i];
        out[o + 2] = B[i];
        out[o + 3] = A ? A[i] : 0x3c00;
    }
    return out;
}
