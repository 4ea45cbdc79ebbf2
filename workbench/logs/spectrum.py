"""The power spectral density of a signal, by Welch's method."""

from dataclasses import dataclass

import numpy as np

from workbench.common.errors import WorkbenchError

WINDOWS = ("hann", "hamming", "flattop", "boxcar")
"""Windows of a segment, by scipy's names."""
DETRENDS = ("constant", "linear", "none")
"""What is subtracted from each segment: its mean, its linear trend, or nothing."""
SPECTRUM = "a spectrum"
LEAST = 16
"""Smallest number of samples."""
JITTER = 0.02
"""Deviation from an even grid up to which samples are used as they are, as a share of a period."""
LATE = 0.2
"""Deviation from an even grid up to which samples are interpolated, as a share of a period."""
GAP = 4.5
"""Number of periods between two samples above which nothing is interpolated."""
UNEVEN = 0.05
"""Largest share of samples that are missing, or farther off."""


@dataclass(frozen=True)
class Welch:
    """The settings of a spectrum.

    Attributes:
        window: one of `WINDOWS`.
        averages: number of averaged segments, which overlap by half.
        detrend: one of `DETRENDS`.
    """

    window: str = "hann"
    averages: int = 8
    detrend: str = "constant"


@dataclass(frozen=True, eq=False)
class Spectrum:
    """A one-sided power spectral density.

    Attributes:
        frequency: (M) [Hz].
        density: (M), in the squared unit of the signal per Hz.
        rate: of the even samples used [Hz].
        segment: number of samples in a segment.
        resampled: whether missing or late samples were interpolated.
    """

    frequency: np.ndarray
    density: np.ndarray
    rate: float
    segment: int
    resampled: bool


def power_spectrum(time: np.ndarray, values: np.ndarray, welch: Welch, name: str = "") -> Spectrum:
    """Return the power spectral density of a signal, by scipy.signal.welch.

    Args:
        time: of the samples (n), increasing [s]; an even grid, except that single missing or late
            samples are interpolated linearly.
        values: (n); values that are not finite count as missing.
        welch: the settings.
        name: of the signal, for messages.

    Raises:
        WorkbenchError: if there are too few samples, or they are too uneven.
    """
    import scipy.signal  # slow to load, and rarely needed

    even, rate, resampled = even_samples(time, values, f"{name}: a spectrum" if name else SPECTRUM)
    size = len(even)
    segment = max(2 * (size // (welch.averages + 1)), LEAST)
    frequency, density = scipy.signal.welch(
        even,
        rate,
        window=welch.window,
        nperseg=segment,
        detrend=False if welch.detrend == "none" else welch.detrend,
        scaling="density",
    )
    return Spectrum(frequency, density, rate, segment, resampled)


def even_samples(time: np.ndarray, values: np.ndarray, what: str) -> tuple[np.ndarray, float, bool]:
    """Return samples on an even grid, their rate [Hz], and whether some were interpolated.

    Args:
        time: as for `power_spectrum`.
        values: as for `power_spectrum`.
        what: their use, for messages, such as "a spectrum".

    Raises:
        WorkbenchError: if there are too few, or gaps are too long or too many.
    """
    whole = np.isfinite(values)
    time, values = time[whole], np.asarray(values, dtype=float)[whole]
    if len(time) < LEAST:
        raise WorkbenchError(
            f"{what} needs {LEAST} samples, but there are only {len(time)}: show more time"
        )
    steps = np.diff(time)
    period = float(np.median(steps))
    if period <= 0.0:
        raise WorkbenchError(f"{what} needs rising times, but these do not rise")
    widest = int(steps.argmax())
    if steps[widest] > GAP * period:
        raise WorkbenchError(
            f"{what} needs evenly spaced samples, but there are none from {time[widest]:.2f} to "
            f"{time[widest + 1]:.2f} s: show a part without the gap"
        )
    span = float(time[-1] - time[0])
    grid = time[0] + span / (len(time) - 1) * np.arange(len(time))
    if np.abs(time - grid).max() <= JITTER * period:
        return values, (len(time) - 1) / span, False
    count = 1 + round(span / period)
    if np.mean(np.abs(steps - period) > LATE * period) > UNEVEN:
        raise WorkbenchError(
            f"{what} needs evenly spaced samples, but these come every {steps.min():.3g} to "
            f"{steps.max():.3g} s"
        )
    grid = np.linspace(time[0], time[-1], count)
    return np.interp(grid, time, values), (count - 1) / span, True


def density_unit(unit: str) -> str:
    """Return the unit of the power spectral density of a signal."""
    if unit == "1":
        return "1/Hz"
    return f"{unit}^2/Hz" if unit.isalpha() else f"({unit})^2/Hz"
