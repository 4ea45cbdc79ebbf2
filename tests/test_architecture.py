"""Who may import whom, and what a bare import may load.

A room is a name directly under `workbench`: a folder or a single file.
"""

import ast
import dataclasses
import functools
import inspect
import io
import re
import subprocess
import sys
import tokenize
from collections.abc import Iterator, Sequence
from pathlib import Path

import pytest

import workbench

ROOT = Path(__file__).resolve().parent.parent
PACKAGE = ROOT / "workbench"

MAY_IMPORT = {
    "common": "",
    "ipc": "common",
    "plant": "common ipc",
    "link": "common ipc",
    "dynamics": "common plant",
    "estimation": "common plant dynamics",
    "parameters": "common plant dynamics estimation",
    "estimators": "common plant dynamics estimation",
    "control": "common plant dynamics estimation parameters",
    "controllers": "common plant dynamics control",
    "scenario": "common plant estimation parameters control",
    "gains": "common plant parameters control scenario",
    "setup": "common plant estimation parameters control scenario gains",
    "systems": "common plant link dynamics estimation control",
    "diagram": "common plant link dynamics estimation control scenario setup systems",
    "session": "common plant link dynamics estimation parameters control scenario gains setup "
    "systems diagram",
    "design": "common ipc plant dynamics estimation parameters control scenario gains setup "
    "systems diagram session",
    "gym": "common plant control design",
    "logs": "common ipc plant link estimation control scenario systems session",
    "logs/flight_film": "design",
    "logs/judged_log": "design",
    "logs/plots": "design",
    "logs/step_response": "design",
    "logs/sensor_samples": "diagram",
    "live": "common ipc plant link estimation parameters control scenario gains systems session "
    "logs",
    "analysis": "common ipc parameters control scenario setup session design logs live",
    "gui": "common ipc plant link parameters control scenario gains systems session design logs "
    "live analysis",
    "gui/settings/flight_form": "estimation",
    "commands": "common ipc plant link estimation parameters control scenario gains setup systems "
    "diagram session design logs live",
    "commands/gui": "gui",
    "extras/__init__": "",
    "extras/autopilots": "common ipc plant control controllers scenario gains setup systems "
    "diagram session design logs commands",
    "extras/flightdata": "common plant link dynamics estimation parameters control scenario gains "
    "systems session design logs analysis commands",
    "extras/flightdata/cards": "gui",
    "extras/formats": "common plant",
    "extras/gateways": "common link commands",
    "pytest_plugin": "common design logs",
    "__main__": "common commands",
    "__init__": "common plant control controllers scenario gains setup diagram session design "
    "logs live",
}
"""What of ours a room may import besides itself, rooms above it alone: so there are no circles of
rooms. `room/file` is what one file of it may besides. Each package of `extras` is a room; none of
the core is named `extras`, so the core never imports them, nor they one another unless named."""

CONTRACTS = {
    *(
        "PARAMETERS",
        "MEMORY",
        "POINTS",
        "LOOPS",
        "DESIGNED",
        "PERIOD",
        "DIVIDERS",
    ),  # of a law's file
    *("update", "rule", "design", "add_parser", "run", "main"),  # of laws, commands and programs
    "find_firmware",  # of an extra
    *("CHART_KIND", "LOG_READER"),  # of a chart's and of a log reader's module
    *("T", "P", "_MODULES"),  # types' variables, and what is loaded lazily
    *("FULL_MOTOR_SIGNAL", "MAX_CRAZYFLIE_MASS_KG", "VOLTAGE_THRUST_CURVE"),  # extras are apart
}
"""Names that modules have in common: a reader, or a caller, knows them by these names."""
MAX_FILE_LINES = 400
LONG_FILES = {
    "gui/gains/gain_editor.py": 588,
    "gui/charts/canvas.py": 478,
    "gui/view3d/view3d_panel.py": 459,
    "gui/charts/chart.py": 422,
    "gui/tuning/compare_card.py": 437,
}
"""Files of the core that are longer than `MAX_FILE_LINES`; they may only become shorter."""

ONLY_HERE = {"PyQt6": {"gui", "extras/flightdata/cards"}}
"""Packages that belong to some rooms, and to some files of others."""

NEVER_HERE = {
    "link": {"pydrake", "PyQt6"},
    "gui": {"pydrake"},
}
"""Packages that a room does without."""

FOREIGN_NAMES = r"(control|workbench|xacro)\..*|imu\.f_z|.*\.(c|config|csv|md|py|sdf|yaml)"
"""Names with a dot of other packages or of files, of entry points, and of a sensor's signal."""

NOWHERE = {"pydrake.all": "it loads all of Drake, slowly: import the modules in use"}


def find_violations(package: Path) -> list[str]:
    """Return a sentence for each import that breaks a rule, and for each unknown room."""
    found = []
    for path in sorted([*package.rglob("*.py"), *package.rglob("*.pyi")]):
        file = path.relative_to(package).with_suffix("")
        where = path.relative_to(package.parent).as_posix()
        if room_of(file.parts) not in MAY_IMPORT:
            found.append(f"{where}: unknown room: add it to MAY_IMPORT in {Path(__file__).name}")
            continue
        found += [
            f"{where}:{line}: imports {name}: {reason}"
            for name, line in sorted(set(imports(path, package)))
            if (reason := why_not(file, name))
        ]
    return found


def room_of(parts: Sequence[str]) -> str:
    """Return the room of a path below `workbench`; each package of `extras` is one."""
    return "/".join(parts[:2]) if parts[0] == "extras" and len(parts) > 1 else parts[0]


