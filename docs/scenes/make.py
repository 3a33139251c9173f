#!/usr/bin/python3
"""make.py BIN SCENES [--table] - renders every scene file below SCENES (hostile/ left out) with the glint and
glintd in BIN, and writes beside itself: contact.jpg, a sheet of small pictures; khronos-*.jpg, one
for each feature test and moment; scenes.md, what the daemon said of each file. --table: scenes.md
alone, nothing is rendered.

Needs python3-openimageio and python3-numpy.
"""
import base64
import json
import pathlib
import re
import subprocess
import sys
import tempfile
import urllib.error
import urllib.request

import numpy
import OpenImageIO as oiio

HERE = pathlib.Path(__file__).resolve().parent
CELL = (240, 180)
COLUMNS = 8
BIG = (400, 300)
# Feature tests that have a picture of their own, and the frames (at 24 a second) of those that move.
FEATURES = {
    'AlphaBlendModeTest': [0], 'AttenuationTest': [0], 'ClearCoatTest': [0],
    'EmissiveStrengthTest': [0], 'MultiUVTest': [0], 'NegativeScaleTest': [0], 'SpecularTest': [0],
    'TextureSettingsTest': [0], 'TextureTransformTest': [0], 'TransmissionTest': [0],
    'BoxVertexColors': [0], 'AnimatedMorphCube': [0, 16, 48], 'BoxAnimated': [14, 46, 79],
    'RiggedSimple': [0, 12, 24],
}


class Daemon:
    """A private glintd on a free port."""

    def __init__(self, folder, state):
        self.process = subprocess.Popen(
            [folder / 'glintd', '--listen', '127.0.0.1:0', '--state', state],
            stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True)
        self.url = re.search(r'http://\S+', self.process.stdout.readline()).group(0)

    def stop(self):
        self.process.terminate()
        self.process.wait()


def scene_files(root):
    kinds = {'.glb', '.gltf', '.obj', '.ply', '.stl'}
    return sorted(p for p in root.rglob('*')
                  if p.suffix in kinds and 'hostile' not in p.relative_to(root).parts)


def environment_scene(path):
    """A mirror, a glass and a grey ball in the light of a picture, as a native scene."""
    kind = {'.hdr': 'image/vnd.radiance', '.exr': 'image/x-exr'}[path.suffix]
    data = base64.b64encode(path.read_bytes()).decode()
    balls = {'mirror': {'metallic': 1, 'roughness': 0}, 'grey': {'base_color': [.5, .5, .5]},
             'glass': {'transmission': 1, 'roughness': 0}}
    return {
        'images': {'sky': {'data': f'data:{kind};base64,{data}'}},
        'environment': {'image': 'sky'}, 'materials': balls,
        'meshes': {'ball': {'primitive': 'sphere'}},
        'instances': {name: {'mesh': 'ball', 'material': name,
                             'transform': {'translation': [2.2 * (i - 1), 0, 0]}}
                      for i, name in enumerate(balls)},
        'cameras': {'eye': {'yfov': .7, 'transform': {'translation': [0, 0, 7]}}}}


def run(command):
    return subprocess.run([str(c) for c in command], capture_output=True, text=True)


def first_line(text):
    lines = [line for line in text.splitlines() if line.strip()]
    return lines[0] if lines else ''


def put(binary, url, path, name):
    """The scene resource, or the refusal."""
    done = run([binary / 'glint', 'put', path, '--name', name, '--server', url, '--json'])
    if done.returncode:
        return {'problem': first_line(done.stderr) or done.stdout.strip()}
    return json.loads(done.stdout)


def forget(url, name):
    """The scene and the jobs that used it: memory for the next one."""
    gone = urllib.request.Request(f'{url}/v1/scenes/{name}?force=true', method='DELETE')
    urllib.request.urlopen(gone).close()
    with urllib.request.urlopen(f'{url}/v1/jobs') as answer:
        for job in json.load(answer)['jobs']:
            urllib.request.urlopen(urllib.request.Request(
                f"{url}/v1/jobs/{job['id']}", method='DELETE')).close()


def added(resource, what):
    return any(what in text and 'was added' in text for text in resource['warnings'])


def light(url, name, picture):
    """A picture all around instead of a constant: white things are seen before it."""
    data = base64.b64encode(picture.read_bytes()).decode()
    patch = {'images': {'contact-sky': {'data': f'data:image/x-exr;base64,{data}'}},
             'environment': {'image': 'contact-sky', 'radiance': [1, 1, 1]}}
    order = urllib.request.Request(
        f'{url}/v1/scenes/{name}', json.dumps(patch).encode(),
        {'Content-Type': 'application/merge-patch+json'}, method='PATCH')
    urllib.request.urlopen(order).close()


def front(url, name):
    """The camera that was added to the scene, moved before it: feature tests face +z."""
    with urllib.request.urlopen(f'{url}/v1/scenes/{name}?format=native') as answer:
        camera = next(iter(json.load(answer)['cameras'].values()))
    away, eye = camera['focus_distance'], camera['transform'][12:15]
    middle = [e - away * back for e, back in zip(eye, (.4, .3, .8660254))]
    return {'yfov': camera['yfov'],
            'transform': {'translation': [middle[0], middle[1], middle[2] + .8 * away]}}


