"""The frequency response of a loop for drawing, and its margins on the curves."""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from workbench.design.judge.gang_of_four import GangOfFour
from workbench.design.judge.margins import LoopMargins
from workbench.gui.charts.curve import CurveStyle
from workbench.gui.tuning.designs import FLOWN, KEPT, PROPOSED
from workbench.gui.tuning.designs import STROKES as STROKES_OF_GAINS

MEASURED = "measured"
COHERENT = 0.9
"""Least coherence at which a measurement is drawn."""
STROKES = {
    **{name: STROKES_OF_GAINS[name] for name in (FLOWN, PROPOSED, KEPT)},
    MEASURED: (CurveStyle.SOLID, 3),
}
"""Style and colour of each loop, in order."""


@dataclass(frozen=True, eq=False)
class DrawnLoop:
    """Frequency response of a loop.

    Attributes:
        name: name in the legend.
        frequency: (F), increasing [rad/s].
        open_loop: (F) L; NaN if unknown.
        control_sensitivity: (F) KS, empty if not measured.
        load_sensitivity: (F) GS, empty if not measured.
        margins: margins of the model; None for a measurement.
        deviation: (F) one-sigma relative error of abs(L); empty for none.
    """

    name: str
    frequency: np.ndarray
    open_loop: np.ndarray
    control_sensitivity: np.ndarray
    load_sensitivity: np.ndarray
    margins: LoopMargins | None
    deviation: np.ndarray

    @property
    def style(self) -> CurveStyle:
        """Style of its curves."""
        return STROKES[self.name][0]

    @property
    def colour(self) -> int:
        """Number of its colour."""
        return STROKES[self.name][1]

    @property
    def sensitivity(self) -> np.ndarray:
        """S = 1 / (1 + L), (F)."""
        with np.errstate(invalid="ignore"):
            response: np.ndarray = 1.0 / (1.0 + self.open_loop)
        return response

    @property
    def crossover(self) -> float:
        """Highest frequency at which abs(L) is 1 [rad/s]; NaN if unknown."""
        return self.margins.crossover if self.margins is not None else np.nan

    def at(self, frequency: float, response: np.ndarray) -> complex:
        """Return one of its responses at a frequency [rad/s]; NaN if unknown.

        Args:
            frequency: magnitude and phase are interpolated between the nearest two.
            response: response (F).
        """
        if len(response) == 0 or not self.frequency[0] <= frequency <= self.frequency[-1]:
            return complex(np.nan, np.nan)
        log = np.log(self.frequency)
        values = np.log(response)
        values = values.real + 1j * np.unwrap(values.imag)
        return complex(np.exp(np.interp(np.log(frequency), log, values)))


def counting(loops: Sequence[DrawnLoop]) -> DrawnLoop | None:
    """Return the loop whose margins are drawn: of the proposed gains, else of the flown ones."""
    named = {each.name: each for each in loops}
    return named.get(PROPOSED, named.get(FLOWN))


def drawn_curves(name: str, curves: GangOfFour) -> DrawnLoop:
    """Return the curves of a set of gains."""
    return DrawnLoop(
        name,
        curves.frequency,
        curves.open_loop,
        curves.control_sensitivity,
        curves.load_sensitivity,
        curves.margins,
        np.empty(0),
    )


def drawn_measurement(
    frequency: np.ndarray, response: np.ndarray, coherence: np.ndarray, deviation: np.ndarray
) -> DrawnLoop:
    """Return a measured loop, as far as it is coherent.

    Args:
        frequency: (F), increasing [rad/s].
        response: (F) complex L.
        coherence: (F), 0 .. 1.
        deviation: (F) one-sigma relative error of abs(L).
    """
    known = coherence >= COHERENT
    none = np.empty(0)
    return DrawnLoop(
        MEASURED,
        frequency,
        np.where(known, response, complex(np.nan, np.nan)),
        none,
        none,
        None,
        np.where(known, deviation, np.nan),
    )


Mark = tuple[float, float]
"""A margin on the curve: its frequency [rad/s], and the curve's value there [dB] or [rad]."""


def decibel(response: np.ndarray) -> np.ndarray:
    """Return the magnitude of a response [dB]."""
    size: np.ndarray = 20.0 * np.log10(np.maximum(np.abs(response), 1e-12))
    return size


def unwrapped(frequency: np.ndarray, response: np.ndarray, crossover: float) -> np.ndarray:
    """Return the unwrapped phase of a response (F) [rad].

    Args:
        frequency: (F), increasing [rad/s].
        response: (F); NaN if unknown.
        crossover: frequency at which the phase is between -270 and 90 degrees; NaN for the first
            one.
    """
    phase = np.angle(response)
    known = np.isfinite(phase)
    if not known.any():
        return phase
    phase[known] = np.unwrap(phase[known])
    at = frequency[known][0] if math.isnan(crossover) else crossover
    there = float(np.interp(at, frequency[known], phase[known]))
    turns = round((there + math.pi) / (2.0 * math.pi) - 0.25)
    return phase - 2.0 * math.pi * turns


def phase_margin_mark(loop: DrawnLoop) -> Mark | None:
    """Return where |L| is 1, with its phase margin from -180 degrees; None without one."""
    if loop.margins is None or not loop.margins.stable or math.isinf(loop.margins.phase_margin):
        return None
    margin = loop.margins.phase_margin
    phase = unwrapped(loop.frequency, loop.open_loop, loop.crossover)
    found = [
        (frequency, float(np.interp(frequency, loop.frequency, phase)))
        for frequency in _crossings(loop.frequency, decibel(loop.open_loop))
    ]
    return min(
        found,
        key=lambda mark: abs(abs(math.remainder(mark[1] - math.pi, math.tau)) - margin),
        default=None,
    )


def gain_margin_mark(loop: DrawnLoop, factor: float) -> Mark | None:
    """Return where the phase is -180 degrees, with the factor that makes |L| 1; None for none."""
    if loop.margins is None or not loop.margins.stable:
        return None
    if not math.isfinite(factor) or factor <= 0.0:
        return None
    size = decibel(loop.open_loop)
    phase = unwrapped(loop.frequency, loop.open_loop, loop.crossover)
    found = []
    for turns in range(-2, 2):
        level = -math.pi + 2.0 * math.pi * turns
        for frequency in _crossings(loop.frequency, phase - level):
            found.append((frequency, float(np.interp(frequency, loop.frequency, size))))
    wanted = -20.0 * math.log10(factor)
    near = [mark for mark in found if abs(mark[1] - wanted) < 1.0]
    return min(near, key=lambda mark: abs(mark[1] - wanted), default=None)


def peak(frequency: np.ndarray, response: np.ndarray) -> Mark:
    """Return the largest magnitude of a response, and its frequency [rad/s]."""
    place = int(np.nanargmax(np.abs(response)))
    return float(frequency[place]), float(np.abs(response[place]))


def _crossings(frequency: np.ndarray, values: np.ndarray) -> list[float]:
    """Return the frequencies [rad/s] at which values (F) change sign."""
    places = np.flatnonzero((values[1:] > 0.0) != (values[:-1] > 0.0))
    log = np.log(frequency)
    share = values[places] / (values[places] - values[places + 1])
    found: list[float] = np.exp(log[places] + share * (log[places + 1] - log[places])).tolist()
    return found
