"""The power spectral density of a signal, by Welch's method."""

from dataclasses import dataclass

import numpy as np

from workbench.common.errors import WorkbenchError

WELCH_WINDOWS = ("hann", "hamming", "flattop", "boxcar")
"""Windows of a segment, by scipy's names."""
WELCH_DETRENDS = ("constant", "linear", "none")
"""What is subtracted from each segment: its mean, its linear trend, or nothing."""
SPECTRUM_PHRASE = "a spectrum"
MIN_SPECTRUM_SAMPLES = 16
"""Smallest number of samples."""
MAX_JITTER_SHARE = 0.02
"""Deviation from an even grid up to which samples are used as they are, as a share of a period."""
MAX_INTERPOLATED_SHARE = 0.2
"""Deviation from an even grid up to which samples are interpolated, as a share of a period."""
MAX_SPECTRUM_GAP_PERIODS = 4.5
"""Number of periods between two samples above which nothing is interpolated."""
MAX_UNEVEN_SHARE = 0.05
"""Largest share of samples that are missing, or farther off."""


@dataclass(frozen=True)
class WelchSettings:
    """The settings of a spectrum.

    Attributes:
        window: one of `WELCH_WINDOWS`.
        averages: number of averaged segments, which overlap by half.
        detrend: one of `WELCH_DETRENDS`.
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
        part: first and last time of the samples used, if a part without long gaps was; else None
            [s].
    """

    frequency: np.ndarray
    density: np.ndarray
    rate: float
    segment: int
    resampled: bool
    part: tuple[float, float] | None = None


def power_spectrum(
    time: np.ndarray, values: np.ndarray, welch: WelchSettings, name: str = ""
) -> Spectrum:
    """Return the power spectral density of a signal, by scipy.signal.welch.

    Args:
        time: of the samples (n), increasing [s]; an even grid, except that single missing or late
            samples are interpolated linearly. Across a longer gap nothing is interpolated: the
            longest part without one is used.
        values: (n); values that are not finite count as missing.
        welch: the settings.
        name: of the signal, for messages.

    Raises:
        WorkbenchError: if there are too few samples, or they are too uneven.
    """
    import scipy.signal  # slow to load, and rarely needed

    time, values, part = longest_part(time, values)
    even, rate, resampled = even_samples(
        time, values, f"{name}: a spectrum" if name else SPECTRUM_PHRASE
    )
    size = len(even)
    segment = max(2 * (size // (welch.averages + 1)), MIN_SPECTRUM_SAMPLES)
    frequency, density = scipy.signal.welch(
        even,
        rate,
        window=welch.window,
        nperseg=segment,
        detrend=False if welch.detrend == "none" else welch.detrend,
        scaling="density",
    )
    return Spectrum(frequency, density, rate, segment, resampled, part)


def longest_part(
    time: np.ndarray, values: np.ndarray
) -> tuple[np.ndarray, np.ndarray, tuple[float, float] | None]:
    """Return the samples of the longest part without a gap that is too long to interpolate.

    Args:
        time: (n), increasing [s].
        values: (n); values that are not finite count as missing.

    Returns:
        Times and values of the part (m), and its ends [s]; None if it is all of them.
    """
    known = np.isfinite(values)
    time, values = time[known], np.asarray(values, dtype=float)[known]
    steps = np.diff(time)
    if not len(steps):
        return time, values, None
    long = np.flatnonzero(steps > MAX_SPECTRUM_GAP_PERIODS * float(np.median(steps)))
    firsts, lasts = np.append(0, long + 1), np.append(long, len(time) - 1)
    best = int(np.argmax(time[lasts] - time[firsts]))
    kept = slice(int(firsts[best]), int(lasts[best]) + 1)
    ends = (float(time[kept][0]), float(time[kept][-1])) if len(long) else None
    return time[kept], values[kept], ends


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
    if len(time) < MIN_SPECTRUM_SAMPLES:
        raise WorkbenchError(
            f"{what} needs {MIN_SPECTRUM_SAMPLES} samples, but there are only {len(time)}: show "
            "more time"
        )
    steps = np.diff(time)
    period = float(np.median(steps))
    if period <= 0.0:
        raise WorkbenchError(f"{what} needs rising times, but these do not rise")
    widest = int(steps.argmax())
    if steps[widest] > MAX_SPECTRUM_GAP_PERIODS * period:
        raise WorkbenchError(
            f"{what} needs evenly spaced samples, but there are none from {time[widest]:.2f} to "
            f"{time[widest + 1]:.2f} s: show a part without the gap"
        )
    span = float(time[-1] - time[0])
    grid = time[0] + span / (len(time) - 1) * np.arange(len(time))
    if np.abs(time - grid).max() <= MAX_JITTER_SHARE * period:
        return values, (len(time) - 1) / span, False
    count = 1 + round(span / period)
    if np.mean(np.abs(steps - period) > MAX_INTERPOLATED_SHARE * period) > MAX_UNEVEN_SHARE:
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
