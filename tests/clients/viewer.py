#!/usr/bin/python3
"""The viewer in headless Chromium against a real daemon."""
import json
import os
import re
import subprocess
import tempfile

import numpy as np

import tap
from browser import Browser, decode, Keys

import sys
sys.path.insert(0, tap.source("tests", "http"))
from daemon import Daemon, GLINTD, ROOM, triangle_glb  # noqa: E402

SIZE = [160, 120]
ALL = ["beauty", "crypto_object", "crypto_material", "crypto_asset", "depth", "albedo"]

# ROOM under a sky: no pixel without light.
SCENE = {**ROOM, "environment": {"radiance": [0.6, 0.7, 0.9]}}

# Over a floor that reflects, a little blurred.
SHINY = {**SCENE, "materials": {**ROOM["materials"], "mirror": {"base_color": [0.8, 0.8, 0.8], "metallic": 1,
                                                                "roughness": 0.05}},
         "instances": {**ROOM["instances"], "floor": {**ROOM["instances"]["floor"], "material": "mirror"}}}
THROUGH = {"through": "glossy", "classes": True, "alpha": 0.02}


def job(**more):
    return {"scene": "room", "resolution": SIZE, "outputs": ALL, "stop": {"samples": 8}, **more}


def shown(daemon, page, **more):
    """Submits a job, opens it and waits for its end; returns its id."""
    name = daemon.submit(**job(**more))
    daemon.frame(name)
    page.run("location.hash = arguments[0]; location.reload()", name)
    page.until(lambda: page.text("#job-line").startswith("done"))
    page.actual()
    settle(page)
    return name


def settle(page):
    """Until two looks at the screen are equal."""
    before = [page.picture()]

    def still():
        now = page.picture()
        same = np.array_equal(now, before[0]) and now.any()
        before[0] = now
        return same
    page.until(still)
    return before[0]


def difference(page, daemon, name, query="output=beauty"):
    """The largest of the screen to frame.png, but where things and the sky share a pixel: a PNG has
    colour without its alpha there, the screen the light as it is."""
    answer = daemon.get(f"/v1/jobs/{name}/frame.png?{query}")
    assert answer.status == 200, answer.body
    wanted = decode(answer.body).astype(int)
    whole = np.isin(wanted[..., 3], (0, 255)) if wanted.shape[2] > 3 else np.full(wanted.shape[:2], True)
    assert whole.mean() > 0.8
    return np.abs(page.picture() - wanted[..., :3])[whole].max()


def chosen(page):
    return page.run("""return [...document.querySelectorAll("#matte-names input")].filter((b) => b.checked)
        .map((b) => b.closest("label").querySelector(".name").textContent)""")


def pick(page, x, y):
    page.at(x, y).click().perform()


# Uploads

def test_files_chosen_or_dropped_become_scenes():
    with Daemon() as daemon, Browser(daemon) as page, tempfile.TemporaryDirectory() as folder:
        page.until(lambda: page.text("#machine"))
        path = os.path.join(folder, "sail boat.glb")
        with open(path, "wb") as file:
            file.write(triangle_glb())
        page.find("#upload-files").send_keys(path)
        page.until(lambda: page.texts("#scenes .title") == ["sail-boat"])
        obj = b"mtllib paint.mtl\nusemtl red\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n"
        page.drop({"flag.obj": obj, "paint.mtl": b"newmtl red\nKd 0.8 0.1 0.1\n",
                   "room.json": json.dumps(ROOM).encode()})
        assert page.run("return window.overlay") is True
        page.until(lambda: page.texts("#scenes .title") == ["flag", "room", "sail-boat"])
        native = daemon.get("/v1/scenes/flag?format=native").json()
        assert native["materials"]["red"]["base_color"][0] > 0.5, "the MTL came with its OBJ"
        assert not page.text("#problems")


