// Requests to the daemon that this page came from.

// What the daemon says about a request that failed: application/problem+json, every fault.
export class Problem extends Error {
    constructor(status, body) {
        super(body?.detail || body?.title || `the daemon answered ${status}`);
        this.status = status;
        this.title = body?.title ?? (status ? `Status ${status}` : "No answer");
        this.errors = Array.isArray(body?.errors) ? body.errors : [];
        this.requestId = body?.request_id;
    }
}

function random(length) {
    const text = "abcdefghijklmnopqrstuvwxyz0123456789";
    return [...crypto.getRandomValues(new Uint8Array(length))].map((b) => text[b % 36]).join("");
}

export const uniqueKey = () => random(24);

const client = `viewer-${random(8)}`;
let token = sessionStorage.getItem("glint-token");
let askToken = null; // (whether one was refused) => Promise: whether there is another now

// f: (whether one was refused) => Promise of a token or null.
export function onTokenNeeded(f) {
    let asked = null; // one question, however many requests are refused meanwhile
    askToken = (refused) => (asked ??= f(refused).then((given) => {
        asked = null;
        if (!given) return false;
        token = given.trim();
        sessionStorage.setItem("glint-token", token);
        return true;
    }));
}

// Who asks: jobs of several clients share the machine fairly.
export function headers(more) {
    const all = { "Glint-Client": client, ...more };
    if (token) all.Authorization = `Bearer ${token}`;
    return all;
}

async function readProblem(response) {
    const body = await response.json().catch(() => null);
    return new Problem(response.status, body);
}

export async function request(method, path, { body, type, headers: more, signal } = {}) {
    const all = headers({ ...(type && { "Content-Type": type }), ...more }), used = token;
    let response;
    try {
        response = await fetch(path, { method, body, headers: all, signal, cache: "no-cache" });
    } catch (error) {
        if (error.name === "AbortError") throw error;
        throw new Problem(0, { title: "No answer", detail: "The daemon does not answer." });
    }
    if (response.ok) return response;
    if (response.status === 401 && askToken && (token !== used || (await askToken(used !== null))))
        return request(method, path, { body, type, headers: more, signal });
    throw await readProblem(response);
}

export const getJson = async (path, signal) => (await request("GET", path, { signal })).json();
export const getBytes = async (path, signal) => (await request("GET", path, { signal })).arrayBuffer();

export async function patchJson(path, patch, signal) {
    const response = await request("PATCH", path,
        { body: JSON.stringify(patch), type: "application/merge-patch+json", signal });
    return response.json();
}

export const jobPath = (job, rest = "") => `/v1/jobs/${encodeURIComponent(job)}${rest}`;
export const scenePath = (name, rest = "") => `/v1/scenes/${encodeURIComponent(name)}${rest}`;

// PUT with progress, which fetch does not tell: progress(sent, total).
export function upload(path, { body, type, headers: more }, progress) {
    const xhr = new XMLHttpRequest();
    xhr.open("PUT", path);
    for (const [name, value] of Object.entries(headers({ ...(type && { "Content-Type": type }), ...more })))
        xhr.setRequestHeader(name, value);
    const done = new Promise((resolve, reject) => {
        xhr.upload.onprogress = (event) => progress(event.loaded, event.total);
        xhr.onload = () => {
            let answer = null;
            try {
                answer = JSON.parse(xhr.responseText);
            } catch { /* told by the status */ }
            if (xhr.status === 200 || xhr.status === 201) resolve({ created: xhr.status === 201, scene: answer });
            else reject(new Problem(xhr.status, answer));
        };
        xhr.onerror = () => reject(new Problem(0, { title: "No answer",
            detail: "The connection was lost before the daemon answered." }));
        xhr.onabort = () => reject(new DOMException("cancelled", "AbortError"));
        xhr.send(body);
    });
    return { done, cancel: () => xhr.abort() };
}

// Server-sent events, read by fetch: an EventSource could not say who asks. Comes back after the last
// event that it has seen. on(name, data); status(connected).
export async function events(path, { on, status, signal }) {
    let last = null, wait = 1000;
    while (!signal.aborted) {
        try {
            const response = await request("GET", path,
                { headers: { Accept: "text/event-stream", ...(last && { "Last-Event-ID": last }) }, signal });
            if (response.status === 204) return;
            status(true);
            wait = 1000;
            for await (const event of readEvents(response.body)) {
                last = event.id ?? last;
                if (event.data) on(event.event, JSON.parse(event.data));
                if (event.event === "done") return;
            }
        } catch (error) {
            if (signal.aborted) return;
            status(false, error);
            if (error.status === 404) return;
        }
        await new Promise((resolve) => setTimeout(resolve, wait));
        wait = Math.min(wait * 2, 15000);
    }
}

async function* readEvents(body) {
    const reader = body.pipeThrough(new TextDecoderStream()).getReader();
    let text = "";
    for (;;) {
        const { value, done } = await reader.read();
        if (done) return;
        text += value;
        for (let end; (end = text.indexOf("\n\n")) >= 0; text = text.slice(end + 2)) {
            const event = {};
            for (const line of text.slice(0, end).split("\n")) {
                const colon = line.indexOf(":");
                if (colon > 0) event[line.slice(0, colon)] = line.slice(colon + 1).replace(/^ /, "");
            }
            yield event;
        }
    }
}
