"""What a law knows of the body that its rotors turn, against equations by hand."""

import numpy as np
import pytest

from tests.jointed import SPHERE, drone, joint, link
from workbench.plant.loading import load_vehicle

BASE, LOAD, LENGTH, DEPTH = 1.0, 0.3, 0.6, 0.1
MOMENTS = np.array([0.01, 0.012, 0.02])
SWING = (0.0, 0.0, -DEPTH)


def pendulum(more: str = "") -> str:
    """Return a load that swings about y below the centre of the base."""
    load = link("load", LOAD, (0.0, 0.0, -LENGTH))
    return load + joint("swing", "continuous", "base", "load", SWING, more=more)


def turned(folder, parts: str):
    return load_vehicle(drone(folder, parts, BASE, MOMENTS.tolist())).turned


def swung_moment() -> float:
    """Return the moment of inertia about y, with the load free to swing, about its centre of mass.

    A force across the hinge meets of the load the mass m I / (I + m l²).
    """
    held = LOAD * SPHERE / (SPHERE + LOAD * LENGTH**2)
    return MOMENTS[1] + BASE * held * DEPTH**2 / (BASE + held)


def test_the_height_of_the_centre_is_the_mean_of_those_for_forces_along_x_and_y(tmp_path):
    body = turned(tmp_path, pendulum())
    held = LOAD * SPHERE / (SPHERE + LOAD * LENGTH**2)
    along_x = -DEPTH * held / (BASE + held)
    along_y = -(DEPTH + LENGTH) * LOAD / (BASE + LOAD)
    assert body.p_BoBcm_B == pytest.approx((0.0, 0.0, 0.5 * (along_x + along_y)), rel=1e-9)


def test_a_load_on_a_cable_pulls_at_its_hook_in_x_and_y(tmp_path):
    """Along the vertical alone the load is a part: its reduced mass turns at the hook.

    A load that begins with a slack cable hangs on it in flight.
    """
    x, y = 0.1, -0.06
    hook = f'<cable name="c" length="0.6"><parent link="base" xyz="{x} {y} 0"/>'
    free = joint("free", "floating", "base", "load", (x, y, -0.5))
    body = turned(tmp_path, link("load", LOAD) + free + f'{hook}<child link="load"/></cable>')
    share = LOAD / (BASE + LOAD)
    assert body.p_BoBcm_B == pytest.approx((share * x, share * y, 0.0), abs=1e-9)
    reduced = BASE * share
    expected = np.diag(MOMENTS) + reduced * np.array(
        [[y * y, -x * y, 0.0], [-x * y, x * x, 0.0], [0.0, 0.0, 0.0]]
    )
    assert np.array(body.I_BBcm_B) == pytest.approx(expected, abs=1e-9)


@pytest.mark.parametrize(("rate", "swings"), [(15.0, True), (25.0, False)])
def test_a_servo_with_little_damping_is_as_stiff_as_its_spring(tmp_path, rate, swings):
    """Above 20 rad/s the arm turns with the base; its inertia is that of both, each free."""
    mass = np.array([[SPHERE + LOAD * LENGTH**2, LOAD * LENGTH], [LOAD * LENGTH, LOAD + BASE]])
    by_base = np.array([LOAD * (LENGTH + DEPTH) * LENGTH + SPHERE, LOAD * (LENGTH + DEPTH)])
    base = MOMENTS[1] + SPHERE + LOAD * (LENGTH + DEPTH) ** 2
    rest = np.array([[base, by_base[1]], [by_base[1], LOAD + BASE]])
    over = np.array([by_base[0], mass[0, 1]])
    inertia = mass[0, 0] - over @ np.linalg.solve(rest, over)
    servo = f'<servo kind="position" stiffness="{inertia * rate**2}" damping="1e-6"/>'
    body = turned(tmp_path, pendulum(servo))
    if swings:
        assert body.I_BBcm_B[1][1] == pytest.approx(swung_moment(), rel=1e-9)
    else:
        assert body is None


def test_a_tie_that_is_slack_holds_nothing_and_a_taut_one_does(tmp_path):
    """A tie from the base to the end of the load, beside the way that it swings."""
    tie = (
        '<cable name="tie" length="{}"><parent link="base" xyz="0.5 0 {}"/>'
        '<child link="load" xyz="0 0 {}"/></cable>'
    )
    level = -DEPTH - LENGTH
    slack = turned(tmp_path, pendulum() + tie.format(0.6, level, -LENGTH))
    assert slack.I_BBcm_B[1][1] == pytest.approx(swung_moment(), rel=1e-9)
    taut = turned(tmp_path, pendulum() + tie.format(0.5, level, -LENGTH))
    whole = MOMENTS[1] + SPHERE + BASE * LOAD / (BASE + LOAD) * level**2
    assert taut.I_BBcm_B[1][1] == pytest.approx(whole, rel=1e-9)
