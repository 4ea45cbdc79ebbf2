"""Gains for a bandwidth and a phase or disk margin, against python-control and a random search."""

import math
import warnings
from functools import cache
from pathlib import Path

import control
import numpy as np
import pytest
from scipy.optimize import differential_evolution

from workbench.analysis.subject import AnalysedVehicle
from workbench.design.judge.affine_loop import AffineLoop
from workbench.design.judge.loop_judgement import opened_to_steer
from workbench.design.judge.loop_shaping import LoopShaper
from workbench.design.judge.margins import RobustnessMeasure
from workbench.scenario.scenario import Scenario, VehicleConfig

DRONES = Path(__file__).parents[2] / "drones"
VEHICLES = {
    "dh_drone": VehicleConfig(),
    "palm": VehicleConfig(model=str(DRONES / "palm_quad.urdf.xacro")),
    "hexacopter": VehicleConfig(model=str(DRONES / "hexacopter.urdf.xacro")),
}
LOOPS = ("pitch", "velocity_x", "velocity_z", "yaw_rate", "position_x")
BANDWIDTHS = (0.4, 0.7, 1.0, 1.3, 2.0)
TURNS = (-20.0, 0.0, 15.0)
"""Asked: times the own bandwidth, and besides the own phase margin [deg]."""


@cache
def subject(vehicle):
    return AnalysedVehicle(Scenario(vehicle=VEHICLES[vehicle]), {})


@cache
def shaper(vehicle, name):
    about = subject(vehicle)
    loop = about.controller.loop(name)

    def model_of(gains):
        holding = about.model(gains)
        return holding if loop.hold else opened_to_steer(holding)

    return model_of, LoopShaper(AffineLoop(model_of, loop, about.gains({}), about.table))


def truth(vehicle, name, gains):
    """Return bandwidth [rad/s], phase margin [deg], open loop and frequencies by python-control.

    None where it is unstable.
    """
    about = subject(vehicle)
    model = shaper(vehicle, name)[0]({**about.gains({}), **gains})
    loop = about.controller.loop(name)
    closed = np.abs(np.linalg.eigvals(model.A))
    if closed.max() > 1.0 + 1e-6:
        return None
    frequencies = np.geomspace(5e-3, 0.999 * math.pi / model.period, 500)
    opened = model.open_loop(loop.point("actuator"))
    response = opened(np.exp(1j * frequencies * model.period))
    measured = control.frd(response, frequencies, smooth=True)
    _, margins, _, _, crossovers, _ = control.stability_margins(measured, returnall=True)
    size = np.abs(response / (1.0 + response))
    flat = frequencies < 0.05 * crossovers.max()
    level = np.median(size[flat]) * 10.0**-0.15
    fall = np.nonzero((size[:-1] > level) & (size[1:] <= level))[0][0]
    between = np.interp(level, size[[fall + 1, fall]], frequencies[[fall + 1, fall]])
    return between, float(np.min(np.abs(margins))), opened, frequencies


def true_disk_margin(opened, frequencies):
    with warnings.catch_warnings():  # python-control's own, of numpy's
        warnings.simplefilter("ignore", DeprecationWarning)
        disk, _, _ = control.disk_margins(opened, frequencies)
    return float(disk)


def shaped(names, quick):
    """Return vehicles and loops; other drones, and loops but the quick ones, are slow tests."""
    pairs = [(vehicle, name) for name in names for vehicle in VEHICLES]
    return [
        pair
        if pair[0] == "dh_drone" and pair[1] in quick
        else pytest.param(*pair, marks=pytest.mark.slow)
        for pair in pairs
    ]


@pytest.mark.parametrize(("vehicle", "name"), shaped(LOOPS, ("pitch", "velocity_z", "yaw_rate")))
def test_what_is_reached_is_what_was_asked_by_python_control(vehicle, name):
    shapes = shaper(vehicle, name)[1]
    assert shapes.loop.is_affine
    own, reached = shapes.loop.margins({}), 0
    for share in BANDWIDTHS:
        for turn in TURNS:
            asked = share * own.bandwidth, own.phase_margin + math.radians(turn)
            found = shapes.shape(*asked)
            bandwidth, margin, *_ = truth(vehicle, name, found.gains)
            assert bandwidth == pytest.approx(found.margins.bandwidth, rel=0.01)
            if not found.reached:
                continue
            reached += 1
            assert bandwidth == pytest.approx(asked[0], rel=0.03)
            if len(subject(vehicle).controller.loop(name).gains) > 1:
                assert margin == pytest.approx(math.degrees(asked[1]), abs=1.0)
    assert reached >= 4


