"""What is shipped: the wheel, the sdist, and sources that name no machine."""

import os
import re
import shutil
import subprocess
import sys
import zipfile
from importlib.metadata import distribution
from pathlib import Path

import pytest

from tests.required import PROJECT, required_with

ROOT = Path(__file__).resolve().parent.parent

MAX_BARE_MB = 600
"""Size limit of an environment without extras, with Drake and pip [MiB]."""

# The brackets keep this file from finding itself.
FORBIDDEN = {
    "an option that names a package index": r"[i]ndex[-_]url|[f]ind[-_]links|[t]rusted[-_]host",
    "a registry's host": r"[p]ypi\.org|[p]ythonhosted\.org|[d]eb\.debian\.org"
    r"|[a]rchive\.ubuntu\.com|[r]egistry\.npmjs",
    "a path of one machine": r"(?<![\w.~])/([w]ork|[r]oot|[h]ome/\w+|[U]sers/\w+)/|[f]ile:///",
}


def run(*command, cwd=ROOT, **environment):
    """Return what a command printed; its failure is the test's."""
    done = subprocess.run(
        [str(part) for part in command],
        cwd=cwd,
        env=os.environ | {"PIP_NO_INDEX": "1"} | environment,
        capture_output=True,
        text=True,
    )
    assert done.returncode == 0, f"{command} failed:\n{done.stdout}{done.stderr}"
    return done.stdout


def build_wheel(source, folder):
    """Return the wheel made of a source tree or an sdist, without a network."""
    options = ("--no-deps", "--no-build-isolation", "--wheel-dir", folder)
    run(sys.executable, "-m", "pip", "wheel", *options, source)
    return next(folder.glob("*.whl"))


@pytest.fixture(scope="module")
def wheel(tmp_path_factory):
    return build_wheel(ROOT, tmp_path_factory.mktemp("wheel"))


@pytest.fixture(scope="module")
def installed(wheel, tmp_path_factory):
    """Return a folder with the installed wheel, away from the sources."""
    folder = tmp_path_factory.mktemp("installed")
    run(sys.executable, "-m", "pip", "install", "--no-deps", "--target", folder, wheel)
    return folder


@pytest.mark.slow
def test_wheel_holds_models_command_and_licence(wheel):
    with zipfile.ZipFile(wheel) as archive:
        names = archive.namelist()
        entry_points = next(name for name in names if name.endswith("/entry_points.txt"))
        assert "workbench = workbench.__main__:main" in archive.read(entry_points).decode()
    models = {path for path in (ROOT / "models").rglob("*") if path.is_file()}
    assert {f"workbench/{path.relative_to(ROOT)}" for path in models} <= set(names)
    pages = {f"workbench/docs/{path.name}" for path in (ROOT / "docs").glob("*.md")}
    assert pages <= set(names)  # the help in the app opens them
    assert "workbench/models/dh_drone/drone.urdf.xacro" in names
    assert any(name.endswith(".dist-info/licenses/LICENSE") for name in names)
    assert {name.split("/")[0].split("-")[0] for name in names} == {
        "workbench",
        "drake_drone_workbench",
    }


@pytest.mark.slow
def test_sdist_makes_the_same_wheel(wheel, tmp_path):
    run(sys.executable, "-m", "hatchling", "build", "--target", "sdist", "--directory", tmp_path)
    again = build_wheel(next(tmp_path.glob("*.tar.gz")), tmp_path)
    with zipfile.ZipFile(wheel) as one, zipfile.ZipFile(again) as other:
        assert sorted(one.namelist()) == sorted(other.namelist())


@pytest.mark.slow
@pytest.mark.parametrize("how", ["module", "script"])
def test_installed_command_runs_from_an_empty_folder(installed, tmp_path, how):
    command = (
        [sys.executable, "-m", "workbench"]
        if how == "module"
        else [sys.executable, installed / "bin" / "workbench"]
    )
    said = run(*command, "--help", cwd=tmp_path, PYTHONPATH=str(installed))
    assert "usage: workbench" in said


