"""Oracle: the law written again with vectors and rotations, of numpy and pydrake.math."""

import math

import numpy as np
import pytest
from pydrake.autodiffutils import InitializeAutoDiff
from pydrake.common.eigen_geometry import AngleAxis, Quaternion
from pydrake.math import RollPitchYaw, RotationMatrix

from workbench.control.controller_file import load_controller
from workbench.control.flight_law import flight_law
from workbench.control.guidance import (
    CEILING_RATE,
    Guidance,
    KnownBody,
    LawSetpoint,
    MeasuredMotion,
    Reference,
    tangent,
)
from workbench.control.law_parts import MIN_LIFT_ACCELERATION
from workbench.control.obstacle_brake import braked
from workbench.plant.gravity import GRAVITY

LAW = load_controller()
VALUES = dict(
    kp_position_xy=1.1,
    kp_position_z=1.7,
    kp_velocity_x=3.0,
    kp_velocity_y=4.0,
    kp_velocity_z=5.0,
    kd_velocity_x=0.1,
    kd_velocity_y=0.2,
    kd_velocity_z=0.3,
    kp_roll=150.0,
    kp_pitch=160.0,
    kd_roll=20.0,
    kd_pitch=22.0,
    kp_yaw_rate=4.0,
    max_speed=5.0,
    max_climb_rate=3.0,
    max_height=20.0,
    max_tilt=0.7,
    max_yaw_rate=0.5,
    spin_up_feedforward=0.0,
)
GAINS = flight_law(LAW).gains([VALUES[row.name] for row in LAW.parameters])
MASS = 1.9
INERTIA = np.array([[0.02, 0.001, -0.002], [0.001, 0.03, 0.0015], [-0.002, 0.0015, 0.04]])
SIX = [INERTIA[i, j] for i, j in ((0, 0), (0, 1), (0, 2), (1, 1), (1, 2), (2, 2))]
FREE = Guidance(1.0, 1.0, 1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0)


def reference(v=(0.0, 0.0, 0.0), yaw_rate=0.0, p=(0.0, 0.0, 0.0), follow=0.0) -> Reference:
    return Reference(*v, yaw_rate, *p, follow)


def cut(vector, most):
    """Return a vector no longer than `most`."""
    length = np.linalg.norm(vector)
    return vector if length <= most else vector * (most / length)


def velocity_by_vectors(p_WB, ref: Reference, guide: Guidance, gains) -> np.ndarray:
    kp = np.array([gains.kp_position_xy, gains.kp_position_xy, gains.kp_position_z])
    steering = guide.authority and any((*ref[:3], ref.follow))
    hold = np.zeros(3) if steering else np.array([guide.hold_xy, guide.hold_xy, guide.hold_z])
    asked = np.array(ref[:3]) + ref.follow * kp * (np.array(ref[4:7]) - p_WB)
    wanted = guide.authority * asked + hold * kp * (np.array(guide[6:9]) - p_WB)
    wanted[2] += guide.climb
    wanted[:2] = cut(wanted[:2], gains.max_speed)
    wanted[2] = min(wanted[2], CEILING_RATE * (gains.max_height - p_WB[2]))
    wanted[2] = np.clip(wanted[2], -gains.max_climb_rate, gains.max_climb_rate)
    yaw = np.clip(guide.authority * ref.yaw_rate, -gains.max_yaw_rate, gains.max_yaw_rate)
    return np.append(wanted, yaw)


def force_by_vectors(v_WB, a_WB, wanted, gains) -> np.ndarray:
    f = np.array(gains[2:5]) * (np.array(wanted[:3]) - v_WB) - np.array(gains[5:8]) * a_WB
    f[2] = max(f[2] + GRAVITY, MIN_LIFT_ACCELERATION)
    f[:2] = cut(f[:2], math.tan(gains.max_tilt) * f[2])
    return f


