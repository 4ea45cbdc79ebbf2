"""Every notebook runs from top to bottom, shows what it stores, and is written as a lecture."""

import ast
import importlib.util
import json
import math
import re
from pathlib import Path
from typing import Any

import pytest

from tests.installed import NO_EXTRA

FOLDER = Path(__file__).parents[2] / "notebooks"
NOTEBOOKS = sorted(FOLDER.glob("*.ipynb"))
LONGEST_FUNCTION = 8
"""Lines; what needs more belongs into the package."""
LARGEST = 1_000_000
"""Bytes of a notebook with its pictures."""
MACHINE = re.compile(r"/(tmp|home|root|work|Users|var)/|0x[0-9a-f]{6,}")
"""A path of a machine or an address in its memory."""
NUMBER = re.compile(r"(?<![\w.])-?\d+\.?\d*(?:e[-+]?\d+)?")
DATE = re.compile(r"\d{4}-\d\d-\d\dT\d\d:\d\d:\d\dZ")
TIME = re.compile(r'(?<=time=")[\d.]+(?=")')
"""Durations in JUnit's files."""

each_notebook = pytest.mark.parametrize("path", NOTEBOOKS, ids=lambda path: path.stem)


def _cells(path: Path, kind: str) -> list[dict[str, Any]]:
    cells = json.loads(path.read_text(encoding="utf-8"))["cells"]
    return [cell for cell in cells if cell["cell_type"] == kind]


def _code(path: Path) -> list[ast.Module]:
    magic = re.compile(r"^%.*$", re.MULTILINE)  # of IPython
    return [ast.parse(magic.sub("", "".join(cell["source"]))) for cell in _cells(path, "code")]


def test_the_course_is_whole():
    assert [path.stem.split("_")[0] for path in NOTEBOOKS] == [
        "01",
        "02",
        "03",
        "04",
        "05",
        "06",
        "07",
        "08",
        "09",
    ]


@pytest.fixture(scope="module")
def tool():
    """Return tools/notebooks.py, which stores what notebooks show."""
    spec = importlib.util.spec_from_file_location("notebooks", FOLDER.parent / "tools/notebooks.py")
    assert spec and spec.loader
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def _shown(cells: list[dict[str, Any]]) -> list[list[str]]:
    """Return what each cell shows: a text, or the kind of a picture."""
    return [
        [
            "image/png"
            if "image/png" in it.get("data", ())
            else "".join(it.get("text") or it["data"]["text/plain"])
            for it in outputs
        ]
        for outputs in (cell["outputs"] for cell in cells)
    ]


def _same(one: str, other: str) -> bool:
    """Return whether two texts are equal, numbers to a tolerance, dates and durations at all."""
    one, other = (TIME.sub("TIME", DATE.sub("DATE", text)) for text in (one, other))
    words = (re.sub(r"\s+", "", NUMBER.sub("#", text)) for text in (one, other))
    if len(set(words)) > 1:
        return False
    pairs = zip(NUMBER.findall(one), NUMBER.findall(other), strict=True)
    return all(math.isclose(float(a), float(b), rel_tol=0.02, abs_tol=2e-3) for a, b in pairs)


@pytest.mark.parametrize(
    ("one", "other", "same"),
    [
        ("rise 0.451 s", "rise 0.452 s", True),
        ("rise 0.451 s", "rise 0.551 s", False),
        ("rise 0.451 s", "rises 0.451 s", False),
        ("[ 1.0  2.0]", "[1.001 2.0 ]", True),
        ("saved: '2026-11-22T23:23:59Z'", "saved: '2026-12-01T01:02:03Z'", True),
        ('<testsuite time="0.371">', '<testsuite time="0.654">', True),
        ("1e-16 and -3", "-2e-17 and 3", False),
    ],
)
def test_shown_texts_are_compared_by_words_and_numbers(one, other, same):
    assert _same(one, other) == same


@pytest.mark.slow
@each_notebook
def test_notebook_shows_what_it_stores_and_leaves_nothing_behind(path, tool, tmp_path, case):
    if "workbench.extras" in path.read_text(encoding="utf-8"):
        pytest.importorskip("workbench.extras", reason=NO_EXTRA)
    ran = tool.run(path, tmp_path)["cells"]
    now = _shown([cell for cell in ran if cell["cell_type"] == "code"])
    for number, (shown, stored) in enumerate(
        zip(now, _shown(_cells(path, "code")), strict=True), 1
    ):
        with case(f"cell {number}; `make notebooks` stores what runs", shown, stored):
            assert len(shown) == len(stored)
            assert all(map(_same, shown, stored))
    assert not list(tmp_path.iterdir())