@pytest.mark.parametrize(
    ("vehicle", "name"), shaped(("pitch", "velocity_z", "position_x"), ("pitch", "position_x"))
)
def test_a_disk_margin_that_is_reached_is_the_asked_one_by_python_control(vehicle, name):
    shapes = shaper(vehicle, name)[1]
    own, reached = shapes.loop.margins({}), 0
    for share in (0.5, 0.8, 1.0, 1.3):
        for more in (-0.2, 0.0, 0.1):
            asked = share * own.bandwidth, own.disk_margin + more
            found = shapes.shape(*asked, RobustnessMeasure.DISK)
            bandwidth, _, *opened = truth(vehicle, name, found.gains)
            disk = true_disk_margin(*opened)
            assert disk == pytest.approx(found.margins.disk_margin, abs=0.01)
            if not found.reached:
                assert disk >= asked[1] - 0.01 or bandwidth <= 1.03 * asked[0]
                continue
            reached += 1
            assert bandwidth == pytest.approx(asked[0], rel=0.03)
            if len(subject(vehicle).controller.loop(name).gains) > 1:
                assert disk == pytest.approx(asked[1], abs=0.01)
    assert reached >= 6


def test_gains_do_not_depend_on_those_that_are_repaired():
    """An unstable loop is brought to the same place as a stable one, with what is linked."""
    about = subject("dh_drone")
    model_of, stable = shaper("dh_drone", "pitch")
    bad = {**about.gains({}), "kp_pitch": 2400.0, "kd_pitch": 1.5}
    links = {"kp_pitch": "kp_roll", "kd_pitch": "kd_roll"}
    loop = about.controller.loop("pitch")
    broken = LoopShaper(AffineLoop(model_of, loop, bad, about.table, links))
    assert not broken.loop.margins({}).stable
    found, wanted = (each.shape(45.0, math.radians(42.0)) for each in (broken, stable))
    assert found.reached and wanted.reached
    for name, other in links.items():
        assert found.gains[name] == found.gains[other]
        assert found.gains[name] == pytest.approx(wanted.gains[name], rel=1e-3)


def test_a_gain_at_its_limit_is_not_tried_beyond_it():
    """The rate loop of `pid` has no derivative: the search for exact numbers begins at kd = 0."""
    about = AnalysedVehicle(Scenario(controller="pid"), {})
    gains, loop = about.gains({}), about.controller.loop("pitch_rate")
    assert gains["kd_rate"] == about.table.find("kd_rate").minimum == 0.0
    shape = LoopShaper(
        AffineLoop(lambda values: opened_to_steer(about.model(values)), loop, gains, about.table)
    )
    now = shape.loop.margins({})
    for factor in (1.0, 0.9, 1.1):
        found = shape.shape(factor * now.bandwidth, now.phase_margin)
        assert 0.0 <= found.gains["kd_rate"] < 1.0
    same = shape.shape(now.bandwidth, now.phase_margin)
    assert same.reached and same.gains["kp_rate"] == pytest.approx(gains["kp_rate"], rel=0.01)


@pytest.mark.slow  # thousands of judgements
@pytest.mark.parametrize(
    ("vehicle", "name"),
    [
        ("dh_drone", "pitch"),
        ("dh_drone", "velocity_z"),
        ("palm", "yaw_rate"),
        ("palm", "velocity_x"),
        ("hexacopter", "position_x"),
    ],
)
def test_no_random_search_finds_what_is_said_to_be_out_of_reach(vehicle, name):
    shapes, about = shaper(vehicle, name)[1], subject(vehicle)
    own = shapes.loop.margins({})
    rows = [about.table.find(gain) for gain in about.controller.loop(name).gains]
    refused = 0
    for share, turn in ((0.1, -20.0), (0.5, -20.0), (1.0, 30.0), (2.0, 10.0), (4.0, 0.0), (20, 0)):
        asked = share * own.bandwidth, own.phase_margin + math.radians(turn)
        if shapes.shape(*asked).reached:
            continue
        refused += 1

        def missed(places, asked=asked):
            """Return how far gains are from what is asked, in tolerances."""
            gains = {
                row.name: max(row.minimum, row.maximum * (10.0 ** (-4.0 * place) - 1e-4))
                for row, place in zip(rows, places, strict=True)
            }
            found = shapes.loop.margins(gains)
            if not found.stable or math.isnan(found.bandwidth):
                return 1e3
            wide = abs(math.log(found.bandwidth / asked[0])) / 0.03
            turned = abs(found.phase_margin - asked[1]) / math.radians(1.0)
            return wide if len(rows) == 1 else max(wide, turned)

        best = differential_evolution(
            missed, [(0.0, 1.0)] * len(rows), maxiter=20, popsize=10, rng=7, polish=False
        )
        assert best.fun > 0.1, (asked, best.x)
    assert refused
