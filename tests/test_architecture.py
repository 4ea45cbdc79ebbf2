"""Who may import whom, and what a bare import may load.

A room is a name directly under `workbench`: a folder or a single file.
"""

import ast
import dataclasses
import inspect
import re
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

import workbench

ROOT = Path(__file__).resolve().parent.parent
PACKAGE = ROOT / "workbench"

MAY_IMPORT = {
    "common": "",
    "ipc": "common",
    "autopilots": "common ipc",
    "plant": "common ipc",
    "link": "common ipc",
    "gateways": "common link",
    "dynamics": "common plant",
    "estimation": "common plant dynamics",
    "estimators": "common plant dynamics estimation",
    "control": "common plant dynamics estimation",
    "controllers": "common autopilots plant dynamics control",
    "scenario": "common plant estimation control",
    "gains": "common plant control scenario",
    "systems": "common plant link dynamics estimation control",
    "diagram": "common plant link dynamics estimation control scenario systems",
    "session": "common autopilots plant link dynamics estimation control scenario gains systems "
    "diagram",
    "design": "common ipc plant dynamics estimation control scenario gains systems diagram session",
    "gym": "common plant control design",
    "logs": "common ipc plant link estimation gateways control scenario systems session",
    "logs/flight_film": "design",
    "logs/judged_log": "design",
    "logs/measured_flight": "design",
    "logs/plots": "design",
    "logs/sensor_samples": "diagram",
    "logs/motion": "design gains",
    "live": "common ipc plant link estimation control scenario gains systems session logs",
    "analysis": "common ipc control scenario session design logs live",
    "gui": "common ipc plant link control scenario gains systems session design logs live analysis",
    "commands": "common ipc autopilots plant link gateways estimation control scenario gains "
    "systems diagram session design logs live",
    "commands/gui": "gui",
    "pytest_plugin": "common design logs",
    "__main__": "common commands",
    "__init__": "common plant control controllers scenario gains diagram session design logs live",
}
"""What of ours a room may import besides itself, rooms above it alone: so there are no circles of
rooms. `room/file` is what one file of it may besides."""

ONLY_HERE = {"PyQt6": {"gui"}}
"""Packages that belong to some rooms."""

NEVER_HERE = {
    "link": {"pydrake", "PyQt6"},
    "gui": {"pydrake"},
}
"""Packages that a room does without."""

NOWHERE = {"pydrake.all": "it loads all of Drake, slowly: import the modules in use"}


def find_violations(package: Path) -> list[str]:
    """Return a sentence for each import that breaks a rule, and for each unknown room."""
    found = []
    for path in sorted([*package.rglob("*.py"), *package.rglob("*.pyi")]):
        file = path.relative_to(package).with_suffix("")
        where = path.relative_to(package.parent).as_posix()
        if file.parts[0] not in MAY_IMPORT:
            found.append(f"{where}: unknown room: add it to MAY_IMPORT in {Path(__file__).name}")
            continue
        found += [
            f"{where}:{line}: imports {name}: {reason}"
            for name, line in sorted(set(imports(path, package)))
            if (reason := why_not(file, name))
        ]
    return found


def why_not(file: Path, name: str) -> str | None:
    """Return why `file` may not import the module `name`, None if it may."""
    room = file.parts[0]
    for unwanted, reason in NOWHERE.items():
        if name == unwanted or name.startswith(unwanted + "."):
            return reason
    top, *rest = name.split(".")
    if top != "workbench":
        if top in NEVER_HERE.get(room, ()):
            return f"'{room}' does without {top}"
        if room not in ONLY_HERE.get(top, {room}):
            return f"only {', '.join(sorted(ONLY_HERE[top]))} may import {top}"
        return None
    target = rest[0] if rest else "__init__"
    # The file's own row is looked up by `room/file`; a room that is one file has just one row.
    rows = {room, file.as_posix()} & MAY_IMPORT.keys()
    allowed = " ".join(MAY_IMPORT[row] for row in sorted(rows)).split()
    if target not in (room, *allowed):
        return f"'{room}' may import of ours only {', '.join(allowed) or 'nothing'}"
    return None


def imports(path: Path, package: Path) -> Iterator[tuple[str, int]]:
    """Yield the full name and the line of each import, those inside functions included."""
    here = [package.name, *path.relative_to(package).parent.parts]
    for node in ast.walk(ast.parse(path.read_text(), str(path))):
        for name in imported_names(node, here, package):
            yield name, node.lineno


def imported_names(node: ast.AST, here: list[str], package: Path) -> list[str]:
    """Return the full module names that one statement or call imports."""
    match node:
        case ast.Import(names=names):
            return [alias.name for alias in names]
        case ast.ImportFrom(module=module, names=names, level=level):
            start = here[: len(here) - level + 1] if level else []
            base = ".".join([*start, *([module] if module else [])])
            # `from workbench import plant` means the room, `from workbench import Vehicle` does not
            return [
                f"{base}.{alias.name}" if is_module(base, alias.name, package) else base
                for alias in names
            ]
        case ast.Call(func=func, args=[ast.Constant(value=str(name)), *_]):
            called = getattr(func, "attr", getattr(func, "id", None))
            return [name] if called in ("import_module", "__import__") else []
    return []


