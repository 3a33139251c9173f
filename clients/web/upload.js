// Scenes from files: what belongs together is one upload, and what cannot be one is said.
import { Problem, scenePath, upload } from "./api.js";
import { h, id, say } from "./dom.js";
import { bytes } from "./format.js";
import { showProblem } from "./problems.js";

const TYPES = {
    glb: "model/gltf-binary", gltf: "model/gltf+json", obj: "model/obj",
    ply: "application/ply", stl: "model/stl", json: "application/json",
};
const ALONE = new Set(["glb", "ply", "stl", "json"]); // need no other files

const extension = (path) => /\.([^./]+)$/.exec(path)?.[1].toLowerCase() ?? "";
const folder = (path) => path.slice(0, path.lastIndexOf("/") + 1);

function sceneName(path) {
    const base = path.slice(path.lastIndexOf("/") + 1).replace(/(.)\.[^.]*$/, "$1").slice(0, 128);
    const name = base.replace(/[^A-Za-z0-9._-]/g, "-");
    return /^\.*$/.test(name) ? "scene" : name;
}

// [{path, file}] as the uploads that they mean: {name, main, files}. A glTF or OBJ takes along what
// is no scene by itself, of its own folder and below where several are dropped.
function groupFiles(files) {
    const mains = files.filter(({ path }) => extension(path) in TYPES);
    const rest = files.filter((f) => !mains.includes(f));
    const needy = mains.filter(({ path }) => !ALONE.has(extension(path)));
    const used = new Set();
    const groups = mains.map((main) => {
        const with_ = ALONE.has(extension(main.path)) ? []
            : rest.filter(({ path }) => needy.length === 1 || path.startsWith(folder(main.path)));
        with_.forEach((f) => used.add(f));
        return { name: sceneName(main.path), main, files: [main, ...with_] };
    });
    return { groups, left: rest.filter((f) => !used.has(f)) };
}

// The body of a PUT. Paths in a form are relative to the main file's folder.
function bodyOf({ main, files }) {
    if (files.length === 1) return { body: main.file, type: TYPES[extension(main.path)] };
    const form = new FormData(), base = folder(main.path);
    for (const { path, file } of files)
        form.append("file", file, path.startsWith(base) ? path.slice(base.length) : path);
    return { body: form };
}

async function readEntry(entry, prefix, out) {
    if (entry.isFile) {
        const file = await new Promise((resolve, reject) => entry.file(resolve, reject));
        out.push({ path: prefix + entry.name, file });
        return;
    }
    const reader = entry.createReader();
    for (let batch; (batch = await new Promise((ok, no) => reader.readEntries(ok, no))).length; )
        for (const inner of batch) await readEntry(inner, `${prefix}${entry.name}/`, out);
}

// Files of a drop, folders with all that is in them.
async function droppedFiles(transfer) {
    const entries = [...transfer.items].map((item) => item.webkitGetAsEntry?.()).filter(Boolean);
    if (!entries.length) return [...transfer.files].map((file) => ({ path: file.name, file }));
    const out = [];
    for (const entry of entries) await readEntry(entry, "", out);
    return out;
}

export class Uploads {
    // taken(scene): a scene is there.
    constructor(list, taken) {
        Object.assign(this, { list, taken });
        this.#listen();
    }

    #listen() {
        const input = id("upload-files");
        id("upload").addEventListener("click", () => input.click());
        input.addEventListener("change", () => {
            this.add([...input.files].map((file) => ({ path: file.webkitRelativePath || file.name, file })));
            input.value = "";
        });
        let depth = 0;
        const files = (event) => event.dataTransfer?.types.includes("Files");
        addEventListener("dragenter", (event) => files(event) && (id("drop").hidden = !++depth));
        addEventListener("dragleave", (event) => files(event) && (id("drop").hidden = !--depth));
        addEventListener("dragover", (event) => files(event) && event.preventDefault());
        addEventListener("drop", async (event) => {
            if (!files(event)) return;
            event.preventDefault();
            depth = 0;
            id("drop").hidden = true;
            const dropped = await droppedFiles(event.dataTransfer).catch((error) => {
                showProblem("The files cannot be read", error);
                return [];
            });
            this.add(dropped);
        });
    }

    add(files) {
        if (!files.length) return;
        const { groups, left } = groupFiles(files);
        if (!groups.length)
            showProblem("No scene among the files", new Problem(0, { detail:
                `${files.map((f) => f.path).join(", ")}: a scene is .glb, .gltf, .obj, .ply, .stl or .json.` }));
        else if (left.length)
            showProblem("Not uploaded", new Problem(0, { detail:
                `${left.map((f) => f.path).join(", ")}: it is not clear which scene they belong to.` }));
        for (const group of groups) this.#send(group);
    }

    async #send(group) {
        const total = group.files.reduce((sum, f) => sum + f.file.size, 0);
        const progress = h("progress", { max: Math.max(total, 1), value: 0, "aria-label": `Upload of ${group.name}` });
        const text = h("span.facts", {}, bytes(total));
        const { done, cancel } = upload(scenePath(group.name), bodyOf(group), (sent, size) => {
            progress.max = size || 1;
            progress.value = sent;
            text.textContent = sent < size ? `${bytes(sent)} of ${bytes(size)}` : "is read by the daemon …";
        });
        const row = h("li", {}, h("div.head", {}, h("b", {}, group.name), " ", text), progress,
            h("button.small", { type: "button", onclick: cancel }, "Cancel"));
        this.list.append(row);
        try {
            const { scene, created } = await done;
            say(`Scene ${scene.name} ${created ? "uploaded" : "replaced"}`);
            this.taken(scene);
        } catch (error) {
            showProblem(`${group.name} was not taken`, error);
        }
        row.remove();
    }
}
