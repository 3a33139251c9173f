// Shortcuts, and the list of them.
import { h, id } from "./dom.js";

// [key, what it is called, what it does, action]; `viewer` is main.js's.
const KEYS = [
    ["U", "Upload a scene", (v) => v.click("upload")],
    ["N", "New job", (v) => v.newJob()],
    ["L", "Live job of the chosen scene", (v) => v.live()],
    ["Space", "Pause or resume the job", (v) => v.toggle()],
    ["J", "Next job", (v) => v.step(1)],
    ["K", "Job before", (v) => v.step(-1)],
    ["H", "Tool: pan", (v) => v.click("tool-pan")],
    ["P", "Tool: pick", (v) => v.click("tool-pick")],
    ["C", "Tool: camera", (v) => v.click("tool-camera")],
    ["R", "Camera back to where it was", (v) => v.resetCamera()],
    ["E", "Exposure up by a third; with Shift down", (v, shift) => v.expose(shift ? -1 / 3 : 1 / 3)],
    ["0", "Exposure back to zero", (v) => v.expose(0)],
    ["+", "Zoom in", (v) => v.zoom(true)],
    ["-", "Zoom out", (v) => v.zoom(false)],
    ["1", "Actual pixels", (v) => v.actual()],
    ["F", "Fit the picture", (v) => v.fit()],
    ["M", "Next way to show the matte", (v) => v.nextShow()],
    ["B", "Mattes through bounces, or of what is seen directly", (v) => v.nextThrough()],
    ["G", "To the picture", (v) => id("viewport").focus()],
    ["?", "This list", (v) => v.click("show-keys")],
];

const MORE = [
    ["Arrows", "in the picture: pan, move the cross, or turn the camera; Shift: ten times, or sideways"],
    ["Enter", "in the picture: pick what is under the cross"],
    ["Page up, down", "in the picture with the camera: closer, farther"],
    ["Drag", "pans; with the camera turns, with Shift or another button moves sideways"],
    ["Wheel", "zooms; with the camera goes closer and farther, with Ctrl zooms"],
    ["Click", "picks; with Shift adds to what is chosen"],
];

const typing = (e) => e.matches?.("input:not([type=range],[type=radio],[type=checkbox]), textarea, select");
const presses = (e) => e.matches?.("button, summary, a, input, [role=radio], [role=tab]");

export function listen(viewer) {
    id("keys").replaceChildren(...[...KEYS.map(([key, what]) => [key, what]), ...MORE].map(([key, what]) =>
        [h("dt", {}, h("kbd", {}, key)), h("dd", {}, what)]).flat());
    document.addEventListener("keydown", (event) => {
        const { target, key, ctrlKey, metaKey, altKey } = event;
        if (ctrlKey || metaKey || altKey || event.defaultPrevented) return;
        if (document.querySelector("dialog[open]") || typing(target)) return;
        if (key === " " && presses(target)) return;
        const wanted = key === " " ? "Space" : key === "=" ? "+" : key.length === 1 ? key.toUpperCase() : key;
        const row = KEYS.find(([name]) => name === wanted);
        if (!row) return;
        event.preventDefault();
        row[2](viewer, event.shiftKey);
    });
}
