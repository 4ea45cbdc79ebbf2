"""The reference: the sum of the pilot's command and a path, in one vector.

The pilot's command is held until the next one; a path is a predefined trajectory. Both are
`guidance.Reference` vectors.
"""

import math

import numpy as np
from pydrake.systems.framework import DiagramBuilder, OutputPort
from pydrake.systems.primitives import Adder, TrajectorySource
from pydrake.trajectories import PiecewisePolynomial

from workbench.control.guidance import Reference

REFERENCE_VALUES = len(Reference._fields)


def add_reference(
    builder: DiagramBuilder, pilot: OutputPort, path: PiecewisePolynomial
) -> OutputPort:
    """Add a path to the pilot's command; return the reference."""
    course = builder.AddNamedSystem("path", TrajectorySource(path))
    both = builder.AddNamedSystem("reference", Adder(2, REFERENCE_VALUES))
    builder.Connect(pilot, both.get_input_port(0))
    builder.Connect(course.get_output_port(), both.get_input_port(1))
    return both.get_output_port()


def path_acceleration(path: PiecewisePolynomial) -> PiecewisePolynomial:
    """Return the acceleration along a path in W (3) [m/s²]."""
    times = np.array(path.get_segment_times())
    velocity = path.vector_values(times)[:3]
    # the derivative of linear pieces would be piecewise constant, with a delay of half a piece
    return PiecewisePolynomial.FirstOrderHold(times, np.gradient(velocity, times, axis=1))


def figure_eight(
    center: list[float], length: float, width: float, period: float, laps: int
) -> PiecewisePolynomial:
    """Return a figure of eight along x, which starts and ends at rest at its centre.

    x = length/2 sin(a), y = width/2 sin(2a), where the angle a runs smoothly from 0 to 2 pi laps.

    Args:
        center: its centre in W [m].
        length: along x [m].
        width: along y [m].
        period: of a lap at full pace [s]; the first and last half period are slower.
        laps: how many.
    """
    rate = 2.0 * math.pi / period
    ramp = 0.5 * period
    end = laps * period + ramp
    times = np.append(np.arange(0.0, end - 1e-9, 1.0 / 64.0), end)
    pace = np.clip(np.minimum(times, end - times) / ramp, 0.0, 1.0)
    pace = pace * pace * (3.0 - 2.0 * pace)
    a_dot = rate * pace
    steps = 0.5 * (a_dot[1:] + a_dot[:-1]) * np.diff(times)
    a = np.concatenate([[0.0], np.cumsum(steps)])
    a *= 2.0 * math.pi * laps / a[-1]
    samples = np.zeros((REFERENCE_VALUES, len(times)))
    samples[0] = 0.5 * length * np.cos(a) * a_dot
    samples[1] = width * np.cos(2.0 * a) * a_dot
    samples[4] = center[0] + 0.5 * length * np.sin(a)
    samples[5] = center[1] + 0.5 * width * np.sin(2.0 * a)
    samples[6] = center[2]
    samples[7] = 1.0
    return PiecewisePolynomial.FirstOrderHold(times, samples)