def test_every_fault_of_a_bad_upload_is_shown_with_its_pointer():
    with Daemon() as daemon, Browser(daemon) as page:
        page.until(lambda: page.text("#machine"))
        bad = json.loads(json.dumps(ROOM))
        bad["cameras"]["main"]["yfov"] = 9
        bad["materials"]["red"]["rouhgness"] = 0.5
        page.drop({"room.json": json.dumps(bad).encode()})
        page.until(lambda: page.all("#problems .problem"))
        assert {"/cameras/main/yfov", "/materials/red/rouhgness"} <= set(page.texts("#problems code"))
        assert "room was not taken" in page.text("#problems b")
        page.click("#problems [aria-label=Dismiss]")
        page.drop({"notes.txt": b"hello"})
        page.until(lambda: "notes.txt" in page.text("#problems"))


def test_a_scene_is_deleted_after_a_question():
    with Daemon() as daemon, Browser(daemon) as page:
        daemon.put("room", SCENE)
        page.until(lambda: page.all("#scenes .card"))
        page.click("[aria-label='Delete scene room']")
        page.press(Keys.ESCAPE)
        assert daemon.get("/v1/scenes/room").status == 200
        page.click("[aria-label='Delete scene room']")
        page.until(lambda: page.focused() == "ask-yes")
        page.press(Keys.ENTER)
        page.until(lambda: not page.all("#scenes .card"))
        assert daemon.get("/v1/scenes/room").status == 404


# The picture

def test_the_screen_shows_frame_png_within_rounding():
    with Daemon() as daemon:
        daemon.put("room", SCENE)
        for webgl in (True, False):
            with Browser(daemon, webgl) as page:
                name = shown(daemon, page)
                assert difference(page, daemon, name) <= 1, webgl
                page.set("#exposure", "-1.5")
                page.set("#tonemap", "reinhard")
                settle(page)
                query = "output=beauty&exposure=-1.5&tonemap=reinhard"
                assert difference(page, daemon, name, query) <= 1, webgl
                page.set("#exposure", "0")
                page.set("#tonemap", "clip")
                for output in ("depth", "crypto_object", "albedo"):
                    page.set("#output", output)
                    page.until(lambda: difference(page, daemon, name, f"output={output}") <= 1)


def test_the_picture_comes_back_when_the_graphics_driver_drops_it():
    with Daemon() as daemon, Browser(daemon) as page:
        daemon.put("room", SCENE)
        name = shown(daemon, page)
        page.run("""window.dropped = document.getElementById("canvas");
            window.dropped.getContext("webgl2").getExtension("WEBGL_lose_context").loseContext()""")
        page.until(lambda: page.run("return window.dropped !== document.getElementById('canvas')"))
        page.until(lambda: difference(page, daemon, name) <= 1)


def point(page, x, y):
    """Moves the pointer there, again as long as the picture has not noticed."""
    def noticed():
        page.at(x + 1, y).perform()
        page.at(x, y).perform()
        return page.text("#readout").startswith(f"{x}, {y} ")
    page.until(noticed)


def test_the_inspector_reads_the_values_under_the_pointer():
    with Daemon() as daemon, Browser(daemon) as page:
        daemon.put("room", SCENE)
        shown(daemon, page)
        point(page, 80, 100)
        page.until(lambda: "A " in page.text("#readout"))
        beauty = page.text("#readout")
        assert "R 0." in beauty and "A 1.000" in beauty, beauty
        page.set("#output", "depth")
        point(page, 80, 101)
        page.until(lambda: "R " not in page.text("#readout") and "80, 101" in page.text("#readout"))
        assert 3 < float(page.text("#readout").split("·")[1]) < 8  # the floor before the camera


# Mattes

def test_a_click_picks_what_the_daemon_picks():
    with Daemon() as daemon, Browser(daemon) as page:
        daemon.put("room", SCENE)
        name = shown(daemon, page)
        for x, y in ((56, 72), (104, 76), (80, 30)):
            wanted = daemon.get(f"/v1/jobs/{name}/pick?x={x}&y={y}").json()["primary"]["object"][0]["name"]
            pick(page, x, y)
            page.until(lambda: chosen(page) == [wanted])
            page.until(lambda: f"{wanted} /" in page.text("#readout"))
        page.set("#matte-layer", "material")
        pick(page, 56, 72)
        page.until(lambda: chosen(page) == ["metal"])


