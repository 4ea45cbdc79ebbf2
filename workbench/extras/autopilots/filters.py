"""Low-pass filters of autopilots, with coefficients that a law's `design` computes.

First order, with cut-off f and time dt between updates:

    k = dt / (dt + 1 / (2 pi f)),   y <- y + k (x - y)

Second order: Butterworth, by the bilinear transform, in the direct form II of the firmware:

    d = x - a1 d1 - a2 d2,   y = b0 d + b1 d1 + b2 d2,   d2 <- d1,  d1 <- d

Betaflight's PT2 and PT3 are two and three first-order filters in a row, with cut-offs raised so
that the whole filter has -3 dB at f. Its filter of second order, a biquad and since 2026.6 a state
variable filter (SVF), is the Butterworth low-pass by the bilinear transform; for a cut-off that
changes it is computed here as an SVF, with g = tan(pi f dt):

    v1 = (i1 + g (x - i2)) / (1 + g (g + 2^½)),   v2 = i2 + g v1,   y = v2
    i1 <- 2 v1 - i1,   i2 <- 2 v2 - i2

A cut-off of 0 passes everything.
"""

import math

from workbench.common.jitable import register_jitable
from workbench.common.vectors import Numbers, Vector3
from workbench.control.law_parts import cosine_sine

PT2_CUTOFF_FACTOR, PT3_CUTOFF_FACTOR = 1.553773974, 1.961459177
"""Cut-off of each low-pass of a PT2 and of a PT3 over that of the whole, as Betaflight has them."""
LOWPASS_COEFFICIENTS = ("b0", "b1", "b2", "a1", "a2")
"""Names of the coefficients of a second-order low-pass, in the order of `butterworth`."""


def first_order(cutoff: float, period: float) -> float:
    """Return the gain k of a first-order low-pass, see above.

    Args:
        cutoff: [Hz].
        period: between updates [s].
    """
    return period / (period + 1.0 / (2.0 * math.pi * cutoff)) if cutoff > 0.0 else 1.0


def cascaded(cutoff: float, period: float, count: int) -> float:
    """Return the gain k of each of `count` low-passes in a row (PT2, PT3), see above."""
    return first_order(cutoff * (1.0, PT2_CUTOFF_FACTOR, PT3_CUTOFF_FACTOR)[count - 1], period)


def butterworth(cutoff: float, period: float) -> tuple[float, ...]:
    """Return `LOWPASS_COEFFICIENTS` of a low-pass of second order.

    Args:
        cutoff: [Hz]; at 0, and at half the rate or more, the filter passes everything.
        period: between updates [s].
    """
    if cutoff <= 0.0 or cutoff >= 0.5 / period:
        return 1.0, 0.0, 0.0, 0.0, 0.0
    ohm = math.tan(math.pi * cutoff * period)
    c = 1.0 + 2.0 * math.cos(math.pi / 4.0) * ohm + ohm * ohm
    b = ohm * ohm / c
    return (
        b,
        2.0 * b,
        b,
        2.0 * (ohm * ohm - 1.0) / c,
        (1.0 - 2.0 * math.cos(math.pi / 4.0) * ohm + ohm * ohm) / c,
    )


@register_jitable(forceinline=True)
def second_order_filtered(
    x: Vector3, one: Vector3, two: Vector3, coefficients: Numbers
) -> tuple[Vector3, Vector3]:
    """Return the outputs of three second-order low-passes, and their new states d1.

    Args:
        x: inputs.
        one: states d1.
        two: states d2.
        coefficients: see `LOWPASS_COEFFICIENTS`.
    """
    b_0, b_1, b_2, a_1, a_2 = coefficients
    d_x = x[0] - a_1 * one[0] - a_2 * two[0]
    d_y = x[1] - a_1 * one[1] - a_2 * two[1]
    d_z = x[2] - a_1 * one[2] - a_2 * two[2]
    y = (
        b_0 * d_x + b_1 * one[0] + b_2 * two[0],
        b_0 * d_y + b_1 * one[1] + b_2 * two[1],
        b_0 * d_z + b_1 * one[2] + b_2 * two[2],
    )
    return y, (d_x, d_y, d_z)


@register_jitable(forceinline=True)
def first_order_filtered(y: Numbers, x: Numbers, k: float) -> Vector3:
    """Return the next states of three first-order low-passes, which are their outputs."""
    return y[0] + k * (x[0] - y[0]), y[1] + k * (x[1] - y[1]), y[2] + k * (x[2] - y[2])


PT1, SECOND_ORDER, PT2, PT3 = 0.0, 1.0, 2.0, 3.0
"""Kinds of `low_passed`, in the order of Betaflight's words."""
MAX_CUTOFF_RATIO = 0.45
"""Largest cut-off of a second order over the rate of the updates."""


@register_jitable(forceinline=True)
def low_passed(
    x: Vector3, states: Numbers, cutoff: float, kind: float, first: bool, dt: float
) -> tuple[Vector3, tuple[float, ...]]:
    """Return the outputs of three low-passes, and their next states (9).

    Args:
        x: inputs.
        states: three of each; those that a kind does not need equal its output.
        cutoff: [Hz]; at 0 everything passes.
        kind: `PT1`, `SECOND_ORDER`, `PT2` or `PT3`.
        first: whether the filters begin, at rest at the inputs.
        dt: between updates [s].
    """
    one, two, three = states[0:3], states[3:6], states[6:9]
    if cutoff <= 0.0:
        return x, (x[0], x[1], x[2], x[0], x[1], x[2], x[0], x[1], x[2])
    none = 0.0 * x[0]
    if kind > 0.5 and kind < 1.5:
        if first:
            one, two = (none, none, none), x
        most = MAX_CUTOFF_RATIO / dt
        f = cutoff if cutoff < most else most + 0.0 * cutoff
        cos, sin = cosine_sine(math.pi * dt * f)
        g = sin / cos
        share = 1.0 / (1.0 + g * (g + 2.0**0.5))
        a_x = share * (one[0] + g * (x[0] - two[0]))
        a_y = share * (one[1] + g * (x[1] - two[1]))
        a_z = share * (one[2] + g * (x[2] - two[2]))
        y = two[0] + g * a_x, two[1] + g * a_y, two[2] + g * a_z
        one = 2.0 * a_x - one[0], 2.0 * a_y - one[1], 2.0 * a_z - one[2]
        two = 2.0 * y[0] - two[0], 2.0 * y[1] - two[1], 2.0 * y[2] - two[2]
        return y, (*one, *two, *y)
    if first:
        one, two, three = x, x, x
    raised = 1.0
    if kind > 1.5:
        raised = PT2_CUTOFF_FACTOR
    if kind > 2.5:
        raised = PT3_CUTOFF_FACTOR
    turn = 2.0 * math.pi * raised * dt * cutoff
    k = turn / (1.0 + turn)
    one = first_order_filtered(one, x, k)
    if kind < 0.5:
        return one, (*one, *one, *one)
    two = first_order_filtered(two, one, k)
    if kind < 2.5:
        return two, (*one, *two, *two)
    three = first_order_filtered(three, two, k)
    return three, (*one, *two, *three)
