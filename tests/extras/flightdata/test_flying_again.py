"""Logs of ours, flown again: as the log with its own gains, as the diagram flies with others."""

import numpy as np
import pytest

from workbench.commands.cli import main
from workbench.common.errors import WorkbenchError
from workbench.extras.flightdata.flying_again_question import FlyAgain
from workbench.scenario.scenario_file import load_scenario
from workbench.session.session import Session

pytestmark = pytest.mark.usefixtures("unheld")

SCENARIO = """
script:
  - {at: 0.2, go_to: [0.6, 0.0, 1.5]}
  - {at: 1.5, go_to: [0.6, 0.6, 1.8]}
duration: 3.0
"""
SOFTER = {"kp_velocity_x": 2.0, "kp_velocity_y": 2.0}


@pytest.fixture(scope="module")
def flown(tmp_path_factory):
    """A scenario's file, and the log of its flight."""
    folder = tmp_path_factory.mktemp("flown")
    scenario, log = folder / "points.yaml", folder / "points.mcap"
    scenario.write_text(SCENARIO)
    assert (
        main(["fly", str(scenario), "--log", str(log), "--no-plots", "--output", str(folder)]) == 0
    )
    return scenario, log


def test_the_log_itself_and_then_what_the_diagram_flies(answer, flown):
    scenario, log = flown
    itself = answer(FlyAgain(log, {}, draws=0))
    assert itself.flown == "pd" and itself.vehicle == itself.logged_vehicle
    assert np.abs(itself.other - itself.logged)[:, :3].max() < 1e-3
    found = answer(FlyAgain(log, SOFTER, draws=4))
    assert np.array_equal(found.logged, itself.logged)
    session, positions = Session(load_scenario(scenario), SOFTER), []
    for time in found.time:
        session.tick(time - session.time)
        positions.append(session.state()[4:7].copy())
    changed = np.abs(np.array(positions) - found.logged[:, :3]).max()
    assert changed > 0.05
    assert np.abs(np.array(positions) - found.other[:, :3]).max() < 0.05 * changed
    assert found.drawn == 5 and found.stays and np.all(found.high >= found.low)
    assert found.off_setpoint[1, 0] != itself.off_setpoint[1, 0]


def test_what_cannot_be_flown_again_is_a_sentence(answer, flown, tmp_path, case):
    _, log = flown
    bench = tmp_path / "bench.csv"
    names = "t,px,py,pz,qx,qy,qz,qw,roll,pitch,yaw,vx,vy,vz"
    rows = "\n".join(f"{0.01 * k:.2f},0,0,0,0,0,0,1,0,0,0,0,0,0" for k in range(100))
    bench.write_text(f"{names}\n{rows}\n")
    mine = tmp_path / "mine.csv"
    mine.write_text("t,vbat\n0.0,11.1\n0.1,11.0\n0.2,11.0\n")
    mine.with_name("mine.mapping.yaml").write_text(
        "time: {column: t, unit: s}\ncolumns: {vbat: {signal: battery.voltage, unit: V}}\n"
    )
    for said, question in (
        ("cannot be read", FlyAgain(tmp_path / "none.mcap", {})),
        ("does not say which controller flew", FlyAgain(mine, {})),
        ("the motors' commands", FlyAgain(bench, {})),
        ("nothing_like_it", FlyAgain(log, {}, controller="nothing_like_it")),
    ):
        with case(said), pytest.raises(WorkbenchError, match=said):
            answer(question)


STEERED = """
script:
  - {at: 0.2, velocity: [1.0, 0.0, 0.0]}
  - {at: 0.5, set: {wind_y: 1.0}}
  - {at: 1.5, velocity: [0.0, 0.0, 0.5], yaw_rate: 0.1}
duration: 2.5
"""


@pytest.fixture(scope="module")
def steered(tmp_path_factory):
    """A scenario's file with velocities, and the log of its flight."""
    folder = tmp_path_factory.mktemp("steered")
    scenario, log = folder / "steered.yaml", folder / "steered.mcap"
    scenario.write_text(STEERED)
    words = ("--log", str(log), "--no-plots", "--output", str(folder))
    assert main(["fly", str(scenario), *words]) == 0
    return scenario, log


def test_a_recording_that_was_steered_is_flown_again_as_its_scenario(answer, steered):
    """Equal with its own gains; with others as a session flies its script, wind included."""
    scenario, log = steered
    itself = answer(FlyAgain(log, {}, draws=0))
    assert np.abs(itself.other - itself.logged).max() < 1e-12  # rounding of the interpolation
    assert not itself.has_band and itself.stays and not itself.doubt
    found = answer(FlyAgain(log, SOFTER, draws=0))
    assert np.array_equal(found.logged, itself.logged)
    session = Session(load_scenario(scenario), SOFTER)
    session.run()
    flown = session.recording()
    other = np.column_stack([np.interp(found.time, flown.time, x) for x in flown.p_WB.T])
    assert np.abs(other - found.other[:, :3]).max() < 1e-9
    assert np.abs(found.other - found.logged)[:, :3].max() > 0.05
    assert found.flown_gains["kp_velocity_x"] != SOFTER["kp_velocity_x"]


@pytest.mark.slow
def test_another_law_flies_a_recording_that_was_steered(answer, steered):
    px4 = answer(FlyAgain(steered[1], {}, controller="px4", draws=0))
    assert px4.flown == "pd" and px4.stays
    assert 0.01 < np.abs(px4.other - px4.logged)[:, :3].max() < 1.0
