"""What the excitation card asks for, kept between starts: apart from its widgets."""

from dataclasses import dataclass, replace

from PyQt6.QtCore import QSettings

from workbench.common.errors import WorkbenchError
from workbench.scenario.axes import AXIS_ROWS, find_axis
from workbench.scenario.excitation import Excitation, Shape

GROUP = "tuning/excitation"
PERIODS = (0.2, 30.0)
"""That may be asked for [s]."""
LEAST = 0.01
"""Amplitude that still says something, in the axis' unit."""


@dataclass(frozen=True)
class ExcitationChoice:
    """An excitation as it is chosen, with the amplitude that each axis had last.

    Attributes:
        axis: its name.
        shape: over time.
        amplitudes: of all axes, in their order.
        period: [s].
        repeats: whether it begins again.
    """

    axis: str = AXIS_ROWS[0].name
    shape: Shape = Shape.STEP
    amplitudes: tuple[float, ...] = tuple(axis.amplitude for axis in AXIS_ROWS)
    period: float = 2.0
    repeats: bool = True

    @property
    def amplitude(self) -> float:
        """Of the chosen axis."""
        return self.amplitudes[AXIS_ROWS.index(find_axis(self.axis))]

    @property
    def excitation(self) -> Excitation:
        """What is to be flown."""
        return Excitation(self.axis, self.shape, self.amplitude, self.period, self.repeats)

    def with_amplitude(self, amplitude: float) -> "ExcitationChoice":
        """Return the choice with another amplitude along its axis."""
        place = AXIS_ROWS.index(find_axis(self.axis))
        values = (*self.amplitudes[:place], amplitude, *self.amplitudes[place + 1 :])
        return replace(self, amplitudes=values)


def reach_text(excitation: Excitation) -> str:
    """Return how far the command leads the drone along its axis, in words; "" for yaw."""
    axis = find_axis(excitation.axis)
    if axis.place is None or excitation.shape is Shape.CHIRP:
        return ""
    share = 1.0 if excitation.shape is Shape.STEP else 0.5
    way = excitation.amplitude * excitation.period * share
    return f"{way:.1f} m along {axis.name}, and back".replace("-", "−")


def load_choice(store: QSettings) -> ExcitationChoice:
    """Return the choice that was kept; the default one where nothing sensible is."""
    default = ExcitationChoice()
    try:
        axis = find_axis(str(store.value(f"{GROUP}/axis", default.axis))).name
        shape = Shape(str(store.value(f"{GROUP}/shape", default.shape.value)))
        period = float(str(store.value(f"{GROUP}/period", default.period)))
        sizes = tuple(
            float(str(store.value(f"{GROUP}/amplitude_{axis.name}", axis.amplitude)))
            for axis in AXIS_ROWS
        )
    except (ValueError, WorkbenchError):  # another version wrote it, or an editor
        return default
    repeats = str(store.value(f"{GROUP}/repeats", default.repeats)).lower() == "true"
    if not PERIODS[0] <= period <= PERIODS[1] or any(size == 0.0 for size in sizes):
        return default
    return ExcitationChoice(axis, shape, sizes, period, repeats)


def keep_choice(store: QSettings, choice: ExcitationChoice) -> None:
    """Keep a choice for the next start."""
    store.setValue(f"{GROUP}/axis", choice.axis)
    store.setValue(f"{GROUP}/shape", choice.shape.value)
    store.setValue(f"{GROUP}/period", choice.period)
    store.setValue(f"{GROUP}/repeats", choice.repeats)
    for axis, amplitude in zip(AXIS_ROWS, choice.amplitudes, strict=True):
        store.setValue(f"{GROUP}/amplitude_{axis.name}", amplitude)
