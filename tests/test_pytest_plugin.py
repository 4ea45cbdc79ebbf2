"""The pytest plugin, in runs of pytest of its own."""

import subprocess
import sys
from importlib.metadata import entry_points
from pathlib import Path

import pytest
from _pytest.pytester import SysModulesSnapshot

from workbench.common.resources import controllers_dir

pytest_plugins = ["pytester"]

ROOT = Path(__file__).parent.parent
PLUGIN = ("-p", "workbench.pytest_plugin")
DRONE = ROOT / "tests" / "drones" / "palm_quad.urdf.xacro"

GOOD = """\
cases:
  - {name: hop, axis: z, amplitude: 0.5, duration: 0.5, limits: {peak: [0.2, 0.7]},
     baseline: {v_z: {absolute: 0.001}}}
  - {name: turn, axis: yaw, amplitude: 0.1, duration: 0.5, limits: {peak: {max: 0.2}}}
"""
BAD = """\
cases:
  - {name: too strict, axis: z, amplitude: 0.5, duration: 0.5, limits: {peak: {max: 0.1}}}
"""


@pytest.fixture(autouse=True)
def imported(monkeypatch):
    """Keep what runs within this process import: Drake cannot be loaded twice, nor can classes."""
    monkeypatch.setattr(SysModulesSnapshot, "restore", lambda self: None)


@pytest.fixture
def plugin() -> tuple[str, ...]:
    """Return what loads the plugin where it is not installed with its entry point."""
    installed = any(point.name == "workbench" for point in entry_points(group="pytest11"))
    return () if installed else PLUGIN


def test_the_plugin_is_light():
    code = "import sys, workbench.pytest_plugin; print(*{n.split('.')[0] for n in sys.modules})"
    done = subprocess.run(
        [sys.executable, "-c", code], cwd=ROOT, capture_output=True, text=True, check=True
    )
    assert not {"pydrake", "matplotlib", "numpy", "scipy", "control"} & set(done.stdout.split())


def test_collecting_specs_loads_no_drake(pytester, plugin):
    pytester.makefile(".workbench.yaml", one=GOOD)
    code = (
        "import sys, pytest\n"
        f"code = pytest.main(['--collect-only', '-q', *{list(plugin)!r}])\n"
        "print('loaded', *{n.split('.')[0] for n in sys.modules})\n"
        "sys.exit(code)\n"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True)
    assert done.returncode == 0, done.stdout + done.stderr
    assert "one.workbench.yaml::hop" in done.stdout
    assert not {"pydrake", "matplotlib"} & set(done.stdout.split("loaded")[1].split())


@pytest.mark.slow
def test_cases_become_items_that_pass_once_recorded(pytester, plugin):
    pytester.makefile(".workbench.yaml", one=GOOD)
    missing = pytester.runpytest_inprocess(*plugin, "-q")
    missing.assert_outcomes(passed=1, failed=1)
    missing.stdout.fnmatch_lines(["*v_z has no baseline yet*--update*"])
    pytester.runpytest_inprocess(*plugin, "--workbench-update").assert_outcomes(passed=2)
    assert {path.name for path in (pytester.path / "one.baseline").iterdir()} == {
        "flown-with.csv",
        "hop.csv",
    }
    pytester.runpytest_inprocess(*plugin, "-v").assert_outcomes(passed=2)


def test_a_failure_is_a_sentence_and_no_traceback(pytester, plugin):
    pytester.makefile(".workbench.yaml", two=BAD)
    done = pytester.runpytest_inprocess(*plugin)
    done.assert_outcomes(failed=1)
    done.stdout.fnmatch_lines(
        [
            "*two.workbench.yaml: too strict*",
            "peak is 0.* m/s, and should be at most 0.1 m/s: 0.* above",
        ]
    )
    assert "Traceback" not in done.stdout.str()
    assert "RegressionError" not in done.stdout.str().split("short test summary")[0]


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("cases: 3\n", "*cases should be a list*"),
        ("cases: [{axis: z}]\n", "*s.workbench.yaml:1: a case needs a name*"),
        ("cases: [\n", "*s.workbench.yaml:*not YAML*"),
    ],
)
def test_a_spec_that_cannot_be_collected_says_where(pytester, plugin, text, said):
    pytester.makefile(".workbench.yaml", s=text)
    done = pytester.runpytest_inprocess(*plugin)
    done.assert_outcomes(errors=1)
    done.stdout.fnmatch_lines([said])
    assert "Traceback" not in done.stdout.str()


