"""Other simulators, each in an environment of its own that is installed when first asked for.

An environment is a folder in `.bench/`, made with the versions in `others/NAME.txt` and redone when
that file changes. gym-pybullet-drones is on no package index: it is measured where a checkout
of it lies in `.bench/sources/gym-pybullet-drones`.
"""

import json
import os
import subprocess
import sys
import venv
from contextlib import suppress
from pathlib import Path
from typing import Any

HERE = Path(__file__).resolve().parent
KEPT = HERE.parent / ".bench"
CHECKOUTS = {"pybullet_drones": KEPT / "sources" / "gym-pybullet-drones"}
PATIENCE = 1200.0
"""For an installation [s]."""


class NoSimulatorError(Exception):
    """A simulator is not to be had here, in a sentence."""


class OtherSimulator:
    """Another simulator in a process of its own that flies what it is told.

    Args:
        name: of `others/with_NAME.py` and `others/NAME.txt`.
        devices: that it may share its work out to, where it can.

    Raises:
        NoSimulatorError: if it cannot be installed.
    """

    def __init__(self, name: str, devices: int = 1) -> None:
        python = _environment(name)
        self._name = name
        self._log = KEPT / f"{name}.log"
        ours, theirs = os.pipe()
        with self._log.open("w", encoding="utf-8") as log:
            self._process = subprocess.Popen(
                [python, str(HERE / "others" / f"with_{name}.py"), str(theirs)],
                stdin=subprocess.PIPE,
                stdout=log,
                stderr=log,
                text=True,
                pass_fds=[theirs],
                cwd=KEPT,
                env={
                    **os.environ,
                    "OPENBLAS_NUM_THREADS": "1",
                    "OMP_NUM_THREADS": "1",
                    "DEVICES": str(devices),
                },
            )
        os.close(theirs)
        self._answers = os.fdopen(ours, encoding="utf-8")

    def ask(self, task: str, **arguments: float) -> dict[str, Any]:
        """Return what it answers to a task.

        Raises:
            NoSimulatorError: if it ends instead.
        """
        assert self._process.stdin
        try:
            self._process.stdin.write(json.dumps({"task": task, **arguments}) + "\n")
            self._process.stdin.flush()
            line = self._answers.readline()
        except BrokenPipeError:
            line = ""
        if not line:
            raise NoSimulatorError(f"it ended by itself: {_last_line(self._log)}")
        answer: dict[str, Any] = json.loads(line)
        return answer

    def __enter__(self) -> "OtherSimulator":
        return self

    def __exit__(self, *_: object) -> None:
        """Let it end."""
        assert self._process.stdin
        with suppress(BrokenPipeError):  # it has ended already
            self._process.stdin.close()
        self._process.wait()
        self._answers.close()


def version(name: str, package: str) -> str:
    """Return the pinned version of a package in an environment."""
    for line in (HERE / "others" / f"{name}.txt").read_text(encoding="utf-8").splitlines():
        if line.lower().startswith(f"{package.lower()}=="):
            return line.partition("==")[2]
    raise KeyError(package)


def _environment(name: str) -> str:
    """Return the Python of an environment, installed where it is not there as pinned."""
    pins = HERE / "others" / f"{name}.txt"
    folder, checkout = KEPT / name, CHECKOUTS.get(name)
    stamp = folder / "installed.txt"
    python = str(folder / "bin" / "python")
    if checkout and not checkout.is_dir():
        raise NoSimulatorError(
            f"not compared: it is on no package index; put a checkout into "
            f"{checkout.relative_to(HERE.parent)} and run this again"
        )
    wanted = f"{sys.version}\n{pins.read_text(encoding='utf-8')}"
    if stamp.is_file() and stamp.read_text(encoding="utf-8") == wanted:
        return python
    print(f"  installing {name} into .bench/, once", file=sys.stderr, flush=True)
    KEPT.mkdir(exist_ok=True)
    venv.create(folder, with_pip=True, clear=True)
    _pip(name, python, "-r", str(pins))
    if checkout:
        _pip(name, python, "--no-deps", "--no-build-isolation", str(checkout))
    stamp.write_text(wanted, encoding="utf-8")
    return python


def _pip(name: str, python: str, *words: str) -> None:
    """Install, or say in a sentence why not."""
    log = KEPT / f"{name}.log"
    command = [python, "-m", "pip", "--disable-pip-version-check", "install", "-q", *words]
    try:
        with log.open("w", encoding="utf-8") as output:
            subprocess.run(
                command, check=True, timeout=PATIENCE, stdout=output, stderr=output, text=True
            )
    except (subprocess.CalledProcessError, subprocess.TimeoutExpired) as error:
        raise NoSimulatorError(f"could not be installed, see .bench/{log.name}") from error


def _last_line(log: Path) -> str:
    lines = log.read_text(encoding="utf-8", errors="replace").split("\n")
    return next((line.strip() for line in reversed(lines) if line.strip()), "it said nothing")
