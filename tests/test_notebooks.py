"""Every notebook runs from top to bottom, and is written as a lecture."""

import ast
import json
import re
from pathlib import Path
from typing import Any

import matplotlib.pyplot as plt
import pytest
from matplotlib import rc_context

FOLDER = Path(__file__).parent.parent / "notebooks"
NOTEBOOKS = sorted(FOLDER.glob("*.ipynb"))
LONGEST_FUNCTION = 8
"""Lines; what needs more belongs into the package."""

each_notebook = pytest.mark.parametrize("path", NOTEBOOKS, ids=lambda path: path.stem)


def _cells(path: Path, kind: str) -> list[dict[str, Any]]:
    cells = json.loads(path.read_text(encoding="utf-8"))["cells"]
    return [cell for cell in cells if cell["cell_type"] == kind]


def _code(path: Path) -> list[ast.Module]:
    return [ast.parse("".join(cell["source"])) for cell in _cells(path, "code")]


def test_the_course_is_whole():
    assert [path.stem.split("_")[0] for path in NOTEBOOKS] == ["01", "02", "03", "04", "05"]


@each_notebook
def test_notebook_runs_and_leaves_nothing_behind(path, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    names: dict[str, object] = {}
    with rc_context():
        for cell in _cells(path, "code"):
            exec(compile("".join(cell["source"]), str(path), "exec"), names)
        plt.close("all")
    assert not list(tmp_path.iterdir())


@each_notebook
def test_outputs_are_cleared(path):
    for cell in _cells(path, "code"):
        assert not cell["outputs"] and cell["execution_count"] is None


@each_notebook
def test_there_is_no_class_and_no_long_function(path):
    nodes = [node for cell in _code(path) for node in ast.walk(cell)]
    assert not any(isinstance(node, ast.ClassDef) for node in nodes)
    for node in nodes:
        if isinstance(node, ast.FunctionDef):
            assert node.end_lineno - node.lineno < LONGEST_FUNCTION, node.name


@each_notebook
def test_it_ends_with_assertions(path):
    cells = json.loads(path.read_text(encoding="utf-8"))["cells"]
    assert cells[-1]["cell_type"] == "code"
    assert sum(isinstance(node, ast.Assert) for node in _code(path)[-1].body) >= 3


@each_notebook
def test_every_cell_of_code_is_introduced(path):
    cells = json.loads(path.read_text(encoding="utf-8"))["cells"]
    assert 10 <= len(cells) <= 20
    assert cells[0]["cell_type"] == "markdown" and "".join(cells[0]["source"]).startswith("# ")
    kinds = [cell["cell_type"] for cell in cells]
    assert ("code", "code") not in list(zip(kinds, kinds[1:], strict=False))


@each_notebook
def test_pictures_of_the_text_are_there(path):
    for cell in _cells(path, "markdown"):
        for target in re.findall(r"!\[[^]]*\]\(([^)]+)\)", "".join(cell["source"])):
            assert (FOLDER / target).is_file(), target
