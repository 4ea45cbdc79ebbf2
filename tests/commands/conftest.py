"""Commands are run through the real `main`."""

import contextlib
import importlib
import io
import json
from dataclasses import dataclass
from pathlib import Path

import pytest

from workbench.commands import drawer, progress
from workbench.commands.cli import main
from workbench.design.plots import write_png
from workbench.logs.flight_log import FlightLog
from workbench.scenario.scenario import Action, Scenario
from workbench.session.session import Session
from workbench.systems.bridge import Bridge


@dataclass(frozen=True)
class Said:
    """What a command returned and printed."""

    code: int
    out: str
    err: str

    @property
    def json(self):
        return json.loads(self.out, parse_constant=_refuse)


STARTING = {f"workbench: {what}" for what in ("loading Drake", "building the diagram")}
"""What a flight says while it starts."""


def _refuse(name):
    raise AssertionError(f"{name} is no JSON")


def _run(*command) -> Said:
    out, err = io.StringIO(), io.StringIO()
    with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
        code = main([str(part) for part in command])
    return Said(code, out.getvalue(), err.getvalue())


@pytest.fixture(autouse=True)
def _files_here(unheld, unconfined_xacro):
    """Commands read logs and xacro files in this process."""


@pytest.fixture(autouse=True)
def _no_progress(monkeypatch):
    """A slow machine says how far it is: here only where a test asks for it."""
    monkeypatch.setattr(progress, "FIRST_DELAY_S", 3600.0)


@pytest.fixture(scope="session")
def run():
    return _run


@pytest.fixture
def refused(run):
    """Run a command that must be refused, and return its sentence."""

    def refuse(*command) -> str:
        said = run(*command)
        assert said.code == 2, said.err
        assert said.out == ""
        # what takes longer than 2 s says so, on a slow machine
        lines = [line for line in said.err.splitlines() if line not in STARTING]
        assert len(lines) == 1, said.err
        assert lines[0].startswith("workbench: ")
        return f"{lines[0]}\n"

    return refuse


@pytest.fixture
def write(tmp_path):
    """Write a file for a command to read, and return its path."""

    def write_file(name: str, text: str) -> Path:
        path = tmp_path / name
        path.write_text(text, encoding="utf-8")
        return path

    return write_file


@pytest.fixture
def out(tmp_path):
    """Return a folder that is not there yet; what a refused command leaves would show in it."""
    return tmp_path / "out" / "deep"


class _DrawerHere:
    """A `Drawer` without a process of its own, which would load matplotlib for every command."""

    def __init__(self, *modules: str) -> None:
        """Load nothing: it is there."""

    def begin(self, to: Path, module: str, function: str, *args, **options) -> None:
        write_png(getattr(importlib.import_module(module), function)(*args, **options), to)

    def finish(self) -> None:
        """Wait for nothing: all is written."""

    def __enter__(self):
        return self

    def __exit__(self, *_) -> None:
        """End nothing."""


@pytest.fixture
def pictures_here(monkeypatch):
    """Draw in this process; tests/commands/test_drawer.py has the process that commands start."""
    monkeypatch.setattr(drawer, "Drawer", _DrawerHere)


@pytest.fixture(scope="session")
def logged():
    """Fly a scenario with a log at a path, and return the path."""

    def fly(scenario: Scenario, path: Path) -> Path:
        session = Session(scenario, bridge=Bridge())
        session.run()
        log = FlightLog(path, session.topics, scenario, {}, {}, session.vehicle.name)
        for sampled in session.drain():
            log.write(sampled)
        log.close()
        return path

    return fly


@pytest.fixture(scope="module")
def log(logged, tmp_path_factory) -> Path:
    """The log of a short flight along x."""
    scenario = Scenario(duration=0.3, script=[Action(0.1, velocity=[1.0, 0.0, 0.0])])
    return logged(scenario, tmp_path_factory.mktemp("logs") / "flight.mcap")
