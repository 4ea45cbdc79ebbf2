"""Poles brought to a place by the gains of a loop, against eigenvalues and the textbook."""

import math

import control
import numpy as np
import pytest
from scipy.linalg import expm

from workbench.analysis.loop_placing import move_pole
from workbench.analysis.queries import MovePole
from workbench.analysis.subject import AnalysedVehicle
from workbench.common.parameter import Parameter
from workbench.design.judge.pole_placing import PolePlacer, state_shares
from workbench.design.linear.linearize import linearize
from workbench.design.linear.operating_point import OperatingPoint
from workbench.scenario.scenario import Scenario


@pytest.fixture(scope="module")
def subject():
    return AnalysedVehicle(Scenario(), {})


def poles(subject, gains):
    """In continuous terms, by eigenvalues."""
    model = subject.model({**subject.gains({}), **gains})
    z = np.linalg.eigvals(model.A)
    return np.log(z[np.abs(z) > 1e-9].astype(complex)) / model.period


def placer(subject, loop, pole, linked=None):
    names = subject.controller.loop(loop).gains
    return PolePlacer(subject.model, names, subject.gains({}), subject.table, pole, linked)


def test_two_gains_bring_a_pair_to_any_place_around(subject, case):
    """A round in eight legs, each from the one before; back again the gains are the first ones."""
    begun = -20.82 + 22.80j
    moves = placer(subject, "pitch", begun)
    round_ = [begun + 3.0 * np.exp(0.25j * math.pi * leg) - 3.0 for leg in range(9)]
    for place in round_:
        with case(place):
            found = moves.place(place)
            assert found.reached
            assert np.abs(poles(subject, found.gains) - place).min() < 0.002 * abs(place)
    for name, value in found.gains.items():
        assert value == pytest.approx(subject.gains({})[name], rel=0.01)


def test_the_open_loop_closed_by_hand_has_the_pole_there(subject, case):
    """The open loop L with the found gains, closed by u = -y."""
    for loop, pole, place in (
        ("pitch", -19.89 + 23.60j, -14.0 + 26.0j),
        ("velocity_x", -5.74 + 3.34j, -5.0 + 4.5j),
    ):
        with case(loop):
            found = placer(subject, loop, pole).place(place)
            assert found.reached
            opened = linearize(at=OperatingPoint(hold=True), loop=loop, gains=found.gains)
            assert isinstance(opened, control.StateSpace) and not opened.D.any()
            z = np.linalg.eigvals(opened.A - opened.B @ opened.C)
            s = np.log(z[np.abs(z) > 1e-9].astype(complex)) / opened.dt
            assert np.abs(s - place).min() < 0.002 * abs(place)


class Springs:
    """x'' = -k x - d x', sampled: the poles are the roots of s^2 + d s + k."""

    period = 0.01

    def __init__(self, gains) -> None:
        self.A = expm(np.array([[0.0, 1.0], [-gains["k"], -gains["d"]]]) * self.period)


class Limits:
    def find(self, name):
        return {
            "k": Parameter(
                "k", "1/s^2", "stiffness", 0.0, 400.0, system="controller", default=100.0
            ),
            "d": Parameter("d", "1/s", "damping", 0.0, 30.0, system="controller", default=8.0),
        }[name]


def test_two_gains_of_a_spring_are_the_coefficients_of_its_polynomial(case):
    """k = |s|^2 and d = -2 Re s; beyond the largest k the pole stays on its circle."""
    begun = complex(-4.0, math.sqrt(84.0))
    for place in (-6.0 + 5.0j, -1.0 + 12.0j, -10.0 + 3.0j):
        with case(place):
            found = PolePlacer(Springs, ("k", "d"), {"k": 100.0, "d": 8.0}, Limits(), begun)
            gains = found.place(place).gains
            assert gains["k"] == pytest.approx(abs(place) ** 2, rel=5e-3)
            assert gains["d"] == pytest.approx(-2.0 * place.real, rel=5e-3)
    far = PolePlacer(Springs, ("k", "d"), {"k": 100.0, "d": 8.0}, Limits(), begun)
    held = far.place(-6.0 + 30.0j)
    assert not held.reached and held.limit == "k"
    assert abs(held.pole) == pytest.approx(20.0, rel=1e-3)