def test_a_new_colour_changes_its_pixels_and_no_other():
    with Daemon() as daemon, Browser(daemon) as page:
        daemon.put("room", SCENE)
        name = shown(daemon, page)
        before = page.picture()
        pick(page, 104, 76)
        page.until(lambda: chosen(page) == ["cube"])
        matte = decode(daemon.get(f"/v1/jobs/{name}/matte.png?name=cube").body)[..., 0].astype(int)
        page.until(lambda: np.abs(page.picture() - before).sum(axis=2)[matte == 255].min() > 0)
        page.set("#recolour-colour", "#2040ff")
        page.click("#recolour")

        def blue():
            now = page.picture()[matte == 255].mean(axis=0)
            return now[2] > 2 * now[0]
        page.until(blue)
        changed = np.abs(settle(page) - before).max(axis=2)
        assert changed[matte == 0].max() <= 1, "what the matte does not cover keeps its colour"
        assert (changed[matte == 255] > 8).mean() > 0.9


def ticked(page):
    """The classes that the mattes are made of."""
    return page.run("""return [...document.querySelectorAll("#matte-through input")]
        .filter((b) => b.checked).map((b) => b.value)""")


def matte_of(daemon, name, query):
    return decode(daemon.get(f"/v1/jobs/{name}/matte.png?{query}").body)[..., 0].astype(int)


def held(daemon, page):
    """A job with mattes through bounces that has begun and is held there; its id."""
    name = daemon.submit(**job(stop={"samples": 100000}, mattes=THROUGH))
    daemon.until(name, lambda j: j["samples"] >= 8)
    page.run("location.hash = arguments[0]; location.reload()", name)
    page.until(lambda: page.text("#job-line").startswith("rendering"))
    paused = daemon.ask("PATCH", f"/v1/jobs/{name}", json.dumps({"paused": True}),
                        {"Content-Type": "application/merge-patch+json"})
    assert paused.status == 200, paused.body
    page.until(lambda: page.text("#job-line").startswith("paused"))
    page.actual()
    settle(page)
    return name


def test_a_new_colour_changes_a_thing_and_its_reflection_while_the_job_is_under_way():
    with Daemon() as daemon, Browser(daemon) as page:
        daemon.put("room", SHINY)
        name = held(daemon, page)
        before = page.picture()
        pick(page, 104, 76)
        page.until(lambda: chosen(page) == ["cube"])
        assert ticked(page) == ["primary", "reflection", "refraction"]
        page.set("#recolour-colour", "#2040ff")
        page.click("#recolour")
        direct, all_of_it = (matte_of(daemon, name, f"name=cube&through={t}")
                             for t in ("primary", "primary,reflection,refraction"))
        mirrored = (direct == 0) & (all_of_it > 100)
        assert mirrored.sum() > 100, mirrored.sum()

        def changed():
            return np.abs(settle(page) - before).max(axis=2)
        page.until(lambda: (changed()[mirrored] > 8).mean() > 0.9)
        seen = changed()
        assert (seen[direct == 255] > 8).mean() > 0.9
        assert seen[all_of_it == 0].max() <= 1, "what the matte does not cover keeps its colour"
        page.find("#viewport").send_keys("b")
        assert ticked(page) == ["primary"]
        page.until(lambda: changed()[direct == 0].max() <= 1)
        assert (changed()[direct == 255] > 8).mean() > 0.9
        page.find("#viewport").send_keys("b")
        page.click("#matte-through input[value=primary]")
        assert ticked(page) == ["reflection", "refraction"]
        page.until(lambda: (changed()[mirrored] > 8).mean() > 0.9 and changed()[direct == 255].max() <= 1)


def test_a_click_in_the_mirror_picks_what_it_shows():
    with Daemon() as daemon, Browser(daemon) as page:
        daemon.put("room", SHINY)
        name = held(daemon, page)
        matte = matte_of(daemon, name, "name=cube&through=reflection")
        y, x = np.unravel_index(np.argmax(matte), matte.shape)
        assert matte[y, x] > 100
        pick(page, int(x), int(y))
        page.until(lambda: chosen(page) == ["floor"])  # the mirror itself covers all of the pixel
        page.click("#matte-through input[value=primary]")
        pick(page, int(x), int(y))
        page.until(lambda: chosen(page) == ["cube"])


