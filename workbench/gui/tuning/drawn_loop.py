"""One loop over frequency as a picture has it: of a set of gains, or measured."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from workbench.analysis.replies import FrequencyCurves
from workbench.design.judge.margins import LoopMargins
from workbench.gui.charts.curve import CurveStyle
from workbench.gui.tuning.designs import FLOWN, KEPT, PROPOSED
from workbench.gui.tuning.designs import STROKES as STROKES_OF_GAINS

MEASURED = "measured"
COHERENT = 0.9
"""A measurement is drawn where its coherence is no less."""
STROKES = {
    **{name: STROKES_OF_GAINS[name] for name in (FLOWN, PROPOSED, KEPT)},
    MEASURED: (CurveStyle.SOLID, 3),
}
"""Style and colour of each, in their order."""


@dataclass(frozen=True, eq=False)
class DrawnLoop:
    """A loop over frequency.

    Attributes:
        name: in the legend.
        frequency: (F), rising [rad/s].
        open_loop: (F) L; NaN where it is not known.
        control_sensitivity: (F) KS, empty where it was not measured.
        load_sensitivity: (F) GS, likewise.
        margins: of the model; None of a measurement.
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
        """Of its curves."""
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
        """Highest frequency at which abs(L) is 1 [rad/s]; NaN where it is not known."""
        return self.margins.crossover if self.margins is not None else np.nan

    def at(self, frequency: float, response: np.ndarray) -> complex:
        """Return a response of it at a frequency [rad/s]; NaN where it is not known.

        Args:
            frequency: size and phase are those between the nearest two.
            response: (F).
        """
        if len(response) == 0 or not self.frequency[0] <= frequency <= self.frequency[-1]:
            return complex(np.nan, np.nan)
        log = np.log(self.frequency)
        values = np.log(response)
        values = values.real + 1j * np.unwrap(values.imag)
        return complex(np.exp(np.interp(np.log(frequency), log, values)))


def counting(loops: Sequence[DrawnLoop]) -> DrawnLoop | None:
    """Return the loop whose margins are drawn: of proposed gains, else of those that fly."""
    named = {each.name: each for each in loops}
    return named.get(PROPOSED, named.get(FLOWN))


def drawn_curves(name: str, curves: FrequencyCurves) -> DrawnLoop:
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
    """Return a measured loop, where it is coherent.

    Args:
        frequency: (F), rising [rad/s].
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
