"""Make .venv and install the workbench in it, where that is not done yet.

Standard library only, and no syntax newer than Python 3.6: it must be able to say that a
Python is too old.
"""

import hashlib
import importlib.util
import subprocess
import sys
from pathlib import Path

from apt import install, leave

ROOT = Path(__file__).resolve().parent.parent
VENV = ROOT / ".venv"
STAMP = VENV / "set-up-for"
"""Holds what .venv was made for: written last, so that a broken-off set-up is done again."""

OLDEST = (3, 11)
VERSION = f"{sys.version_info[0]}.{sys.version_info[1]}"


def main():
    """Do what is left to do."""
    if sys.version_info < OLDEST:
        leave(
            f"Python {VERSION} at {sys.executable} is too old, the workbench needs 3.11 or newer: "
            "install one and name it, as in `make PYTHON=python3.12 test`."
        )
    wanted = _wanted()
    if STAMP.exists() and STAMP.read_text() == wanted and _fits():
        return
    if not _fits():
        _make_venv()
    print("Installing the packages of constraints.txt into .venv (some 1 GB) ...", flush=True)
    # The build back end comes first and pinned, so that pip need not fetch another for the build.
    _pip("hatchling")
    _pip("--no-build-isolation", "-e", ".[dev]")
    STAMP.write_text(wanted)


def _wanted():
    """Return the text of a stamp that is up to date."""
    files = b"".join((ROOT / name).read_bytes() for name in ("pyproject.toml", "constraints.txt"))
    return hashlib.sha256(files).hexdigest()


def _fits():
    """Return whether .venv runs, is of this Python, and was made where it stands."""
    try:
        config = (VENV / "pyvenv.cfg").read_text()
    except OSError:
        return False
    made_by = dict(line.split(" = ", 1) for line in config.splitlines() if " = " in line)
    return (
        (VENV / "bin" / "python").exists()  # false for a link to a Python that is gone
        and made_by.get("version", "").startswith(VERSION + ".")
        and made_by.get("command", "").endswith(" " + str(VENV))
    )


def _make_venv():
    if importlib.util.find_spec("ensurepip") is None:
        install([f"python{VERSION}-venv"], f"Python {VERSION} lacks ensurepip")
    print(f"Making .venv with Python {VERSION} ...", flush=True)
    _run([sys.executable, "-m", "venv", "--clear", str(VENV)], "Making .venv failed")


def _pip(*what):
    pip = [str(VENV / "bin" / "python"), "-m", "pip", "--disable-pip-version-check"]
    _run(
        pip + ["install", "-qq", "-c", "constraints.txt"] + list(what),
        "Installing failed: if pip could not reach its package index, check the network",
    )


def _run(command, failure):
    if subprocess.run(command, cwd=str(ROOT)).returncode != 0:
        leave(f"{failure} (what went wrong stands above), then run make again.")


if __name__ == "__main__":
    main()