def wrench_by_vectors(R_WB: np.ndarray, w_WB, f_W, yaw_rate, gains) -> np.ndarray:
    w, f = R_WB.T @ w_WB, R_WB.T @ f_W
    axis = np.cross([0.0, 0.0, 1.0], f)
    angle = np.arctan2(np.linalg.norm(axis), f[2])
    error = 2.0 * np.sin(angle / 2.0) * axis / np.linalg.norm(axis)
    rate_error = R_WB.T @ [0.0, 0.0, yaw_rate] - w
    alpha = np.array(
        [
            gains.kp_roll * error[0] + gains.kd_roll * rate_error[0],
            gains.kp_pitch * error[1] + gains.kd_pitch * rate_error[1],
            gains.kp_yaw_rate * rate_error[2],
        ]
    )
    return np.append(MASS * f[2], INERTIA @ alpha + np.cross(w, INERTIA @ w))


def update(
    q=(1.0, 0.0, 0.0, 0.0),
    p_WB=(0.0, 0.0, 5.0),
    v_WB=(0.0, 0.0, 0.0),
    a_WB=(0.0, 0.0, 0.0),
    w_WB=(0.0, 0.0, 0.0),
    drag=(0.0, 0.0, 0.0),
    yaw_drag=0.0,
    ref=None,
    guide=FREE,
):
    """Return the wrench (4), and what comes to the loop points by name; at rest by default."""
    measured = MeasuredMotion(p_WB, v_WB, a_WB, q, w_WB, drag, (0.0, 0.0, 0.0, 0.0))
    asked = LawSetpoint(ref or reference(), guide, (0.0, 0.0, 0.0))
    loops = [*LAW.closed, *[0.0] * len(LAW.points)]
    body = KnownBody(MASS, SIX, yaw_drag, rotor_lag=0.02, spin_up_time=0.0)
    found, memory = LAW.update(measured, asked, GAINS, body, (), 1 / 128, loops)
    assert memory == ()
    return found, dict(zip(LAW.points, loops[len(LAW.closed) :], strict=True))


def setpoint(p_WB, ref: Reference, guide: Guidance):
    """Return the velocity (3) and the yaw rate that the law flies at: their errors at rest."""
    signals = update(p_WB=p_WB, ref=ref, guide=guide)[1]
    return (*(signals[f"velocity_{axis}_error"] for axis in "xyz"), signals["yaw_rate_error"])


ALONG = ((0.5, 0.5, 0.5, 0.5), (0.5, -0.5, -0.5, -0.5), (1.0, 0.0, 0.0, 0.0))
"""Attitudes whose z lies along x, y and z of W."""


def force(v_WB, a_WB, wanted, drag=(0.0, 0.0, 0.0)):
    """Return the specific force in W far from the limits of place: a share of it at a time."""
    motion = {"v_WB": v_WB, "a_WB": a_WB, "drag": drag, "ref": reference(wanted)}
    return [update(q, **motion)[0][0] / MASS for q in ALONG]


def wrench(q, w_WB, yaw_rate=0.0, yaw_drag=0.0) -> np.ndarray:
    """Return the wrench of a drone at rest but for its turn: it wants a force straight up."""
    asked = reference(yaw_rate=yaw_rate)
    return np.array(update(q, w_WB=w_WB, yaw_drag=yaw_drag, ref=asked)[0])


