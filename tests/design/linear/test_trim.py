"""Oracle: the flight core's own derivatives, and what a push by drag must lean."""

import math

import numpy as np
import pytest

from workbench.common.errors import WorkbenchError
from workbench.design.linear.operating_point import OperatingPoint, parse_point
from workbench.design.linear.trim import guidance_of, reference_of
from workbench.diagram.core import make_flight_core
from workbench.plant.gravity import GRAVITY

RATE = 50.0


@pytest.fixture(scope="module")
def core(study):
    return make_flight_core(study.setup)


def slopes(core, trim) -> np.ndarray:
    """Return the continuous core's derivatives at a trim (21)."""
    context = core.CreateDefaultContext()
    core.GetInputPort("reference").FixValue(context, reference_of(trim))
    core.GetInputPort("guidance").FixValue(context, guidance_of(trim))
    filtered = trim.v_WB - trim.vdot_WB / RATE
    known = [trim.state, trim.speeds, filtered]
    context.SetContinuousState(np.concatenate([*known, [0.0]]))
    controller = core.GetSubsystemByName("controller")
    moment = controller.wanted_yaw_moment(controller.GetMyContextFromRoot(context))
    context.SetContinuousState(np.concatenate([*known, [moment]]))
    return core.EvalTimeDerivatives(context).CopyToVector()


@pytest.mark.parametrize(
    "text", ["hover", "hold=1", "vx=6", "vx=-3,vy=5", "vz=4", "vz=-3,vx=2", "yaw_rate=0.35"]
)
def test_a_steady_flight_stays_as_it_is(study, core, text):
    trim = study.trim(parse_point(text))
    found = slopes(core, trim)
    assert found[4:7] == pytest.approx(trim.v_WB, abs=1e-12)
    assert found[7:13] == pytest.approx(np.zeros(6), abs=1e-7)
    assert found[13:17] == pytest.approx(np.zeros(4), abs=5e-5)  # of 700 rad/s, each second
    assert found[17:] == pytest.approx(np.zeros(4), abs=1e-9)


@pytest.mark.parametrize(("text", "faster"), [("hover", 1.0), ("vx=6,vz=-1", 1.0), ("vz=3", 1.13)])
def test_so_does_one_with_all_effects(effects_study, text, faster):
    """Commands are larger than speeds by what the battery sags; climbing takes faster rotors."""
    vehicle, core = effects_study.vehicle, make_flight_core(effects_study.setup)
    trim = effects_study.trim(parse_point(text))
    found = slopes(core, trim)
    assert found[7:13] == pytest.approx(np.zeros(6), abs=1e-7)
    assert found[13:17] == pytest.approx(np.zeros(4), abs=5e-5)
    shares = trim.speeds / trim.commands
    assert shares == pytest.approx([shares[0]] * 4, rel=1e-12)
    assert 0.85 < shares[0] < 0.95
    assert trim.speeds.sum() / vehicle.hover_speeds.sum() == pytest.approx(faster, abs=0.02)


def test_a_turn_leans_inwards_as_a_pendulum_does(study):
    """Level at speed v with yaw rate r the drag-free lean is atan(v r / g)."""
    trim = study.trim(OperatingPoint(velocity=(3.0, 0.0, 0.0), yaw_rate=0.35))
    w, x, y, z = trim.q_WB
    z_W = np.array([2 * (x * z + w * y), 2 * (y * z - w * x), 1 - 2 * (x * x + y * y)])
    assert z_W[1] / z_W[2] == pytest.approx(3.0 * 0.35 / GRAVITY, rel=0.02)
    assert trim.vdot_WB == pytest.approx([0.0, 3.0 * 0.35, 0.0])


def test_an_accelerated_flight_leans_by_its_acceleration(study):
    """At rest without drag, a = kp v_sp - kd a, with an estimate of a that has settled."""
    trim = study.trim(OperatingPoint(acceleration=(3.0, 0.0, 0.0)))
    assert trim.tilt == pytest.approx(math.atan(3.0 / GRAVITY), rel=1e-6)
    kp, kd = (study.gains[f"{name}_velocity_x"] for name in ("kp", "kd"))
    assert trim.reference[:3] == pytest.approx(
        [3.0 * (1.0 + kd) / kp, 0.0, 0.0], rel=1e-6, abs=1e-9
    )


def test_a_climb_below_a_low_ceiling_is_trimmed_where_nothing_slows_it(study):
    """Climbs are slowed within a second of flight below the largest height: at 1 m/s in 1 m."""
    low, free = (study.trim(parse_point("vz=1"), {"max_height": top}) for top in (3.0, 100.0))
    assert 0.0 <= low.p_WB[2] <= 3.0 - 1.0
    assert low.reference == pytest.approx(free.reference, abs=1e-9)


@pytest.mark.parametrize("text", ["vx=12", "vz=9", "yaw_rate=2", "ax=20"])
def test_what_cannot_be_flown_is_said(study, text):
    with pytest.raises(WorkbenchError, match=f"no flight as '{text}' for dh_drone"):
        study.trim(parse_point(text))


def test_other_gains_ask_for_another_reference(study):
    soft = study.trim(parse_point("vx=5"), {"kp_velocity_x": 2.0})
    own = study.trim(parse_point("vx=5"))
    assert abs(soft.reference[0] - 5.0) > 1.5 * abs(own.reference[0] - 5.0)
    assert soft.q_WB == pytest.approx(own.q_WB, abs=1e-9)
