"""The console command as a whole: help, version, exit codes, and what it loads."""

import argparse
import logging
import os
import signal
import subprocess
import sys
from pathlib import Path

import pytest

from workbench import __main__
from workbench.commands import controllers
from workbench.commands.cli import _parser, main
from workbench.commands.remark_sentences import remarks_as_sentences

ROOT = Path(__file__).resolve().parent.parent
COMMANDS = (
    "inspect",
    "check",
    "margins",
    "record",
    "reproduce",
    "step",
    "sweep",
    "fly",
    "params",
    "gains",
    "gui",
)


@pytest.mark.parametrize("command", COMMANDS)
def test_help_has_a_sentence_and_an_example(command, capsys):
    with pytest.raises(SystemExit) as stopped:
        main([command, "--help"])
    assert stopped.value.code == 0
    help_text = capsys.readouterr().out
    assert ".\n" in help_text.split("options:")[0]
    assert f"example:\n  workbench {command}" in help_text


def test_all_commands_but_one_have_json(capsys):
    """As `workbench --help` and docs/index.md say."""
    found = dict(commands_of(_parser(), "workbench"))
    assert len(found) > len(COMMANDS)
    without = {name for name, parser in found.items() if "--json" not in parser.format_help()}
    assert without == {"workbench gui"}
    with pytest.raises(SystemExit):
        main(["--help"])
    assert "All commands but gui print JSON with --json" in capsys.readouterr().out
    index = (ROOT / "docs" / "index.md").read_text(encoding="utf-8")
    assert "All but `gui` also have `--json`" in index


def commands_of(parser, name):
    """Yield the names and parsers of commands that do something by themselves."""
    kinds = [each for each in parser._actions if isinstance(each, argparse._SubParsersAction)]
    if not kinds:
        yield name, parser
    for each in kinds:
        for word, below in each.choices.items():
            yield from commands_of(below, f"{name} {word}")


def test_help_lists_every_command(capsys):
    with pytest.raises(SystemExit):
        main(["--help"])
    listed = capsys.readouterr().out
    assert all(f"\n    {command}" in listed for command in COMMANDS)


def test_numpy_has_one_thread_in_a_command_and_in_the_processes_that_it_starts(monkeypatch):
    monkeypatch.delenv("OPENBLAS_NUM_THREADS", raising=False)
    monkeypatch.setattr(sys, "argv", ["workbench", "--version"])
    monkeypatch.setattr(__main__, "_end_quickly", lambda: None)
    assert __main__.main() == 0
    assert os.environ["OPENBLAS_NUM_THREADS"] == "1"


def test_without_a_command_help_goes_to_stderr(capsys):
    assert main([]) == 2
    out, err = capsys.readouterr()
    assert out == ""
    assert "usage: workbench" in err


@pytest.mark.parametrize(
    ("command", "said"),
    [
        (["flie"], "unknown command 'flie': known are "),
        (["step", "--nonsense"], "--help"),
        (
            ["step", "--axis", "w"],
            "unknown --axis 'w': known are pitch, pitch_rate, roll, roll_rate, x, y, yaw, z",
        ),
    ],
)
def test_what_the_command_line_does_not_have_is_refused_in_a_sentence(command, said, capsys):
    assert main(command) == 2
    out, err = capsys.readouterr()
    assert out == ""
    assert err.startswith("workbench: ")
    assert said in err
    assert err.count("\n") == 1


def test_version(capsys):
    assert main(["--version"]) == 0
    assert capsys.readouterr().out.startswith("workbench ")


def test_progress_that_stands_still_is_said_again_and_a_remark_once(capsys):
    """Processes that wait at a time say it once; a silence would look like a hang."""

    def say(name, at):
        record = logging.LogRecord(name, logging.WARNING, "", 0, "as before", (), None)
        record.created = at
        logging.getLogger(name).handle(record)

    with remarks_as_sentences():
        for at in (100.0, 100.1, 104.0, 108.0):
            say("workbench.progress", at)
    assert capsys.readouterr().err == 3 * "workbench: as before\n"
    with remarks_as_sentences():
        for at in (100.0, 104.0, 108.0):
            say("workbench.plant", at)
    assert capsys.readouterr().err == "workbench: as before\n"


def test_an_interrupt_is_a_sentence_and_130(monkeypatch, capsys):
    def interrupted(args):
        raise KeyboardInterrupt

    monkeypatch.setattr(controllers, "run_params", interrupted)
    assert main(["params"]) == 130
    assert "interrupted" in capsys.readouterr().err


