// What went wrong, in full: the daemon's own words, each fault with its pointer.
import { h, id } from "./dom.js";

export function describeProblem(error) {
    const faults = (error.errors ?? []).map(({ pointer, detail }) =>
        h("li", {}, pointer ? h("code", {}, pointer) : null, pointer ? " " : "", detail));
    const alone = faults.length === 1 && !error.errors[0].pointer && error.errors[0].detail === error.message;
    return [
        faults.length && !alone ? null : h("p", {}, error.message),
        faults.length && !alone ? h("ul", {}, faults) : null,
        error.requestId ? h("p.id", {}, `Request ${error.requestId}`) : null,
    ].filter(Boolean);
}

// Shows it in a corner until it is dismissed, or in `place` in stead of what was there.
export function showProblem(what, error, place) {
    if (error.name === "AbortError") return;
    const title = error.title && error.status ? `${what}: ${error.title.toLowerCase()} (${error.status})` : what;
    const box = h("div.problem", {},
        h("div.head", {}, h("b", {}, title),
            place ? null : h("button.quiet.small", { type: "button", "aria-label": "Dismiss",
                onclick: () => box.remove() }, "✕")),
        ...describeProblem(error));
    if (place) {
        place.replaceChildren(box);
        return;
    }
    const all = id("problems");
    const same = [...all.children].find((other) => other.textContent === box.textContent);
    if (same) return;
    all.append(box);
    while (all.children.length > 4) all.firstChild.remove();
}