def picture(url, name, size, samples, work, **more):
    """The finished frame as sRGB; None where it was refused."""
    job = {'scene': name, 'resolution': size, 'outputs': ['beauty'],
           'stop': {'samples': samples}, **more}
    try:
        order = urllib.request.Request(f'{url}/v1/jobs', json.dumps(job).encode(),
                                       {'Content-Type': 'application/json'})
        with urllib.request.urlopen(order) as answer:
            place = answer.headers['Location']
        with urllib.request.urlopen(f'{url}{place}/frame.exr?wait=done') as answer:
            out = work / f"{place.rsplit('/')[-1]}.exr"  # a name of its own: OpenImageIO caches
            out.write_bytes(answer.read())
    except urllib.error.HTTPError as error:
        print(name, error.read().decode(), file=sys.stderr)
        return None
    pixels = oiio.ImageBuf(str(out)).get_pixels(oiio.FLOAT)[..., :3]
    c = numpy.clip(pixels, 0, 1)
    return numpy.where(c <= .0031308, 12.92 * c, 1.055 * c ** (1 / 2.4) - .055)


def save(pixels, path, quality=80):
    height, width = pixels.shape[:2]
    spec = oiio.ImageSpec(width, height, 3, oiio.UINT8)
    spec.attribute('CompressionQuality', quality)
    out = oiio.ImageOutput.create(str(path))
    out.open(str(path), spec)
    out.write_image((pixels * 255 + .5).astype(numpy.uint8))
    out.close()


def sheet(cells):
    height, width = cells[0].shape[:2]
    rows = -(-len(cells) // COLUMNS)
    whole = numpy.ones((rows * height, COLUMNS * width, 3), numpy.float32)
    for i, cell in enumerate(cells):
        y, x = i // COLUMNS * height, i % COLUMNS * width
        whole[y:y + height, x:x + width] = cell
    return whole


def table(said):
    """Markdown, in the order of the sheet."""
    lines = ['| row, column | file | triangles | effects | warnings |', '| --- | --- | --- | --- | --- |']
    for i, (label, scene) in enumerate(said.items()):
        note = scene.get('problem') or '<br>'.join(scene.get('warnings', []))
        lines.append(f"| {i // COLUMNS + 1}, {i % COLUMNS + 1} | {label} | "
                     f"{scene.get('triangles', '-')} | {', '.join(scene.get('effects', []))} | "
                     f"{note.replace('|', '/')} |")
    return '\n'.join(lines) + '\n'


def main():
    binary, root = pathlib.Path(sys.argv[1]).resolve(), pathlib.Path(sys.argv[2]).resolve()
    table_alone = '--table' in sys.argv[3:]
    work = pathlib.Path(tempfile.mkdtemp())
    daemon = Daemon(binary, work / 'state')
    cells, said = [], {}
    try:
        sources = [(p, p) for p in scene_files(root)]
        for p in sorted((root / 'env').glob('*')) if (root / 'env').is_dir() else []:
            if p.suffix in ('.hdr', '.exr'):
                native = work / f'{p.stem}.json'
                native.write_text(json.dumps(environment_scene(p)))
                sources.append((p, native))
        for i, (path, source) in enumerate(sources):
            label = str(path.relative_to(root))
            name = f's{i}'
            resource = put(binary, daemon.url, source, name)
            said[label] = {k: resource.get(k) for k in
                           ('triangles', 'effects', 'warnings', 'problem') if resource.get(k)}
            print(label, resource.get('problem', ''), flush=True)
            if 'problem' in resource:
                cells.append(numpy.full((CELL[1], CELL[0], 3), .8))
                continue
            if table_alone:
                forget(daemon.url, name)
                continue
            if added(resource, 'environment'):
                light(daemon.url, name, root / 'env' / 'sunset.dwab.exr')
            small = picture(daemon.url, name, CELL, 64, work)
            if small is None:
                small = numpy.zeros((CELL[1], CELL[0], 3))
            cells.append(small)
            feature = path.stem if path.parent.name != 'glTF-Quantized' else None
            for frame in FEATURES.get(feature, []):
                turned = len(FEATURES[feature]) == 1 and added(resource, 'camera')
                view = {'camera': front(daemon.url, name)} if turned else {}
                big = picture(daemon.url, name, BIG, 128, work, frame=frame, **view)
                if big is not None:
                    moment = f'-{frame}' if len(FEATURES[feature]) > 1 else ''
                    save(big, HERE / f'khronos-{feature}{moment}.jpg')
            forget(daemon.url, name)
    finally:
        daemon.stop()
    if not table_alone:
        save(sheet(cells), HERE / 'contact.jpg', 75)
    (HERE / 'scenes.md').write_text(table(said))


if __name__ == '__main__':
    main()
