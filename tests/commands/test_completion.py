"""Tab in a shell: argcomplete's hook asks by the environment, and reads the answer from a file."""

import os
import subprocess
import sys
from pathlib import Path

from workbench import __main__

MARK = "PYTHON_ARGCOMPLETE_OK"


def test_a_shell_is_told_what_may_stand_at_its_cursor(tmp_path, case):
    answer = tmp_path / "answer"
    for line, offered in (
        ("workbench rep", {"replay", "reproduce"}),
        ("workbench step --axis y", {"y", "yaw"}),
        ("workbench step --no-p", {"--no-plots"}),
        ("workbench gains di", {"diff"}),
        ("workbench gains sa", {"save"}),
    ):
        with case(line):
            asked = {
                "_ARGCOMPLETE": "1",
                "_ARGCOMPLETE_IFS": "\n",
                "_ARGCOMPLETE_STDOUT_FILENAME": str(answer),
                "COMP_LINE": line,
                "COMP_POINT": str(len(line)),
            }
            command = [sys.executable, "-m", "workbench"]
            subprocess.run(command, env=os.environ | asked, check=True, timeout=300.0)
            assert {each.strip() for each in answer.read_text().splitlines()} == offered


def test_argcomplete_knows_the_command_by_its_mark():
    assert MARK in Path(__main__.__file__).read_text(encoding="utf-8")[:1024]