def test_velocity_is_reference_and_hold_within_limits():
    rng = np.random.default_rng(2)
    cut_in = {"speed": 0, "climb": 0, "ceiling": 0, "yaw": 0, "none": 0}
    for _ in range(2000):
        p_WB = rng.uniform(-4, 4, 3) + [0, 0, rng.choice([5, 19])]
        ref = reference(
            rng.uniform(-4, 4, 3) * rng.integers(0, 2),
            rng.uniform(-0.8, 0.8),
            p_WB + rng.uniform(-3, 3, 3),
            float(rng.integers(0, 2)),
        )
        bits = rng.integers(0, 2, 3).astype(float)
        guide = Guidance(
            1.0, 1.0, bits[0], rng.uniform(-1, 1), bits[1], bits[2], *rng.uniform(0, 9, 3)
        )
        found = setpoint(p_WB.tolist(), ref, guide)
        assert found == pytest.approx(velocity_by_vectors(p_WB, ref, guide, GAINS), abs=1e-12)
        speed = math.hypot(found[0], found[1])
        cut_in["speed"] += abs(speed - GAINS.max_speed) < 1e-9
        cut_in["climb"] += abs(found[2]) == GAINS.max_climb_rate
        cut_in["ceiling"] += found[2] == CEILING_RATE * (GAINS.max_height - p_WB[2])
        cut_in["yaw"] += abs(found[3]) == GAINS.max_yaw_rate
        cut_in["none"] += speed < 4.9 and abs(found[2]) < 2.9
    assert min(cut_in.values()) > 20  # every branch was taken, and often


def test_a_pilot_who_steers_is_not_pulled_back():
    holding = FREE._replace(hold_xy=1.0, hold_z=1.0, p_x=9.0, p_y=9.0, p_z=9.0)
    steered = setpoint([0, 0, 5], reference(v=(0.0, 1.0, 0.0)), holding)
    assert steered == pytest.approx((0.0, 1.0, 0.0, 0.0))
    let_be = setpoint([0, 0, 5], reference(yaw_rate=0.1), holding)
    assert let_be[2] == pytest.approx(GAINS.max_climb_rate)


def test_above_the_ceiling_it_sinks_no_faster_than_allowed():
    """max_height may be lowered in flight."""
    sinking = setpoint([0, 0, 100.0], reference(), FREE)
    assert sinking[2] == pytest.approx(-GAINS.max_climb_rate)


def walled(*walls, brake=1.5) -> Guidance:
    """Free to fly, with three walls: n in W, and the place along it at which to stop."""
    return Guidance(*FREE[:9], brake, *(number for wall in walls for number in wall))


NO_WALL = (0.0, 0.0, 0.0, 0.0)


def test_walls_brake_what_the_limits_leave():
    """Oracle: `braked` itself; slowing down takes half of what `max_tilt` allows."""
    guide = walled((1.0, 0.0, 0.0, 3.0), (0.0, 0.6, 0.8, 4.3), NO_WALL)
    rng = np.random.default_rng(5)
    slowing = 0.5 * GRAVITY * tangent(GAINS.max_tilt)
    slowed = 0
    for _ in range(200):
        p_WB, fast = rng.uniform(-1, 4, 3), reference(v=rng.uniform(-9, 9, 3))
        *free, yaw_rate = setpoint(p_WB, fast, FREE)
        wanted = (*braked(*free, p_WB, 1.5, guide[10:], slowing), yaw_rate)
        assert setpoint(p_WB, fast, guide) == wanted
        assert setpoint(p_WB, fast, guide._replace(brake=0.0)) == (
            *free,
            yaw_rate,
        )
        slowed += wanted[:3] != tuple(free)
    assert 50 < slowed < 190


@pytest.mark.parametrize("way", [-9.0, -0.2, 0.0, 0.5, 30.0])
def test_walls_have_derivatives(way):
    """Oracle: differences of the law itself."""
    slope = math.sqrt(0.5)
    guide = walled((slope, slope, 0.0, way), (0.0, 0.6, 0.8, way + 1.0), NO_WALL, brake=1.0)

    def law(p):
        return setpoint(p, reference(v=(3.0, 2.0, 2.5)), guide)[:3]

    at = np.array([0.3, -0.2, 0.1])
    carried = law(InitializeAutoDiff(at).ravel())
    values = [getattr(x, "value", lambda x=x: x)() for x in carried]
    assert values == pytest.approx(law(at.tolist()))
    for axis in range(3):
        step = 1e-6 * np.eye(3)[axis]
        wanted = (np.array(law(at + step)) - law(at - step)) / 2e-6
        found = [x.derivatives()[axis] if hasattr(x, "derivatives") else 0.0 for x in carried]
        assert found == pytest.approx(wanted, abs=1e-6)


