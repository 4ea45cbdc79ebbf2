"""Oracle: a figure of eight is a curve: its velocity is the derivative of its position."""

import math

import numpy as np
import pytest
from pydrake.systems.framework import DiagramBuilder
from pydrake.trajectories import PiecewisePolynomial

from workbench.control.guidance import Reference
from workbench.systems.pilot import PilotCommand, PilotSystem
from workbench.systems.reference import (
    REFERENCE_VALUES,
    add_reference,
    figure_eight,
    path_acceleration,
)

PATHS = {
    "default": {"center": [0.0, 0.0, 1.5], "length": 4.0, "width": 2.0, "period": 10.0, "laps": 2},
    "one lap": {"center": [1.0, -2.0, 3.0], "length": 6.0, "width": 1.0, "period": 8.0, "laps": 1},
    "odd period": {
        "center": [0.0, 5.0, 2.0],
        "length": 3.0,
        "width": 3.0,
        "period": 7.3,
        "laps": 3,
    },
}


@pytest.fixture(params=PATHS)
def eight(request):
    return figure_eight(**PATHS[request.param]), PATHS[request.param]


def sampled(path):
    times = np.array(path.get_segment_times())
    return times, np.array([path.value(time).ravel() for time in times])


def test_velocity_is_the_derivative_of_position(eight):
    """Central differences over two samples of 1/64 s are in error by h² x''' / 6.

    x''' is at most length/2 (and y's 4 width) times the rate cubed, of the order of 4 m/s³.
    """
    path, _ = eight
    times, samples = sampled(path)
    slope = (samples[2:, 4:7] - samples[:-2, 4:7]) / (times[2:] - times[:-2])[:, None]
    assert samples[1:-1, 0:3] == pytest.approx(slope, abs=1e-3)
    assert np.diff(times).max() <= 1.0 / 64.0 + 1e-12


def test_it_begins_and_ends_at_its_centre_at_rest(eight):
    path, shape = eight
    for time in (path.start_time(), path.end_time(), path.end_time() + 10.0):
        now = path.value(time).ravel()
        assert now[4:7] == pytest.approx(shape["center"], abs=1e-9)
        assert now[0:4] == pytest.approx(np.zeros(4), abs=1e-9)
        assert now[7] == 1.0


def test_it_takes_its_laps_and_one_half_period_more(eight):
    path, shape = eight
    assert path.end_time() == pytest.approx((shape["laps"] + 0.5) * shape["period"], abs=1 / 64)
    _, samples = sampled(path)
    x = samples[:, 4] - shape["center"][0]
    peaks = np.flatnonzero((x[1:-1] > x[:-2]) & (x[1:-1] >= x[2:]))
    assert len(peaks) == shape["laps"]


def test_it_stays_on_the_curve_of_an_eight(eight):
    """With sin a = 2 x / length, sin 2a = 2 y / width, so (2y/w)² = 4 s² (1 - s²)."""
    path, shape = eight
    _, samples = sampled(path)
    sine = 2.0 * (samples[:, 4] - shape["center"][0]) / shape["length"]
    double = 2.0 * (samples[:, 5] - shape["center"][1]) / shape["width"]
    assert double**2 == pytest.approx(4.0 * sine**2 * (1.0 - sine**2), abs=1e-9)
    assert np.ptp(samples[:, 4]) == pytest.approx(shape["length"], rel=1e-3)
    assert np.ptp(samples[:, 5]) == pytest.approx(shape["width"], rel=1e-3)
    assert np.all(samples[:, 6] == shape["center"][2])


def test_full_pace_is_once_around_a_period(eight):
    path, shape = eight
    _, samples = sampled(path)
    fastest = np.hypot(samples[:, 0], samples[:, 1]).max()
    rate = 2.0 * math.pi / shape["period"]
    assert fastest == pytest.approx(
        rate * math.hypot(shape["length"] / 2, shape["width"]), rel=1e-2
    )


def flown(path, asked: Reference, time: float) -> np.ndarray:
    """Return the reference that a pilot who asks and a path make at a time."""
    builder = DiagramBuilder()
    pilot = builder.AddSystem(PilotSystem())
    port = add_reference(builder, pilot.GetOutputPort("reference"), path)
    builder.ExportOutput(port, "reference")
    diagram = builder.Build()
    context = diagram.CreateDefaultContext()
    context.SetTime(time)
    pilot.set_command(pilot.GetMyMutableContextFromRoot(context), PilotCommand(asked))
    return diagram.GetOutputPort("reference").Eval(context)


def test_pilot_and_path_are_added():
    ramp = np.outer(np.arange(1.0, REFERENCE_VALUES + 1.0), [0.0, 2.0])
    path = PiecewisePolynomial.FirstOrderHold([0.0, 2.0], ramp)
    found = flown(path, Reference(*range(10, 18)), 0.5)
    assert found == pytest.approx(
        np.arange(10.0, 18.0) + 0.5 * np.arange(1.0, REFERENCE_VALUES + 1.0)
    )


def test_the_acceleration_along_a_path_is_the_second_derivative_of_its_places():
    path = figure_eight([0.0, 0.0, 5.0], 8.0, 4.0, 6.0, 1)
    acceleration, step = path_acceleration(path), 1 / 32
    for time in (1.0, 2.5, 4.0, 7.0):
        before, now, after = (path.value(time + k * step)[4:7, 0] for k in (-1, 0, 1))
        expected = (before - 2.0 * now + after) / step**2
        assert acceleration.value(time)[:, 0] == pytest.approx(expected, abs=0.1)
