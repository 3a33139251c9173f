"""A few of the kills that tests/http/kill9 does many of."""
import os
import subprocess
import sys

import daemon
import tap


def test_nothing_accepted_is_lost_by_kills():
    program = os.path.join(os.path.dirname(os.path.abspath(__file__)), "kill9")
    done = subprocess.run([sys.executable, program, "--kills", "6", "--slack", "10"], text=True,
                          env={**os.environ, "GLINTD": daemon.GLINTD}, timeout=6 * daemon.PATIENCE,
                          stdout=subprocess.PIPE, check=False)
    print(done.stdout)
    assert done.returncode == 0, done.stdout


if __name__ == "__main__":
    tap.main()
