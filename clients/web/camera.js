// The camera of a live job. Moves turn it around a point; the newest is sent as soon as the one
// before has been answered, so that a slow daemon gets fewer moves and never a queue of them.
import { jobPath, patchJson } from "./api.js";

const add = (a, b, t = 1) => a.map((v, k) => v + t * b[k]);
const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
const unit = (a) => a.map((v) => v / (Math.hypot(...a) || 1));

// Rodrigues' formula.
function turn(v, axis, angle) {
    const c = Math.cos(angle), s = Math.sin(angle), k = dot(axis, v) * (1 - c), w = cross(axis, v);
    return v.map((x, i) => x * c + w[i] * s + axis[i] * k);
}

function multiply(a, b) {
    return Array.from({ length: 16 }, (_, i) =>
        [0, 1, 2, 3].reduce((sum, k) => sum + a[4 * k + (i & 3)] * b[(i & ~3) + k], 0));
}

// 16 numbers column by column, of either form of a transform.
function matrixOf(transform) {
    if (Array.isArray(transform)) return transform;
    const { translation: t = [0, 0, 0], rotation: r = [0, 0, 0, 1], scale: s = [1, 1, 1] } = transform ?? {};
    const n = Math.hypot(...r) || 1, [x, y, z, w] = r.map((v) => v / n);
    return [
        (1 - 2 * (y * y + z * z)) * s[0], 2 * (x * y + z * w) * s[0], 2 * (x * z - y * w) * s[0], 0,
        2 * (x * y - z * w) * s[1], (1 - 2 * (x * x + z * z)) * s[1], 2 * (y * z + x * w) * s[1], 0,
        2 * (x * z + y * w) * s[2], 2 * (y * z - x * w) * s[2], (1 - 2 * (x * x + y * y)) * s[2], 0,
        ...t, 1];
}

// The camera that a job means, with its transform to the world at rest.
export function findCamera(scene, wanted) {
    if (wanted && typeof wanted === "object") return { ...wanted, transform: matrixOf(wanted.transform) };
    const all = Object.entries(scene.cameras ?? {});
    const [, found] = all.find(([key, c]) => !wanted || key === wanted || c.name === wanted) ?? all[0] ?? [];
    if (!found) return null;
    const { node, ...camera } = found;
    let matrix = matrixOf(camera.transform);
    const seen = new Set(); // a cycle is refused by the daemon
    for (let at = node; at && !seen.has(at); at = scene.nodes?.[at]?.parent) {
        seen.add(at);
        matrix = multiply(matrixOf(scene.nodes?.[at]?.transform), matrix);
    }
    return { ...camera, transform: matrix };
}

export class Camera {
    constructor(job, camera, failed) {
        const m = camera.transform;
        Object.assign(this, { job, camera, failed });
        this.position = m.slice(12, 15);
        this.right = unit(m.slice(0, 3));
        this.up = unit(m.slice(4, 7));
        this.forward = unit(m.slice(8, 11)).map((v) => -v);
        this.distance = this.#guess();
        const { position, right, up, forward, distance } = this;
        this.first = { camera, position, right, up, forward, distance };
        this.sent = 0;
    }

    // Until the depth is known: the place on the axis that is nearest to the world's middle.
    #guess() {
        const ahead = -dot(this.position, this.forward);
        return ahead > 1e-3 ? ahead : Math.max(Math.hypot(...this.position), 1);
    }

    // What turns go around lies this far ahead, metres.
    aim(distance) {
        if (Number.isFinite(distance) && distance > 1e-6 && distance < 1e12) this.distance = distance;
    }

    get flat() {
        return this.camera.projection === "orthographic";
    }

    get height() { // metres that the picture is high at what is aimed at
        return 2 * (this.flat ? this.camera.ymag : this.distance * Math.tan(this.camera.yfov / 2));
    }

    // kind: orbit, track or dolly; by shares of the picture's height.
    move(kind, dx, dy) {
        if (kind === "orbit") this.#orbit(-dx * Math.PI, -dy * Math.PI);
        else if (kind === "track")
            this.position = add(add(this.position, this.right, -dx * this.height), this.up, dy * this.height);
        else this.#dolly(Math.exp(dy * 2));
        this.send();
    }

    #orbit(yaw, pitch) {
        const centre = add(this.position, this.forward, this.distance), rise = this.forward[1];
        const angle = Math.asin(Math.max(-1, Math.min(1, rise))), limit = 1.55;
        const tilt = Math.max(-limit, Math.min(limit, angle + pitch)) - angle;
        const level = unit(cross(this.forward, [0, 1, 0]));
        for (const axis of ["right", "up", "forward"])
            this[axis] = unit(turn(turn(this[axis], level, tilt), [0, 1, 0], yaw));
        this.position = add(centre, this.forward, -this.distance);
    }

    #dolly(factor) {
        if (this.flat) this.camera = { ...this.camera, ymag: this.camera.ymag * factor };
        const next = this.distance * factor;
        this.position = add(this.position, this.forward, this.distance - next);
        this.distance = next;
    }

    reset() {
        Object.assign(this, this.first);
        this.send();
    }

    // As a job has it.
    describe() {
        const back = this.forward.map((v) => -v);
        return { ...this.camera,
            transform: [...this.right, 0, ...this.up, 0, ...back, 0, ...this.position, 1] };
    }

    async send() {
        this.waiting = true;
        if (this.busy) return;
        this.busy = true;
        while (this.waiting) {
            this.waiting = false;
            const camera = this.describe();
            this.sent++;
            await patchJson(jobPath(this.job), { camera }).catch(this.failed);
        }
        this.busy = false;
    }
}