def test_a_reader_who_leaves_early_is_no_error():
    command = f"{sys.executable} -m workbench params | head -1; exit ${{PIPESTATUS[0]}}"
    done = subprocess.run(["bash", "-c", command], cwd=ROOT, capture_output=True, text=True)
    assert done.returncode in (0, 141)
    assert done.stderr == ""


def test_a_closed_stdout_is_no_traceback():
    reader, writer = os.pipe()
    os.close(reader)
    done = subprocess.run(
        [sys.executable, "-m", "workbench", "params"], cwd=ROOT, stdout=writer, stderr=-1, text=True
    )
    os.close(writer)
    assert done.returncode == 141
    assert done.stderr == ""


def test_commands_load_what_they_use_and_no_more(case, tmp_path):
    """Each of these takes a tenth of a second to a second, of commands that take half of one.

    One process runs them all: what none may load is not there after the last.
    """
    slow = {"control", "matplotlib", "numba", "scipy"}
    table = [
        (["inspect", "dh_drone"], slow | {"yaml"}),
        (["linearize"], slow),
        (["step", "--duration", "0.2", "--no-plots"], slow),
    ]
    code = (
        "import sys\nfrom workbench.commands.cli import main\n"
        f"for command in {[command for command, _ in table]}:\n"
        "    print(main(command), *sys.modules, file=sys.stderr)"
    )
    done = subprocess.run(
        [sys.executable, "-c", code],
        cwd=tmp_path,
        env=os.environ | {"PYTHONPATH": str(ROOT)},
        capture_output=True,
        text=True,
    )
    assert done.returncode == 0, done.stderr
    lines = [
        line.split() for line in done.stderr.splitlines() if " workbench.commands.cli " in line
    ]
    for (command, unwanted), (exit_code, *modules) in zip(table, lines, strict=True):
        with case(*command):
            assert exit_code == "0"
            assert not unwanted & set(modules)


def test_an_interrupt_that_a_loading_module_made_its_own_is_still_one(monkeypatch, capsys):
    def run(args):
        try:
            raise KeyboardInterrupt
        except KeyboardInterrupt as error:
            raise ImportError("initialization failed") from error

    monkeypatch.setattr("workbench.commands.controllers.run_params", run)
    assert main(["params"]) == 130
    assert "interrupted" in capsys.readouterr().err


def test_another_import_error_is_not_hidden(monkeypatch):
    def run(args):
        raise ImportError("no such module")

    monkeypatch.setattr("workbench.commands.controllers.run_params", run)
    with pytest.raises(ImportError, match="no such module"):
        main(["params"])


SIGNALLED = """
import os, runpy, signal, sys
number, module = int(sys.argv[1]), sys.argv[2]
class Signal:
    def find_spec(self, name, *_):
        if name == module:
            os.kill(os.getpid(), number)
sys.meta_path.insert(0, Signal())
sys.argv[:] = ["workbench", *sys.argv[3:]]
sys.path.insert(0, os.environ["SOURCES"])
runpy.run_module("workbench", run_name="__main__", alter_sys=True)
"""
"""Runs a command to which a signal comes while it loads a module."""


@pytest.mark.parametrize(
    ("number", "module"),
    [
        (signal.SIGINT, "workbench.commands.cli"),
        (signal.SIGINT, "argparse"),
        (signal.SIGINT, "workbench.commands.judge"),
        (signal.SIGINT, "numpy"),
        (signal.SIGINT, "numpy._core._multiarray_umath"),
        (signal.SIGINT, "pydrake.systems.framework"),
        (signal.SIGINT, "workbench.session.session"),
        (signal.SIGTERM, "numpy"),
        pytest.param(signal.SIGTERM, "workbench.session.session", marks=pytest.mark.slow),
        pytest.param(signal.SIGHUP, "workbench.session.session", marks=pytest.mark.slow),
    ],
)
def test_a_signal_at_any_time_is_a_sentence_and_leaves_nothing(number, module, tmp_path):
    """The last module is loaded when the first flight begins, and files are begun."""
    command = ["judge", "--output", "out"]
    done = subprocess.run(
        [sys.executable, "-c", SIGNALLED, str(int(number)), module, *command],
        cwd=tmp_path,
        env=os.environ | {"SOURCES": str(ROOT)},
        capture_output=True,
        text=True,
    )
    assert done.returncode == 128 + number, done.stderr
    said = "interrupted" if number == signal.SIGINT else "terminated"
    assert done.stderr.splitlines()[-1] == f"workbench: {said}; nothing was written"
    assert "Traceback" not in done.stderr
    assert list(tmp_path.rglob("*")) == []
