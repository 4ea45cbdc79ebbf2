"""Logs of ours, flown again: as the log with its own gains, as the diagram flies with others."""

import numpy as np
import pytest

from workbench.analysis.questions import FlyAgain
from workbench.commands.cli import main
from workbench.common.errors import WorkbenchError
from workbench.scenario.scenario import load_scenario
from workbench.session.session import Session

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
