"""Other programs that look at our files."""
import subprocess

import tap


def run(*command, **options):
    """What it prints."""
    return subprocess.run(command, check=True, capture_output=True, timeout=300, **options).stdout


def exrinfo(*arguments):
    """What exrinfo prints. The exit status of OpenEXR 3.1.5's is random where it has no fault to tell."""
    told = subprocess.run((tap.tool("exrinfo"), *arguments), capture_output=True, timeout=300, text=True)
    assert told.returncode >= 0 and not told.stderr, told.stderr
    return told.stdout
