"""The frequency response of a loop, measured in flight.

A multisine d is added at a loop point: the law computes u there, and v = u + d is passed on. With
negative feedback u = -L v, so L = -U / V of the signals' Fourier coefficients. The signals have the
period of the multisine, so there is no leakage and no window; the non-periodic rest is noise.
(Ljung, System Identification, 2nd edition, 1999, section 13.3 on periodic inputs and 13.5 on loops
that are closed; Pintelon and Schoukens, System Identification, 2nd edition, 2012, section 2.5.)
"""

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from workbench.common.errors import WorkbenchError

if TYPE_CHECKING:
    from workbench.session.injected import InjectedSignal

MIN_COHERENCE = 0.9
"""Smallest coherence of a valid measurement."""
CONFIDENCE_SIGMAS = 1.645
"""Standard deviations below the mean of the lower bound of a one-sided 95 % interval."""


@dataclass(frozen=True)
class MeasuredLoop:
    """A measured loop over frequency.

    Attributes:
        point: the loop point where it was opened.
        frequency: (F), increasing [rad/s].
        response: (F) complex L, with negative feedback.
        coherence: (F), 0 .. 1, see `_injection_coherence`: the smaller one of injection with u and
            with v.
        deviation: (F) one-sigma relative error of abs(L); of its phase, the same in rad.
        periods: number of measured periods.
    """

    point: str
    frequency: np.ndarray
    response: np.ndarray
    coherence: np.ndarray
    deviation: np.ndarray
    periods: int


def measured_loop(injected: "InjectedSignal") -> MeasuredLoop:
    """Return the loop response that a flown injection measures.

    Args:
        injected: signals of a flight, with two complete periods or more.

    Raises:
        WorkbenchError: with fewer.
    """
    periods = len(injected.came)
    if periods < 2:
        raise WorkbenchError(f"{periods} whole periods were measured: inject for three or more")
    lines = injected.multisine.lines
    sent = np.fft.rfft(injected.sent)[lines]
    came = np.fft.rfft(injected.came, axis=1)[:, lines]
    went = came + sent
    response = -came.mean(axis=0) / went.mean(axis=0)
    left = came + response * went
    noise = (np.abs(left) ** 2).sum(axis=0) / (periods * (periods - 1))
    size = np.abs(came.mean(axis=0))
    return MeasuredLoop(
        point=injected.asked.point,
        frequency=injected.multisine.frequency,
        response=response,
        coherence=np.minimum(_injection_coherence(came), _injection_coherence(went)),
        deviation=np.sqrt(0.5 * noise) / size,
        periods=periods,
    )


def _injection_coherence(spectra: np.ndarray) -> np.ndarray:
    """Return the coherence of spectra (P, F) with an injection that repeats exactly.

    With few periods an estimate is biased upwards. So this is the lower bound of a one-sided 95 %
    confidence interval, by Fisher's transformation (Enochson and Goodman, 1965; Bendat and Piersol,
    Random Data, 4th edition, 2010, section 9.2.3).
    """
    count = len(spectra)
    power = (np.abs(spectra) ** 2).mean(axis=0)
    estimate = np.abs(spectra.mean(axis=0)) / np.sqrt(np.maximum(power, 1e-300))
    spread = 1.0 / math.sqrt(2.0 * (count - 1))
    z = np.arctanh(np.minimum(estimate, 1.0 - 1e-12)) - spread**2 - CONFIDENCE_SIGMAS * spread
    found: np.ndarray = np.tanh(np.maximum(z, 0.0)) ** 2
    return found
