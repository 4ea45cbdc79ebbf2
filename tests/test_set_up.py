"""Set-up: the Python it takes or refuses; what is pinned fits what is promised."""

import ast
import os
import pty
import re
import subprocess
import sys
from importlib import metadata
from pathlib import Path

import pytest
from packaging.markers import default_environment
from packaging.requirements import Requirement
from packaging.specifiers import SpecifierSet
from packaging.version import Version

from tests.required import PROJECT, canonical, required_with

ROOT = Path(__file__).resolve().parent.parent
PYTHONS = ["3.11", "3.12", "3.13"]
FAKE = """#!/bin/sh
# Answers as a Python does that the set-up asks for its version, to make an environment, to install.
case "$1 $2" in
"-c "*) echo {version}; echo "$0"; exit {lacks_ensurepip} ;;
"-m venv")
    /bin/mkdir -p "$4/bin" && /bin/cp "$0" "$4/bin/python"
    printf 'version = {version}.1\\ncommand = x -m venv --clear %s\\n' "$4" > "$4/pyvenv.cfg" ;;
esac
"""


@pytest.fixture
def machine(tmp_path):
    """Return a copy of what sets up, on a machine whose Pythons are scripts."""
    return Machine(tmp_path)


class Machine:
    def __init__(self, folder: Path) -> None:
        self.folder = folder / "clone"
        self.environment = {"PATH": str(folder / "bin"), "HOME": str(folder)}
        for name in ("tools/set_up.py", "tools/apt.py", "pyproject.toml", "constraints.txt"):
            (self.folder / name).parent.mkdir(parents=True, exist_ok=True)
            (self.folder / name).write_text((ROOT / name).read_text())

    def put(self, place: str, version: str, *, lacks_ensurepip: bool = False) -> Path:
        """Put a Python at a path below the home."""
        path = self.folder.parent / place
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(FAKE.format(version=version, lacks_ensurepip=int(lacks_ensurepip)))
        path.chmod(0o755)
        return path

    def set_up(self, *arguments: str) -> subprocess.CompletedProcess[str]:
        return subprocess.run(
            [sys.executable, str(self.folder / "tools" / "set_up.py"), *arguments],
            env=self.environment,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            text=True,
        )

    def taken(self, *arguments: str) -> str:
        """Return the version of the environment after a set-up."""
        done = self.set_up(*arguments)
        assert done.returncode == 0, done.stdout
        config = (self.folder / ".venv" / "pyvenv.cfg").read_text()
        return re.findall(r"version = (\d+\.\d+)", config)[0]


def test_the_newest_supported_python_is_taken_wherever_it_is(machine):
    machine.put("bin/python3", "3.10")
    machine.put("bin/python3.11", "3.11")
    assert machine.set_up("--find", "3.12").returncode == 1
    shim = machine.put("bin/python3.13", "3.13")
    shim.write_text("#!/bin/sh\necho 'pyenv: python3.13: command not found' >&2; exit 127\n")
    machine.put(".pyenv/versions/3.12.1/bin/python3.12", "3.12")
    machine.put(".pyenv/versions/3.13t/bin/python3.13", "3.13t")  # no wheels are for it
    machine.put(".pyenv/versions/3.14.0/bin/python3", "3.14")
    assert machine.taken() == "3.12"
    other = machine.put("elsewhere/versions/3.13.0/bin/python3", "3.13")
    assert machine.taken() == "3.12"  # what stands keeps its Python
    machine.environment["PYENV_ROOT"] = str(other.parents[3])
    assert machine.set_up("--find", "3.13").stdout == f"{other}\n"
    assert machine.taken() == "3.12"
    assert machine.taken("--python", str(other)) == "3.13"  # but where another is named
    assert machine.taken() == "3.13"
    assert machine.set_up().stdout == ""  # nothing is left to do