def test_specific_force_is_velocity_pd_plus_gravity_within_tilt():
    rng = np.random.default_rng(3)
    least, tilted, free = 0, 0, 0
    for _ in range(2000):
        v_WB, a_WB, wanted = rng.uniform(-3, 3, (3, 3))
        found = force(v_WB.tolist(), a_WB.tolist(), wanted)
        assert found == pytest.approx(force_by_vectors(v_WB, a_WB, wanted, GAINS), abs=1e-7)
        tilt = math.atan2(math.hypot(found[0], found[1]), found[2])
        assert tilt <= GAINS.max_tilt + 1e-7
        least += found[2] == pytest.approx(MIN_LIFT_ACCELERATION)
        tilted += tilt > GAINS.max_tilt - 1e-6
        free += tilt < GAINS.max_tilt - 1e-6 and found[2] > MIN_LIFT_ACCELERATION + 1e-6
    assert min(least, tilted, free) > 100


def test_what_drag_takes_is_added_to_force_and_yaw_moment():
    """Tilt stays within its limit."""
    v_WB, a_WB, wanted = [0.1, 0.2, 0.3], [0.0] * 3, (0.2, 0.1, 0.3)
    plain = np.array(force(v_WB, a_WB, wanted))
    drag = np.array([0.5, -0.4, 0.3])
    found = force(v_WB, a_WB, wanted, drag)
    assert found == pytest.approx(plain + drag, rel=1e-12)
    tilted = force(v_WB, a_WB, wanted, [100.0, 0.0, 0.0])
    assert math.atan2(tilted[0], tilted[2]) == pytest.approx(GAINS.max_tilt, abs=1e-5)
    q, w_WB = [1.0, 0, 0, 0], [0.0, 0.0, 0.3]
    still, dragged = wrench(q, w_WB, 0.3), wrench(q, w_WB, 0.3, 0.5)
    turn = INERTIA[:, 2] * 0.5 * 0.3
    assert np.subtract(dragged, still) == pytest.approx([0.0, *turn], abs=1e-12)


def test_wrench_is_that_of_vectors_at_any_attitude():
    rng = np.random.default_rng(4)
    for _ in range(2000):
        q = rng.normal(size=4)
        w_WB, v_WB, a_WB = rng.normal(size=(3, 3)) * 3.0
        asked = reference(rng.normal(size=3), rng.uniform(-1.0, 1.0))
        R_WB = RotationMatrix(Quaternion(q / np.linalg.norm(q))).matrix()
        *wanted_v, yaw_rate = velocity_by_vectors(np.array([0.0, 0.0, 5.0]), asked, FREE, GAINS)
        f_W = force_by_vectors(v_WB, a_WB, wanted_v, GAINS)
        found = update(q, v_WB=v_WB, a_WB=a_WB, w_WB=w_WB, ref=asked)[0]
        wanted = wrench_by_vectors(R_WB, w_WB, f_W, yaw_rate, GAINS)
        assert found == pytest.approx(wanted, rel=1e-6, abs=1e-6)


@pytest.mark.parametrize("angle", [1e-6, 0.1, 1.5, 3.0, math.pi - 1e-2])
def test_tilt_error_is_twice_the_sine_of_half_the_angle_about_the_shortest_axis(angle):
    """Upright wanted, rolled and pitched about one level axis: the way back is about that axis."""
    axis = np.array([math.cos(0.3), math.sin(0.3), 0.0])
    q = AngleAxis(angle, axis).quaternion().wxyz()
    moment = wrench(q, [0, 0, 0])[1:]
    error = -2.0 * math.sin(angle / 2.0) * axis
    alpha = [GAINS.kp_roll * error[0], GAINS.kp_pitch * error[1], 0.0]
    assert moment == pytest.approx(INERTIA @ alpha, rel=1e-6)


