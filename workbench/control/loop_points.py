"""The places where a signal of the law can be cut, scaled, added to or measured.

At each a probe passes on gate times signal plus injection. With gates of 1 and injections of 0, as
in every normal flight, that changes no bit. A loop is opened by its gate, delayed or driven by its
injection, and its transfer functions are derivatives by injections: linear models, margins and
their proof in flight all go through here.
"""

from typing import Any

from numba.extending import register_jitable

Scalar = Any
Signal = Any
"""A sequence of scalars: a list in Python, an array in compiled code."""

POINTS = (
    "position_x_error",
    "position_y_error",
    "position_z_error",
    "velocity_x_error",
    "velocity_y_error",
    "velocity_z_error",
    "acceleration_x",
    "acceleration_y",
    "acceleration_z",
    "roll_error",
    "pitch_error",
    "yaw_rate_error",
    "roll_acceleration",
    "pitch_acceleration",
    "yaw_acceleration",
)
"""Errors [m, m/s, 1, rad/s] and what follows from them: specific force in W, without gravity
[m/s²], and angular acceleration about the axes of the frame that hovers upright [rad/s²]. The
errors of roll and pitch are twice the sine of half the angle, about x and y of that frame."""

COUNT = len(POINTS)
GATES = 0
INJECTIONS = COUNT
SIGNALS = 2 * COUNT
"""Where the three parts of a `loops` sequence begin; the third is written by the law."""

POSITION, VELOCITY, ACCELERATION, ATTITUDE, ANGULAR_ACCELERATION = range(0, COUNT, 3)
"""Where the three points of each stage begin."""

CLOSED = (1.0,) * COUNT + (0.0,) * COUNT
"""Gates and injections of a normal flight."""


def closed_loops() -> list[float]:
    """Return a `loops` sequence of a normal flight."""
    return [*CLOSED, *[0.0] * COUNT]


@register_jitable(forceinline=True)
def probe(signals: Signal, first: int, loops: Signal) -> tuple[Scalar, Scalar, Scalar]:
    """Return what goes on from three points, and note what came there.

    Args:
        signals: that come (3).
        first: place of the first point in `POINTS`.
        loops: gates, injections, and places for the signals, one each a point; None where all
            are closed and nobody listens.
    """
    x, y, z = signals
    if loops is None:
        return x, y, z
    place = SIGNALS + first
    loops[place], loops[place + 1], loops[place + 2] = x, y, z
    gate, injection = GATES + first, INJECTIONS + first
    return (
        loops[gate] * x + loops[injection],
        loops[gate + 1] * y + loops[injection + 1],
        loops[gate + 2] * z + loops[injection + 2],
    )