def test_a_python_that_cannot_make_environments_is_the_last_choice(machine):
    machine.put("bin/python3.13", "3.13", lacks_ensurepip=True)
    alone = machine.set_up()
    assert alone.returncode == 2 and "install what Debian calls python3.13-venv" in alone.stdout
    machine.put("bin/python3.12", "3.12")
    said = machine.set_up().stdout
    assert "lacks ensurepip" in said and "Making .venv with Python 3.12" in said


def test_extras_are_installed_once_until_what_is_pinned_changes(machine):
    machine.put("bin/python3.13", "3.13")
    for extras in ((), ("test",), ("app,logs",)):
        said = f"Installing [{''.join(extras) or 'dev'}] into .venv"
        assert said in machine.set_up(*extras).stdout
        assert machine.set_up(*extras).stdout == ""
    with (machine.folder / "constraints.txt").open("a") as stream:
        stream.write("tree==1.0\n")
    # also those of other extras, which share packages with it
    assert "Installing [bench,app,logs,dev,test]" in machine.set_up("bench").stdout
    for extras in ((), ("test",), ("app,logs",), ("bench",)):
        assert machine.set_up(*extras).stdout == ""


def test_an_environment_that_is_a_link_is_not_emptied(machine):
    machine.put("bin/python3.13", "3.13")
    other = machine.folder / "other"
    other.mkdir()
    (other / "kept").write_text("")
    (machine.folder / ".venv").symlink_to(other)
    done = machine.set_up()
    assert (done.returncode, ".venv is a link to" in done.stdout) == (2, True), done.stdout
    assert [path.name for path in other.iterdir()] == ["kept"]


@pytest.mark.parametrize(
    ("target", "extras"),
    [
        ("setup", [""]),
        ("run", ["", "app,gamepad,logs"]),
        ("test", ["", "test"]),
        ("test-slow", ["", "slow"]),
        ("docs", ["", "docs"]),
        ("bench", ["", "bench"]),
        ("notebooks", ["", "slow"]),
        ("examples", [""]),
    ],
)
def test_a_target_adds_the_extras_that_it_needs(target, extras):
    env = {"PATH": os.environ["PATH"]}
    words = ["make", "--dry-run", target]
    done = subprocess.run(words, cwd=ROOT, env=env, capture_output=True, text=True, check=True)
    assert re.findall(r"set_up\.py --venv \.venv *(\S*)(?=$| &&)", done.stdout, re.M) == extras
    names = {name for each in extras for name in each.split(",")}
    assert names - {""} <= PROJECT["optional-dependencies"].keys()


@pytest.mark.parametrize(
    ("here", "arguments", "said"),
    [
        ("3.10", (), "runs on Python 3.11, 3.12 and 3.13, and none of them is on PATH"),
        ("3.14", (), "runs on Python 3.11, 3.12 and 3.13, and none of them is on PATH"),
        (
            "3.10",
            ("--python", "python3"),
            "python3 is Python 3.10: name another, as in `make",
        ),
        (
            "3.14",
            ("--python", "python3"),
            "python3 is Python 3.14: name another, as in `make",
        ),
        (
            "3.13",
            ("--python", "python3.9"),
            "no Python that runs as python3.9: install it",
        ),
        ("3.13", ("--python", "true"), "no Python that runs as true: install it"),
    ],
)
def test_other_pythons_are_refused_with_a_sentence(machine, here, arguments, said):
    machine.put("bin/python3", here)
    machine.put("bin/true", "").write_text("#!/bin/sh\n")
    done = machine.set_up(*arguments)
    assert (done.returncode, said in done.stdout) == (2, True), done.stdout
    assert not (machine.folder / ".venv").exists()


