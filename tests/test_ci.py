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
ABSENT = "install chromium"
PRIVATE = "put the real flights into ../shared/flights"


PYTEST = (sys.executable, "-m", "pytest", "-p", "no:cacheprovider")
PYTEST += ("--disable-plugin-autoload", "-p", "xdist", "-p", "xdist.looponfail")
"""Without plugins of other packages, which each worker would load again."""


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
                [*PYTEST, "-n", "1", *options],
                cwd=tmp_path,
                capture_output=True,
                text=True,
            )
            assert done.returncode == code, done.stdout
            assert last in done.stdout


FAILS = "echo 'FAILED tests/test_it.py::test_it - assert 1 == 2'; echo 'make: *** Error'; exit 2"
SKIPS = "echo 'NOT RUN [1] test_page.py:64: install chromium'; exit 2"


@pytest.mark.parametrize(
    ("program", "word", "script", "last"),
    [
        ("make", "test-slow", FAILS, "CI FAILED: the slow tests with Python 3.13: FAILED tests/"),
        ("make", "test", FAILS, "CI FAILED: lint, types and quick tests with Python 3.13, in the "),
        ("make", "quick", FAILS, "CI FAILED: quick tests of plants, systems, diagrams, laws, "),
        ("make", "test-slow", SKIPS, "CI FAILED: the slow tests with Python 3.13: NOT RUN [1] tes"),
        ("make", "docs", "echo 'no such page'; exit 2", "CI FAILED: the site of the documentation"),
        ("python3", "3.11", "exit 1", "CI FAILED: Python 3.11: there is no Python 3.11 on PATH"),
        ("python3", "tools/test_programs.py", "echo 'gcc is missing'; exit 2", "CI FAILED: the pr"),
        ("pip", "-e", "echo 'it does not compile'; exit 1", "CI FAILED: the real Betaflight: it d"),
        ("true", "", "", "CI: every test has run and passed"),
    ],
)
def test_ci_ends_with_the_reason(tmp_path, program, word, script, last):
    failing = {program: f'case " $* " in *" {word} "*) {script};; esac\n'}
    done, _ = run_ci(tmp_path, failing)
    assert done.returncode == (0 if program == "true" else 1), done.stdout
    assert last in done.stdout.splitlines()[-1]


def test_a_part_uses_its_python_only(tmp_path, case):
    for part, last in (
        ("3.11", "CI: what belongs to Python 3.11 has run and passed"),
        ("3.12 3.13", "CI: what belongs to Python 3.12, 3.13 has run and passed"),
    ):
        with case(part):
            done, made = run_ci(tmp_path / part, {}, *part.split())
            assert done.returncode == 0, done.stdout
            assert done.stdout.splitlines()[-1] == last
            assert {line.rpartition("VENV=.venv-")[2].split()[0] for line in made} == set(
                part.split()
            )
            assert made[0].split()[0] in ("test", "test-setup")  # they install what tests need
    done, made = run_ci(tmp_path / "none", {}, "3.9")
    assert (done.returncode, made) == (2, [])
    assert "name some of 3.11 3.12 3.13" in done.stderr


def run_ci(folder, failing, *parts):
    """Run the script itself, with stand-ins for the programs that it starts.

    Returns what it did, and the arguments of each `make`.
    """
    (folder / ".ci").mkdir(parents=True)
    run = shutil.copy(ROOT / ".ci" / "run", folder / ".ci")
    programs = folder / ".venv-3.13" / "bin"
    programs.mkdir(parents=True)
    made = folder / "made"
    made.touch()
    for each in ("make", "python3", "pip"):
        note = f'echo "$*" >> "{made}"\n' if each == "make" else ""
        (programs / each).write_text(f"#!/bin/sh\n{note}{failing.get(each, '')}exit 0\n")
        (programs / each).chmod(0o755)
    env = os.environ | {"PATH": f"{programs}{os.pathsep}{os.environ['PATH']}", "SEED": "7"}
    done = subprocess.run([run, *parts], env=env, capture_output=True, text=True)
    return done, made.read_text().splitlines()
