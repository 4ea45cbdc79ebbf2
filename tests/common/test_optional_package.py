"""What needs a package that only an extra brings, where that is not installed."""

import re
import subprocess
import sys
import tomllib
from pathlib import Path

import pytest

from workbench import Scenario
from workbench.common.compiled import compile_cached
from workbench.common.optional_package import EXTRA_OF_PACKAGE, install_command
from workbench.design.flier import COMPILED, DIAGRAM, Flier

ROOT = Path(__file__).parents[2]


def test_each_package_is_in_the_extra_that_is_named():
    project = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
    for package, extra in EXTRA_OF_PACKAGE.items():
        lines = project["optional-dependencies"][extra]
        assert any(re.match(rf"{package}\b(?!-)", line) for line in lines), package


@pytest.mark.parametrize(
    ("package", "command"),
    [
        ("PyQt6", ["gui"]),
        ("numba", ["sweep", "kp_pitch=100..400:2"]),
        ("numba", ["tune"]),
        ("websockets", ["serve", "--web"]),
    ],
    ids=lambda it: it if isinstance(it, str) else it[0],
)
def test_a_command_names_what_to_install(package, command, tmp_path):
    code = (
        f"import sys; sys.modules[{package!r}] = None; "
        f"from workbench.commands.cli import main; sys.exit(main({command}))"
    )
    done = subprocess.run(
        [sys.executable, "-c", code], cwd=tmp_path, capture_output=True, text=True
    )
    last = done.stderr.splitlines()[-1]
    assert (done.returncode, done.stdout) == (2, "")
    assert f"need the package {package}: run `{install_command(package)}`" in last


def test_without_numba_a_function_runs_as_python_with_a_warning(monkeypatch, caplog):
    monkeypatch.setitem(sys.modules, "numba", None)
    run = compile_cached(lambda a, b: a + b, (), "sums")
    assert [run(1, 2), run("x", "y")] == [3, "xy"]
    assert [record.message for record in caplog.records] == [
        f"sums: without numba Python computes them, which is slow: run `{install_command('numba')}`"
    ]


def test_without_numba_the_diagram_flies_what_was_to_be_compiled(monkeypatch, caplog):
    monkeypatch.setitem(sys.modules, "numba", None)
    caplog.set_level("INFO", "workbench.flier")
    Flier(Scenario(duration=1.0), fly_on=COMPILED)
    assert f"{DIAGRAM} flies: numba is not installed" in caplog.text
    assert install_command("numba") in caplog.text