@pytest.mark.slow
def test_installed_package_finds_its_own_models(installed, tmp_path):
    code = "from workbench.common.resources import find_model; print(find_model('dh_drone'))"
    said = run(sys.executable, "-c", code, cwd=tmp_path, PYTHONPATH=str(installed))
    assert Path(said.strip()).is_relative_to(installed / "workbench" / "models")


@pytest.fixture(scope="module")
def bare(wheel, tmp_path_factory):
    """Return an environment with the wheel, and what it requires without extras.

    Packages are links to those of this environment, so that no network is needed.
    """
    folder = tmp_path_factory.mktemp("bare") / "venv"
    run(sys.executable, "-m", "venv", folder)
    run(folder / "bin" / "python", "-m", "pip", "install", "--no-deps", wheel)
    packages = next(folder.glob("lib/python*/site-packages"))
    for name in required_with("") - {PROJECT["name"]}:
        for path in distribution(name).files or ():
            top = path.parts[0]
            link = packages / top
            if top not in ("..", "__pycache__") and not link.exists():
                link.symlink_to(distribution(name).locate_file(top))
    run(folder / "bin" / "python", "-m", "pip", "check")
    return folder


@pytest.mark.slow
def test_without_extras_neither_qt_nor_a_compiler_is_installed(bare):
    code = "from importlib.util import find_spec; print(*(n for n in {} if find_spec(n)))"
    extras = (
        "PyQt6",
        "pyqtgraph",
        "numba",
        "llvmlite",
        "embreex",
        "websockets",
        "uvloop",
        "pytest",
    )
    assert run(bare / "bin" / "python", "-c", code.format(extras)).split() == []
    files = {
        Path(folder, name).resolve()
        for folder, _, names in os.walk(bare, followlinks=True)
        for name in names
    }
    used = sum(path.stat().st_blocks * 512 for path in files) / 2**20
    assert used < MAX_BARE_MB


@pytest.mark.slow
@pytest.mark.parametrize(
    "command",
    [
        "step --axis x --amplitude 1",
        "margins --loop pitch",
        "sweep kp_pitch=100..200:2 --axis x --full",
        "serve --duration 0.5 --port 0",  # with a lidar, by asyncio's own loop
    ],
    ids=lambda command: command.split()[0],
)
def test_without_extras_commands_run(bare, tmp_path, command):
    run(bare / "bin" / "workbench", *command.split(), cwd=tmp_path)


def test_no_file_names_a_registry_or_a_machine():
    found = [
        f"{path.relative_to(ROOT)}:{number}: names {what}: {match.group()}"
        for path in tracked_files()
        for number, line in enumerate(lines_of(path), start=1)
        for what, pattern in FORBIDDEN.items()
        if (match := re.search(pattern, line))
    ]
    assert not found, "\n" + "\n".join(found)


@pytest.mark.parametrize(
    "line",
    [
        "pip install --extra-index" + "-url x",
        "find" + "-links = x",
        "https://py" + "pi.org/simple",
        "open('/wo" + "rk/main/x')",
        "cd /ho" + "me/ada/drone",
        "fi" + "le:///tmp",
    ],
)
def test_forbidden_names_are_seen(line):
    assert any(re.search(pattern, line) for pattern in FORBIDDEN.values())


def tracked_files():
    """Return the files that git has or would take."""
    if shutil.which("git") is None or not (ROOT / ".git").exists():
        pytest.skip("only git knows which files belong to the project: run this in a git clone")
    names = run("git", "ls-files", "--cached", "--others", "--exclude-standard", "-z").split("\0")
    return [ROOT / name for name in names if name and (ROOT / name).is_file()]


def lines_of(path):
    """Return the lines of a text file, none of a binary one."""
    try:
        return path.read_text(encoding="utf-8").splitlines()
    except UnicodeDecodeError:
        return []