def test_a_pole_goes_past_the_place_of_one_that_no_gain_moves(subject):
    """From -14.0 + 20.0 j to beyond the pole of roll, -20.8 + 22.8 j, by eigenvalues."""
    gains = {**subject.gains({}), "kp_pitch": 303.18, "kd_pitch": 26.416}
    names, place = subject.controller.loop("pitch").gains, -20.82 + 23.42j
    moves = PolePlacer(subject.model, names, gains, subject.table, -14.01 + 20.01j)
    found = moves.place(place)
    assert found.reached
    assert np.abs(poles(subject, found.gains) - place).min() < 0.002 * abs(place)


def test_a_gain_of_zero_that_leaves_states_out_may_grow():
    """Without its integral gain PX4's rate loop has other states."""
    subject = AnalysedVehicle(Scenario(controller="px4"), {})
    gains = {**subject.gains({}), "MC_ROLLRATE_I": 0.0}
    names, place = subject.controller.loop("roll_rate").gains, -39.3 + 77.7j
    assert len(subject.model(gains).A) != len(subject.model(subject.gains({})).A)
    moves = PolePlacer(subject.model, names, gains, subject.table, -41.4 + 81.8j)
    found = moves.place(place)
    assert found.reached
    assert np.abs(poles(subject, found.gains) - place).min() < 0.002 * abs(place)


def test_a_search_does_not_depend_on_the_targets_before(subject):
    """Near the pole of the given gains it begins there."""
    begun = -20.82 + 22.80j
    far, near = placer(subject, "pitch", begun), placer(subject, "pitch", begun)
    far.place(-14.0 + 20.0j)
    assert far.place(begun + 0.6j) == near.place(begun + 0.6j)


def test_gains_that_are_linked_move_along_and_their_poles_too(subject):
    found = placer(
        subject, "pitch", -20.0 + 24.0j, {"kp_pitch": "kp_roll", "kd_pitch": "kd_roll"}
    ).place(-16.0 + 20.0j)
    assert found.reached and found.gains["kp_roll"] == found.gains["kp_pitch"]
    near = np.abs(poles(subject, found.gains) - (-16.0 + 20.0j)) < 1.0
    assert np.count_nonzero(near) == 2


def test_a_single_gain_stops_where_its_line_begins_to_lead_away(subject):
    """By a walk along the pole's own branch of the root locus, in small steps of the gain."""
    begun, place = -5.7 + 3.3j, -4.0 + 3.6j
    found = placer(subject, "position_x", begun).place(place)
    assert not found.reached
    at, way = begun, [math.inf]
    for k in np.arange(1.0, 2.0, 0.005):
        near = poles(subject, {"kp_position_xy": k})
        at = near[np.argmin(np.abs(near - at))]
        if abs(at - place) > way[-1]:
            break
        way.append(abs(at - place))
    assert len(way) > 10 and k < 1.9
    assert abs(found.pole - place) == pytest.approx(way[-1], rel=1e-3)


def test_why_a_pole_stays_does_not_depend_on_the_targets_before(subject):
    """At a right angle to its line the one gain of a loop moves nothing, but it moves the pole."""
    begun, beside = -5.7 + 3.3j, -7.5 + 2.4j
    fresh, dragged = placer(subject, "position_x", begun), placer(subject, "position_x", begun)
    assert dragged.place(-5.4 + 2.8j).pole != dragged.place(begun).pole
    for moves in (fresh, dragged):
        held = moves.place(beside)
        assert not held.reached and not held.unmoved
    still = placer(subject, "yaw_rate", begun).place(beside)
    assert not still.reached and still.unmoved


def test_participation_is_that_of_the_textbook():
    """Of an upper triangular matrix each state is its own mode."""

    class Model:
        A = np.diag([0.9, 0.8, 0.5])
        period = 0.01

    pole = math.log(0.8) / 0.01
    np.testing.assert_allclose(state_shares(Model, pole), [0.0, 1.0, 0.0], atol=1e-12)


def test_a_law_of_a_scheduled_set_keeps_its_names(subject):
    about = AnalysedVehicle(Scenario(controller="pd@speed=0,4"), {})
    asked = {f"{name}_at_4": about.own[name] for name in ("kp_pitch", "kd_pitch")}
    question = MovePole(asked, "pitch", -20.0 + 24.0j, -18.0 + 22.0j)
    moved = next(each for each in move_pole(about, question, None) if each)
    assert moved.reached and set(moved.gains) == set(asked) and moved.said == ""
