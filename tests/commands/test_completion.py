"""Tab in a shell: what is offered at the cursor, by the shell itself."""

import argparse
import os
import pty
import re
import select
import shutil
import subprocess
import sys
import time
from pathlib import Path

import pytest

from workbench.commands.cli import _parser
from workbench.commands.completion import _NAMES, offered

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


def commands():
    (found,) = (a for a in _parser()._actions if isinstance(a, argparse._SubParsersAction))
    return found


def actions_below(parser):
    for action in parser._actions:
        yield action
        if isinstance(action, argparse._SubParsersAction):
            for below in action.choices.values():
                yield from actions_below(below)


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


def test_what_may_stand_at_the_cursor():
    whole = commands()
    assert {line: offered(whole, line.split(" ")) for line in LINES} == LINES
    assert set(offered(whole, [""])) == set(whole.choices)
    assert {"--model", "--set", "--json", "--help"} <= set(offered(whole, ["step", "--"]))


def test_a_shell_asks_for_it_with_the_command_alone(run, case):
    """As the scripts do, with an empty last word where nothing is begun yet."""
    for line in ("rep", "fly --world r", "hover --model ", "gateway ro", "completion ", "nope --a"):
        with case(line):
            asked = run("completion", "words", *line.split(" "))
            assert asked.code == 0
            assert asked.out.split() == offered(commands(), line.split(" "))
    assert set(run("completion", "words", "").out.split()) == set(commands().choices)


def test_every_argument_with_names_is_there():
    assert set(_NAMES) <= {action.dest for action in actions_below(_parser())}


@pytest.mark.parametrize("shell", ["bash", "zsh", "fish"])
def test_a_shell_takes_its_script(run, shell, tmp_path):
    if shutil.which(shell) is None:
        pytest.skip(f"needs {shell}: apt-get install {shell}")
    script = tmp_path / "script"
    script.write_text(run("completion", shell).out)
    done = subprocess.run([shell, "-n", script], capture_output=True, text=True)
    assert (done.returncode, done.stderr) == (0, "")


PROMPTS = {
    "bash": (["bash", "--norc", "--noprofile", "-i"], "true"),
    "zsh": (["zsh", "-f", "-i"], "autoload -Uz compinit && compinit -u"),
}
"""How a shell begins without files of the user's, and what its completion needs first."""


@pytest.mark.parametrize("shell", PROMPTS)
def test_a_shell_completes_at_its_prompt(shell, path, tmp_path):
    """A real shell on a terminal: Tab after a word that is begun, then Enter."""
    if shutil.which(shell) is None:
        pytest.skip(f"needs {shell}: apt-get install {shell}")
    command, first = PROMPTS[shell]
    master, terminal = pty.openpty()
    (tmp_path / "my_drone.urdf").touch()
    process = subprocess.Popen(
        command,
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
        answer(master, f"{first}\n", "ready> ")
        answer(master, f"source <(workbench completion {shell})\n", "ready> ")
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
