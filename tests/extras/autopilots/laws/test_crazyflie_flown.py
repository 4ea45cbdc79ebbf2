"""The Crazyflie's laws beside real flights of a Crazyflie, on the setpoints that were logged.

The flights are those of NanoBench (Ullah and Baca, arXiv:2603.09908), with motion capture. What
flies is `crazyflie.urdf`, 44 g on the firmware's own thrust curve. The baseline is the setpoint
itself, late by 0.53 s, the median lag of all flights.
"""

import csv
import gzip
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pytest

from workbench.scenario.scenario import Scenario, ScenarioStart, VehicleConfig
from workbench.session.session import Session

FLIGHTS = Path(__file__).parents[4] / "../shared/flights/given/nanobench"
DRONES = Path(__file__).parents[3] / "drones"
PERIOD = 0.01
LATE = 0.53
"""Median lag from setpoint to position of the PID's flights [s]."""
SETTLING = 4.0
"""Held at the first setpoint, until the integrals are as in a flight that has begun [s]."""
MOVES = 0.3
"""An axis whose setpoint moves less than this tells of no lag [m]."""
LAWS = {"PID": "crazyflie", "Mellinger": "mellinger"}

pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(not FLIGHTS.exists(), reason="put the real flights into ../shared/flights"),
]


class Compared(NamedTuple):
    """RMSE of the position, flown here and by the late setpoint [m], and lags [s] of each axis."""

    error: float
    late: float
    lags: list[float]
    real_lags: list[float]


def flights(controller):
    with (FLIGHTS / "index.csv").open() as file:
        return [row for row in csv.DictReader(file) if row["controller"] == controller]


def lag(t, setpoint, position):
    """Return by how much a position is late [s], by least squares with a gain and an offset."""
    found = []
    for late in np.arange(0.0, 1.2, 0.01):
        past = np.interp(t - late, t, setpoint)
        known = t > t[0] + 1.2
        columns = np.column_stack([past[known], np.ones(known.sum())])
        rest = np.linalg.lstsq(columns, position[known], rcond=None)[1]
        found.append((float(rest[0]), late))
    return min(found)[1]


def compared(row) -> Compared:
    with gzip.open(FLIGHTS / f"{row['file']}.gz", "rt") as file:
        log = np.genfromtxt(file, delimiter=",", names=True)
    t = log["t"] - log["t"][0]
    end = min(float(row["airborne_to_s"]), float(row["onboard_data_end_s"]))
    now = np.arange(float(row["airborne_from_s"]), end, PERIOD)

    def signals(names, late=0.0):
        return np.column_stack([np.interp(now - late, t, log[name]) for name in names])

    axes = [f"sp_ctrltarget_{axis}" for axis in "xyz"]
    real, asked, late = signals(["px", "py", "pz"]), signals(axes), signals(axes, LATE)
    start = ScenarioStart(
        position=real[0].tolist(),
        velocity=signals(["vx", "vy", "vz"])[0].tolist(),
        roll_pitch_yaw=signals(["roll", "pitch", "yaw"])[0].tolist(),
    )
    vehicle = VehicleConfig(
        model=str(DRONES / "crazyflie.urdf"), rotors=str(DRONES / "crazyflie.rotors.yaml")
    )
    scenario = Scenario(controller=LAWS[row["controller"]], vehicle=vehicle, start=start)
    session = Session(scenario, {"vbat": float(row["median_vbat_V"])})
    session.go_to(asked[0].tolist())
    session.tick(SETTLING)
    flown = np.empty_like(real)
    for number, point in enumerate(asked.tolist()):
        session.go_to(point)
        flown[number] = session.state()[4:7]
        session.tick(PERIOD)
    moves = [axis for axis in (0, 1) if np.ptp(asked[:, axis]) > MOVES]
    return Compared(
        float(np.sqrt(np.mean(np.sum((flown - real) ** 2, axis=1)))),
        float(np.sqrt(np.mean(np.sum((late - real) ** 2, axis=1)))),
        [lag(now, asked[:, axis], flown[:, axis]) for axis in moves],
        [lag(now, asked[:, axis], real[:, axis]) for axis in moves],
    )


@pytest.mark.parametrize(("controller", "wanted"), [("PID", 0.53), ("Mellinger", 0.59)])
def test_it_flies_as_the_real_one_did(controller, wanted):
    rows = flights(controller)
    assert len(rows) == {"PID": 30, "Mellinger": 3}[controller]
    found = [compared(row) for row in rows[:: {"PID": 5, "Mellinger": 2}[controller]]]
    assert np.median(sum((each.lags for each in found), [])) == pytest.approx(wanted, abs=0.05)
    assert np.median(sum((each.real_lags for each in found), [])) == pytest.approx(wanted, abs=0.04)
    error = np.median([each.error for each in found])
    assert error < 0.1 and error < np.median([each.late for each in found])
