// Numbers for people.

export function count(n) {
    if (n === null || n === undefined) return "–";
    return Math.round(n).toLocaleString("en").replaceAll(",", "\u202f");
}

export const plural = (n, what) => `${count(n)}\u00a0${what}${n === 1 ? "" : "s"}`;

export function short(n) {
    if (!(Math.abs(n) >= 10000)) return count(n);
    const at = Math.min(Math.floor(Math.log10(Math.abs(n)) / 3), 4);
    return `${(n / 1000 ** at).toPrecision(3)}\u202f${["", "k", "M", "G", "T"][at]}`;
}

export function bytes(n) {
    if (!n) return "0 B";
    const at = Math.min(Math.floor(Math.log2(Math.abs(n)) / 10), 4);
    const value = n / 1024 ** at;
    return `${at ? value.toPrecision(3) : value}\u00a0${["B", "KiB", "MiB", "GiB", "TiB"][at]}`;
}

export function seconds(s) {
    if (s === null || s === undefined) return "–";
    if (s < 0.1) return `${(s * 1000).toPrecision(2)} ms`;
    if (s < 60) return `${s.toFixed(1)} s`;
    const m = Math.floor(s / 60);
    return m < 60 ? `${m} min ${Math.floor(s % 60)} s` : `${Math.floor(m / 60)} h ${m % 60} min`;
}

export const percent = (x, digits = 0) => `${(100 * x).toFixed(digits)} %`;

export function number(v) {
    if (!Number.isFinite(v)) return String(v);
    if (v === 0) return "0";
    const a = Math.abs(v);
    return a >= 1e6 || a < 1e-4 ? v.toExponential(2) : a >= 100 ? v.toFixed(1) : v.toPrecision(4);
}

export const signed = (v) => (v < 0 ? "−" : "+") + Math.abs(v).toFixed(2);

// Of a job's estimate; null where nothing is foretold.
export function forecast(f) {
    if (f && !f.reachable && !f.samples) return `${number(f.error)} is unreachable with these settings`;
    if (!f?.samples) return null;
    const range = f.lower_bound ? " or more" : ` (${count(f.interval[0])} to ${count(f.interval[1])})`;
    return `${number(f.error)} at ${count(f.samples)} samples${range}` +
        (f.reachable ? "" : ", unreachable with these settings");
}

// Settings that the daemon picked for a job, from what was measured, and what it expects of them.
export function choice({ settings, row, expected_error: error, expected_samples: samples, expected_seconds: time }) {
    const dials = Object.entries(settings.accuracy).map(([name, setting]) => `${name} ${setting}`);
    return `${row || "settings"}: ${dials.join(", ")}, ${settings.max_bounces} bounces; ` +
        `expected ${number(error)} at ${count(samples)} samples in ${seconds(time)}`;
}
