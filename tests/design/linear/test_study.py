"""Oracles: central differences of the nonlinear core, and the textbook's hovering quadrotor."""

from functools import partial

import numpy as np
import pytest
import scipy.linalg
from scipy.spatial.transform import Rotation

from workbench.control.controller_file import load_controller
from workbench.design.linear.operating_point import OperatingPoint
from workbench.design.linear.trim import guidance_of, reference_of
from workbench.design.linear.vehicle import matrix_exponential
from workbench.diagram.core import make_flight_core
from workbench.plant.gravity import GRAVITY

GAINS = [row.name for row in load_controller().parameters]
COUNT = len(load_controller().points)
INPUTS = 7 + COUNT
"""Reference (4), place to hold (3), and loop points."""
RATE = 50.0
STEP = 2e-4
HOLD_X = 6


@pytest.fixture(scope="module")
def core(study):
    return make_flight_core(study.setup)


def rotated(q_WB: np.ndarray, angles: np.ndarray) -> np.ndarray:
    turned = Rotation.from_rotvec(angles) * Rotation.from_quat(q_WB, scalar_first=True)
    return turned.as_quat(scalar_first=True)


class Nonlinear:
    """The core's slopes as a function of small states and inputs."""

    def __init__(self, core, trim, gains):
        self.core, self.trim = core, trim
        self.context = core.CreateDefaultContext()
        controller = core.GetSubsystemByName("controller")
        self.in_controller = controller.GetMyMutableContextFromRoot(self.context)
        values = [gains[name] for name in GAINS]
        self.in_controller.get_mutable_numeric_parameter(0).SetFromVector(values)
        self.moment = 0.0
        self(np.zeros(20), np.zeros(INPUTS))
        self.moment = controller.wanted_yaw_moment(self.in_controller)

    def __call__(self, small: np.ndarray, inputs: np.ndarray) -> np.ndarray:
        trim, core, context = self.trim, self.core, self.context
        motion = np.concatenate([trim.p_WB, trim.w_WB, trim.v_WB]) + small[3:12]
        filtered = trim.v_WB - trim.vdot_WB / RATE + small[16:19]
        q_WB = rotated(trim.q_WB, small[:3])
        moment = [self.moment + small[19]]
        state = np.concatenate([q_WB, motion, trim.speeds + small[12:16], filtered, moment])
        context.SetContinuousState(state)
        reference, guide = reference_of(trim), guidance_of(trim)
        reference[:4] += inputs[:4]
        guide[HOLD_X : HOLD_X + 3] += inputs[4:7]
        core.GetInputPort("reference").FixValue(context, reference)
        core.GetInputPort("guidance").FixValue(context, guide)
        probes = np.concatenate([np.ones(COUNT), inputs[7:]])
        self.in_controller.get_mutable_numeric_parameter(1).SetFromVector(probes)
        return core.EvalTimeDerivatives(context).CopyToVector()


def differences(function, size) -> np.ndarray:
    """Return derivatives by central differences, extrapolated once (Richardson)."""

    def column(index: int, step: float) -> np.ndarray:
        change = np.zeros(size)
        change[index] = step
        return (function(change) - function(-change)) / (2.0 * step)

    return np.array([(4.0 * column(i, STEP / 2.0) - column(i, STEP)) / 3.0 for i in range(size)]).T


def assert_rows_agree(found: np.ndarray, wanted: np.ndarray, units: np.ndarray) -> None:
    """To 1e-6 of the largest entry of each row, columns taken in units of their own.

    (The body's drag v |v| has a kink at rest, which differences see and derivatives do not.)
    """
    rows = np.abs(wanted * units).max(axis=1, keepdims=True)
    assert np.all(np.abs(found - wanted) * units <= 1e-6 * np.maximum(rows, 1e-3))


@pytest.mark.parametrize("count", [20, pytest.param(100, marks=pytest.mark.slow)])
def test_a_and_b_are_the_differences_of_the_nonlinear_core_at_many_trims(study, core, count):
    rng = np.random.default_rng(1)
    for index in range(count):
        hold = index % 10 == 0
        point = OperatingPoint(
            velocity=(0.0, 0.0, 0.0) if hold else tuple(rng.uniform(-4, 4, 3)),
            yaw_rate=0.0 if hold else rng.uniform(-0.2, 0.2),
            acceleration=(0.0, 0.0, 0.0) if hold else tuple(rng.uniform(-2, 2, 3)),
            hold=hold,
        )
        factors = rng.uniform(0.7, 1.4, 13)
        gains = {name: study.gains[name] * f for name, f in zip(GAINS, factors, strict=False)}
        model = study.continuous(point, gains)
        nonlinear = Nonlinear(core, model.trim, {**study.gains, **gains})
        by_state = differences(partial(nonlinear, inputs=np.zeros(INPUTS)), 20)
        by_input = differences(partial(nonlinear, np.zeros(20)), INPUTS)
        turning = np.cross(np.eye(3), [0.0, 0.0, -point.yaw_rate])  # of the axes
        A, B = model.A.copy(), model.input_matrix
        for block in (3, 6, 9, 16):
            A[block : block + 3, block : block + 3] += turning.T
        A[0:3, 6:9] -= np.eye(3)
        assert np.abs(A[0:3]).max() < 1e-9  # in the heading's axes angles grow with the rate alone
        units = np.ones(20)
        units[12:16] = model.trim.speeds
        assert_rows_agree(A[3:], by_state[4:], units)
        assert_rows_agree(B[3:], by_input[4:], np.ones(INPUTS))


