"""The README and docs/index.md: Python and commands work as printed, and no page is missing."""

import re
import shlex
from pathlib import Path

import pytest

from workbench.commands.cli import main

ROOT = Path(__file__).parents[2]
README, INDEX = ROOT / "README.md", ROOT / "docs" / "index.md"
FIRST_DRONE = (ROOT / "docs" / "first-drone.md").read_text(encoding="utf-8")
LONGEST = 115
"""Lines of the README: two screens."""


def _blocks(language: str) -> list[str]:
    text = README.read_text(encoding="utf-8") + INDEX.read_text(encoding="utf-8")
    return re.findall(rf"```{language}\n(.*?)```", text, re.DOTALL)


@pytest.mark.parametrize("code", _blocks("python"))
def test_python_example_runs(code, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    exec(compile(code, str(README), "exec"), {"__name__": "__main__"})
    assert capsys.readouterr().out.strip()


def _commands() -> list[str]:
    """Return all but those that tests/docs/test_docs_first_drone.py walks, in one folder."""
    lines = [line.split("#")[0].strip() for line in "\n".join(_blocks("sh")).splitlines()]
    return [each for each in lines if each and f"\n{each}\n" not in FIRST_DRONE]


@pytest.mark.slow
@pytest.mark.parametrize("command", _commands())
def test_command_line_runs(command, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    assert main(shlex.split(command)[1:]) == 0
    assert capsys.readouterr().out.strip()


def test_the_readme_is_two_screens_long():
    assert len(README.read_text(encoding="utf-8").splitlines()) <= LONGEST


def test_every_page_is_in_the_index_and_every_link_leads_somewhere():
    index = INDEX.read_text(encoding="utf-8")
    pages = sorted((ROOT / "docs").glob("*.md"))
    assert [page.name for page in pages if page != INDEX and f"({page.name})" not in index] == []
    pages += [README, ROOT / "CONTRIBUTING.md", ROOT / "CHANGELOG.md"]
    broken = [
        f"{page.name}: {target}"
        for page in pages
        for target in re.findall(r"\]\(([^)#\s]+)[^)]*\)", page.read_text(encoding="utf-8"))
        if "://" not in target and not (page.parent / target).exists()
    ]
    assert broken == []


def test_nothing_says_to_install_from_the_index():
    """The package is not there: `pip install` of its name finds nothing, or somebody else's."""
    wrong = re.compile(r"pip install\s+[\"'`\s]*drake-drone-workbench(?! @)")
    files = [README, *ROOT.glob("docs/*.md"), *ROOT.glob("workbench/**/*.py"), *ROOT.glob("*.md")]
    assert [path.name for path in files if wrong.search(path.read_text(encoding="utf-8"))] == []
