"""Tab in a shell: what is offered at the cursor, by the shell itself."""

import itertools
import os
import pty
import re
import select
import subprocess
import sys
import time
from pathlib import Path

import argcomplete
import pytest

from workbench.commands.cli import COMMANDS, _parser
from workbench.commands.completion import _NAMES, SHELLS, _actions_below, add_names

DEADLINE = 300.0
"""Of a shell on a busy machine [s]; nothing waits so long that goes well."""
LINES = {
    "rep": ["replay", "reproduce"],
    "fly take": ["take-off-and-land"],
    "fly --world r": ["room"],
    "fly --controller p": ["pd", "pid", "px4"],
    "fly --estimator c": ["complementary"],
    "gui --estimator ": ["complementary", "ekf", "truth"],
    "controllers g": ["geometric"],
    "compare pd pi": ["pid"],
    "hover --model ": ["dh_drone"],
    "hover --model my_dr": [],
    "step --axis y": ["y", "yaw"],
    "step --set kp_pi": ["kp_pitch="],
    "step --set kp_pitch=3 --axis z --no-p": ["--no-plots"],
    "sweep kp_roll=1..2:3 kd_ro": ["kd_roll="],
    "sweep vary.ma": ["vary.mass="],
    "fly hover --sensors imu,gp": ["imu,gps"],
    "regress steps mar": ["margins"],
    "gains di": ["diff"],
    "gains diff rul": ["rule"],
    "gains show --mod": ["--model"],
    "gateway ro": ["ros2"],
    "completion ": ["bash", "fish", "zsh"],
    "nonsense --a": [],
}


@pytest.fixture
def path(tmp_path):
    """Return a PATH on which `workbench` is this one."""
    program = tmp_path / "bin" / "workbench"
    program.parent.mkdir()
    root = Path(__file__).resolve().parents[2]
    program.write_text(
        f'#!/bin/sh\nPYTHONPATH="{root}:$PYTHONPATH" exec "{sys.executable}" -m workbench "$@"\n'
    )
    program.chmod(0o755)
    return f"{program.parent}{os.pathsep}{os.environ['PATH']}"


def offered(line):
    """Return what stands at the cursor at the end of a command line."""
    parser = _parser(*line.split(" ")[:-1][:1])
    add_names(parser)
    finder = argcomplete.CompletionFinder(parser, always_complete_options=False)
    numbers = itertools.count()
    whole = iter(lambda: finder.rl_complete(line, next(numbers)), None)
    return sorted(each[line.rfind(" ") + 1 :].rstrip() for each in whole)


def test_what_may_stand_at_the_cursor(monkeypatch, tmp_path, case):
    monkeypatch.chdir(tmp_path)
    for line, names in LINES.items():
        with case(line):
            assert offered(line) == names
    assert set(COMMANDS) <= set(offered(""))
    assert {"--model", "--set", "--json", "--help"} <= set(offered("step --"))


def test_every_argument_with_names_is_there():
    assert set(_NAMES) <= {action.dest for action in _actions_below(_parser())}


def test_each_shell_has_a_script(run):
    for shell in SHELLS:
        assert "_ARGCOMPLETE" in run("completion", shell).out


def test_a_shell_completes_at_its_prompt(path, tmp_path):
    """A real shell on a terminal: Tab after a word that is begun, then Enter."""
    master, terminal = pty.openpty()
    (tmp_path / "my_drone.urdf").touch()
    process = subprocess.Popen(
        ["bash", "--norc", "--noprofile", "-i"],
        cwd=tmp_path,
        stdin=terminal,
        stdout=terminal,
        stderr=terminal,
        env={"PATH": path, "PS1": "ready> ", "TERM": "dumb", "HOME": str(tmp_path)},
        start_new_session=True,
    )
    os.close(terminal)
    try:
        answer(master, "", "ready> ")
        answer(master, "source <(workbench completion bash)\n", "ready> ")
        for typed, completed in (
            ("workbench repr\t", "workbench reproduce "),
            ("workbench fly take\t", "workbench fly take-off-and-land "),
            ("workbench step --set kp_pi\t7", "workbench step --set kp_pitch=7"),
            ("workbench inspect my_d\t", "workbench inspect my_drone.urdf "),
            ("workbench controllers \t\t", "betaflight"),
        ):
            answer(master, typed, completed)
            answer(master, "\x15\n", "ready> ")  # Ctrl+U: away with the line
    finally:
        process.kill()
        process.wait()
        os.close(master)


def answer(master, typed, expected):
    """Type, and wait until a terminal shows what is expected."""
    os.write(master, typed.encode())
    shown, end = "", time.monotonic() + DEADLINE
    while expected not in shown:
        assert time.monotonic() < end, shown
        if select.select([master], [], [], 1.0)[0]:
            shown += re.sub(r"\x1b\[[?0-9;]*[a-zA-Z]|\x07", "", os.read(master, 65536).decode())
    return shown
