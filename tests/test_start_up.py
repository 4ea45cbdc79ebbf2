"""What a command loads, as everything that it loads is waited for at every call."""

import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parent.parent
HEAVY = "numpy scipy pydrake numba llvmlite matplotlib control trimesh embreex PyQt6 yaml tqdm"
CODE = """
import sys
sys.path.insert(0, sys.argv.pop(1))
from workbench.commands.cli import main
try:
    code = main(sys.argv[1:])
except SystemExit as stopped:
    code = stopped.code
print("loaded:", code, *sys.modules)
"""


def loaded_by(folder, *command):
    """Return the exit code of a command in a fresh process, and the modules that it loaded."""
    done = subprocess.run(
        [sys.executable, "-c", CODE, str(ROOT), *command],
        cwd=folder,
        capture_output=True,
        text=True,
    )
    assert done.returncode == 0, done.stderr
    code, *modules = done.stdout.splitlines()[-1].removeprefix("loaded: ").split()
    return int(code), set(modules)


@pytest.mark.parametrize(
    "command",
    [
        ["--help"],
        ["step", "--help"],
        ["gui", "--help"],
    ],
    ids=" ".join,
)
def test_what_needs_no_package_loads_none(command, tmp_path):
    code, modules = loaded_by(tmp_path, *command)
    assert code == 0
    assert not modules & set(HEAVY.split())


def test_help_loads_nothing_slow_of_pythons_own(tmp_path):
    """Packages' versions come with a parser of e-mails, and that with sockets."""
    _, modules = loaded_by(tmp_path, "--help")
    assert not modules & {"importlib.metadata", "email", "socket", "logging", "difflib", "tempfile"}


@pytest.mark.parametrize(
    "option",
    [
        ["--nonsense"],
        ["--axis", "w"],
        ["--set", "kp_velocity_q"],
        ["--set", "kp_velocity_z=fast"],
        ["--vary", "mas=1"],
        ["--arg", "mass"],
    ],
    ids=" ".join,
)
def test_a_wrong_option_is_refused_without_any_package(option, tmp_path):
    code, modules = loaded_by(tmp_path, "step", *option)
    assert code == 2
    assert not modules & set(HEAVY.split())


@pytest.mark.parametrize(
    "option",
    [
        ["--set", "kp_velocity_q=1"],
        ["--set", "kp_velocity_z=1e9"],
        ["--amplitude", "0"],
        ["--duration", "-1"],
        ["--vary", "mass=-1"],
        ["--gains", "nowhere.yaml"],
        ["--rotors", "nowhere.yaml"],
        ["--model", "nowhere"],
        ["--world", "nowhere"],
    ],
    ids=" ".join,
)
def test_what_is_plainly_wrong_is_refused_without_drake(option, tmp_path):
    code, modules = loaded_by(tmp_path, "step", *option)
    assert code == 2
    assert not modules & {"pydrake", "numba", "scipy", "matplotlib"}


@pytest.fixture(scope="module")
def step_modules(tmp_path_factory):
    folder = tmp_path_factory.mktemp("step")
    code, modules = loaded_by(folder, "step", "--axis", "x", "--amplitude", "1", "--duration", "1")
    assert code == 0
    assert (folder / "out" / "step-x.png").is_file()
    return modules


def test_a_step_does_without(case, step_modules):
    """numba brings a little of scipy with it, whose BLAS it offers to what it compiles."""
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


def test_the_app_leaves_drake_to_other_processes():
    """The window is there before Drake would be, and no search holds the interpreter's lock."""
    code = (
        "import sys, importlib, workbench.gui.app; from workbench.gui.screen_table import SCREENS; "
        "[importlib.import_module(row.path) for row in SCREENS]; print(*sys.modules)"
    )
    done = subprocess.run([sys.executable, "-c", code], cwd=ROOT, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    heavy = {"pydrake", "numba", "scipy", "matplotlib", "control"}
    assert not heavy & set(done.stdout.split())


def test_the_first_screen_does_not_wait_for_the_charts():
    code = (
        "import sys, importlib, workbench.gui.main_window; "
        "from workbench.gui.screen_table import SCREENS; "
        "importlib.import_module(SCREENS[0].path); print(*sys.modules)"
    )
    done = subprocess.run([sys.executable, "-c", code], cwd=ROOT, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    assert "pyqtgraph" not in done.stdout.split()