def test_the_coverage_of_every_class_is_a_view():
    with Daemon() as daemon, Browser(daemon) as page:
        daemon.put("room", SHINY)
        name = shown(daemon, page, mattes=THROUGH)
        for view in ("crypto_object:reflection", "crypto_material:refraction", "crypto_object"):
            output, _, through = view.partition(":")
            page.set("#output", view)
            query = f"output={output}" + (f"&through={through}" if through else "")
            page.until(lambda: difference(page, daemon, name, query) <= 1)
        assert daemon.get(f"/v1/jobs/{name}/frame.png?output=crypto_object&through=glossy").status == 422


# Live

def test_a_drag_moves_the_camera_of_a_live_job_and_the_matte_follows():
    with Daemon() as daemon, Browser(daemon) as page:
        daemon.put("room", SCENE)
        name = daemon.submit(**job(live=True, stop={"samples": 64}))
        page.run("location.hash = arguments[0]; location.reload()", name)
        page.until(lambda: page.find("#tool-camera").get_attribute("aria-checked") == "true")
        daemon.until(name, lambda j: j["samples"] >= 1)
        page.actual()
        page.until(lambda: page.picture().any(axis=2).mean() > 0.9)
        before = page.picture()
        page.at(80, 60).click_and_hold().move_by_offset(-40, 0).move_by_offset(-40, 8).release().perform()
        page.until(lambda: np.abs(page.picture() - before).mean() > 10)
        moved = page.until(lambda: daemon.job(name)["job"].get("camera"))
        assert moved["yfov"] == ROOM["cameras"]["main"]["yfov"]
        x, y, z = moved["transform"][12:15]
        assert x > 0.5 and abs(np.hypot(x, z) - 5) < 1, "it turned around what it looks at"
        pick(page, 80, 60)
        page.until(lambda: chosen(page))
        page.find("#viewport").send_keys("r")
        page.until(lambda: abs(daemon.job(name)["job"]["camera"]["transform"][12]) < 1e-6)


# The inspector

def test_the_plan_and_the_curve_show_what_the_daemon_tells():
    with Daemon() as daemon, Browser(daemon) as page:
        daemon.put("room", SCENE)
        name = shown(daemon, page, stop={"samples": 64, "error": 1e-6})
        plan = daemon.get(f"/v1/jobs/{name}/plan").json()
        page.click("#tab-plan")
        page.until(lambda: page.all("#panel-plan .cost"))
        text = page.text("#panel-plan").replace(" ", "_")
        assert all(e["effect"].replace(" ", "_") in text for e in plan["effects"])
        assert all(e["reason"].replace(" ", "_") in text for e in plan["effects"])
        assert len(page.all("#panel-plan .cost")) >= len(plan["passes"])
        page.click("#tab-curve")
        page.until(lambda: page.all("#panel-curve svg"))
        data = daemon.get(f"/v1/jobs/{name}/convergence").json()
        points = [p for p in data["curve"] if p["error"]]
        assert len(page.all("#panel-curve .dot")) >= len(points) > 1
        assert "64 samples" in page.find("#panel-curve svg").get_attribute("aria-label")
        assert page.all("#panel-curve .target") and page.all("#panel-curve .aim")


def facts(page):
    """{name: text} of the job's figures that are shown."""
    return page.run("return Object.fromEntries([...document.querySelectorAll('#panel-job dt')]"
                    ".filter((t) => !t.hidden).map((t) => [t.textContent, t.nextSibling.textContent]))")