def test_a_spec_with_an_unknown_metric_fails_with_file_and_line(pytester, plugin):
    text = "cases:\n  - {name: a, axis: z, amplitude: 1,\n     limits: {risetime: {max: 1}}}\n"
    pytester.makefile(".workbench.yaml", s=text)
    done = pytester.runpytest_inprocess(*plugin)
    done.assert_outcomes(failed=1)
    done.stdout.fnmatch_lines(["*s.workbench.yaml:3: unknown metric 'risetime'*'rise_time'*"])


def test_another_pattern_of_names(pytester, plugin):
    pytester.makeini("[pytest]\nworkbench_spec_files = flight_*.yaml\n")
    (pytester.path / "flight_one.yaml").write_text(BAD.replace("0.1}", "1.0}"))
    (pytester.path / "other.workbench.yaml").write_text(BAD)
    pytester.runpytest_inprocess(*plugin).assert_outcomes(passed=1)


def test_an_older_name_is_collected_too(pytester, plugin):
    pytester.makefile(".spec.yaml", one=BAD.replace("0.1}", "1.0}"))
    pytester.runpytest_inprocess(*plugin).assert_outcomes(passed=1)


def test_pytest_regressions_may_have_the_same_option(pytester, plugin):
    """It is not installed with us, so a module in its place states its option."""
    theirs = "def pytest_addoption(parser):\n    parser.addoption('--force-regen', default=False, "
    pytester.makepyfile(pytest_regressions=f"{theirs}action='store_true')\n")
    pytester.syspathinsert()
    (pytester.path / "one.workbench.yaml").write_text(GOOD)
    done = pytester.runpytest_inprocess(
        *plugin, "-p", "pytest_regressions", "--force-regen", "-k", "hop"
    )
    done.assert_outcomes(passed=1)
    assert (pytester.path / "one.baseline" / "hop.csv").is_file()


@pytest.mark.slow
def test_in_parallel_and_with_a_model_beside_the_spec(pytester, plugin):
    """As in a repository of one's own: a model, two specs, a hand-written test."""
    for name in (DRONE.name, "parts.xacro"):
        (pytester.path / name).write_text((DRONE.parent / name).read_text())
    vehicle = f"vehicle: {{model: {DRONE.name}}}\n"
    pytester.makefile(".workbench.yaml", one=vehicle + GOOD, two=vehicle + GOOD)
    pytester.makepyfile(
        """
        def test_rise(step_response):
            step = step_response("z", 0.5, duration=0.5)
            assert step_response("z", 0.5, duration=0.5) is step
            assert step_response("z", 0.4, duration=0.5) is not step
            assert step.metrics.peak > 0.2
        """
    )
    workers = ("-p", "xdist", "-n", "2")
    updated = pytester.runpytest_subprocess(*plugin, *workers, "--workbench-update")
    updated.assert_outcomes(passed=5)
    pytester.runpytest_subprocess(*plugin, *workers).assert_outcomes(passed=5)
    kept = (pytester.path / "one.baseline" / "flown-with.csv").read_text()
    assert "mass,0.0" in kept


@pytest.mark.slow
def test_a_controller_of_the_repository_runs_as_its_conftest_does(pytester, plugin):
    """One from elsewhere does not."""
    law = (controllers_dir() / "pd.py").read_text(encoding="utf-8")
    elsewhere = pytester.path.parent / f"{pytester.path.name}-other"
    elsewhere.mkdir()
    for folder in (pytester.path, elsewhere):
        (folder / "law.py").write_text(law, encoding="utf-8")
    hop = "{name: hop, axis: z, amplitude: 0.5, duration: 0.5, limits: {peak: {max: 1}}}"
    pytester.makefile(
        ".workbench.yaml",
        near=f"controller: law.py\ncases: [{hop}]\n",
        far=f"controller: {elsewhere / 'law.py'}\ncases: [{hop}]\n",
    )
    pytester.makefile(".ini", pytest="[pytest]\n")
    done = pytester.runpytest_subprocess(*plugin)
    done.assert_outcomes(passed=1, failed=1)
    done.stdout.fnmatch_lines(["*far.workbench.yaml:1: *is Python code that would run here*"])
