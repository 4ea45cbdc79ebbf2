"""A test that hangs ends the run, which names it and shows what all threads wait for."""

import os
import subprocess
import sys
from pathlib import Path

CONFTEST = (Path(__file__).parent / "conftest.py").read_text(encoding="utf-8")
LIMITS = "LIMIT, SLOW_LIMIT = 600.0, 1200.0"
HANGING = """
import threading

import pytest


@pytest.fixture
def lazy():
    yield
    threading.Event().wait()


def test_the_tear_down_after_a_failure_hangs(lazy):
    assert False
"""


def test_a_hang_after_a_failure_ends_the_run_and_is_named(tmp_path):
    assert LIMITS in CONFTEST
    short = CONFTEST.replace(LIMITS, "LIMIT, SLOW_LIMIT = 1.0, 1.0")
    (tmp_path / "conftest.py").write_text(short, encoding="utf-8")
    (tmp_path / "test_it.py").write_text(HANGING, encoding="utf-8")
    plugins = ("--disable-plugin-autoload", "-p", "xdist", "-p", "xdist.looponfail")
    workers = ("-n", "1", "--dist", "loadfile", "--max-worker-restart", "0")
    done = subprocess.run(
        [
            *(sys.executable, "-m", "pytest", "-p", "no:cacheprovider"),
            *(*plugins, *workers, str(tmp_path)),
        ],
        cwd=tmp_path,
        capture_output=True,
        text=True,
    )
    assert done.returncode == 1
    assert 'test_it.py", line 10 in lazy' in done.stderr
    assert (
        "crashed while running 'test_it.py::test_the_tear_down_after_a_failure_hangs" in done.stdout
    )


def test_only_make_test_all_runs_slow_tests():
    root = Path(__file__).parent.parent
    quick, slow = '-m "not slow"', "-m slow --durations 30"
    outer = {
        "MAKEFLAGS",
        "MAKELEVEL",
        "MAKEOVERRIDES",
        "VENV",
        "PYTHON",
        "PYTEST_OPTIONS",
    }  # of the make that runs this
    env = {name: value for name, value in os.environ.items() if name not in outer}
    for target, runs in (("test", [quick]), ("test-slow", [slow]), ("test-all", [quick, slow])):
        done = subprocess.run(
            ["make", "--dry-run", target],
            cwd=root,
            env=env,
            capture_output=True,
            text=True,
            check=True,
        )
        assert (".venv/bin/pyrefly check" in done.stdout) == (target != "test-slow")
        lines = [line for line in done.stdout.splitlines() if "bin/pytest" in line]
        lines = [line for line in lines if "--collect-only" not in line]
        assert [line.partition("--max-worker-restart 0 ")[2].strip() for line in lines] == runs, (
            target
        )
