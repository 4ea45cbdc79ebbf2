"""Closed forms: fall, climb, and what a tumbling body keeps."""

import math

import numpy as np
import pytest
from pydrake.common.eigen_geometry import Quaternion
from pydrake.math import RotationMatrix
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import DiagramBuilder
from pydrake.systems.primitives import ConstantVectorSource

from workbench.diagram.airframe import add_airframe
from workbench.gains.gain_choice import flight_gains
from workbench.plant.loading import make_vehicle
from workbench.scenario.scenario import Rates
from workbench.session.integration import Integration

UPRIGHT = [1.0, 0.0, 0.0, 0.0]
TUMBLING = [0.3, -0.5, 0.7, 0.41, 1.0, 2.0, 100.0, 3.0, -2.0, 1.5, 2.0, -1.0, 4.0]


def set_tumbling(rig):
    state = np.array(TUMBLING)
    state[:4] /= np.linalg.norm(state[:4])
    rig.set_state(state)


def momenta(rig) -> np.ndarray:
    """Return angular momentum about the centre of mass, and linear momentum, in W."""
    p_WBcm = rig.plant.CalcCenterOfMassPositionInWorld(rig.context)
    return rig.plant.CalcSpatialMomentumInWorldAboutPoint(rig.context, p_WBcm).get_coeffs()


def energies(rig) -> tuple[float, float]:
    plant = rig.plant
    return plant.EvalKineticEnergy(rig.context), plant.EvalPotentialEnergy(rig.context)


def spin_energy(rig) -> float:
    """Return the energy of rotation, from the vehicle's inertia."""
    state = rig.state
    R_WB = RotationMatrix(Quaternion(state[:4] / np.linalg.norm(state[:4]))).matrix()
    w_B = R_WB.T @ state[7:10]
    return 0.5 * float(w_B @ rig.vehicle.inertia @ w_B)


def test_it_falls_freely(rig):
    """z = z0 + v t - g t²/2."""
    rig.set_state([*UPRIGHT, 0, 0, 100, 0, 0, 0, 1, 0, 5])
    rig.fly(3.0)
    assert rig.state[4:7] == pytest.approx([3.0, 0.0, 100 + 15 - 0.5 * 9.81 * 9], abs=1e-7)
    assert rig.state[10:13] == pytest.approx([1.0, 0.0, 5 - 9.81 * 3], abs=1e-7)


def test_it_climbs_with_what_thrust_leaves_after_gravity(rig):
    """Twice the hover thrust is one g upwards."""
    rig.set_state([*UPRIGHT, 0, 0, 10, 0, 0, 0, 0, 0, 0])
    rig.set_speeds(math.sqrt(2.0) * rig.vehicle.hover_speeds)
    rig.fly(2.0)
    assert rig.state[4:7] == pytest.approx([0, 0, 10 + 0.5 * 9.81 * 4], abs=1e-7)
    assert rig.state[10:13] == pytest.approx([0, 0, 9.81 * 2], abs=1e-7)
    assert rig.state[0:4] == pytest.approx(UPRIGHT, abs=1e-9)


def test_it_turns_evenly_faster_under_an_even_yaw_moment(rig):
    """Two rotors faster and two slower about hover: 2 · 2 k w² · 0.1 · 0.016 m of drag about z."""
    vehicle = rig.vehicle
    thrusts = np.array([r.motor_constant for r in vehicle.rotors]) * vehicle.hover_speeds**2
    turns = np.array([rotor.direction for rotor in vehicle.rotors])
    change = 0.1 * float(thrusts.mean())
    speeds = np.sqrt((thrusts - turns * change) / [r.motor_constant for r in vehicle.rotors])
    rig.set_state([*UPRIGHT, 0, 0, 50, 0, 0, 0, 0, 0, 0])
    rig.set_speeds(speeds)
    yaw_acceleration = 4 * change * 0.016 / vehicle.inertia[2, 2]
    assert rig.accelerations()[2] == pytest.approx(yaw_acceleration, rel=1e-3)


def test_tumbling_keeps_momentum_and_energy(rig):
    set_tumbling(rig)
    angular, linear = np.split(momenta(rig), 2)
    spin, energy = spin_energy(rig), sum(energies(rig))
    mass = rig.vehicle.mass
    for time in (0.5, 1.0, 2.0, 3.0):
        rig.fly(time)
        now_angular, now_linear = np.split(momenta(rig), 2)
        assert now_angular == pytest.approx(angular, rel=1e-7)
        assert now_linear == pytest.approx(linear - [0, 0, mass * 9.81 * time], rel=1e-7)
        assert spin_energy(rig) == pytest.approx(spin, rel=1e-7)
        assert sum(energies(rig)) == pytest.approx(energy, rel=1e-8)
    assert rig.state[0:4] != pytest.approx(TUMBLING[:4], abs=0.1)


def flown_airframe(rig, state, speeds, time) -> np.ndarray:
    """Return the state (13) after a time as the workbench integrates the airframe, in no air."""
    builder = DiagramBuilder()
    airless = {**flight_gains(rig.vehicle), "drag_area": 0.0}
    airframe = add_airframe(
        builder, rig.description, airless, vehicle=make_vehicle(rig.description), rates=Rates()
    )
    source = builder.AddSystem(ConstantVectorSource(speeds))
    builder.Connect(source.get_output_port(), airframe.commands)
    simulator = Simulator(builder.Build())
    root, rates = simulator.get_mutable_context(), Rates()
    airframe.place(root, np.array(state, dtype=float), np.array(speeds))
    Integration(simulator, airframe, rates).advance(round(time / rates.physics_step))
    return airframe.body_state(root)


def test_the_flown_airframe_falls_exactly(rig):
    """A parabola is of second order, and so is exact."""
    start = [*UPRIGHT, 0, 0, 100, 0, 0, 0, 0, 0, 0]
    state = flown_airframe(rig, start, np.zeros(4), 2.0)
    assert state[12] == pytest.approx(-9.81 * 2.0, rel=1e-12)
    assert state[6] == pytest.approx(100 - 9.81 * 2.0**2 / 2, rel=1e-12)


def test_the_flown_airframe_agrees_with_the_continuous_one(rig):
    """One second of a powered tumble."""
    speeds = rig.vehicle.hover_speeds * [1.02, 1.0, 1.01, 0.99]
    set_tumbling(rig)
    start = rig.state.copy()
    rig.set_speeds(speeds)
    rig.fly(1.0)
    stepped, exact = flown_airframe(rig, start, speeds, 1.0), rig.state
    stepped[:4] *= np.sign(stepped[:4] @ exact[:4])
    assert stepped[0:4] == pytest.approx(exact[0:4], abs=2e-5)
    assert stepped[4:7] == pytest.approx(exact[4:7], abs=1e-4)
    assert stepped[7:10] == pytest.approx(exact[7:10], abs=1e-4)
    assert stepped[10:13] == pytest.approx(exact[10:13], abs=2e-4)
