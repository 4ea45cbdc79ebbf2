"""CI passes only if every test ran and passed; otherwise its last line says why."""

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parent.parent
ALLOWED = ROOT / ".ci" / "allowed_skips.txt"
TESTS = """
import pytest

def test_that_skips():
    pytest.skip({reason!r})

def test_that_passes():
    pass
"""
ABSENT = "install graphviz"
PRIVATE = "put the real flights into ../shared/flights"


def test_a_skip_fails_a_run_unless_its_reason_is_allowed(tmp_path, case):
    (tmp_path / "conftest.py").write_text((ROOT / "tests" / "conftest.py").read_text())
    late = ("--until=0", f"--allowed-skips={ALLOWED}")
    for reason, options, code, last in (
        (ABSENT, (), 0, "1 passed, 1 skipped"),
        (ABSENT, (f"--allowed-skips={ALLOWED}",), 1, f"NOT RUN [1] test_it.py:5: {ABSENT}"),
        (PRIVATE, (f"--allowed-skips={ALLOWED}",), 0, "1 passed, 1 skipped"),
        (PRIVATE, late, 1, "NOT RUN [2] conftest.py"),
    ):
        with case(reason, *options):
            (tmp_path / "test_it.py").write_text(TESTS.format(reason=reason))
            done = subprocess.run(
                [sys.executable, "-m", "pytest", "-p", "no:cacheprovider", "-n", "1", *options],
                cwd=tmp_path,
                capture_output=True,
                text=True,
            )
            assert done.returncode == code, done.stdout
            assert last in done.stdout


FAILS = "echo 'FAILED tests/test_it.py::test_it - assert 1 == 2'; echo 'make: *** Error'; exit 2"
SKIPS = "echo 'NOT RUN [1] test_graph.py:64: install graphviz'; exit 2"


@pytest.mark.parametrize(
    ("program", "word", "script", "last"),
    [
        ("make", "test-slow", FAILS, " of the slow ones by SEED=7: FAILED tests/"),
        ("make", "test", FAILS, "CI FAILED: lint, types and quick tests with Python 3.13, in the "),
        ("make", "quick", FAILS, "CI FAILED: quick tests of plants, systems, diagrams, laws, "),
        ("make", "test-slow", SKIPS, " of the slow ones by SEED=7: NOT RUN [1] tes"),
        ("make", "docs", "echo 'no such page'; exit 2", "CI FAILED: the site of the documentation"),
        ("python3", "3.11", "exit 1", "CI FAILED: Python 3.11: there is no Python 3.11 on PATH"),
        ("python3", "tools/test_programs.py", "echo 'dot is missing'; exit 2", "CI FAILED: the pr"),
        ("pip", "-e", "echo 'it does not compile'; exit 1", "CI FAILED: the real Betaflight: it d"),
        ("true", "", "", "CI: every quick test and half "),
    ],
)
def test_ci_ends_with_the_reason(tmp_path, program, word, script, last):
    """The script itself, with stand-ins for the programs that it starts."""
    (tmp_path / ".ci").mkdir()
    run = shutil.copy(ROOT / ".ci" / "run", tmp_path / ".ci")
    folder = tmp_path / ".venv-3.13" / "bin"
    folder.mkdir(parents=True)
    for each in ("make", "python3", "pip"):
        failing = f'case " $* " in *" {word} "*) {script};; esac\n' if each == program else ""
        (folder / each).write_text(f"#!/bin/sh\n{failing}exit 0\n")
        (folder / each).chmod(0o755)
    env = os.environ | {"PATH": f"{folder}{os.pathsep}{os.environ['PATH']}", "SEED": "7"}
    done = subprocess.run([run], env=env, capture_output=True, text=True)
    assert done.returncode == (0 if program == "true" else 1), done.stdout
    assert last in done.stdout.splitlines()[-1]
