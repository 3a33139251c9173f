// Reads multipart/mixed as it arrives; every part has a Content-Length.

const MAX_PART = 1 << 26;

class Bytes {
    constructor(body) {
        this.reader = body.getReader();
        this.chunks = []; // not yet taken
        this.length = 0;
    }

    async more() {
        const { value, done } = await this.reader.read();
        if (done) return false;
        this.chunks.push(value);
        this.length += value.length;
        return true;
    }

    // The next `size` bytes, null at the end.
    async take(size) {
        while (this.length < size) if (!(await this.more())) return null;
        const out = new Uint8Array(size);
        for (let at = 0; at < size; ) {
            const chunk = this.chunks[0], n = Math.min(chunk.length, size - at);
            out.set(chunk.subarray(0, n), at);
            at += n;
            if (n === chunk.length) this.chunks.shift();
            else this.chunks[0] = chunk.subarray(n);
        }
        this.length -= size;
        return out;
    }

    // A line without its end, null at the end of all.
    async line() {
        for (let scanned = 0; ; ) {
            let at = 0;
            for (const chunk of this.chunks) {
                const found = chunk.indexOf(10, Math.max(0, scanned - at));
                if (found >= 0) {
                    const text = new TextDecoder().decode(await this.take(at + found + 1));
                    return text.replace(/\r?\n$/, "");
                }
                at += chunk.length;
            }
            scanned = at;
            if (at > 65536) throw new Error("a line of the stream is too long");
            if (!(await this.more())) return null;
        }
    }
}

async function readHeaders(input) {
    const headers = new Map();
    for (let line; (line = await input.line()); ) {
        const colon = line.indexOf(":");
        if (colon > 0) headers.set(line.slice(0, colon).toLowerCase(), line.slice(colon + 1).trim());
    }
    return headers;
}

// Yields {headers: Map, body: Uint8Array}; returns true where the closing delimiter came.
export async function* readParts(response) {
    const boundary = /boundary="?([^";]+)/.exec(response.headers.get("Content-Type") ?? "")?.[1];
    if (!boundary) throw new Error("the stream has no boundary");
    const input = new Bytes(response.body);
    for (;;) {
        let line = await input.line();
        while (line === "") line = await input.line();
        if (line === null) return false;
        if (line === `--${boundary}--`) return true;
        if (line !== `--${boundary}`) throw new Error("the stream is damaged");
        const headers = await readHeaders(input), size = Number(headers.get("content-length"));
        if (!(size >= 0 && size <= MAX_PART)) throw new Error("a part of the stream has no good length");
        const body = await input.take(size);
        if (!body) return false;
        yield { headers, body };
    }
}
