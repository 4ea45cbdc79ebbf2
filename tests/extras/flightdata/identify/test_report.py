"""What identify writes is what any command flies with."""

import dataclasses
from pathlib import Path

import numpy as np
import pytest
from scipy import signal

from workbench.common.errors import WorkbenchError
from workbench.extras.flightdata.identify.fit import Fit
from workbench.extras.flightdata.identify.flight import (
    IdentificationFlight,
    PlanLimits,
    excitation,
    usual_limits,
)
from workbench.extras.flightdata.identify.held_back import HeldBackPrediction
from workbench.extras.flightdata.identify.identified_number import (
    NOT_DETERMINED,
    NOT_ENOUGH_MOTION,
    REFUTED,
    ROUGHLY_KNOWN,
    WELL_KNOWN,
    IdentifiedNumber,
    identified_rows,
    validated_numbers,
)
from workbench.extras.flightdata.identify.identified_sidecar import sidecar_text
from workbench.extras.flightdata.identify.quantities import (
    identifiable_quantities,
    with_quantities,
)
from workbench.extras.flightdata.identify.report import IdentificationReport
from workbench.extras.flightdata.identify.search import IdentificationResult
from workbench.plant.loading import load_vehicle
from workbench.plant.rotor_sources.sidecar import load_sidecar
from workbench.scenario.scenario_file import load_scenario, save_scenario

DRONES = Path(__file__).parents[3] / "drones"
FOUND = {
    "lag": 0.1,
    "thrust": -0.05,
    "inertia_x": 0.2,
    "inertia_z": -0.1,
    "center_x": 0.03,
    "turn": 0.02,
    "spin_up": 0.1,
    "drag": 0.3,
    "climb_drag": 0.1,
}
ONE = np.zeros((1, 1))
ROW = IdentifiedNumber("rotor_lag", "s", 0.02, 0.018, 0.022, 0.0167, "well", "")


def test_the_sidecar_flies_as_what_was_identified(tmp_path: Path) -> None:
    for name in ("crazyflie.urdf", "hexacopter.urdf.xacro", "tilted_quad.urdf.xacro"):
        vehicle = load_vehicle(DRONES / name)
        found = with_quantities(vehicle, FOUND)
        file = tmp_path / "found.rotors.yaml"
        file.write_text(sidecar_text(found, [ROW], [Path("a.csv")]), encoding="utf-8")
        read = load_vehicle(DRONES / name, rotors=file)
        assert read.mass == pytest.approx(found.mass, rel=1e-9), name
        np.testing.assert_allclose(read.inertia, found.inertia, rtol=1e-9, atol=1e-15)
        np.testing.assert_allclose(read.p_BoBcm_B, found.p_BoBcm_B, rtol=1e-9, atol=1e-12)
        for one, other in zip(read.rotors, found.rotors, strict=True):
            for field in ("motor_constant", "time_constant_up", "inertia", "inflow_coefficient"):
                assert getattr(one, field) == pytest.approx(getattr(other, field), rel=1e-5), field
            np.testing.assert_allclose(one.p_BR, other.p_BR, atol=1e-8)
            assert one.direction == other.direction
        assert load_sidecar(file)[1].identified[0].high == 0.022


def test_quantities_make_the_vehicle_that_they_are_of() -> None:
    vehicle = load_vehicle(DRONES / "crazyflie.urdf")
    made = with_quantities(vehicle, FOUND)
    np.testing.assert_allclose(
        np.diag(made.inertia), np.diag(vehicle.inertia) * np.exp([0.2, 0.0, -0.1])
    )
    moved = np.array(made.p_BoBcm_B) - vehicle.p_BoBcm_B
    np.testing.assert_allclose(moved, [0.03 * 0.5 * vehicle.span, 0.0, 0.0], atol=1e-12)
    for one, other in zip(made.rotors, vehicle.rotors, strict=True):
        more = 1.02 if other.direction > 0 else 0.98  # counter-clockwise ones give more
        assert one.motor_constant == pytest.approx(other.motor_constant * np.exp(-0.05) * more)
        assert one.time_constant_up == pytest.approx(other.time_constant_up * np.exp(0.1))
        assert one.time_constant_down == pytest.approx(other.time_constant_down * np.exp(0.1))
    drags = sum(one.rotor_drag_coefficient for one in made.rotors)
    mean = np.mean(made.hover_speeds)  # of rotors that give a little more or less
    assert drags * mean / vehicle.mass == pytest.approx(0.3, rel=1e-3)


