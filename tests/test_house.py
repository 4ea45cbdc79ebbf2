"""tools/house.py counts as its docstring says."""

import importlib
import json
from pathlib import Path

import pytest

TOOLS = Path(__file__).resolve().parent.parent / "tools"
FILES = {
    "workbench/__init__.py": '"""Public."""\n_HOME = {"Kept": "workbench.law.kept"}\n',
    "workbench/law/__init__.py": "from .kept import Kept\n",
    "workbench/law/kept.py": '''\
"""A docstring
of two lines."""

import math  # an import is no code
from typing import (
    Any,
)

LIMIT = 1.0
"""The sentence below a constant is a docstring too."""


class Kept:
    """A class."""

    unread: int = 3

    # a comment
    def used(self) -> Any:
        return """a string
of two lines"""
''',
    "workbench/law/first.py": """\
from workbench.law import Kept


def go():
    return Kept.used
""",
    "workbench/law/second.py": """\
def go_on():
    from workbench.law import third

    return third
""",
    "workbench/law/third.py": "from . import second\n\nboth = second.go_on\n",
    "workbench/law/upper.py": "from workbench.lower import base\n\nbase.both()\n",
    "workbench/lower/base.py": "both = 1\n",
    "workbench/lower/more.py": "import workbench.law.third\n\nworkbench.law.third.both()\n",
    "workbench/start.py": "import workbench.law.first\n\nworkbench.law.first.go()\n",
    "workbench/__main__.py": "import workbench.start\n",
    "workbench/seldom.py": "from workbench import Kept\n\nKept.used()\n",
    "tests/test_law.py": "LIMIT\n",
    "docs/law.md": "Set `both`.\n",
}


@pytest.fixture
def tool(monkeypatch):
    monkeypatch.syspath_prepend(TOOLS)
    return importlib.import_module("house")


def test_a_tree_is_counted_as_defined(tool, tmp_path, monkeypatch, capsys):
    for name, text in FILES.items():
        path = tmp_path / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text)
    monkeypatch.setattr("sys.argv", ["house.py", str(tmp_path), "--json"])
    assert tool.main() == 0
    found = json.loads(capsys.readouterr().out)
    law = found["rooms"]["law"]
    assert {name: law[name] for name in ("code", "classes", "files")} == {
        "code": 6 + 2 + 2 + 1 + 1,
        "classes": 1,
        "files": 6,
    }
    assert found["rooms"]["start"]["code"] == 1
    assert {Path(row["file"]).stem: row["importer"] for row in found["single"]} == {
        "first": "workbench/start.py",
        "second": "workbench/law/third.py",
        "start": "workbench/__main__.py",
        "seldom": None,
        "upper": None,
        "base": "workbench/law/upper.py",
        "more": None,
    }
    assert found["circles"] == [
        {"kind": "hidden", "modules": ["workbench.law.second", "workbench.law.third"]},
        {"kind": "rooms", "modules": ["law", "lower"]},
    ]
    assert {row["name"]: row["used_by"] for row in found["unused"]} == {
        "unread": "",
        "LIMIT": "tests",
    }


def test_a_folder_without_the_package_is_refused(tool, tmp_path, monkeypatch, capsys):
    monkeypatch.setattr("sys.argv", ["house.py", str(tmp_path)])
    assert tool.main() == 2
    assert "no folder workbench" in capsys.readouterr().err