@pytest.mark.parametrize("rpy", [(math.pi, 0, 0), (0, math.pi, 0), (math.pi, 0, 2.0)])
def test_exactly_upside_down_it_rolls_with_all_it_has(rpy):
    q = RollPitchYaw(rpy).ToQuaternion().wxyz()
    force, *moment = wrench(q, [0, 0, 0])
    assert force == pytest.approx(-MASS * GRAVITY)
    assert moment == pytest.approx(INERTIA @ [2.0 * GAINS.kp_roll, 0, 0], rel=1e-9)


def test_exactly_upside_down_in_whole_numbers():
    """No rounding at all: 1 + f_z / |f| is 0."""
    moment = wrench([0.0, 1.0, 0.0, 0.0], [0, 0, 0])[1:]
    assert moment == pytest.approx(INERTIA @ [2.0 * GAINS.kp_roll, 0, 0], rel=1e-12)


def test_near_upside_down_the_error_stays_finite_and_full():
    for angle in math.pi - np.logspace(-12, -2, 60):
        q = [math.cos(angle / 2), math.sin(angle / 2), 0.0, 0.0]
        moment = wrench(q, [0, 0, 0])[1:]
        alpha = np.linalg.solve(INERTIA, moment)
        level = np.hypot(alpha[0] / GAINS.kp_roll, alpha[1] / GAINS.kp_pitch)
        assert level == pytest.approx(2.0, rel=1e-3)


def test_length_and_sign_of_a_quaternion_do_not_matter():
    q = np.array([0.5, -0.1, 0.7, 0.2])
    motion = {"w_WB": [1.0, 2.0, 3.0], "ref": reference((0.3, -0.5, -0.4), 0.3)}
    first = update(q, **motion)[0]
    for factor in (-1.0, 0.01, 100.0):
        assert update(factor * q, **motion)[0] == pytest.approx(first, rel=1e-12)


def test_yaw_alone_asks_for_no_tilt():
    """Level at any heading, one yaw rate wanted and another flown: moment about z only."""
    q = RollPitchYaw(0, 0, 1.1).ToQuaternion().wxyz()
    force, *moment = wrench(q, [0, 0, 0.1], 0.4)
    assert force == pytest.approx(MASS * GRAVITY)
    spin = np.cross([0, 0, 0.1], INERTIA @ [0, 0, 0.1])
    assert moment == pytest.approx(INERTIA @ [0, 0, GAINS.kp_yaw_rate * 0.3] + spin)


def test_tangent_is_that_of_the_library():
    for angle in np.linspace(-1.2, 1.2, 241):
        assert tangent(angle) == pytest.approx(math.tan(angle), abs=1e-8)


@pytest.mark.parametrize("seed", range(5))
def test_the_law_gives_the_same_numbers_with_derivatives(seed):
    rng = np.random.default_rng(seed)
    p_WB, v_WB, a_WB, w_WB, hold = rng.normal(size=(5, 3))
    q = rng.normal(size=4)
    ref = reference(rng.normal(size=3), 0.3, rng.normal(size=3), 1.0)
    guide = FREE._replace(hold_xy=1.0, hold_z=1.0, p_x=hold[0], p_y=hold[1], p_z=hold[2])

    def fly(p, v, a, w, quaternion):
        found, signals = update(quaternion, p, v, a, w, ref=ref, guide=guide)
        return [*found, *signals.values()]

    plain = fly(p_WB, v_WB, a_WB, w_WB, q)
    every = InitializeAutoDiff(np.concatenate([p_WB, v_WB, a_WB, w_WB, q])).ravel()
    carried = fly(every[0:3], every[3:6], every[6:9], every[9:12], every[12:16])
    values = [getattr(x, "value", lambda x=x: x)() for x in carried]
    assert values == pytest.approx(plain, abs=1e-12)
