"""The core alone: without `workbench/extras` it works, and names the package of what it lacks."""

import json
import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from tests.test_extensions import COMMANDS

ROOT = Path(__file__).parent.parent
CHILDREN = ("worker", "child", "entry", "drawer", "process", "__main__")
"""Ends of the names of modules that are programs: they begin to work when they are imported."""

LACKING = [
    (
        ["inspect", "a.sdf"],
        "looks like SDF (<sdf>), which the package workbench.extras.formats reads",
    ),
    (
        ["inspect", "a.xml"],
        "looks like MJCF (<mujoco>), which the package workbench.extras.formats",
    ),
    (
        ["step", "--controller", "px4"],
        "the law 'px4' is in workbench.extras.autopilots.laws.px4 of",
    ),
    (["log", "a.ulg"], "is in workbench.extras.flightdata.log_readers of the package"),
    (["gateway", "foxglove"], "the command 'gateway' is in workbench.extras.gateways.command of"),
    (
        ["gains", "import", "a.params"],
        "workbench.extras.autopilots.gain_files.firmware of the package",
    ),
]


@pytest.fixture(scope="module")
def core(tmp_path_factory):
    """Return a folder with the project's core alone."""
    folder = tmp_path_factory.mktemp("core")
    shutil.copytree(
        ROOT / "workbench",
        folder / "workbench",
        ignore=lambda path, _: {"extras", "__pycache__"} if path == str(ROOT / "workbench") else (),
    )
    for name in ("models", "docs"):
        (folder / name).symlink_to(ROOT / name)
    (folder / "a.sdf").write_text(
        '<sdf version="1.9"><model name="a"><link name="b"/></model></sdf>'
    )
    (folder / "a.xml").write_text('<mujoco model="a"><worldbody/></mujoco>')
    (folder / "a.ulg").write_bytes(b"ULog\x01\x12\x35\x01")
    (folder / "a.params").write_text("1\t1\tMC_ROLL_P\t6.5\t9\n")
    return folder


def run(core, *words):
    there = os.environ | {"PYTHONPATH": str(core), "QT_QPA_PLATFORM": "offscreen"}
    return subprocess.run(
        [sys.executable, *words], cwd=core, env=there, capture_output=True, text=True, timeout=300.0
    )


def test_all_of_it_can_be_imported(core):
    package = core / "workbench"
    paths = [path.relative_to(core).with_suffix("") for path in package.rglob("*.py")]
    names = [".".join(path.parts).removesuffix(".__init__") for path in paths]
    wanted = sorted(name for name in names if not name.endswith(CHILDREN))
    code = f"import importlib\nfor name in {wanted!r}:\n    importlib.import_module(name)"
    done = run(core, "-c", code)
    assert done.returncode == 0, done.stderr[-2000:]
    assert len(wanted) > 600


def test_help_lists_what_is_there(core):
    done = run(core, "-m", "workbench", "--help")
    assert done.returncode == 0, done.stderr
    assert "linearize" in done.stdout and "gateway" not in done.stdout.split("example:")[0]


def test_what_it_lacks_is_a_sentence_that_names_the_package(core, case):
    done = run(core, "-c", COMMANDS, json.dumps([words for words, _ in LACKING]))
    assert done.returncode == 0, done.stderr
    for (words, said), (code, _, error) in zip(LACKING, json.loads(done.stdout), strict=True):
        with case(*words):
            assert code == 2
            assert said in error and "Traceback" not in error


def test_it_flies(core):
    done = run(core, "-m", "workbench", "step", "--axis", "z", "--duration", "0.5", "--no-plots")
    assert done.returncode == 0, done.stderr