@each_notebook
def test_outputs_are_stored_without_errors_or_traces_of_a_machine(path):
    cells = _cells(path, "code")
    assert [cell["execution_count"] for cell in cells] == list(range(1, len(cells) + 1))
    shown = [output for cell in cells for output in cell["outputs"]]
    assert {output["output_type"] for output in shown} <= {
        "stream",
        "execute_result",
        "display_data",
    }
    assert all(output.get("name") != "stderr" for output in shown)
    assert sum("image/png" in output.get("data", ()) for output in shown) >= 2
    said = [
        "".join(part)
        for it in shown
        for part in (it.get("text"), it.get("data", {}).get("text/plain"))
        if part
    ]
    assert said and not [text for text in said if MACHINE.search(text)]
    assert path.stat().st_size < LARGEST


@each_notebook
def test_only_public_names_are_imported(path):
    for node in (node for cell in _code(path) for node in ast.walk(cell)):
        if isinstance(node, ast.Import):
            assert not [it.name for it in node.names if it.name.startswith("workbench")]
        elif isinstance(node, ast.ImportFrom) and node.module.split(".")[0] == "workbench":
            assert node.module == "workbench" or node.module.startswith("workbench.extras.")
            public = pytest.importorskip(node.module, reason=NO_EXTRA).__all__
            assert {it.name for it in node.names} <= set(public)
        elif isinstance(node, ast.Attribute):
            assert not node.attr.startswith("_"), node.attr


@each_notebook
def test_exercises_have_solutions_that_are_checked(path):
    cells = json.loads(path.read_text(encoding="utf-8"))["cells"]
    texts = ["".join(cell["source"]) for cell in cells]
    start = next(place for place, text in enumerate(texts) if text.startswith("## Exercises"))
    asked = re.findall(r"^(\d+)\. ", texts[start], re.MULTILINE)
    solutions = list(zip(cells[start + 1 :: 2], cells[start + 2 :: 2], strict=True))
    assert len(asked) >= 2 and len(solutions) == len(asked)
    for number, (title, code) in zip(asked, solutions, strict=True):
        assert "".join(title["source"]).startswith(f"## Solution {number}\n")
        assert code["metadata"]["jupyter"]["source_hidden"]  # Jupyter shows it when it is asked to
        assert any(
            isinstance(it, ast.Assert) for it in ast.walk(ast.parse("".join(code["source"])))
        )


@each_notebook
def test_there_is_no_class_and_no_long_function(path):
    nodes = [node for cell in _code(path) for node in ast.walk(cell)]
    assert not any(isinstance(node, ast.ClassDef) for node in nodes)
    for node in nodes:
        if isinstance(node, ast.FunctionDef):
            assert node.end_lineno - node.lineno < LONGEST_FUNCTION, node.name


@each_notebook
def test_the_lecture_ends_with_assertions(path):
    cells = json.loads(path.read_text(encoding="utf-8"))["cells"]
    texts = ["".join(cell["source"]) for cell in cells]
    last = next(place for place, text in enumerate(texts) if text.startswith("## Exercises")) - 1
    assert texts[last - 1] == "## Checks"
    assert sum(isinstance(node, ast.Assert) for node in ast.parse(texts[last]).body) >= 3


@each_notebook
def test_every_cell_of_code_is_introduced(path):
    cells = json.loads(path.read_text(encoding="utf-8"))["cells"]
    assert 10 <= len(cells) <= 30
    assert cells[0]["cell_type"] == "markdown" and "".join(cells[0]["source"]).startswith("# ")
    kinds = [cell["cell_type"] for cell in cells]
    assert ("code", "code") not in list(zip(kinds, kinds[1:], strict=False))


@each_notebook
def test_pictures_of_the_text_are_there(path):
    for cell in _cells(path, "markdown"):
        for target in re.findall(r"!\[[^]]*\]\(([^)]+)\)", "".join(cell["source"])):
            assert (FOLDER / target).is_file(), target