def test_a_job_shows_its_error_its_forecast_and_what_was_chosen():
    with Daemon() as daemon, Browser(daemon) as page:
        daemon.put("room", SCENE)
        rough = {"settings": {"accuracy": {"gi": "none"}, "max_bounces": 1}, "seconds": 1e-6,
                 "rays": 3, "variance": 0.5, "bias": 0.1, "row": "rough,1"}
        assert daemon.ask("PUT", "/v1/scenes/room/front", json.dumps({"points": [rough]}),
                          {"Content-Type": "application/json"}).status == 201
        name = shown(daemon, page, accuracy={"error": 0.3}, stop={"samples": 64})
        page.until(lambda: "Chosen" in facts(page))
        told, estimate = facts(page), daemon.job(name)["estimate"]
        assert re.match(r"rough,1: gi none, .*, 1 bounces; expected 0\.\d+ at \d+ samples in ", told["Chosen"])
        assert re.match(r"[\d.]+ \([\d.]+ to [\d.]+\)$", told["Error"]), told
        assert ("Rare events" in told) == estimate["rare_events"]
        assert "accuracy.gi none" in told["Not in the error"]
        assert told["Known bias"].startswith("0.1000, with the error 0.")
        name = daemon.submit(**job(accuracy={"gi": "none"}, max_bounces=1, outputs=["beauty"],
                                   stop={"error": 0.001, "samples": 1000000}))
        page.run("location.hash = arguments[0]; location.reload()", name)
        page.until(lambda: facts(page).get("Forecast") == "0.001000 is unreachable with these settings")
        assert "Chosen" not in facts(page)


# Without a pointer

def tab_to(page, name):
    for _ in range(60):
        if page.focused() == name:
            return
        page.press(Keys.TAB)
    raise AssertionError(f"Tab does not come to {name}")


def test_a_job_is_submitted_extended_and_looked_at_by_keys_alone():
    with Daemon() as daemon, Browser(daemon) as page:
        daemon.put("room", SCENE)
        page.until(lambda: page.all("#scenes .card"))
        page.press("n")
        page.until(lambda: page.all("#job-dialog[open]"))
        page.press(*3 * [Keys.BACKSPACE], "4", Keys.TAB, "0")
        tab_to(page, "job-submit")
        page.press(Keys.ENTER)
        page.until(lambda: "/stop/error" in page.text("#job-problem"))
        assert page.run("return document.activeElement.getAttribute('aria-invalid')") == "true"
        page.press(Keys.BACKSPACE, Keys.ENTER)
        page.until(lambda: not page.all("#job-dialog[open]"))
        page.until(lambda: page.text("#job-line").startswith("done"), 120)
        (name,) = [j["id"] for j in daemon.get("/v1/jobs").json()["jobs"]]
        assert daemon.job(name)["samples"] == 4
        page.run("document.querySelector('[aria-label=\"Samples per pixel\"]').focus()")
        page.press(Keys.ENTER)
        page.until(lambda: page.text("#job-line").startswith("done · 8 samples"), 120)
        page.press(Keys.TAB, "g", "p", Keys.ARROW_RIGHT, Keys.ARROW_DOWN, Keys.ENTER)
        page.until(lambda: chosen(page) == ["wall"])
        page.press("?")
        page.until(lambda: page.all("#keys-dialog[open]"))
        assert "Upload" in page.text("#keys")
        page.press(Keys.ESCAPE)
        page.until(lambda: not page.all("#keys-dialog[open]"))
        tab_to(page, "tab-mattes")
        page.press(Keys.ARROW_RIGHT)
        page.until(lambda: page.all("#panel-plan .cost"))


def names(page):
    """(role, name) of everything in the accessibility tree that can be used."""
    tree = page.driver.execute_cdp_cmd("Accessibility.getFullAXTree", {})["nodes"]
    for node in tree:
        role = node.get("role", {}).get("value")
        if not node.get("ignored"):
            yield role, node.get("name", {}).get("value", "")


def test_everything_has_a_role_and_a_name():
    with Daemon() as daemon, Browser(daemon) as page:
        daemon.put("room", SCENE)
        shown(daemon, page)
        used = {"button", "textbox", "combobox", "slider", "checkbox", "radio", "tab", "tabpanel",
                "link", "dialog", "progressbar", "searchbox", "spinbutton", "application", "img",
                "main", "complementary", "toolbar", "tablist", "list", "radiogroup", "ColorWell"}
        for key in ("", "n", Keys.ESCAPE, "?", Keys.ESCAPE):
            page.press(*([key] if key else []))
            found = list(names(page))
            assert [role for role, name in found if role in used - {"list"} and not name.strip()] == []
        roles = {role for role, _ in names(page)}
        assert {"banner", "main", "complementary", "status", "alert", "tab", "application"} <= roles, roles
        assert page.text("#said")


