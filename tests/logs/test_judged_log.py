"""Logs judged by specs: as the flights that they are of, and honest where they do not tell."""

import json
from pathlib import Path

import numpy as np
import pytest
import yaml

from tests.logs.conftest import fly, write_log
from workbench.common.errors import WorkbenchError
from workbench.design.regress.flight import Changes, case_scenario, changed_scenario
from workbench.design.regress.loading import load_spec
from workbench.design.regress.running import regress
from workbench.design.response_metrics import noise_rms, response_lag
from workbench.logs.judged_log import read_case
from workbench.session.session import Session
from workbench.setup import make_setup

pytestmark = pytest.mark.usefixtures("unheld")

TELEMETRY = 1 / 128
"""Between two samples of the state in a log of ours [s]."""
STEPS = {
    "rise_time": 2 * TELEMETRY,
    "settling_time": 2 * TELEMETRY,
    "peak_time": 2 * TELEMETRY,
    "t90": 2 * TELEMETRY,
    "overshoot": 0.05,
    "peak": 2e-3,
    "steady_state_value": 2e-3,
    "steady_state_error": 0.1,
    "mean_acceleration": 0.1,
    "tracking_error": 0.02,
    "lag": 2 * TELEMETRY,
    "coupling_y": 1e-3,
    "coupling_z": 1e-3,
    "coupling_yaw": 1e-3,
    "peak_rotor_use": 5e-3,
    "mean_rotor_use": 2e-3,
    "trim": 2e-3,
    "peak_tilt": 3e-3,
    "peak_speed": 2e-3,
    "hover_thrust": 5e-3,
    "hover_rotor_speed": 0.05,
    "hover_rotor_spread": 0.05,
    "mean of p_x": 5e-3,
    "maximum of pitch": 3e-3,
}
"""Metrics of a step, and how far a log may be off: its samples are coarser than the control's, and
come later than the edge by one of them at most; so times are off by two, and a signal by what it
moves in that time at its extremes, where it stands."""


def write_spec(folder: Path, *cases: dict, name: str = "ours.workbench.yaml", **head) -> Path:
    """Write a spec, and return its file."""
    path = folder / name
    path.write_text(
        yaml.safe_dump(json.loads(json.dumps({**head, "cases": cases})), sort_keys=False),
        encoding="utf-8",
    )
    return path


def values_of(path: Path) -> dict[str, float]:
    """Return the measured values of a spec's only case."""
    (result,) = regress([path], read_log=read_case)
    assert not result.trouble
    return {check.name: check.value for check in result.checks}


@pytest.fixture(scope="module")
def step(tmp_path_factory) -> Path:
    """Return a folder with a step as spec, its log and its table of states."""
    folder = tmp_path_factory.mktemp("step")
    limits = {name: {"max": 1e9} for name in STEPS}
    case = {"name": "x", "axis": "x", "amplitude": 2.0, "duration": 2.5, "limits": limits}
    spec = load_spec(write_spec(folder, case, name="flown.workbench.yaml"))
    scenario = case_scenario(spec.content.cases[0], make_setup(changed_scenario(spec, Changes())))
    write_log(fly(scenario, [], {}), folder / "flight.mcap")
    session = Session(scenario)
    session.run()
    session.recording().write_csv(folder / "flight.csv")
    return folder


@pytest.mark.slow
def test_a_log_gives_the_metrics_of_the_flight_that_it_is_of(case, step):
    check_metrics(case, step, "flight.mcap", 1.0)


def check_metrics(case, step, file, share):
    """Check the metrics of a log of the step, within a share of what they may be off."""
    flown = values_of(step / "flown.workbench.yaml")
    limits = {name: {"max": 1e9} for name in STEPS}
    log = {"file": file, "span": [1.0, 3.5]}
    logged = values_of(write_spec(step, {"name": "x", "log": log, "loop": "v_x", "limits": limits}))
    for name, slack in STEPS.items():
        with case(name):
            assert logged[name] == pytest.approx(flown[name], abs=share * slack, rel=1e-9)


def test_tracking_lag_and_noise_are_those_of_closed_forms():
    time = np.arange(0.0, 20.0, 1e-3)
    asked = np.sin(time) + 0.5 * np.sin(2.3 * time)
    late = np.interp(time - 0.123, time, asked)
    assert response_lag(time, asked, 0.9 * late + 0.2, np.arange(0.0, 0.5, 1e-3)) == pytest.approx(
        0.123
    )
    buzz = 0.3 * np.sin(2.0 * np.pi * 90.0 * time)
    assert noise_rms(time, asked + buzz) == pytest.approx(0.3 / np.sqrt(2.0), rel=1e-3)
    white = 0.2 * np.random.default_rng(0).standard_normal(len(time))
    # 480 of the 500 Hz are faster than 20 Hz
    assert noise_rms(time, asked + white) == pytest.approx(0.2 * np.sqrt(0.96), rel=0.02)
    assert noise_rms(time, asked) < 1e-4
    slow = np.arange(0.0, 20.0, 0.03)
    assert np.isnan(noise_rms(slow, np.sin(slow)))


def test_what_our_own_log_cannot_give_is_a_sentence(case, log, tmp_path):
    for changed, said in (
        ({"log": {"file": str(log), "span": [9, 12]}}, "lasts from 0 to"),
        ({"log": {"file": str(log), "number": 2}}, "has one log: --log-number 2"),
        ({"log": str(log), "loop": "roll_rate"}, "has no rate_setpoint.w_x"),
    ):
        limits = {"peak_tilt": {"max": 1.0}}
        spec = write_spec(tmp_path, {"name": "one", "limits": limits, **changed})
        with case(said), pytest.raises(WorkbenchError, match=said):
            regress([spec], read_log=read_case)
