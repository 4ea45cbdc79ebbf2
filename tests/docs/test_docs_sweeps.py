"""What docs/sweeps.md and the gain files of docs/files.md show runs as it stands."""

import re
import shlex
from pathlib import Path

import pytest

from workbench.commands.cli import main
from workbench.gains.gains import load_gains

DOCS = Path(__file__).parents[2] / "docs"
SWEEPS = (DOCS / "sweeps.md").read_text(encoding="utf-8")
GAINS = re.search(r"## Gain file\n(.*?)\n## ", (DOCS / "files.md").read_text(), re.DOTALL)[1]


def commands(text: str) -> list[str]:
    lines = "\n".join(re.findall(r"```sh\n(.*?)```", text, re.DOTALL)).splitlines()
    return [line.split("#")[0].strip() for line in lines if line.startswith("workbench ")]


def run_python(text: str) -> None:
    code = "\n".join(
        re.findall(r"```python\n(.*?)```", text, re.DOTALL)
    )  # one goes on from another
    exec(compile(code, "page.md", "exec"), {"__name__": "__main__"})


@pytest.mark.slow
@pytest.mark.parametrize("command", commands(SWEEPS))
def test_the_sweeps_of_the_page_run(command, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    assert main(shlex.split(command)[1:]) == 0
    said = "no best is chosen" if " vary." in command else "full diagram"
    assert said in capsys.readouterr().out
    assert {path.suffix for path in tmp_path.rglob("*") if path.is_file()} == {".csv", ".png"}


@pytest.mark.slow
def test_the_python_of_the_sweeps_page_runs(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    run_python(SWEEPS)
    assert {path.name for path in tmp_path.iterdir()} == {"climb.csv", "climb.png"}
    out = capsys.readouterr().out
    assert out.strip()
    assert "nan" not in out


def test_the_gain_files_of_the_page_are_saved_and_restored(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    for command in commands(GAINS):
        assert main(shlex.split(command)[1:]) == 0, command
    run_python(GAINS)
    assert capsys.readouterr().out.splitlines()[-1] == "4 softer climb 3.0"
    assert load_gains(tmp_path / "my_gains.yaml").gains["kp_velocity_z"] == 2.5