@pytest.mark.parametrize(
    ("answer", "consent", "installs"),
    [("y", "", True), ("", "", False), (None, "", False), (None, "yes", True)],
)
def test_apt_get_runs_only_if_the_user_agrees(tmp_path, answer, consent, installs):
    """Without an answer there is no terminal, as in CI."""
    log = tmp_path / "log"
    for name, text in {"apt-get": f'echo "$@" > {log}', "sudo": 'shift; exec "$@"'}.items():
        (tmp_path / name).write_text(f"#!/bin/sh\n{text}\n")
        (tmp_path / name).chmod(0o755)
    ours, theirs = pty.openpty()
    os.write(ours, f"{answer}\n".encode())
    done = subprocess.run(
        [sys.executable, "-c", "import apt; apt.install(['tree'], 'A tree is missing')"],
        cwd=ROOT / "tools",
        env={"PATH": f"{tmp_path}:/usr/bin:/bin", "WORKBENCH_APT": consent},
        stdin=subprocess.DEVNULL if answer is None else theirs,
        capture_output=True,
        text=True,
    )
    os.close(ours)
    os.close(theirs)
    assert ("Install tree with apt-get? [y/N]" in done.stdout) == (answer is not None)
    assert log.exists() == installs
    if not installs:
        assert done.returncode == 2 and "run `sudo apt-get install tree`" in done.stderr


def test_all_places_promise_the_same_pythons():
    minors = [f"3.{minor}" for minor in range(30)]
    assert [it for it in minors if it in SpecifierSet(PROJECT["requires-python"])] == PYTHONS
    classifier = "Programming Language :: Python :: 3."
    assert [
        it.rpartition(" ")[2] for it in PROJECT["classifiers"] if it.startswith(classifier)
    ] == PYTHONS
    set_up = (ROOT / "tools" / "set_up.py").read_text()
    assert re.search(r"SUPPORTED = \((.*)\)", set_up)[1] == '"3.13", "3.12", "3.11"'
    ci = (ROOT / ".ci" / "run").read_text()
    assert f'VERSIONS="{" ".join(PYTHONS)}"' in ci
    assert all(f"with Python {version}" in ci for version in PYTHONS)


@pytest.mark.parametrize("python", PYTHONS)
def test_what_is_pinned_is_what_the_requirements_allow(python):
    environment = default_environment() | {
        "python_version": python,
        "python_full_version": f"{python}.0",
    }
    pins: dict[str, str] = {}
    for line in (ROOT / "constraints.txt").read_text().splitlines():
        if line.startswith("#"):
            continue
        pin = Requirement(line)
        if pin.marker is None or pin.marker.evaluate(environment):
            assert canonical(pin.name) not in pins, f"two pins of {pin.name}"
            pins[canonical(pin.name)] = str(pin.specifier).removeprefix("==")
    wanted = requirements()
    for it in wanted:
        if it.marker is None or it.marker.evaluate(environment):
            assert pins[canonical(it.name)] in it.specifier, it
    drake = next(it.specifier for it in wanted if it.name == "drake")
    assert pins["drake"] == ("1.51.1" if python == "3.11" else "1.58.0")
    assert "1.59.0" not in drake and "1.50.0" not in drake


FIRST_WITHOUT_HOLES = {
    "aiohttp": ("3.14.4", "PYSEC-2026-4371, and 40 before"),
    "distributed": ("2026.1.0", "CVE-2026-23528"),
    "lxml": ("6.1.0", "CVE-2026-41066"),
    "pillow": ("13.0.0", "CVE-2026-112403, and others before"),
    "playwright": ("1.55.1", "CVE-2025-59288"),
    "pyarrow": ("23.0.1", "CVE-2026-25087"),
    "pyqt6": ("6.10.1", "CVE-2025-12385, in the Qt of its wheels"),
    "pyqt6-webengine": ("6.10.1", "the Chromium of its wheels"),
    "pytest": ("9.0.3", "CVE-2025-71176"),
    "tqdm": ("4.66.3", "CVE-2024-34062"),
}
"""First releases without a vulnerability that was published by November 2026, and the last one of
that package."""