def test_text_has_the_contrast_that_AA_asks_for():
    with Daemon() as daemon, Browser(daemon) as page:
        daemon.put("room", SCENE)
        shown(daemon, page)
        page.click("#tab-plan")
        page.until(lambda: page.all("#panel-plan .cost"))
        poor = page.run(CONTRAST)
        assert poor == [], poor


# Of every text that is shown, its colour over the nearest background that is not transparent.
CONTRAST = """
const channel = (v) => (v /= 255) <= 0.04045 ? v / 12.92 : ((v + 0.055) / 1.055) ** 2.4;
const read = (text) => text.match(/[\\d.]+/g).map(Number);
const light = ([r, g, b]) => 0.2126 * channel(r) + 0.7152 * channel(g) + 0.0722 * channel(b);
const behind = (e) => {
    for (; e; e = e.parentElement) {
        const c = read(getComputedStyle(e).backgroundColor);
        if (c.length === 3 || c[3] === 1) return c;
    }
    return [22, 22, 22];
};
const poor = [];
for (const e of document.querySelectorAll("body *")) {
    const own = [...e.childNodes].some((n) => n.nodeType === 3 && n.data.trim());
    if (!own || !e.checkVisibility() || e.disabled || e.closest(".unseen, .skip")) continue;
    const front = e.ownerSVGElement ? getComputedStyle(e).fill : getComputedStyle(e).color;
    const [a, b] = [light(read(front)), light(behind(e))].sort((x, y) => y - x);
    if ((a + 0.05) / (b + 0.05) < 4.5) poor.push([e.textContent.trim().slice(0, 40), front, behind(e).join()]);
}
return poor;
"""


# Who asks

def test_a_token_is_asked_for_and_kept_as_long_as_the_tab():
    made = subprocess.run([GLINTD, "--new-token", "ann:submit"], capture_output=True, text=True, check=True)
    with tempfile.NamedTemporaryFile("w") as file:
        file.write(made.stdout)
        file.flush()
        with Daemon("--token-file", file.name) as daemon, Browser(daemon) as page:
            for secret, says in ("wrong", "asks for a token"), (made.stderr.strip(), "refused that token"):
                page.until(lambda: says in page.text("#ask-text") and page.focused() == "ask-input")
                page.press(secret, Keys.ENTER)
            page.until(lambda: page.text("#machine"))
            page.run("location.reload()")
            page.until(lambda: page.text("#machine"))
            assert not page.all("dialog[open]") and made.stderr.strip() not in page.driver.current_url


# What is served

def test_files_have_their_type_their_policy_and_a_tag_that_is_honoured():
    with Daemon() as daemon:
        kinds = {"/": "text/html; charset=utf-8", "/viewer/style.css": "text/css; charset=utf-8",
                 "/viewer/main.js": "text/javascript; charset=utf-8", "/viewer/icon.svg": "image/svg+xml"}
        for path, kind in kinds.items():
            answer = daemon.get(path)
            headers = answer.headers
            assert answer.status == 200 and headers["Content-Type"] == kind, path
            assert headers["X-Content-Type-Options"] == "nosniff"
            assert headers["Referrer-Policy"] == "no-referrer"
            policy = dict(part.strip().split(" ", 1) for part in headers["Content-Security-Policy"].split(";"))
            assert policy == {"default-src": "'none'", "script-src": "'self'", "style-src": "'self'",
                              "img-src": "'self' blob:", "connect-src": "'self'", "base-uri": "'none'",
                              "form-action": "'none'", "frame-ancestors": "'none'"}
            again = daemon.get(path, {"If-None-Match": headers["ETag"]})
            assert again.status == 304 and not again.body
        assert daemon.get("/viewer/absent.js").status == 404
        assert daemon.get("/viewer/..%2findex.html").status == 404


if __name__ == "__main__":
    tap.main()
