"""Low-pass and notch filters as second-order sections in state space.

    x' = A x + B u
    y = C x + D u

A section is nine numbers: A in row order (4), B (2), C (2) and D. They come from the trapezoidal
rule with a prewarped cut-off, so they equal the digital Butterworth and notch filters of
scipy.signal (`butter`, `iirnotch`). The states are those of the state variable filter: at rest the
first is 0 and the second is the input, whatever the coefficients. So moving a cut-off or switching
a filter on causes no jump.

Source: A. Simper, Linear Trapezoidal Integrated State Variable Filter With Low Noise Optimisation,
Cytomic, 2013; V. Zavalishin, The Art of VA Filter Design, 2.1, 2018, sections 3 and 4.
"""

import math
from collections.abc import Sequence

from workbench.common.jitable import register_jitable
from workbench.common.vectors import Numbers, Vector3

NYQUIST_SHARE = 0.49
"""A filter with a frequency above this share of the sampling rate is off."""


Section = tuple[float, float, float, float, float, float, float, float, float]
PASS_THROUGH: Section = (0.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 1.0)
"""Passes the input; its state is that of a filter at rest, so that switching causes no jump."""


@register_jitable
def filter_is_on(frequency: float, period: float) -> bool:
    """Return whether a filter at a frequency [Hz] is on, for samples every `period` [s]."""
    return 0.0 < frequency <= NYQUIST_SHARE / period


@register_jitable
def lowpass(cutoff: float, order: float, period: float) -> Section:
    """Return a Butterworth low-pass of first or second order.

    Args:
        cutoff: frequency of -3 dB [Hz]; no filter at 0 or near half the sampling rate.
        order: 1 or 2.
        period: between samples [s].
    """
    if not filter_is_on(cutoff, period):
        return PASS_THROUGH
    g = math.tan(math.pi * cutoff * period)
    if order == 1.0:
        share = g / (1.0 + g)
        return (0.0, 0.0, 0.0, 1.0 - 2.0 * share, 0.0, 2.0 * share, 0.0, 1.0 - share, share)
    a1, a2, a3 = _band(g, math.sqrt(2.0))
    return (
        2.0 * a1 - 1.0,
        -2.0 * a2,
        2.0 * a2,
        1.0 - 2.0 * a3,
        2.0 * a2,
        2.0 * a3,
        a2,
        1.0 - a3,
        a3,
    )


@register_jitable
def notch(centre: float, width: float, period: float) -> Section:
    """Return a notch.

    Args:
        centre: removed frequency [Hz]; no filter at 0 or near half the sampling rate.
        width: of the band below -3 dB [Hz].
        period: between samples [s].
    """
    if not filter_is_on(centre, period):
        return PASS_THROUGH
    g = math.tan(math.pi * centre * period)
    # scipy.signal.iirnotch has the band's edges where the digital filter is 3 dB down
    k = math.tan(math.pi * min(width, 0.5 / period * NYQUIST_SHARE) * period) * (1.0 + g * g) / g
    a1, a2, a3 = _band(g, k)
    return (
        2.0 * a1 - 1.0,
        -2.0 * a2,
        2.0 * a2,
        1.0 - 2.0 * a3,
        2.0 * a2,
        2.0 * a3,
        -k * a1,
        k * a2,
        1.0 - k * a2,
    )


@register_jitable(forceinline=True)
def section_output(section: Numbers, x_1: float, x_2: float, u: float) -> float:
    """Return the output of a section with states x_1, x_2 for an input."""
    return section[6] * x_1 + section[7] * x_2 + section[8] * u


@register_jitable(forceinline=True)
def section_states(section: Numbers, x_1: float, x_2: float, u: float) -> tuple[float, float]:
    """Return the states of a section after an input."""
    return (
        section[0] * x_1 + section[1] * x_2 + section[4] * u,
        section[2] * x_1 + section[3] * x_2 + section[5] * u,
    )


@register_jitable
def _band(g: float, k: float) -> Vector3:
    """Return the factors of a state variable filter with damping k / 2."""
    a1 = 1.0 / (1.0 + g * (g + k))
    a2 = g * a1
    return a1, a2, g * a2


def mean_smoothed(
    section: Numbers, states: Sequence[float], rows: Sequence[Sequence[float]]
) -> tuple[list[float], list[float]]:
    """Return the mean output of a section for vectors in turn (3), and its states after them (6).

    Args:
        section: coefficients (9), the same for the three components.
        states: of the section for each component, two a piece (6).
        rows: the vectors (K, 3).
    """
    mean, ends, count = [0.0] * 3, [], len(rows)
    for i, values in enumerate(zip(*rows, strict=True)):
        x_1, x_2 = states[2 * i : 2 * i + 2]
        for value in values:
            mean[i] += section_output(section, x_1, x_2, value) / count
            x_1, x_2 = section_states(section, x_1, x_2, value)
        ends += [x_1, x_2]
    return mean, ends
