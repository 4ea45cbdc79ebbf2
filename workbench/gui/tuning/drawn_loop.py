"""The frequency response of a loop for drawing, and its margins on the curves."""

import math
from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from workbench.design.judge.gang_of_four import GangOfFour
from workbench.design.judge.loop_response import decibels
from workbench.design.judge.margins import LoopMargins
from workbench.gui.charts.curve import CurveStyle
from workbench.gui.tuning.designs import FLOWN_SET, KEPT_SET, PROPOSED_SET
from workbench.gui.tuning.designs import GAIN_SET_STROKES as STROKES_OF_GAINS

MEASURED_LOOP = "measured"
MIN_DRAWN_COHERENCE = 0.9
"""Least coherence at which a measurement is drawn."""
LOOP_STROKES = {
    **{name: STROKES_OF_GAINS[name] for name in (FLOWN_SET, PROPOSED_SET, KEPT_SET)},
    MEASURED_LOOP: (CurveStyle.POINTS, 3),
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
        coherence: (F) coherence of a measurement, 0 .. 1; empty for none.
    """

    name: str
    frequency: np.ndarray
    open_loop: np.ndarray
    control_sensitivity: np.ndarray
    load_sensitivity: np.ndarray
    margins: LoopMargins | None
    deviation: np.ndarray
    coherence: np.ndarray = field(default_factory=lambda: np.empty(0))

    @property
    def style(self) -> CurveStyle:
        """Style of its curves."""
        return LOOP_STROKES[self.name][0]

    @property
    def colour(self) -> int:
        """Number of its colour."""
        return LOOP_STROKES[self.name][1]

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


def loop_with_margins(loops: Sequence[DrawnLoop]) -> DrawnLoop | None:
    """Return the loop whose margins are drawn: of the proposed gains, else of the flown ones."""
    named = {each.name: each for each in loops}
    return named.get(PROPOSED_SET, named.get(FLOWN_SET))


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
    known = coherence >= MIN_DRAWN_COHERENCE
    none = np.empty(0)
    return DrawnLoop(
        MEASURED_LOOP,
        frequency,
        np.where(known, response, complex(np.nan, np.nan)),
        none,
        none,
        None,
        np.where(known, deviation, np.nan),
        coherence,
    )


MarginMark = tuple[float, float]
"""A margin on the curve: its frequency [rad/s], and the curve's value there [dB] or [rad]."""


def unwrapped_phase(frequency: np.ndarray, response: np.ndarray) -> np.ndarray:
    """Return the unwrapped phase of a response (F) [rad].

    Its branch is the nearest to Bode's relation at the crossover, or at the lowest frequency of a
    response without one: a right angle for each 20 dB per decade. So n integrators are at -90 n
    degrees whatever the gains are, and a phase margin is read from -180 degrees, also where the
    phase of an unstable vehicle begins a turn away.

    Args:
        frequency: (F), increasing.
        response: (F) complex, NaN where unknown.
    """
    phase = np.angle(response)
    known = np.flatnonzero(np.isfinite(phase))
    if len(known) > 1:
        phase[known] = np.unwrap(phase[known])
        size, place = np.log(np.abs(response[known])), np.log(frequency[known])
        above = np.flatnonzero(size[:-1] >= 0.0)
        at = above[-1] if len(above) else 0
        slope = (size[at + 1] - size[at]) / (place[at + 1] - place[at])
        turns = (phase[known[at]] - 0.5 * math.pi * slope) / math.tau
        phase -= math.tau * math.floor(turns + 0.5)
    return phase


def phase_beside(loop: DrawnLoop, model: DrawnLoop | None) -> np.ndarray:
    """Return the unwrapped phase of a loop (F) [rad]; of a measurement, on the model's branch."""
    phase = unwrapped_phase(loop.frequency, loop.open_loop)
    known = np.isfinite(phase)
    if loop.name == MEASURED_LOOP and model is not None and known.any():
        modelled = unwrapped_phase(model.frequency, model.open_loop)
        beside = np.interp(loop.frequency, model.frequency, modelled)
        phase -= math.tau * round(float(np.median((phase - beside)[known])) / math.tau)
    return phase


def phase_margin_mark(loop: DrawnLoop) -> MarginMark | None:
    """Return where |L| is 1, with its phase margin from -180 degrees; None without one."""
    if loop.margins is None or not loop.margins.stable or math.isinf(loop.margins.phase_margin):
        return None
    margin = loop.margins.phase_margin
    phase = unwrapped_phase(loop.frequency, loop.open_loop)
    found = [
        (frequency, float(np.interp(frequency, loop.frequency, phase)))
        for frequency in _zero_crossings(loop.frequency, decibels(loop.open_loop))
    ]
    return min(
        found,
        key=lambda mark: abs(abs(math.remainder(mark[1] - math.pi, math.tau)) - margin),
        default=None,
    )


def gain_margin_mark(loop: DrawnLoop, factor: float) -> MarginMark | None:
    """Return where the phase is -180 degrees, with the factor that makes |L| 1; None for none."""
    if loop.margins is None or not loop.margins.stable:
        return None
    if not math.isfinite(factor) or factor <= 0.0:
        return None
    size = decibels(loop.open_loop)
    phase = unwrapped_phase(loop.frequency, loop.open_loop)
    found = []
    for turns in range(-2, 2):
        level = -math.pi + 2.0 * math.pi * turns
        for frequency in _zero_crossings(loop.frequency, phase - level):
            found.append((frequency, float(np.interp(frequency, loop.frequency, size))))
    wanted = -20.0 * math.log10(factor)
    near = [mark for mark in found if abs(mark[1] - wanted) < 1.0]
    return min(near, key=lambda mark: abs(mark[1] - wanted), default=None)


def response_peak(frequency: np.ndarray, response: np.ndarray) -> MarginMark:
    """Return the largest magnitude of a response, and its frequency [rad/s]."""
    place = int(np.nanargmax(np.abs(response)))
    return float(frequency[place]), float(np.abs(response[place]))


def _zero_crossings(frequency: np.ndarray, values: np.ndarray) -> list[float]:
    """Return the frequencies [rad/s] at which values (F) change sign."""
    places = np.flatnonzero((values[1:] > 0.0) != (values[:-1] > 0.0))
    log = np.log(frequency)
    share = values[places] / (values[places] - values[places + 1])
    found: list[float] = np.exp(log[places] + share * (log[places + 1] - log[places])).tolist()
    return found
