"""The README's Python example and its commands work as printed."""

import re
import shlex
from pathlib import Path

import pytest

from workbench.cli import main

README = Path(__file__).parent.parent / "README.md"


def _blocks(language: str) -> list[str]:
    return re.findall(rf"```{language}\n(.*?)```", README.read_text(encoding="utf-8"), re.DOTALL)


@pytest.mark.parametrize("code", _blocks("python"))
def test_python_example_runs(code, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    exec(compile(code, str(README), "exec"), {"__name__": "__main__"})
    assert capsys.readouterr().out.strip()


def _commands() -> list[str]:
    lines = "\n".join(_blocks("sh")).splitlines()
    return [line.split("#")[0].strip() for line in lines if line.startswith("workbench ")]


@pytest.mark.parametrize("command", _commands())
def test_command_line_runs(command, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    assert main(shlex.split(command)[1:]) == 0
    assert capsys.readouterr().out.strip()