def why_not(file: Path, name: str) -> str | None:
    """Return why `file` may not import the module `name`, None if it may."""
    room = room_of(file.parts)
    for unwanted, reason in NOWHERE.items():
        if name == unwanted or name.startswith(unwanted + "."):
            return reason
    top, *rest = name.split(".")
    if top != "workbench":
        if top in NEVER_HERE.get(room, ()):
            return f"'{room}' does without {top}"
        if not {room, file.as_posix()} & ONLY_HERE.get(top, {room}):
            return f"only {', '.join(sorted(ONLY_HERE[top]))} may import {top}"
        return None
    target = room_of(rest) if rest else "__init__"
    # The file's own row is looked up by `room/file`; a room that is one file has just one row.
    rows = {room, file.as_posix()} & MAY_IMPORT.keys()
    allowed = " ".join(MAY_IMPORT[row] for row in sorted(rows)).split()
    if target not in (room, *allowed):
        return f"'{room}' may import of ours only {', '.join(allowed) or 'nothing'}"
    return None


def imports(path: Path, package: Path) -> Iterator[tuple[str, int]]:
    """Yield the full name and the line of each import, those inside functions included."""
    here = [package.name, *path.relative_to(package).parent.parts]
    for node in ast.walk(tree_of(path)):
        for name in imported_names(node, here, package):
            yield name, node.lineno


@functools.cache
def tree_of(path: Path) -> ast.Module:
    """Return the parsed file, which several tests look through."""
    return ast.parse(path.read_text(), str(path))


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


@functools.cache
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
        above |= {room_of(row.split("/"))}


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
        ("session/a.py", "from PyQt6.QtCore import QObject", "cards, gui may import PyQt6"),
        ("link/a.py", "import pydrake.math", "'link' does without pydrake"),
        ("gui/a.py", "from pydrake import math", "'gui' does without pydrake"),
        ("plant/a.py", "from pydrake.all import X", "loads all of Drake"),
        ("plant/a.py", "from pydrake import all", "loads all of Drake"),
        ("attic.py", "", "unknown room: add it"),
        ("extras/attic/a.py", "", "unknown room: add it"),
        (
            "commands/a.py",
            "import workbench.extras.gateways.b",
            "'commands' may import of ours only",
        ),
        ("extras/gateways/a.py", "import workbench.plant.b", "only common, link, commands"),
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


def test_a_name_stands_for_one_thing():
    """A class, public function or constant at the top of a module has a name of its own."""
    places: dict[str, set[str]] = {}
    for path in PACKAGE.rglob("*.py"):
        for node in tree_of(path).body:
            for name in top_names(node):
                places.setdefault(name, set()).add(path.relative_to(PACKAGE).as_posix())
    shared = {name: files for name, files in places.items() if len(files) > 1}
    assert {name: files for name, files in shared.items() if name not in CONTRACTS} == {}


def top_names(node: ast.stmt) -> list[str]:
    match node:
        case ast.ClassDef(name=name):
            return [name]
        case ast.FunctionDef(name=name):
            return [] if name.startswith("_") else [name]
        case ast.Assign(targets=targets):
            stored = [each for target in targets for each in ast.walk(target)]
        case ast.AnnAssign(target=target):
            stored = [target]
        case _:
            return []
    return [each.id for each in stored if isinstance(each, ast.Name) and each.id.isupper()]


def test_names_in_prose_stand_in_their_module():
    """Each `module.NAME` of a docstring or a comment; members of a module's classes count, too."""
    files = [path for path in PACKAGE.rglob("*.py") if path.stem != "__init__"]
    names: dict[str, set[str]] = {path.stem: set() for path in files}
    for path in files:
        names[path.stem] |= set(defined_names(tree_of(path)))
        names.get(path.parent.name, set()).add(path.stem)

    def unknown(text: str) -> list[str]:
        return [
            whole
            for whole, module, name in re.findall(r"`((?:\w+\.)*(\w+)\.(\w+))[(`]", text)
            if name not in names.get(module, {name})
            and not re.fullmatch(FOREIGN_NAMES, f"{module}.{name}")
        ]

    wrong = []
    for path in PACKAGE.rglob("*.py"):
        source = path.read_text()
        if not unknown(source):  # in few files there is one in code, so tokens need not be found
            continue
        for token in tokenize.generate_tokens(io.StringIO(source).readline):
            if token.type == tokenize.COMMENT or token.string.startswith('"""'):
                where = path.relative_to(PACKAGE)
                wrong += [f"{where}: `{whole}`" for whole in unknown(token.string)]
    assert not wrong, "\n" + "\n".join(wrong)


def defined_names(tree: ast.AST) -> Iterator[str]:
    """Yield the names of a module and of its classes, without those inside functions."""
    for node in ast.iter_child_nodes(tree):
        if isinstance(node, ast.ClassDef | ast.FunctionDef):
            yield node.name
        elif isinstance(node, ast.Name) and isinstance(node.ctx, ast.Store):
            yield node.id
        if not isinstance(node, ast.FunctionDef):
            yield from defined_names(node)


def test_files_of_the_core_are_short():
    for path in PACKAGE.rglob("*.py"):
        file = path.relative_to(PACKAGE).as_posix()
        if not file.startswith("extras/"):
            assert len(path.read_text().splitlines()) <= LONG_FILES.get(file, MAX_FILE_LINES), file


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
