"""Slips of a unit, each made once with the shipped drone; and drones as they are published."""

import dataclasses
from pathlib import Path

import numpy as np
import pytest

from tests.installed import FORMATS
from workbench.common.errors import WorkbenchError
from workbench.plant import ranges
from workbench.plant.description import read_description
from workbench.plant.loading import make_vehicle
from workbench.plant.plausible import implausible_values
from workbench.plant.vehicle import BatteryPack

TESTS = Path(__file__).resolve().parents[1]
MODELS = TESTS.parents[1] / "shared" / "models"
MAVS = {"namespace": "bird"}
BASES = MAVS | {
    "enable_mavlink_interface": "false",
    "enable_ground_truth": "true",
    "enable_logging": "true",
    "log_file": "log",
    "wait_to_record_bag": "true",
}


def with_rotors(vehicle, **changes):
    rotors = tuple(dataclasses.replace(rotor, **changes) for rotor in vehicle.rotors)
    return dataclasses.replace(vehicle, rotors=rotors)


def pack(**changes):
    usual = {
        "capacity": 18000.0,
        "resistance": 0.012,
        "open_circuit_voltage": ((0.0, 9.0), (1.0, 12.6)),
    }
    return BatteryPack(**(usual | changes))


def longer(vehicle, factor):
    rotors = tuple(
        dataclasses.replace(rotor, p_BR=tuple(factor * np.array(rotor.p_BR)))
        for rotor in vehicle.rotors
    )
    return dataclasses.replace(vehicle, rotors=rotors)


def heavier_to_turn(vehicle, factor):
    inertia = tuple(tuple(factor * x for x in row) for row in vehicle.I_BBcm_B)
    return dataclasses.replace(vehicle, I_BBcm_B=inertia)


def flyable(root):
    """Yield the vehicles of the descriptions below a folder; parts of drones do not fly."""
    for path in sorted(root.rglob("*")):
        if path.suffix not in (".xacro", ".urdf", ".sdf"):
            continue
        for args in ({}, MAVS, BASES):
            try:
                yield path, make_vehicle(read_description(path, args))
                break
            except WorkbenchError:
                continue


@pytest.mark.slow
@pytest.mark.parametrize(
    ("root", "least"),
    [(TESTS.parent / "models", 1), (TESTS / "drones", 10), (MODELS, 4 if FORMATS else 2)],
    ids=["shipped", "of the tests", "published"],
)
def test_a_drone_as_it_is_published_is_a_drone(root, least):
    if not root.is_dir():
        pytest.skip(f"put published descriptions into {root} to try them")
    found = {path: implausible_values(vehicle) for path, vehicle in flyable(root)}
    assert len(found) >= least
    assert {path: said for path, said in found.items() if said} == {}


@pytest.mark.parametrize(
    ("spoil", "said"),
    [
        (lambda v: longer(v, 1000.0), "were millimetres written for metres?"),
        (lambda v: longer(v, 100.0), "were centimetres written for metres?"),
        (lambda v: longer(v, 39.4), "were inches written for metres?"),
        (lambda v: longer(v, 0.1), "are lengths in m and masses in kg?"),
        (lambda v: heavier_to_turn(v, 1000.0), "moment of inertia about z"),
        (lambda v: heavier_to_turn(v, 20.0), "moment of inertia about x"),
        (lambda v: heavier_to_turn(v, 0.001), "is it in kg m²"),
        (lambda v: dataclasses.replace(v, mass=0.0019), "masses in kg"),
        (lambda v: with_rotors(v, max_rot_velocity=11000.0), "not RPM"),
        (lambda v: with_rotors(v, max_rot_velocity=800.0), "leaves next to nothing"),
        (
            # RPM and per RPM², which make the same thrust
            lambda v: with_rotors(v, max_rot_velocity=10504.0, motor_constant=8.54858e-6 / 91.19),
            "its tips would move at",
        ),
        (lambda v: with_rotors(v, motor_constant=8.54858e-4), "that of a propeller of some"),
        (lambda v: with_rotors(v, time_constant_up=12.5), "did you mean 12.5 ms?"),
        (lambda v: with_rotors(v, time_constant_up=900.0), "are they in s?"),
        (lambda v: with_rotors(v, rotor_drag_coefficient=0.01), "its rotor drag over the weight"),
        (lambda v: with_rotors(v, rolling_moment_coefficient=0.01), "its rolling moment over"),
        (lambda v: with_rotors(v, inflow_coefficient=0.01), "thrust lost in a climb of 1 m/s"),
        (lambda v: with_rotors(v, ground_effect_coefficient=900.0), "its ground effect coefficien"),
        (
            lambda v: with_rotors(v, ground_effect_coefficient=5.0, propeller_radius=127.0),
            "its propeller radius, 127 m, is",
        ),
        (lambda v: dataclasses.replace(v, battery=pack(capacity=5.0)), "did you mean 5 A h?"),
        (lambda v: dataclasses.replace(v, battery=pack(resistance=12.0)), "did you mean 12 mohm?"),
        (
            lambda v: dataclasses.replace(
                v, battery=pack(open_circuit_voltage=((0, 9e3), (1, 12e3)))
            ),
            "did you mean 12000 mV?",
        ),
        (lambda v: with_rotors(v, moment_constant=1.6), "its moment constant is 1.6 m"),
        (lambda v: with_rotors(v, inertia=1e-7), "about 4e-05 kg m²: is it the rotor's own"),
        (lambda v: with_rotors(v, inertia=0.065), "or a placeholder?"),
        (lambda v: dataclasses.replace(v, p_BoBcm_B=(0.16, 0.0, 0.0)), "the centre of mass"),
    ],
)
def test_a_slip_of_a_unit_is_doubted(dh_vehicle, spoil, said):
    assert any(said in doubt for doubt in implausible_values(spoil(dh_vehicle)))


def test_a_doubt_names_what_and_what_is_usual(dh_vehicle):
    said = implausible_values(longer(dh_vehicle, 1000.0))[0]
    assert "is 253 m from the centre of mass; a 1.9 kg multirotor has arms of about 0.2 m" in said


SI_BY_UNIT = {"g": 1e-3, "oz": 0.028349523125, "lb": 0.45359237, "kg": 1.0}
SI_BY_UNIT |= {"mm": 1e-3, "cm": 1e-2, "in": 0.0254, "mV": 1e-3, "mohm": 1e-3, "ms": 1e-3}
SI_BY_UNIT |= {"A h": 3600.0, "mA h": 3.6, "mAh": 3.6}
"""By definition: the pound and the inch of 1959, and what a prefix says."""


def test_units_that_are_written_by_mistake_have_the_values_of_their_definitions(case):
    compared = 0
    for name, each in vars(ranges).items():
        for unit, factor in each.others.items() if isinstance(each, ranges.Range) else ():
            with case((name, unit)):
                weight = 9.80665 if each.unit == "N" else 1.0  # of a mass
                expected = weight * SI_BY_UNIT[unit] / SI_BY_UNIT.get(each.unit, 1.0)
                assert factor == pytest.approx(expected, rel=2e-3)
                compared += 1
    assert compared >= 20
