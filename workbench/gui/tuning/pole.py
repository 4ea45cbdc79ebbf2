"""A pole of the closed loop as drawn, and the poles of flown and proposed gains in words."""

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from workbench.analysis.replies import Judged
from workbench.common.plain_text import plain_name
from workbench.common.quantity import number_text
from workbench.control.loop import loop_label
from workbench.design.judge.loop_response import growing_poles
from workbench.gui.units import frequency_text, hertz_text


@dataclass(frozen=True)
class Pole:
    """One pole of the closed loop.

    Attributes:
        value: its value [1/s].
        proposed: whether it belongs to the proposed gains, else to the flown ones, or to `whose`.
        loop: name of the loop that it belongs to, "" for none or if unknown.
        whose: name of its design, if several are compared.
        colour: number of that design's colour.
        joint: name of the joint that moves most in it, "" for none.
    """

    value: complex
    proposed: bool
    loop: str = ""
    whose: str = ""
    colour: int = 0
    joint: str = ""

    @property
    def frequency(self) -> float:
        """Natural frequency [rad/s]."""
        return abs(self.value)

    @property
    def damping(self) -> float:
        """Damping ratio; negative if unstable."""
        return -self.value.real / abs(self.value) if self.value else 1.0

    @property
    def is_stable(self) -> bool:
        """Whether it does not grow; an idle integrator, at 0 but for rounding, does not."""
        return not growing_poles(np.array([self.value]), 0.0).any()

    @property
    def text(self) -> str:
        """The pole in words."""
        whose = self.whose or ("proposed" if self.proposed else "flown")
        word = "" if self.is_stable else ", unstable"
        numbers = f"{whose}: {hertz_text(self.frequency)}, {damping_text(self.damping)}{word}"
        return f"{numbers}{self.owner}"

    @property
    def owner(self) -> str:
        """What it belongs to, in words after a comma; "" if that is not known."""
        joint = f", of the joint {plain_name(self.joint)}" if self.joint else ""
        loop = f", of the loop {loop_label(self.loop)}" if self.loop else ""
        return joint + loop


def drawn_poles(flown: Judged | None, proposed: Judged | None) -> tuple[Pole, ...]:
    """Return the poles for both sets of gains, upper half of the plane; the flown ones first."""
    return *poles_of(flown, proposed=False), *poles_of(proposed, proposed=True)


def poles_of(
    judged: Judged | None, *, proposed: bool, whose: str = "", colour: int = 0
) -> tuple[Pole, ...]:
    """Return the poles of a judgement, upper half of the plane.

    Args:
        judged: with the poles; None has none.
        proposed: see `Pole`, as are the others.
        whose: name of the design.
        colour: of it.
    """
    if judged is None:
        return ()
    loops, joints = (
        names or [""] * len(judged.poles) for names in (judged.pole_loops, judged.pole_joints)
    )
    return tuple(
        Pole(complex(value), proposed, loop, joint=joint, whose=whose, colour=colour)
        for value, loop, joint in zip(judged.poles, loops, joints, strict=True)
        if value.imag >= -1e-9
    )


def leading_pole(poles: Iterable[Pole]) -> Pole | None:
    """Return the proposed pole that grows fastest, or else the least damped one, if any."""
    proposed = [pole for pole in poles if pole.proposed]
    growing = [pole for pole in proposed if not pole.is_stable]
    if growing:
        return max(growing, key=lambda pole: pole.value.real)
    swinging = [pole for pole in proposed if abs(pole.value.imag) > 1e-9]
    return min(swinging, key=lambda pole: pole.damping, default=None)


def poles_headline(poles: Iterable[Pole]) -> str:
    """Return a summary of the proposed poles, as a sentence: it names the leading one's loop."""
    drawn = tuple(poles)
    leading = leading_pole(drawn)
    if leading is None:
        return "Nothing oscillates."
    if leading.is_stable:
        where = f"at {frequency_text(leading.frequency)}{leading.owner}"
        return f"Least {damping_text(leading.damping)}, {where}."
    growing = sum(
        (1 if pole.value.imag <= 1e-9 else 2)
        for pole in drawn
        if pole.proposed and not pole.is_stable
    )
    return f"{growing} unstable pole{'s' if growing > 1 else ''}{leading.owner}."


def damping_text(damping: float) -> str:
    """Return the damping of a pole, with its name."""
    return f"damping {number_text(damping, 2)}"
