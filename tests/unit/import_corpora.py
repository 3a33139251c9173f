#!/usr/bin/python3
"""Public and hostile scene files through the sandboxed import: counts, refusals, no lost helper."""
import base64
import glob
import json
import os
import re
import subprocess
import tempfile

import tap

LIMIT = 5  # seconds of processor time for any small file


def dump(files, *options):
    """{file: answer}; one importer serves all, so each answer proves that its helper lived on."""
    run = subprocess.run([tap.build("tests/unit/import_dump"), *options, *files],
                         capture_output=True, text=True, timeout=600)
    assert run.returncode == 0, run.stderr
    answers = [json.loads(line) for line in run.stdout.splitlines()]
    assert [a["file"] for a in answers] == list(files), "an answer is missing"
    for answer in answers:
        # fine, syntax, range, too large: any other status would not be the fault of the file
        assert answer["status"] in (0, 1, 2, 9), answer
        assert not answer.get("imported"), answer  # what an import gives must parse
        assert "crashed" not in answer.get("detail", ""), answer
    return {answer["file"]: answer for answer in answers}


def counted():
    """{file name: triangles drawn} of the scene list."""
    table = {}
    with open(tap.scenes("SCENES.md"), encoding="utf-8") as text:
        for line in text:
            row = re.match(r"\| `(\S+\.glb)` \| [\d.]+ \| ([\d,]+)(?: \(([\d,]+) drawn\))?", line)
            if row:
                table[row[1]] = int((row[3] or row[2]).replace(",", ""))
    return table


def test_every_public_glb_imports_with_the_triangles_that_are_listed():
    listed = counted()
    assert listed
    files = [tap.scenes(name) for name in listed]
    answers = dump(files)
    for name, file in zip(listed, files):
        assert answers[file]["status"] == 0, answers[file]
        assert answers[file]["drawn"] == listed[name], (name, answers[file]["drawn"], listed[name])


def test_equal_accessors_are_stored_once():
    answer, = dump([tap.scenes("khronos/MetalRoughSpheresNoTextures.glb")]).values()
    assert answer["triangles"] * 50 < answer["drawn"], answer


def expected(name):
    """What the made corpus asks for: the words after its name in the list beside it."""
    with open(tap.scenes("hostile/made/README.md"), encoding="utf-8") as text:
        for line in text:
            if f"`{name}`" in line:
                return line.split(":", 1)[1]
    return ""


def test_made_files_are_refused_or_loaded_as_listed():
    files = sorted(glob.glob(tap.scenes("hostile/made") + "/*.gl*"))
    assert len(files) >= 10
    for file, answer in dump(files).items():
        wish = expected(os.path.basename(file)).strip()
        if wish.startswith("refuse") and " or " not in wish:
            assert answer["status"] != 0, answer
        elif wish.startswith("load;"):
            assert answer["status"] == 0, answer


def test_no_file_of_the_hostile_corpora_stops_the_importer():
    files = sorted(path for pattern in ("*.glb", "*.gltf", "*.ply", "*.obj", "*.json", "*.hdr")
                   for path in glob.glob(tap.scenes("hostile") + "/**/" + pattern, recursive=True)
                   if not path.endswith(".report.json"))
    assert len(files) > 300
    for answer in dump(files, "--cpu", str(LIMIT)).values():
        assert "took longer" not in answer.get("detail", ""), answer
    dump(files, "--native")


def report_errors(path):
    """Errors that the Khronos validator reports for a file, None without a report."""
    reports = glob.glob(glob.escape(path) + ".report.json")
    if not reports:
        return None
    with open(reports[0], encoding="utf-8") as text:
        return json.load(text)["issues"]["numErrors"]


def test_broken_containers_of_the_validator_corpus_are_refused():
    files = sorted(glob.glob(tap.scenes("hostile/khronos-validator") + "/data/glb/*.glb"))
    assert files
    answers = dump(files)
    for file in files:
        if report_errors(file):
            assert answers[file]["status"] != 0, file


def test_the_picture_environments_decode_in_native_scenes():
    with open(tap.scenes("env/roof_garden_1k.hdr"), "rb") as file:
        uri = "data:image/vnd.radiance;base64," + base64.b64encode(file.read()).decode()
    scene = {"images": {"sky": {"data": uri}}, "environment": {"image": "sky"},
             "materials": {"m": {}}, "meshes": {"s": {"primitive": "sphere"}},
             "instances": {"ball": {"mesh": "s", "material": "m"}}}
    with tempfile.NamedTemporaryFile("w", suffix=".json") as text:
        json.dump(scene, text)
        text.flush()
        answer, = dump([text.name], "--native").values()
    assert answer["status"] == 0 and answer["images"] == 1, answer
    assert answer["asset_bytes"] >= 1024 * 512 * 8, answer


if __name__ == "__main__":
    tap.main()