def test_the_vehicle_at_hover_is_the_textbooks(study):
    """Thrust k w²: each rotor's speed lags, lifts by 2 k w / m, and tilts by its arm over I.

    Drag apart, x'' = g pitch and y'' = -g roll.
    """
    vehicle = study.vehicle
    model = study.bare_vehicle()
    A, B = model.A, model.input_matrix
    rates = [(1 / r.time_constant_up + 1 / r.time_constant_down) / 2 for r in vehicle.rotors]
    assert A[12:, 12:] == pytest.approx(-np.diag(rates))
    assert B[12:] == pytest.approx(np.diag(rates))
    assert A[9, 1] == pytest.approx(GRAVITY, rel=1e-3)
    assert A[10, 0] == pytest.approx(-GRAVITY, rel=1e-3)
    assert A[3:6, 9:12] == pytest.approx(np.eye(3))
    assert A[0:3, 6:9] == pytest.approx(np.eye(3))
    slopes = [
        2 * r.motor_constant * w for r, w in zip(vehicle.rotors, model.trim.speeds, strict=True)
    ]
    assert A[11, 12:] == pytest.approx(np.array(slopes) / vehicle.mass)
    arms = [np.array(r.p_BR) - vehicle.p_BoBcm_B for r in vehicle.rotors]
    moments = [
        [arm[1], -arm[0], -r.direction * r.moment_constant]
        for arm, r in zip(arms, vehicle.rotors, strict=True)
    ]
    turned = np.linalg.solve(vehicle.inertia, np.array(moments).T * slopes)
    # spin-up: J dw/dt about z, against each rotor's turning
    spin_up = [-r.direction * r.inertia for r in vehicle.rotors]
    lead = np.linalg.solve(vehicle.inertia, np.outer([0.0, 0.0, 1.0], np.array(spin_up) * rates))
    assert A[6:9, 12:] == pytest.approx(turned - lead, abs=1e-9)
    assert B[6:9] == pytest.approx(lead, abs=1e-9)


def test_the_opened_climb_loop_has_a_closed_form(study):
    """L = kp / s times the lag, and the derivative share comes back filtered."""
    gains, vehicle = study.gains, study.vehicle
    L = study.continuous().open_loop("acceleration_z")
    lag = 2.0 / (1 / vehicle.rotors[0].time_constant_up + 1 / vehicle.rotors[0].time_constant_down)
    for w in (0.3, 2.0, 9.0, 40.0):
        s = 1j * w
        feedback = gains["kp_velocity_z"] + gains["kd_velocity_z"] * s / (1 + s / RATE)
        assert complex(L(s)) == pytest.approx(feedback / s / (lag * s + 1), rel=1e-6)


def test_the_opened_pitch_loop_has_a_closed_form(study):
    """Cut at the angular acceleration, with the velocity loop around it closed.

    Drag is left out: over frequencies well above its rate it is within a percent.
    """
    gains, vehicle = study.gains, study.vehicle
    L = study.continuous().open_loop("pitch_acceleration")
    lag = 2.0 / (1 / vehicle.rotors[0].time_constant_up + 1 / vehicle.rotors[0].time_constant_down)
    for w in (5.0, 20.0, 60.0):
        s = 1j * w
        velocity = gains["kp_velocity_x"] + gains["kd_velocity_x"] * s / (1 + s / RATE)
        wanted = velocity / s  # wanted tilt, over the tilt: g in and over g out cancel
        tilt = gains["kp_pitch"] * (1 + wanted) + gains["kd_pitch"] * s
        assert complex(L(s)) == pytest.approx(tilt / s**2 / (lag * s + 1), rel=0.02)


def test_the_exponential_is_scipys():
    rng = np.random.default_rng(2)
    for scale in (0.0, 1e-9, 1e-3, 0.3, 5.0, 60.0):
        A = scale * rng.normal(size=(7, 7)) / 7.0
        wanted = scipy.linalg.expm(A)
        assert np.abs(matrix_exponential(A) - wanted).max() < 1e-11 * np.abs(wanted).max()
