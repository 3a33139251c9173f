// Half floats as JavaScript has them in few browsers yet.

const scratch = new Float32Array(1), bits = new Uint32Array(scratch.buffer);

// Every half as a number, made once.
export const fromHalf = new Float32Array(65536);
for (let h = 0; h < 65536; h++) {
    const sign = h & 0x8000 ? -1 : 1, exponent = (h >> 10) & 31, fraction = h & 1023;
    fromHalf[h] = exponent === 31 ? (fraction ? NaN : sign * Infinity)
        : exponent ? sign * 2 ** (exponent - 15) * (1 + fraction / 1024) : sign * 2 ** -24 * fraction;
}

// To nearest, ties to even; what is too large becomes the largest half.
export function toHalf(value) {
    scratch[0] = value;
    const b = bits[0], sign = (b >>> 16) & 0x8000, a = b & 0x7fffffff;
    if (a > 0x7f800000) return 0x7e00;
    if (a >= 0x477ff000) return sign | 0x7bff;
    if (a < 0x38800000) return sign | Math.round(Math.abs(scratch[0]) * 2 ** 24);
    const rounded = a - 0x38000000 + 0xfff + ((a >>> 13) & 1);
    return sign | (rounded >>> 13);
}