def test_the_delay_of_a_gyro_is_that_of_its_low_pass_and_half_of_it_is_in_doubt() -> None:
    """Behind a filter a slow ramp is late by its group delay, here by scipy's own filter."""
    vehicle, still = load_vehicle(DRONES / "crazyflie.urdf"), np.zeros((10, 3))
    for cutoff in (30.0, 80.0):
        flight = IdentificationFlight(
            time=0.002 * np.arange(10),
            commands=np.ones((10, 4)),
            gyro=still,
            force=still,
            gyro_lowpass=cutoff,
        )
        b, a = signal.butter(2, 2.0 * np.pi * cutoff, analog=True)
        w, response = signal.freqs(b, a, [1e-3])
        delay = -float(np.angle(response)[0] / w[0])
        (found,) = (
            each for each in identifiable_quantities(flight, vehicle) if each.name == "gyro_delay"
        )
        assert (found.start, found.prior) == pytest.approx((delay, 0.5 * delay), rel=1e-5)


def test_a_body_that_cannot_be_is_refused_with_its_line(tmp_path: Path) -> None:
    vehicle = load_vehicle(DRONES / "crazyflie.urdf")
    text = sidecar_text(vehicle, [ROW], [Path("a.csv")])
    mass = f"mass: {vehicle.mass}"
    for good, bad, said in (
        (mass, "mass: -1.0", "positive number of kg"),
        (mass, f"{mass}\n  weight: 3", "weight"),
        ("center_of_mass: [", "center_of_mass: [1.0, ", "three numbers"),
        ("inertia: [", "inertia: [-", "does not fit any body"),
    ):
        assert good in text
        file = tmp_path / "bad.rotors.yaml"
        file.write_text(text.replace(good, bad, 1), encoding="utf-8")
        with pytest.raises(WorkbenchError, match=said):
            load_vehicle(DRONES / "crazyflie.urdf", rotors=file)


def test_the_plan_is_a_scenario_that_moves_every_axis(tmp_path: Path) -> None:
    vehicle = load_vehicle(DRONES / "crazyflie.urdf")
    limits = usual_limits(vehicle)
    plan = excitation(vehicle, str(DRONES / "crazyflie.urdf"), limits, 60.0)
    save_scenario(plan, tmp_path / "plan.yaml")
    script = load_scenario(tmp_path / "plan.yaml").script
    asked = np.array([[*(each.velocity or ()), each.yaw_rate or 0.0] for each in script])
    most = (limits.speed, limits.speed, limits.climb, limits.yaw_rate)
    np.testing.assert_allclose(np.abs(asked).max(axis=0), most)
    held = np.diff([*(each.at for each in script), plan.duration])
    # doublets go back to where they began, but for their times' rounding
    assert (np.abs(held @ asked) < 0.5 * np.array(most)).all()
    assert (asked[-1] == 0.0).all()
    for bad in (
        dataclasses.replace(limits, speed=0.0),
        dataclasses.replace(limits, climb=float("nan")),
        PlanLimits(1.0, 1.0, 50.0),
    ):
        with pytest.raises(WorkbenchError, match="largest"):
            excitation(vehicle, "x", bad, 60.0)
    with pytest.raises(WorkbenchError, match="minute"):
        excitation(vehicle, "x", limits, 3.0)


def test_verdicts_go_by_the_validation(case) -> None:
    """Well is only what predicts the part held back better than a constant does."""
    names = ("rotor_lag", "motor_constant", "inertia_x", "drag")
    rows = [IdentifiedNumber(name, "1", 1.0, 0.9, 1.1, None, WELL_KNOWN, "") for name in names]
    rows.append(IdentifiedNumber("delay", "s", 0.0, -1.0, 1.0, None, NOT_DETERMINED, ""))
    better, worse, damaged = (0.5, 1.0), (5.0, 1.0), (float("nan"), 1.0)
    for force, level, turn, expected in (
        (better, better, better, [WELL_KNOWN, WELL_KNOWN, WELL_KNOWN, WELL_KNOWN, NOT_DETERMINED]),
        (worse, better, better, [ROUGHLY_KNOWN, REFUTED, WELL_KNOWN, WELL_KNOWN, NOT_DETERMINED]),
        (better, better, worse, [ROUGHLY_KNOWN, WELL_KNOWN, REFUTED, WELL_KNOWN, NOT_DETERMINED]),
        (worse, worse, worse, [REFUTED, REFUTED, REFUTED, REFUTED, REFUTED]),
        (better, damaged, better, [WELL_KNOWN, WELL_KNOWN, WELL_KNOWN, REFUTED, NOT_DETERMINED]),
    ):
        with case(force, level, turn):
            found = validated_numbers(
                rows, HeldBackPrediction(*force, *level, *turn, 0.2, 2.0, 1.0)
            )
            assert [row.verdict for row in found] == expected
    assert [row.verdict for row in validated_numbers(rows, None)] == [
        *[ROUGHLY_KNOWN] * 4,
        NOT_DETERMINED,
    ]
    slow = [row for row in rows if not row.name.startswith("inertia")]  # turning is not judged
    found = validated_numbers(slow, HeldBackPrediction(*better, *better, *worse, 0.2, 2.0, 1.0))
    assert [row.verdict for row in found] == [WELL_KNOWN, WELL_KNOWN, WELL_KNOWN, NOT_DETERMINED]
    found = validated_numbers(slow, HeldBackPrediction(*worse, *better, *worse, 0.2, 2.0, 1.0))
    assert [row.verdict for row in found] == [REFUTED, REFUTED, WELL_KNOWN, REFUTED]


