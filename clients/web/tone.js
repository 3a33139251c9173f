// From scene-linear light to the 8-bit codes of a screen, as frame.png has it; the shader in
// display-gl.js computes the same.
import { fromHalf } from "./half.js";

const TONES = { clip: (v) => Math.min(v, 1), reinhard: (v) => 1 - 1 / (1 + v) };

const encode = (v) => (v <= 0.0031308 ? 12.92 * v : 1.055 * v ** (1 / 2.4) - 0.055);

export function code(value, exposure, tone) {
    const v = value * 2 ** exposure;
    return v > 0 ? Math.round(255 * encode((TONES[tone] ?? TONES.clip)(v))) : 0; // NaN too
}

// The code of every half.
export function codesOfHalves(exposure, tone) {
    const table = new Uint8Array(65536);
    for (let h = 0; h < 65536; h++) table[h] = code(fromHalf[h], exposure, tone);
    return table;
}

export const luminance = (r, g, b) => 0.2126 * r + 0.7152 * g + 0.0722 * b;

// "#rrggbb" as linear light.
export function linear(hex) {
    return [1, 3, 5].map((at) => {
        const v = parseInt(hex.slice(at, at + 2), 16) / 255;
        return v <= 0.04045 ? v / 12.92 : ((v + 0.055) / 1.055) ** 2.4;
    });
}
