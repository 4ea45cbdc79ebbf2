"""What the page on linear models shows runs as it stands."""

import re
import shlex
from pathlib import Path

import pytest

from workbench.commands.cli import main

PAGE = (Path(__file__).parents[2] / "docs" / "linear.md").read_text(encoding="utf-8")


def shown(language: str) -> list[str]:
    return re.findall(rf"```{language}\n(.*?)```", PAGE, re.DOTALL)


COMMANDS = [line for block in shown("bash") for line in block.splitlines()]


@pytest.mark.parametrize("code", shown("python"))
def test_the_python_of_the_page_runs(code, capsys):
    exec(compile(code, "linear.md", "exec"), {"__name__": "__main__"})
    assert capsys.readouterr().out.strip()


@pytest.mark.slow
@pytest.mark.parametrize("command", COMMANDS[:1] + COMMANDS[-2:])
def test_the_commands_of_the_page_run(command, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert main(shlex.split(command)[1:]) == 0
