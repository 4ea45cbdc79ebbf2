"""Make a virtual environment and install the workbench with extras, where that is not done yet.

It has the Python that is named; otherwise the one it has; otherwise the newest supported one that
is found, among the programs of PATH and pyenv's.

Standard library only, and no syntax newer than Python 3.6: any python3 can run it.
"""

import argparse
import hashlib
import os
import shutil
import subprocess
import sys
from collections import namedtuple
from pathlib import Path

from apt import install, leave

ROOT = Path(__file__).resolve().parent.parent
STAMP = "set-up-for-"
"""Begins the name of the file that says what extras were installed from. It is written last, so
that a broken-off set-up is redone."""

SUPPORTED = ("3.13", "3.12", "3.11")
"""The Pythons that the tests pass with, newest first; as `requires-python` says."""
SENTENCE = "The workbench runs on Python 3.11, 3.12 and 3.13"

PROBE = """
import sys
flags = getattr(sys, "abiflags", "")
print("%d.%d" % sys.version_info[:2] + flags)
print(getattr(sys, "_base_executable", None) or sys.executable)
import ensurepip, venv
print("makes environments")
"""
"""Prints version, the program itself (not a link of a virtual environment), and the last line if
environments can be made: Debian leaves ensurepip out. A flag "t" is a Python without the lock."""

Python = namedtuple("Python", "path version makes_environments")
"""A Python program: its path, its version as "3.13", whether it has venv and ensurepip."""


def main():
    """Do what is left to do, or print the path of a Python."""
    args = _arguments()
    if args.find:
        found = _choose(_found([args.find]))
        if found is None:
            sys.exit(1)
        print(found.path)
        return
    venv = ROOT / args.venv
    if not (_standing(venv) in SUPPORTED and not args.python):
        python = _named(args.python) if args.python else _newest()
        if _standing(venv) != python.version:
            _make_venv(venv, python)
    wanted = _wanted()
    stamps = {stamp.name[len(STAMP) :]: stamp for stamp in sorted(venv.glob(STAMP + "*"))}
    # extras share packages: what was installed from other pins is installed anew with these
    stale = [extras for extras, stamp in stamps.items() if stamp.read_text() != wanted]
    if args.extras in stamps and not stale:
        return
    for extras in stale:
        stamps[extras].unlink()
    names = ",".join(dict.fromkeys(",".join([args.extras] + stale).split(",")))
    print(f"Installing [{names}] into {venv.name} as constraints.txt pins it ...", flush=True)
    # The build back end comes first and pinned, so that pip need not fetch another for the build.
    _pip(venv, "hatchling")
    _pip(venv, "--no-build-isolation", "-e", f".[{names}]")
    for extras in [args.extras] + stale:
        (venv / (STAMP + extras)).write_text(wanted)


def _arguments():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("extras", nargs="?", default="dev", help="as pip writes them: app,logs")
    parser.add_argument("--venv", default=".venv", help="the environment's folder")
    parser.add_argument("--python", help="the program to make it with")
    parser.add_argument(
        "--find", metavar="VERSION", help="print the path of that Python; exit code 1 without one"
    )
    return parser.parse_args()


def _wanted():
    """Return the text of a stamp that is up to date."""
    files = b"".join((ROOT / name).read_bytes() for name in ("pyproject.toml", "constraints.txt"))
    return hashlib.sha256(files).hexdigest()


def _standing(venv):
    """Return the version of an environment that runs and was made where it stands, else None."""
    try:
        config = (venv / "pyvenv.cfg").read_text()
    except OSError:
        return None
    made_by = dict(line.split(" = ", 1) for line in config.splitlines() if " = " in line)
    runs = (venv / "bin" / "python").exists()  # false for a link to a Python that is gone
    if runs and made_by.get("command", "").endswith(" " + str(venv)):
        return ".".join(made_by.get("version", "").split(".")[:2])
    return None


def _named(program):
    """Return the Python that was asked for, or leave with a sentence."""
    path = shutil.which(program)
    python = path and _probe(path)
    if not python:
        leave(
            f"There is no Python that runs as {program}: install it, or name another, as in "
            "`make PYTHON=python3.12 test`."
        )
    if python.version not in SUPPORTED:
        leave(
            f"{SENTENCE}, and {program} is Python {python.version}: name another, as in "
            "`make PYTHON=python3.12 test`, or none, for the newest that is found."
        )
    return python


def _newest():
    """Return the newest supported Python that is found, or leave with a sentence."""
    found = _found(SUPPORTED)
    python = _choose(found)
    if python is None:
        here = _probe(sys.executable)
        leave(
            f"{SENTENCE}, and none of them is on PATH or in pyenv ({here.path} is Python "
            f"{here.version}): install one, as by `sudo apt-get install python3.12-venv` or "
            f"`pyenv install {SUPPORTED[0]}`, then run make again."
        )
    if found[0].version != python.version:
        print(
            f"{found[0].path} lacks ensurepip, which Debian has in python{found[0].version}-venv: "
            f"taking Python {python.version}.",
            flush=True,
        )
    return python


def _choose(found):
    """Return the first that can make an environment, else the first, None of none."""
    return next((it for it in found if it.makes_environments), found[0] if found else None)


def _found(versions):
    """Return the Pythons of some versions that run, in the order of the versions."""
    folders = [Path(folder) for folder in os.get_exec_path()]
    pyenv = Path(os.environ.get("PYENV_ROOT") or Path.home() / ".pyenv") / "versions"
    folders += sorted(pyenv.glob("*/bin"))
    found = {}
    for folder in folders:
        for name in ["python3"] + [f"python{version}" for version in versions]:
            path = folder / name
            python = _probe(path) if os.access(str(path), os.X_OK) else None
            if python and python.version in versions:
                found.setdefault(python.path, python)
    return sorted(found.values(), key=lambda python: versions.index(python.version))


def _probe(path):
    """Return what a program says about itself, None if it is not a Python that runs.

    pyenv's shims, for one, run only for the versions that are switched on.
    """
    done = subprocess.run(
        [str(path), "-c", PROBE],
        stdout=subprocess.PIPE,
        stderr=subprocess.DEVNULL,
    )
    lines = done.stdout.decode(errors="replace").splitlines()
    return Python(lines[1], lines[0], done.returncode == 0) if len(lines) > 1 else None


def _make_venv(venv, python):
    if venv.is_symlink():  # venv would empty what it leads to, and then fail
        leave(
            f"{venv.name} is a link to {venv.resolve()}: remove the link, or name another "
            "folder, as in `make VENV=.venv-mine setup`."
        )
    if not python.makes_environments:
        install([f"python{python.version}-venv"], f"Python {python.version} lacks ensurepip")
    print(f"Making {venv.name} with Python {python.version}, {python.path} ...", flush=True)
    _run([python.path, "-m", "venv", "--clear", str(venv)], f"Making {venv.name} failed")


def _pip(venv, *what):
    pip = [str(venv / "bin" / "python"), "-m", "pip", "--disable-pip-version-check"]
    # What runs is compiled then: all of it would take as long again, and 240 MB.
    _run(
        pip + ["install", "-qq", "--no-compile", "-c", "constraints.txt"] + list(what),
        "Installing failed: if pip could not reach its package index, check the network",
    )


def _run(command, failure):
    if subprocess.run(command, cwd=str(ROOT)).returncode != 0:
        leave(f"{failure} (what went wrong stands above), then run make again.")


if __name__ == "__main__":
    main()
