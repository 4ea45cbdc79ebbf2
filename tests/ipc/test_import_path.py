"""Which modules a process of the workbench imports: its own, not what lies about."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

from workbench.common.import_path import own_packages_first

WORKBENCH = str(Path(sys.executable).with_name("workbench"))
POOL = """
from workbench.design.executor.executor import LocalProcesses, Task

if __name__ == "__main__":
    print(list(LocalProcesses(1).run([Task(None, str)])))
"""


def output(*command, cwd, **variables):
    """Return what a command prints, on both streams; it must succeed."""
    done = subprocess.run(
        [*map(str, command)], cwd=cwd, env=os.environ | variables, capture_output=True, text=True
    )
    assert done.returncode == 0, done.stderr
    return done.stdout + done.stderr


@pytest.fixture
def folder(tmp_path):
    """A folder with files that have the names of modules, and end whatever imports them."""
    folder = tmp_path / "mine"
    folder.mkdir()
    for name in ("signal", "struct", "math", "json", "random", "numpy", "xacro"):
        (folder / f"{name}.py").write_text(f"raise SystemExit('imported {name}.py')\n")
    return folder


def test_a_command_in_a_folder_with_names_of_modules(folder, tmp_path):
    """The cache is empty, so a process expands the xacro file."""
    said = output(WORKBENCH, "inspect", "dh_drone", cwd=folder, XDG_CACHE_HOME=str(tmp_path))
    assert "imported" not in said
    assert "rotors" in said
    assert "workbench" in output(sys.executable, "-m", "workbench", "--version", cwd=folder)


def test_processes_of_a_pool_in_such_a_folder(folder, tmp_path):
    script = tmp_path / "script.py"
    script.write_text(POOL)
    (folder / "types.py").write_text("raise SystemExit('imported types.py')\n")
    assert output(sys.executable, script, cwd=folder) == "[(0, 'None')]\n"


def test_packages_of_a_sourced_ros_come_after_the_own_ones(folder, tmp_path):
    """As its xacro: PYTHONPATH comes before the packages of an environment."""
    ros = tmp_path / "ros"
    ros.mkdir()
    (folder / "xacro.py").rename(ros / "xacro.py")
    variables = {"PYTHONPATH": str(ros), "XDG_CACHE_HOME": str(tmp_path)}
    assert "imported" not in output(WORKBENCH, "inspect", "dh_drone", cwd=tmp_path, **variables)


def test_what_pythonpath_alone_has_is_found(tmp_path, monkeypatch):
    """As a control law in a package of the user's."""
    monkeypatch.setenv("PYTHONPATH", f"{tmp_path}{os.pathsep}")
    monkeypatch.setattr(sys, "path", [str(tmp_path), "/usr/lib/python", "/env/site-packages"])
    own_packages_first()
    assert sys.path == ["/usr/lib/python", "/env/site-packages", str(tmp_path)]
    monkeypatch.delenv("PYTHONPATH")
    own_packages_first()
    assert sys.path[-1] == str(tmp_path)


def test_the_checkout_that_runs_keeps_its_place(monkeypatch):
    """Its processes would import the workbench of the environment."""
    import workbench

    root = str(Path(workbench.__file__).resolve().parents[1])
    monkeypatch.setenv("PYTHONPATH", root)
    monkeypatch.setattr(sys, "path", [root, "/env/site-packages"])
    own_packages_first()
    assert sys.path == [root, "/env/site-packages"]


def test_specs_run_with_the_plugins_of_a_sourced_ros(tmp_path):
    """They are found by their metadata on PYTHONPATH, and import what this environment lacks."""
    ros = tmp_path / "ros"
    (ros / "launch_testing-1.dist-info").mkdir(parents=True)
    (ros / "launch_testing-1.dist-info" / "METADATA").write_text("Name: launch-testing\n")
    (ros / "launch_testing-1.dist-info" / "entry_points.txt").write_text("[pytest11]\nros = ros\n")
    (ros / "ros.py").write_text("raise ImportError('lark is missing')\n")
    (tmp_path / "any.workbench.yaml").write_text("cases: [{name: up, axis: z, amplitude: 1.0}]\n")
    pytest_command = [sys.executable, "-m", "pytest", "-q", "--collect-only", "any.workbench.yaml"]
    with pytest.raises(AssertionError, match="lark is missing"):
        output(*pytest_command, cwd=tmp_path, PYTHONPATH=str(ros))
    said = output(
        *pytest_command,
        *("-p", "workbench.pytest_plugin"),
        cwd=tmp_path,
        PYTHONPATH=str(ros),
        PYTEST_DISABLE_PLUGIN_AUTOLOAD="1",
    )
    assert "any.workbench.yaml::up" in said
