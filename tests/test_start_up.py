"""What a command loads, as everything that it loads is waited for at every call."""

import json
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parent.parent
HEAVY = "numpy scipy pydrake numba llvmlite matplotlib control trimesh embreex PyQt6 yaml tqdm"
CODE = """
import json, sys
sys.path.insert(0, sys.argv[1])
from workbench.commands.cli import main
codes = []
for command in json.loads(sys.argv[2]):
    try:
        codes.append(main(command))
    except SystemExit as stopped:
        codes.append(stopped.code)
print()
print(json.dumps([codes, [*sys.modules]]))
"""


def loaded_by(folder, *commands):
    """Return the exit codes of commands in a fresh process, and the modules that they loaded."""
    done = subprocess.run(
        [sys.executable, "-c", CODE, str(ROOT), json.dumps(commands)],
        cwd=folder,
        capture_output=True,
        text=True,
    )
    assert done.returncode == 0, done.stderr
    codes, modules = json.loads(done.stdout.splitlines()[-1])
    return codes, set(modules)


def test_what_needs_no_package_loads_none(tmp_path):
    codes, modules = loaded_by(tmp_path, ["--help"], ["step", "--help"], ["gui", "--help"])
    assert codes == [0, 0, 0]
    assert not modules & set(HEAVY.split())


def test_help_of_a_command_loads_nothing_slow_of_pythons_own(tmp_path):
    """Packages' entry points come with a parser of e-mails, and that with sockets: only help that
    lists the installed laws reads them."""
    _, modules = loaded_by(tmp_path, ["new", "--help"])
    assert not modules & {"importlib.metadata", "email", "socket", "logging", "difflib", "tempfile"}


def test_a_wrong_option_is_refused_without_any_package(tmp_path):
    codes, modules = loaded_by(
        tmp_path,
        ["step", "--nonsense"],
        ["step", "--axis", "w"],
        ["step", "--set", "kp_velocity_q"],
        ["step", "--set", "kp_velocity_z=fast"],
        ["step", "--vary", "mas=1"],
        ["step", "--arg", "mass"],
    )
    assert codes == 6 * [2]
    assert not modules & set(HEAVY.split())


def test_what_is_plainly_wrong_is_refused_without_drake(tmp_path):
    codes, modules = loaded_by(
        tmp_path,
        ["step", "--set", "kp_velocity_q=1"],
        ["step", "--set", "kp_velocity_z=1e9"],
        ["step", "--amplitude", "0"],
        ["step", "--duration", "-1"],
        ["step", "--vary", "mass=-1"],
        ["step", "--gains", "nowhere.yaml"],
        ["step", "--rotors", "nowhere.yaml"],
        ["step", "--model", "nowhere"],
        ["step", "--world", "nowhere"],
    )
    assert codes == 9 * [2]
    assert not modules & {"pydrake", "numba", "scipy", "matplotlib"}


@pytest.fixture(scope="module")
def step_modules(tmp_path_factory):
    folder = tmp_path_factory.mktemp("step")
    step = ["step", "--controller", "lqi", "--axis", "x", "--amplitude", "1", "--duration", "1"]
    codes, modules = loaded_by(folder, step)
    assert codes == [0]
    assert (folder / "out" / "step-x.png").is_file()
    return modules


def test_a_step_does_without(case, step_modules):
    """numba brings a little of scipy with it, whose BLAS it offers to what it compiles.

    The law is lqi, which designs its feedback before it flies.
    """
    for module in [
        "control",
        "embreex",
        "matplotlib.pyplot",
        "pydrake.all",
        "pymap3d",
        "PyQt6",
        "scipy.optimize",
        "scipy.signal",
        "scipy.spatial",
        "scipy.stats",
        "tqdm",
        "trimesh",
        "workbench.design.rollout.engine",
        "workbench.systems.casting.caster",
    ]:
        with case(module):
            assert module not in step_modules


def test_loading_the_session_does_not_look_through_the_stack():
    """Drake does so for each template that is filled; within nested imports that takes a second."""
    code = (
        "import inspect; inspect.stack = None; "
        "import workbench.session.session, workbench.diagram.core"
    )
    done = subprocess.run([sys.executable, "-c", code], cwd=ROOT, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr


def test_the_first_screen_waits_for_no_chart_and_the_app_for_no_drake():
    """The window is there before Drake would be, and no search holds the interpreter's lock."""
    code = (
        "import sys, importlib, workbench.gui.main_window\n"
        "from workbench.gui.screen_table import SCREEN_TABLE\n"
        "importlib.import_module(SCREEN_TABLE[0].path)\n"
        "print(*sys.modules)\n"
        "import workbench.gui.app\n"
        "[importlib.import_module(row.path) for row in SCREEN_TABLE]\n"
        "print(*sys.modules)\n"
    )
    done = subprocess.run([sys.executable, "-c", code], cwd=ROOT, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    first, all_screens = (set(line.split()) for line in done.stdout.splitlines())
    heavy = {"pydrake", "numba", "scipy", "matplotlib", "control"}
    charts = "workbench.gui.charts.strip_chart"
    assert not first & (heavy | {charts})
    assert charts in all_screens
    assert not all_screens & heavy
