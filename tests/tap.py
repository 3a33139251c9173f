"""tap.py - runs every function named test_* of the calling module, in source order, prints TAP.

    import tap

    def test_a_frame_is_read_back():
        exrinfo = tap.tool("exrinfo")     # skips this test where the program is missing
        assert ...

    if __name__ == "__main__":
        tap.main()

A test passes if it returns, is skipped if it raises tap.Skip, fails with anything else. Arguments
on the command line pick tests by a part of their name. What a test prints goes to stderr.
"""
import contextlib
import os
import shutil
import sys
import traceback


class Skip(Exception):
    """Raised by a test that cannot run here; its text is the reason."""


def tool(name):
    """Path of a program, or Skip."""
    path = shutil.which(name)
    if not path:
        raise Skip(f"no {name}")
    return path


def build(*path):
    """Path inside the build tree; the runner starts tests at its top."""
    return os.path.join(os.environ.get("GLINT_BUILD", os.getcwd()), *path)


def source(*path):
    """Path inside the source tree."""
    return os.path.join(os.path.dirname(os.path.dirname(os.path.abspath(__file__))), *path)


def scenes(*path):
    """Path inside the folder of test scenes, or Skip where it does not exist."""
    root = os.environ.get("GLINT_SCENES", source("..", "shared", "scenes"))
    full = os.path.join(root, *path)
    if not os.path.exists(full):
        raise Skip(f"no {os.path.join('GLINT_SCENES', *path)}")
    return full


def skip_all(reason):
    """Ends the program: none of its tests can run here."""
    print(f"1..0 # SKIP {reason}", flush=True)
    sys.exit(0)


def _run(number, name, function):
    claim = name.removeprefix("test_")
    try:
        with contextlib.redirect_stdout(sys.stderr):
            function()
    except Skip as reason:
        line, passed = f"ok {number} - {claim} # SKIP {reason}", True
    except Exception:
        line, passed = f"not ok {number} - {claim}", False
        for text in traceback.format_exc().splitlines():
            print(f"# {text}")
    else:
        line, passed = f"ok {number} - {claim}", True
    print(line, flush=True)
    return passed


def main():
    """Runs the tests of the program that was started; exits 1 if one of them failed."""
    found = {name: value for name, value in vars(sys.modules["__main__"]).items()
             if name.startswith("test_") and callable(value)}
    wanted = sys.argv[1:]
    tests = [item for item in found.items() if not wanted or any(w in item[0] for w in wanted)]
    print(f"1..{len(tests)}", flush=True)
    results = [_run(number, *test) for number, test in enumerate(tests, 1)]
    sys.exit(0 if all(results) else 1)
