"""cli.py - runs the client under test. Where $GLINT names no program every test is skipped."""
import os
import socket
import subprocess

import tap


PROGRAM = os.environ.get("GLINT") or tap.build("glint")
if not os.access(PROGRAM, os.X_OK):
    tap.skip_all("no glint")


def environment(**more):
    """The tests' own, without the user's daemon."""
    mine = ("GLINT_SERVER", "GLINT_TOKEN", "GLINT_CA_FILE")
    kept = {k: v for k, v in os.environ.items() if k not in mine}
    return {**kept, **more}


def glint(*arguments, server=None, cwd=None, **more):
    """The finished process, its output as text."""
    variables = environment(**({"GLINT_SERVER": server} if server else {}), **more)
    return subprocess.run([PROGRAM, *map(str, arguments)], env=variables, cwd=cwd, text=True,
                          capture_output=True, timeout=120, stdin=subprocess.DEVNULL)


def start(*arguments, server=None, binary=None, **more):
    """The running process, with pipes."""
    variables = environment(**({"GLINT_SERVER": server} if server else {}), **more)
    return subprocess.Popen([binary or PROGRAM, *map(str, arguments)], env=variables, text=True,
                            stdout=subprocess.PIPE, stderr=subprocess.PIPE,
                            stdin=subprocess.DEVNULL)


class Silence:
    """A server address that refuses connections for as long as it is held."""

    def __enter__(self):
        self.socket = socket.socket()
        self.socket.bind(("127.0.0.1", 0))  # bound, never listening
        return f"http://127.0.0.1:{self.socket.getsockname()[1]}"

    def __exit__(self, *error):
        self.socket.close()
