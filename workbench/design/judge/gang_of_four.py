"""The gang of four of a loop over frequency: S, T, KS and GS.

Åström and Murray, Feedback Systems (2nd edition, 2021), section 12.1, call them sensitivity,
complementary sensitivity, noise sensitivity CS and load sensitivity PS.
"""

from dataclasses import dataclass

import numpy as np

from workbench.control.loop import Loop
from workbench.design.judge.loop_response import loop_responses
from workbench.design.judge.margins import LoopMargins, frequency_grid, response_margins
from workbench.design.linear.model import LinearModel, frequency_response

MIN_GANG_FREQUENCY_RAD_S = 0.05
"""Lowest frequency of curves [rad/s], with a period of two minutes."""


@dataclass(frozen=True)
class GangOfFour:
    """The gang of four of a loop over frequency, of the sampled model for one of that kind.

    KS is the response of the loop at `control` to noise at `error`. GS is the response of the
    controlled quantity to a load: an amount added to `control`, after the law and before
    allocation, hold, delays and rotors. Both include the effect of the outer loops.

    Attributes:
        cut: the loop point where L, S and T are taken.
        error: the loop point of its error.
        control: the loop point of its output.
        error_unit: SI unit of the error.
        control_unit: SI unit of the control.
        frequency: (F), increasing; up to half the rate of a sampled model [rad/s].
        open_loop: (F) L, with negative feedback.
        control_sensitivity: (F) KS [control_unit / error_unit].
        load_sensitivity: (F) GS [error_unit / control_unit].
        margins: of the loop at the cut.
    """

    cut: str
    error: str
    control: str
    error_unit: str
    control_unit: str
    frequency: np.ndarray
    open_loop: np.ndarray
    control_sensitivity: np.ndarray
    load_sensitivity: np.ndarray
    margins: LoopMargins

    @property
    def sensitivity(self) -> np.ndarray:
        """S = 1 / (1 + L), (F)."""
        response: np.ndarray = 1.0 / (1.0 + self.open_loop)
        return response

    @property
    def control_per_error(self) -> str:
        """Unit of KS."""
        return _ratio_unit(self.control_unit, self.error_unit)

    @property
    def error_per_control(self) -> str:
        """Unit of GS."""
        return _ratio_unit(self.error_unit, self.control_unit)

    @property
    def complementary_sensitivity(self) -> np.ndarray:
        """T = L / (1 + L), (F)."""
        return self.open_loop * self.sensitivity


def gang_of_four(model: LinearModel, loop: Loop, cut: str = "actuator") -> GangOfFour:
    """Return the gang of four of a loop.

    Args:
        model: of the closed loop; one that holds its position for a loop that holds a position.
        loop: one of the loops of its controller.
        cut: where to take L, actuator or error.

    Raises:
        WorkbenchError: for another cut.
    """
    cut_at, control = loop.point(cut), control_point(model, loop)
    loops = loop_responses(model, [cut_at])
    frequency = frequency_grid(loops)
    frequency = frequency[frequency >= min(MIN_GANG_FREQUENCY_RAD_S, 0.01 * frequency[-1])]
    # both from injections to signals at the same points, as one closed loop: (F, 2, 2)
    places = [loop.error, control]
    response = frequency_response(model, frequency, places, places)
    (_, load), (noise, _) = response.transpose(1, 2, 0)
    if control == loop.error:  # what comes there, and what is added, goes on
        noise = 1.0 + noise
    units = {signal.name: signal.unit for signal in model.outputs}
    return GangOfFour(
        cut=cut_at,
        error=loop.error,
        control=control,
        error_unit=units[loop.error],
        control_unit=units[control],
        frequency=frequency,
        open_loop=loops.at(frequency)[0],
        control_sensitivity=noise,
        load_sensitivity=-load,
        margins=response_margins(loops)[0],
    )


def control_point(model: LinearModel, loop: Loop) -> str:
    """Return the loop point of the output of a loop.

    For a loop that passes on its error directly, such as a position loop, this is the next inner
    loop along the same axis; without one, its output is its error.
    """
    if loop.actuator not in ("", loop.error):
        return loop.actuator
    names = [each.name for each in model.loops]
    place = names.index(loop.name)
    inside = [*model.loops[place + 1 :], *model.loops[:place]]
    found = (
        each.actuator
        for each in inside
        if loop.axis and each.axis == loop.axis and each.actuator not in ("", each.error)
    )
    return next(found, loop.error)


def _ratio_unit(above: str, below: str) -> str:
    """Return the unit of a ratio of two, such as (m/s^2)/(m/s)."""
    if above == below:
        return "1"
    return "/".join(f"({unit})" if "/" in unit else unit for unit in (above, below))