def test_no_requirement_admits_a_release_with_a_known_hole():
    wanted = requirements()
    for it in wanted:
        first, hole = FIRST_WITHOUT_HOLES.get(canonical(it.name), ("0", ""))
        least = [Version(each.version) for each in it.specifier if each.operator in (">=", "==")]
        assert least and max(least) >= Version(first), f"{it} admits {hole}"
    assert FIRST_WITHOUT_HOLES.keys() <= {canonical(it.name) for it in wanted}


def requirements() -> list[Requirement]:
    """Return all that the project and its extras require, but the project itself."""
    extras = PROJECT["optional-dependencies"].values()
    every = [Requirement(it) for it in sum(extras, PROJECT["dependencies"])]
    return [it for it in every if it.name != PROJECT["name"]]


MAX_DIRECT_DEPENDENCIES = 12
"""Without extras, as servers and CI install it."""
IMPORTED_WITH_EXTRAS = {
    "app": ("gui", "extras/flightdata/cards"),
    "sweep": ("design/rollout", "common/code_cache"),
    "web": ("link/qr", "link/server/web", "link/server/web_socket"),
    "ros2": ("extras/gateways/ros2",),
    "mavlink": ("extras/gateways/mavlink",),
    "dev": ("pytest_plugin",),
}
"""Modules, by the beginning of their paths, that are imported only where an extra is asked for."""


def test_without_extras_few_packages_are_required():
    assert len(PROJECT["dependencies"]) <= MAX_DIRECT_DEPENDENCIES


MAX_SET_UP_MIB = 1085
"""Size limit of the files that `make setup` installs, with pip; `du` counts 40 more, of folders.
With Python 3.13 they have 1036, with 3.11, whose wheels of Drake and scipy are larger, 1063."""


def test_set_up_makes_a_small_environment():
    """By the sizes in the packages' own lists of files, without what Python compiles later."""
    sizes = {
        name: sum(it.size or 0 for it in metadata.files(name) or () if it.suffix != ".pyc")
        for name in required_with("dev") | {"pip"}
    }
    total = sum(sizes.values()) / 2**20
    assert total <= MAX_SET_UP_MIB, sorted(sizes.items(), key=lambda it: -it[1])[:9]


def test_the_app_differs_from_what_set_up_makes_by_the_web_engine():
    app, dev = (PROJECT["optional-dependencies"][extra] for extra in ("app", "dev"))
    only = {canonical(Requirement(line).name) for line in set(app) - set(dev)}
    assert only == {"pyqt6-webengine"}


OWN = sys.stdlib_module_names | {"workbench"}
"""Modules that need no package of others."""


def test_what_the_core_imports_comes_without_extras(case):
    """At a module's top level, as functions say what an extra brings before they import it."""
    always = required_with("")
    brought = {extra: required_with(extra) for extra in IMPORTED_WITH_EXTRAS}
    packages_of = metadata.packages_distributions()

    def is_allowed(name: str, allowed: set[str]) -> bool:
        return bool({canonical(it) for it in packages_of.get(name, ())} & allowed)

    for path in sorted((ROOT / "workbench").rglob("*.py")):
        file = path.relative_to(ROOT / "workbench").with_suffix("").as_posix()
        extras = [it for it, places in IMPORTED_WITH_EXTRAS.items() if file.startswith(places)]
        allowed = always.union(*(brought[extra] for extra in extras))
        source = path.read_text()
        seen = set(re.findall(r"^(?:from|import) (\w+)", source, re.MULTILINE))
        if all(is_allowed(name, allowed) for name in seen - OWN):
            continue  # parsing takes longer, and is for what only looks like an import
        for name in top_level_imports(ast.parse(source)):
            with case(f"{file} imports {name}"):
                assert is_allowed(name, allowed)


def top_level_imports(tree: ast.Module) -> set[str]:
    """Return the packages of others that a module imports when it is imported."""
    names: set[str] = set()
    for node in tree.body:
        if isinstance(node, ast.Import):
            names |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom):
            names.add(node.module or "")
    tops = {name.partition(".")[0] for name in names}
    return tops - OWN
