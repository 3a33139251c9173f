// Another colour for what a matte covers: the transform of `glint recolor`, described in
// clients/cli/recolour.h. out = in + alpha (T F - F), T_k F = own_k F_k + lead_k F_j.
import { fromHalf } from "./half.js";
import { luminance } from "./tone.js";

const DARKEST = 0.01;

export const leading = (c) => (c[1] > c[0] ? (c[2] > c[1] ? 2 : 1) : c[2] > c[0] ? 2 : 0);

function meanOf(mask, read, least) {
    const sum = [0, 0, 0];
    let total = 0;
    for (let i = 0; i < mask.length; i++) {
        if (mask[i] < least) continue;
        const v = read(i), w = (mask[i] / 255) ** 8;
        if (!Number.isFinite(v[0] + v[1] + v[2])) continue;
        for (let k = 0; k < 3; k++) sum[k] += w * Math.max(v[k], 0);
        total += w;
    }
    return total ? sum.map((v) => v / total) : null;
}

// Mean of what read(i) gives, over the pixels that are the matte's alone, where it has any.
export const meanUnder = (mask, read) => meanOf(mask, read, 255) ?? meanOf(mask, read, 1) ?? [0, 0, 0];

export function meanOfPicture(mask, halves) {
    return meanUnder(mask, (i) => [fromHalf[halves[4 * i]], fromHalf[halves[4 * i + 1]], fromHalf[halves[4 * i + 2]]]);
}

// old: mean albedo under the matte or, where `scale`, mean of the picture there, which then is scaled
// to the new colour's luminance, so that the surface keeps its brightness.
export function makeTransform(old, colour, scale) {
    let a = [...old];
    if (scale) {
        const now = luminance(...a), then = luminance(...colour);
        a = a.map((v) => (now > 0 ? (v * then) / now : 0));
    }
    const j = leading(a);
    if (!scale) a[j] = Math.max(a[j], DARKEST);
    if (!(a[j] > 0)) return { own: [0, 0, 0], lead: [0, 0, 0], j };
    const share = a.map((v) => v / a[j]);
    return { own: colour.map((c, k) => (c * share[k]) / a[j]),
        lead: colour.map((c, k) => (c * (1 - share[k] ** 2)) / a[j]), j };
}

// What the surface shows where other things share its pixel: the mean of what is around, the most
// covered counting by far the most, and no more than the pixel holds.
function atEdge(mask, halves, width, height, x, y, alpha) {
    const sum = [0, 0, 0];
    let total = 0;
    for (let v = Math.max(0, y - 2); v <= Math.min(height - 1, y + 2); v++)
        for (let u = Math.max(0, x - 2); u <= Math.min(width - 1, x + 2); u++) {
            const i = v * width + u;
            if (!mask[i]) continue;
            const w = (mask[i] / 255) ** 8 / (1 + (u - x) ** 2 + (v - y) ** 2);
            for (let k = 0; k < 3; k++) sum[k] += w * fromHalf[halves[4 * i + k]];
            total += w;
        }
    const at = 4 * (y * width + x);
    return sum.map((s, k) => Math.min(total ? s / total : 0, fromHalf[halves[at + k]] / alpha));
}

// The new light of pixel i; the shader of display-gl.js computes the same.
export function recolour({ own, lead, j }, mask, halves, width, height, i) {
    const light = [0, 1, 2].map((k) => fromHalf[halves[4 * i + k]]), alpha = mask[i] / 255;
    const f = mask[i] === 255 ? light
        : atEdge(mask, halves, width, height, i % width, Math.floor(i / width), alpha);
    return light.map((v, k) => v + alpha * (own[k] * f[k] + lead[k] * f[j] - f[k]));
}
