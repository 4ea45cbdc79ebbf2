"""What docs/regression.md shows is run as it stands."""

import re
import shlex
from importlib.metadata import entry_points
from pathlib import Path

import pytest
import yaml

import workbench.design.regress.running  # noqa: F401  Drake cannot be loaded again by a run inside
from tests.docs.test_docs_logs_of_real_flights import write_page_log
from workbench.commands.cli import main

pytest_plugins = ["pytester"]

PAGE = Path(__file__).parents[2] / "docs" / "regression.md"


def shown(language: str, first_line: str = "") -> str:
    pattern = rf"```{language}\n({re.escape(first_line)}.*?)```"
    found = re.search(pattern, PAGE.read_text(encoding="utf-8"), re.DOTALL)
    assert found
    return found[1]


def commands() -> list[str]:
    text = "\n".join(re.findall(r"```sh\n(.*?)```", PAGE.read_text(encoding="utf-8"), re.DOTALL))
    return [line.split("#")[0].strip() for line in text.splitlines() if line]


@pytest.fixture
def specs(tmp_path, monkeypatch):
    """Return a folder with the page's spec, where its commands are run."""
    monkeypatch.chdir(tmp_path)
    path = tmp_path / "specs" / "ours.spec.yaml"
    path.parent.mkdir()
    path.write_text(shown("yaml", "# spec"), encoding="utf-8")
    return path.parent


@pytest.mark.slow
def test_the_spec_is_recorded_and_holds(specs, capsys):
    assert main(["regress", "specs/", "--update", "-j", "1"]) == 0, capsys.readouterr().out
    assert {path.name for path in (specs / "ours.baseline").iterdir()} == {
        "flown-with.csv",
        "x-ahead.csv",
    }
    assert main(["regress", "specs/", "-j", "1"]) == 0
    for line in commands():
        words = shlex.split(line)[1:]
        if "specs/" in words and "--update" not in words:
            expected = 1 if "--set" in words else 0
            assert main([*words, "-j", "1"]) in (0, expected), line
            assert capsys.readouterr().out.strip()
    assert Path("out/regress.html").is_file() and Path("out/regress.xml").is_file()


def test_the_commands_are_understood():
    from workbench.commands.cli import _parser

    for line in commands():
        assert _parser().parse_args(shlex.split(line)[1:]).command in ("regress", "pin")


def test_the_spec_of_a_log_holds(tmp_path, monkeypatch, capsys):
    """The log is that of docs/logs-of-real-flights.md; it has one motor alone."""
    monkeypatch.chdir(tmp_path)
    write_page_log(tmp_path)
    Path("logged.spec.yaml").write_text(shown("yaml", "# of a log"), encoding="utf-8")
    lines = [line for line in commands() if "logged" in line or "monday" in line]
    assert len(lines) == 3
    for line in lines:
        assert main(shlex.split(line)[1:]) == 0, line
    said = capsys.readouterr().out
    assert "roll doublets of Monday: skipped: saturation: " in said
    assert "pinned to the present values: " in said


def test_the_python_runs(capsys):
    code = shown("python", "# python")
    exec(compile(code, str(PAGE), "exec"), {"__name__": "__main__"})
    assert capsys.readouterr().out.strip()


def test_the_hand_written_test_passes_under_the_pages_ini(pytester):
    pytester.makefile(".ini", pytest=shown("ini"))
    pytester.makepyfile(test_flights=shown("python", "# test_flights.py"))
    installed = any(point.name == "workbench" for point in entry_points(group="pytest11"))
    options = () if installed else ("-p", "workbench.pytest_plugin")
    done = pytester.runpytest_inprocess(*options)
    done.assert_outcomes(passed=1)


def test_the_workflow_is_yaml():
    found = yaml.safe_load(shown("yaml", "# .github"))
    assert any(
        "workbench regress" in step.get("run", "") for step in found["jobs"]["regress"]["steps"]
    )
