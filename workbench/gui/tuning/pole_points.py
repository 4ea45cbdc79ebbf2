"""Poles as they are shown: where they lie, and what they mean."""

import math
from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class Pole:
    """One pole of the closed loop.

    Attributes:
        value: [1/s].
        proposed: whether it is of the proposed gains, else of those that fly.
    """

    value: complex
    proposed: bool

    @property
    def frequency(self) -> float:
        """Natural frequency [rad/s]."""
        return abs(self.value)

    @property
    def damping(self) -> float:
        """Ratio of damping; negative where it grows."""
        return -self.value.real / abs(self.value) if self.value else 1.0

    @property
    def is_stable(self) -> bool:
        """Whether it dies out."""
        return self.value.real < 0.0

    @property
    def text(self) -> str:
        """The pole in words."""
        whose = "proposed" if self.proposed else "flown"
        word = "" if self.is_stable else ", unstable"
        hertz = self.frequency / (2.0 * math.pi)
        where = f"{self.frequency:.3g} rad/s ({hertz:.3g} Hz)"
        return f"{whose}: {where}, damping {self.damping:.2f}{word}".replace("-", "−")


def shown_poles(flown: np.ndarray | None, proposed: np.ndarray | None) -> tuple[Pole, ...]:
    """Return the poles of both, upper half of the plane; those of the flown gains first."""
    found = []
    for values, is_proposed in ((flown, False), (proposed, True)):
        if values is not None:
            found += [Pole(complex(each), is_proposed) for each in values if each.imag >= -1e-9]
    return tuple(found)


def poles_headline(proposed: np.ndarray) -> str:
    """Return what the poles come to, in a sentence."""
    growing = int(np.count_nonzero(proposed.real >= 0.0))
    if growing:
        return f"{growing} unstable pole{'s' if growing > 1 else ''}."
    swinging = [Pole(complex(each), True) for each in proposed if abs(each.imag) > 1e-9]
    if not swinging:
        return "Nothing swings."
    least = min(swinging, key=lambda pole: pole.damping)
    return f"Least damping {least.damping:.2f}, at {least.frequency:.3g} rad/s."
