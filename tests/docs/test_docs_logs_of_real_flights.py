"""What docs/logs-of-real-flights.md shows runs, on a CSV that its mapping describes."""

import re
import shlex
from pathlib import Path

import numpy as np
import pytest

from tests.logs.test_step_response import fly
from workbench.commands.cli import main
from workbench.logs.readers.units import find_unit
from workbench.logs.step_response import LOOPS

PAGE = (Path(__file__).parents[2] / "docs" / "logs-of-real-flights.md").read_text(encoding="utf-8")


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """Return a folder with the page's log and mapping."""
    path: Path = tmp_path_factory.mktemp("page")
    write_page_log(path)
    return path


def write_page_log(path: Path) -> None:
    """Write the page's log and mapping into a folder."""
    time, wanted, rate = fly()
    roll = np.cumsum(rate) * 0.5 * (time[1] - time[0])
    columns = {
        "t": 1000.0 * time,
        "gx": np.degrees(rate),
        "gy": 0.0 * time,
        "m1": np.full(len(time), 1500.0),
        "want": np.degrees(wanted),
        "vbat": np.full(len(time), 11500.0),
        "q0": np.cos(roll),
        "q1": np.sin(roll),
        "q2": 0.0 * time,
        "q3": 0.0 * time,
    }
    table = np.column_stack([*columns.values()])
    np.savetxt(path / "flight.csv", table, "%.9g", ",", header=",".join(columns), comments="")
    mapping = re.search(r"```yaml\n(.*?)```", PAGE, re.DOTALL)[1]
    (path / "flight.mapping.yaml").write_text(mapping, encoding="utf-8")


@pytest.mark.slow
def test_the_commands_run(folder, monkeypatch, capsys):
    monkeypatch.chdir(folder)
    for line in re.search(r"```sh\n(.*?)```", PAGE, re.DOTALL)[1].splitlines():
        assert main(shlex.split(line.split("#")[0])[1:]) == 0, line
    said = capsys.readouterr().out
    assert "step responses: roll_rate" in said and "roll_rate: rate_setpoint.w_x" in said
    for name in ("out/flight.png", "rate.png", "spectrum.png", "step.png", "both.png"):
        assert Path(name).stat().st_size > 10_000
    assert Path("tables/imu.csv").is_file()
    assert "Meshcat" in Path("flight.html").read_text(encoding="utf-8")


@pytest.mark.slow
def test_the_road_from_a_log_to_gains_runs(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    for line in re.search(r"```sh\n# road\n(.*?)```", PAGE, re.DOTALL)[1].splitlines():
        assert main(shlex.split(line.split("#")[0])[1:]) == 0, line
    assert "by the intervals in flown.rotors.yaml" in capsys.readouterr().err
    assert "\tMC_ROLLRATE_P\t" in Path("drone.params").read_text(encoding="utf-8")


def test_the_python_runs(folder, monkeypatch, capsys):
    monkeypatch.chdir(folder)
    (code,) = re.findall(r"```python\n(.*?)```", PAGE, re.DOTALL)
    exec(compile(code, "logs-of-real-flights.md", "exec"), {"__name__": "__main__"})
    assert capsys.readouterr().out.splitlines() == [
        "200 Hz, 0 gaps",
        "(6000, 2) 1.00 of it known",
        "True 0.156 s",
    ]


def test_the_page_names_units_and_loops():
    units = re.search(r"and their products: (.*?)\. There are also (.*?), and `g`", PAGE, re.DOTALL)
    for unit in [*re.findall(r"`(.*?)`", units[1]), *re.findall(r"\w+", units[2]), "g"]:
        find_unit("1" if unit == "and" else unit)
    assert all(f"`{name}`" in PAGE for name in ("roll_rate", "roll", "v_x", "x") if name in LOOPS)