def is_module(base: str, name: str, package: Path) -> bool:
    """Return whether `name` in `from base import name` is a module whose name matters here."""
    if f"{base}.{name}" in NOWHERE:
        return True
    folder = package.parent.joinpath(*base.split("."), name)
    return folder.is_dir() or folder.with_suffix(".py").is_file()


def test_rooms_import_only_what_they_may():
    violations = find_violations(PACKAGE)
    assert not violations, "\n" + "\n".join(violations)


def test_a_room_imports_only_rooms_above_it():
    above = set()
    for row, rooms in MAY_IMPORT.items():
        assert set(rooms.split()) <= above, row
        above |= {row.split("/")[0]}


def test_a_broken_rule_is_named(case, tmp_path):
    table = [
        ("plant/a.py", "from workbench.systems import b", "'plant' may import of ours only common"),
        ("plant/a.py", "from ..systems.b import C", "imports workbench.systems.b"),
        ("plant/a.py", "from .. import systems", "imports workbench.systems:"),
        ("plant/a.py", "from workbench import systems", "imports workbench.systems:"),
        ("plant/a.py", "from workbench import Vehicle", "imports workbench:"),
        ("common/a.py", "import workbench.plant", "only nothing"),
        ("systems/a.py", "def f():\n    import workbench.gui", "workbench/systems/a.py:2:"),
        ("systems/a.py", "import_module('workbench.gui.b')", "imports workbench.gui.b"),
        ("commands/fly.py", "def f():\n    from workbench.gui import b", "imports workbench.gui"),
        ("__main__.py", "def f():\n    import workbench.session.session", "only common, commands"),
        ("session/a.py", "from PyQt6.QtCore import QObject", "only gui may import PyQt6"),
        ("link/a.py", "import pydrake.math", "'link' does without pydrake"),
        ("gui/a.py", "from pydrake import math", "'gui' does without pydrake"),
        ("plant/a.py", "from pydrake.all import X", "loads all of Drake"),
        ("plant/a.py", "from pydrake import all", "loads all of Drake"),
        ("attic.py", "", "unknown room: add it"),
        ("__init__.pyi", "from workbench.gui import b as b", "imports workbench.gui"),
    ]
    for number, (file, source, said) in enumerate(table):
        with case(file, source, said):
            package = make_package(tmp_path / str(number), file, source)
            violations = find_violations(package)
            assert len(violations) == 1
            assert said in violations[0]


@pytest.mark.parametrize(
    ("file", "source"),
    [
        ("plant/a.py", "from workbench.common.errors import WorkbenchError"),
        ("plant/a.py", "from . import b\nfrom .b import C\nimport workbench.plant.b"),
        ("commands/gui.py", "def f():\n    from workbench.gui import b"),
        ("gui/a.py", "from PyQt6.QtCore import QObject"),
    ],
)
def test_what_is_allowed_passes(tmp_path, file, source):
    assert find_violations(make_package(tmp_path, file, source)) == []


def make_package(folder: Path, file: str, source: str) -> Path:
    """Return a package of that file and of empty ones for it to import."""
    package = folder / "workbench"
    for name in ("plant/b.py", "systems/b.py", "gui/b.py", "commands/b.py", file):
        (package / name).parent.mkdir(parents=True, exist_ok=True)
        (package / name).write_text("")
    (package / file).write_text(source)
    return package


def test_each_public_name_is_written_once_and_can_be_loaded():
    lines = (PACKAGE / "__init__.pyi").read_text().splitlines()[2:]
    assert lines == sorted(set(lines))
    said = [re.fullmatch(r"from (workbench\.[\w.]+) import (\w+) as \2", each) for each in lines]
    assert all(said) and workbench.__all__ == sorted(each[2] for each in said)
    for name in workbench.__all__:
        assert getattr(workbench, name) is not None, name
    with pytest.raises(AttributeError, match="module 'workbench' has no attribute 'Drone'"):
        _ = workbench.Drone


def test_public_functions_take_paths_as_text_too():
    """Those of modules and classes; the fields of records keep what they were made with."""
    wrong = []
    for name in workbench.__all__:
        public = getattr(workbench, name)
        functions = {name: public} if inspect.isfunction(public) else {}
        if inspect.isclass(public):
            members = [
                *inspect.getmembers(public, inspect.isfunction),
                *inspect.getmembers(public, inspect.ismethod),
            ]
            functions = {f"{name}.{key}": each for key, each in members if key[0] != "_"}
            if not dataclasses.is_dataclass(public) and inspect.isfunction(public.__init__):
                functions[name] = public.__init__
        for key, function in functions.items():
            for each in inspect.signature(function).parameters.values():
                kind = str(each.annotation)
                is_path = "Path" in kind or each.name == "name_or_path"
                if is_path and not ("Path" in kind and "str" in kind):
                    wrong.append(f"{key}({each.name}: {kind})")
    assert wrong == []


@pytest.mark.parametrize("module", ["workbench", "workbench.commands.cli"])
def test_a_bare_import_stays_light(module):
    code = f"import sys, {module}; print(*{{name.split('.')[0] for name in sys.modules}})"
    done = subprocess.run([sys.executable, "-c", code], cwd=ROOT, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    heavy = {"pydrake", "PyQt6", "matplotlib", "scipy", "control"} & set(done.stdout.split())
    assert not heavy, f"`import {module}` also loads {', '.join(sorted(heavy))}"
