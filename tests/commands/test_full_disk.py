"""A full device, for files and standard output: exit code 2, a sentence, nothing half-written."""

import os
import re
import resource
import subprocess
import sys
from contextlib import contextmanager
from importlib.util import find_spec
from pathlib import Path

import pytest

from workbench.commands.cli import main

NEW = "--mass 1kg --diagonal 450mm --propeller 10x4.5 --max-thrust 850g"
QUAD = f"--model {Path(__file__).parents[1] / 'drones' / 'crazyflie.urdf'}"
"""No xacro file, for which a process is started through a file."""
WITH_GATEWAYS = pytest.mark.skipif(
    find_spec("workbench.extras") is None, reason="the gateways are an extra"
)
WRITERS = (
    f"new quad {NEW}",
    f"inspect {QUAD.removeprefix('--model ')} --write there",
    "tokens new.tokens",
    f"gains save new.yaml --set kp_roll=200 {QUAD}",
    "export flight.mcap --output there",
    f"pin new.workbench.yaml --axis z --duration 0.5 --no-margins {QUAD}",
    f"step --axis z --duration 0.2 {QUAD}",
    f"fly hover --duration 0.1 --no-plots {QUAD}",
    f"fly hover --duration 0.1 --log flown.mcap --no-plots {QUAD}",
    f"fly hover --duration 0.1 --html flown.html --no-plots {QUAD}",
    f"sweep kp_roll=100..110:2 --duration 0.1 --no-plots {QUAD}",
    "plot flight.mcap exact_state.p_wb.0",
    pytest.param("gateway ros2 --write-messages there", marks=WITH_GATEWAYS),
)
"""Commands that write files."""
PRINTERS = (
    "--help",
    "fly --help",
    "--version",
    "params",
    "inspect dh_drone",
    "inspect dh_drone --json",
    "fly --list",
    "controllers",
    "step --axis z --duration 0.2 --no-plots --json",
    pytest.param("hover --no-plots", marks=pytest.mark.slow),
    "gains show",
    "linearize",
    "frames --model dh_drone",
)
FULL = "workbench: standard output cannot be written: No space left on device: redirect it"
FEW_BYTES = 20


@pytest.fixture
def unheld():
    """Logs are read in a held process here: it has a limit of its own for the size of files."""


@contextmanager
def files_of_at_most(size):
    """Let writing more to a file fail, as on a full device.

    Python itself would leave the beginning of a compiled module, which no later process can load.
    """
    before = resource.getrlimit(resource.RLIMIT_FSIZE)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(sys, "dont_write_bytecode", True)
        patch.setenv("PYTHONDONTWRITEBYTECODE", "1")
        resource.setrlimit(resource.RLIMIT_FSIZE, (size, before[1]))
        try:
            yield
        finally:
            resource.setrlimit(resource.RLIMIT_FSIZE, before)


@pytest.mark.parametrize("command", WRITERS)
def test_a_full_device(command, run, tmp_path, monkeypatch, log, pictures_here):
    monkeypatch.chdir(tmp_path)
    Path("flight.mcap").symlink_to(log)
    before = sorted(tmp_path.iterdir())
    with files_of_at_most(FEW_BYTES):
        said = run(*command.split())
    assert said.code == 2, said
    last = said.err.splitlines()[-1]
    assert "cannot be written: File too large" in last
    assert not re.search(r"(^|[/ ])\.\w", last)  # it names the target, and no temporary file
    assert sorted(tmp_path.iterdir()) == before


@pytest.mark.parametrize("command", PRINTERS)
def test_a_full_standard_output(command, monkeypatch, capsys, tmp_path):
    monkeypatch.chdir(tmp_path)
    with Path("/dev/full").open("w") as full:
        monkeypatch.setattr(sys, "stdout", full)
        assert main(command.split()) == 2
    assert capsys.readouterr().err.splitlines()[-1].startswith(FULL)


def shell(line):
    """Run a line of a shell with `workbench`, and return its exit code, output and errors."""
    done = subprocess.run(
        ["bash", "-c", f'workbench() {{ "{sys.executable}" -m workbench "$@"; }}; {line}'],
        capture_output=True,
        text=True,
        env=os.environ,
    )
    return done.returncode, done.stdout, done.stderr


def test_closed_streams(case):
    closed = "workbench: standard output cannot be written: it is closed: redirect it"
    for line, code, out, err in (
        ("workbench controllers >&-", 2, "", closed),
        ("workbench --version 2>&-", 0, "workbench ", ""),
        ("workbench nothing 2>&-", 2, "", ""),
        ("workbench --version 2> /dev/full", 0, "workbench ", ""),
        ("workbench new quad --mass 1kg <&-", 2, "", "workbench: --diagonal is missing"),
        ("PYTHONUNBUFFERED=1 workbench --version > /dev/full", 2, "", FULL),
    ):
        with case(line):
            found = shell(line)
            assert found[0] == code
            assert found[1].startswith(out)
            assert found[2].startswith(err)
            assert len(found[2].splitlines()) == bool(err)


def test_a_closed_reader_is_no_failure():
    """As of `workbench params | head -1`."""
    reader, writer = os.pipe()
    os.close(reader)
    words = [sys.executable, "-m", "workbench", "--version"]
    done = subprocess.run(words, stdout=writer, stderr=subprocess.PIPE)
    os.close(writer)
    assert (done.returncode, done.stderr) == (141, b"")