def test_thrust_is_refuted_only_by_a_flight_that_changes_it(case) -> None:
    """By a tenth of the weight, as commanded or as measured; an error that is no number refutes."""
    names = ("rotor_lag", "hover_command", "drag")
    slow = [IdentifiedNumber(name, "1", 1.0, 0.9, 1.1, None, WELL_KNOWN, "") for name in names]
    turning = [*slow, IdentifiedNumber("inertia_x", "1", 1.0, 0.9, 1.1, None, WELL_KNOWN, "")]
    quiet, better, worse = NOT_ENOUGH_MOTION, (0.5, 1.0), (5.0, 1.0)
    for rows, force, turn, commanded, expected in (
        (slow, (0.4, 0.3), better, 0.6, [quiet, quiet, WELL_KNOWN]),
        (slow, (0.2, 0.3), better, 0.6, [WELL_KNOWN, WELL_KNOWN, WELL_KNOWN]),
        (slow, (0.4, 0.3), better, 1.1, [REFUTED, REFUTED, WELL_KNOWN]),
        (slow, (1.2, 1.1), better, 0.6, [REFUTED, REFUTED, WELL_KNOWN]),
        (slow, (float("nan"), 0.3), better, 0.6, [REFUTED, REFUTED, WELL_KNOWN]),
        (turning, (0.4, 0.3), better, 0.6, [ROUGHLY_KNOWN, quiet, WELL_KNOWN, WELL_KNOWN]),
        (turning, (0.4, 0.3), worse, 0.6, [REFUTED, quiet, WELL_KNOWN, REFUTED]),
    ):
        with case(force, turn, commanded):
            held_back = HeldBackPrediction(*force, *better, *turn, 0.2, commanded, 1.0)
            assert [row.verdict for row in validated_numbers(rows, held_back)] == expected


def test_drag_is_refuted_only_by_a_flight_that_moves_sideways(case) -> None:
    """By 0.08 m/s², as measured or as modelled; an error that is no number refutes."""
    names = ("hover_command", "drag")
    rows = [IdentifiedNumber(name, "1", 1.0, 0.9, 1.1, None, WELL_KNOWN, "") for name in names]
    better = (0.5, 1.0)
    for level, modelled, expected in (
        ((0.051, 0.049), 0.03, NOT_ENOUGH_MOTION),
        ((0.03, 0.049), 0.03, WELL_KNOWN),
        ((0.051, 0.049), 0.09, REFUTED),
        ((0.1, 0.09), 0.03, REFUTED),
        ((float("nan"), 0.049), 0.03, REFUTED),
    ):
        with case(level, modelled):
            held_back = HeldBackPrediction(*better, *level, *better, 0.2, 2.0, modelled)
            hover, drag = validated_numbers(rows, held_back)
            assert (hover.verdict, drag.verdict) == (WELL_KNOWN, expected)
            assert ("2 m/s" in drag.flight) is (expected == NOT_ENOUGH_MOTION)


def test_a_voltage_exponent_is_at_most_roughly_known_and_says_why(case) -> None:
    """Its interval does not have what drifts along a flight as the voltage does."""
    names = ("curve_0", "curve_1", "curve_2", "voltage")
    for deviation, verdict in ((0.01, ROUGHLY_KNOWN), (0.9, NOT_DETERMINED)):
        with case(deviation):
            covariance = np.diag([1e-6, 1e-6, 1e-6, deviation**2])
            fit = Fit(names, np.array([0.0, 0.5, 0.5, 1.0]), covariance, 20, ONE, ("force",), True)
            vehicle = load_vehicle(DRONES / "crazyflie.urdf")
            found = IdentificationResult(vehicle, (), fit, None, {}, 30.0)
            rows = identified_rows(found)
            assert {row.name: row.verdict for row in rows}["voltage_exponent"] == verdict
            assert next(row for row in rows if row.name == "hover_command").verdict == WELL_KNOWN
            report = IdentificationReport(found, rows, ONE, (0.0, 0.0), None, "")
            assert sum("drifts along a flight" in said for said in report.sentences) == 1
            without = dataclasses.replace(report, rows=rows[:-1])
            assert not any("drifts along a flight" in said for said in without.sentences)
