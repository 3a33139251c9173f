"""crews.py - the renderers of the bench `peers` as processes that answer one request after another."""
import json
import os
import shutil
import subprocess
import sys

HERE = os.path.dirname(os.path.abspath(__file__))
BLENDER = ("blender", "-b", "--factory-startup", "-P")


class Missing(Exception):
    """A renderer that cannot be had; its text is the reason."""


def in_venv(module, script, *more):
    """A renderer from PyPI, installed by tests/bench/peers_install."""
    def command(tools):
        python = os.path.join(tools, "bin", "python")
        if not os.path.exists(python):
            raise Missing(f"no virtual environment {tools}: tests/bench/peers_install makes it")
        probe = subprocess.run([python, "-c", f"import {module}"], capture_output=True, text=True,
                               check=False)
        if probe.returncode:
            raise Missing(f"{module}: {(probe.stderr.strip().splitlines() or ['crashed'])[-1]}")
        return [python, os.path.join(HERE, script)], list(more)
    return command


def debian_blender(_):
    if not shutil.which("blender"):
        raise Missing("Debian's blender is not installed")
    return [*BLENDER, os.path.join(HERE, "cycles_serve.py"), "--"], []


def ours(_):
    build = os.environ.get("GLINT_BUILD", os.getcwd())
    return [os.path.join(build, "tests/bench/peers/glint"), "serve"], []


def embree(_):
    raise Missing("Embree's pathtracer writes eight bits a channel, clamped to 1 (of .pfm too): it has "
                  "no error that could be measured")


RENDERERS = {"glint": ours, "cycles-debian": debian_blender,
             "cycles": in_venv("bpy", "cycles_serve.py"),
             "mitsuba-llvm": in_venv("mitsuba", "mitsuba_serve.py", "llvm_ad_rgb"),
             "mitsuba-scalar": in_venv("mitsuba", "mitsuba_serve.py", "scalar_rgb"),
             "luxcore": in_venv("pyluxcore", "luxcore_serve.py"), "embree": embree}


class Crew:
    """One renderer with one scene resident."""

    def __init__(self, name, tools, folder, size, bounces, log):
        head, more = RENDERERS[name](tools)
        self.name, self.size, self.version = name, size, name
        self.process = subprocess.Popen(
            [*head, folder, str(size[0]), str(size[1]), str(bounces), *more],
            stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=log, text=True)
        self.out = os.path.join(folder, f"out-{name}")

    def answer(self):
        """The next JSON line; a renderer's own chatter is passed over."""
        for line in self.process.stdout:
            if line.startswith("{"):
                answer = json.loads(line)
                if "ready" in answer:
                    self.version = answer["ready"]
                    continue
                return answer
        raise Missing(f"{self.name} ended with status {self.process.wait()}")

    def render(self, samples, seed, read):
        """(picture, user CPU seconds, samples of a pixel that were taken)"""
        try:
            self.process.stdin.write(f"{samples} {seed} {self.out}\n")
            self.process.stdin.flush()
        except BrokenPipeError:
            raise Missing(f"{self.name} ended with status {self.process.wait()}") from None
        answer = self.answer()
        return read(self.out, *self.size), answer["user"], answer.get("samples", samples)

    def close(self):
        self.process.stdin.close()
        try:
            self.process.wait(60)
        except subprocess.TimeoutExpired:
            self.process.kill()
            self.process.wait()


def open_crew(name, tools, folder, size, bounces):
    log = open(os.path.join(folder, f"log-{name}"), "w", encoding="utf-8")
    with log:
        return Crew(name, tools, folder, size, bounces, log)
