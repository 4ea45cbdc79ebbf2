"""The input of the excitation card, stored between starts, without its widgets."""

from dataclasses import dataclass, replace

from PyQt6.QtCore import QSettings

from workbench.common.errors import WorkbenchError, find_named_row
from workbench.scenario.attitude_axes import ATTITUDE_ROWS, AttitudeAxis
from workbench.scenario.axes import AXIS_ROWS, CommandAxis
from workbench.scenario.excitation import Excitation, Shape
from workbench.scenario.loads import GUST_ROWS, PUSH_ROWS, Load, find_excited

EXCITATION_SETTINGS_GROUP = "tuning/excitation"
EXCITATION_KIND_KEY = f"{EXCITATION_SETTINGS_GROUP}/kind"
"""Settings key of the last kind."""
PERIOD_LIMITS_S = (0.2, 30.0)
"""Limits of a period [s]."""
MIN_PUSH_DURATION_S = 0.1
"""Shortest duration of a push [s]."""
MIN_AMPLITUDE = 0.01
"""Smallest useful amplitude, in the axis' unit."""


@dataclass(frozen=True)
class ExcitationKind:
    """A kind of excitation.

    Attributes:
        name: name on its tab.
        rows: axes or loads that it can use.
        shapes: its shapes.
        period: default period [s].
        shortest: shortest period [s].
        start: text of the start button.
        stronger: default amplitudes, as multiples of those of its rows.
        repeats: default for repetition.
        help: its description.
        time: label of the period.
    """

    name: str
    rows: tuple[CommandAxis | AttitudeAxis | Load, ...]
    shapes: tuple[Shape, ...]
    period: float
    shortest: float
    start: str
    stronger: float
    repeats: bool
    help: str
    time: str = "&Period"

    def label(self, row: CommandAxis | AttitudeAxis | Load) -> str:
        """Return the short name of a row for this kind."""
        if isinstance(row, AttitudeAxis):
            return row.label
        return row.name.rpartition("_")[2]

    def find(self, name: str) -> int:
        """Return the index of a row of this kind; -1 if it has no such row."""
        return [row.name for row in self.rows].index(name)


STEP_SHAPES = (Shape.STEP, Shape.DOUBLET, Shape.SQUARE)
EXCITATION_KINDS = (
    ExcitationKind(
        "Setpoint",
        AXIS_ROWS,
        (*STEP_SHAPES, Shape.CHIRP),
        2.0,
        PERIOD_LIMITS_S[0],
        "Start",
        1.0,
        True,
        "A step of the commanded velocity or yaw rate",
    ),
    ExcitationKind(
        "Attitude",
        ATTITUDE_ROWS,
        (*STEP_SHAPES, Shape.CHIRP),
        1.0,
        PERIOD_LIMITS_S[0],
        "Start",
        1.0,
        True,
        "A step of the setpoint of roll, pitch or a rate of them; the loops outside are open",
    ),
    ExcitationKind(
        "Load",
        PUSH_ROWS,
        STEP_SHAPES,
        4.0,
        PERIOD_LIMITS_S[0],
        "Start",
        1.0,
        True,
        "A force at the centre of mass or a torque that comes and stays for the period",
    ),
    ExcitationKind(
        "Push",
        PUSH_ROWS,
        (Shape.PULSE,),
        0.2,
        MIN_PUSH_DURATION_S,
        "Push now",
        5.0,
        False,
        "A force at the centre of mass or a torque for a moment",
        "&Duration",
    ),
    ExcitationKind(
        "Gust",
        GUST_ROWS,
        (Shape.PULSE,),
        1.0,
        PERIOD_LIMITS_S[0],
        "Gust now",
        1.0,
        False,
        "Wind that rises to the amplitude and falls within the duration",
        "&Duration",
    ),
)


def find_kind(name: str) -> ExcitationKind:
    """Return the kind with a name.

    Raises:
        WorkbenchError: if there is none.
    """
    return find_named_row("kind of excitation", name, EXCITATION_KINDS)


def loop_excitation(loop: str) -> tuple[ExcitationKind, str] | None:
    """Return the kind and the axis that give the setpoint of a loop; None without one."""
    axis = "yaw" if loop == "yaw_rate" else loop.removeprefix("velocity_")
    for kind in EXCITATION_KINDS:
        if axis in (row.name for row in kind.rows):
            return kind, axis
    return None


@dataclass(frozen=True)
class ExcitationChoice:
    """The selected excitation, with the last amplitude of each axis.

    Attributes:
        axis: name of the axis.
        shape: shape over time.
        amplitudes: amplitudes of all axes of its kind, in order.
        period: period [s].
        repeats: whether it repeats.
        kind: kind of excitation.
    """

    axis: str = AXIS_ROWS[0].name
    shape: Shape = Shape.STEP
    amplitudes: tuple[float, ...] = tuple(axis.amplitude for axis in AXIS_ROWS)
    period: float = 2.0
    repeats: bool = True
    kind: ExcitationKind = EXCITATION_KINDS[0]

    @property
    def amplitude(self) -> float:
        """Amplitude of the selected axis."""
        return self.amplitudes[self.kind.find(self.axis)]

    @property
    def excitation(self) -> Excitation:
        """The excitation to fly."""
        return Excitation(self.axis, self.shape, self.amplitude, self.period, self.repeats)

    def with_amplitude(self, amplitude: float) -> "ExcitationChoice":
        """Return the choice with another amplitude of its axis."""
        place = self.kind.find(self.axis)
        values = (*self.amplitudes[:place], amplitude, *self.amplitudes[place + 1 :])
        return replace(self, amplitudes=values)


def first_choice(kind: ExcitationKind) -> ExcitationChoice:
    """Return the defaults of a kind."""
    sizes = tuple(kind.stronger * row.amplitude for row in kind.rows)
    return ExcitationChoice(
        kind.rows[0].name, kind.shapes[0], sizes, kind.period, kind.repeats, kind
    )


def reach_text(excitation: Excitation) -> str:
    """Return how far the command moves the drone along its axis, in words; "" for a rotation."""
    axis = find_excited(excitation.axis)
    if isinstance(axis, Load):
        return ""
    if isinstance(axis, AttitudeAxis) or axis.place is None or excitation.shape is Shape.CHIRP:
        return ""
    share = 1.0 if excitation.shape is Shape.STEP else 0.5
    way = excitation.amplitude * excitation.period * share
    return f"{way:.1f} m along {axis.name}, and back".replace("-", "−")


def load_kind(store: QSettings) -> ExcitationKind:
    """Return the stored kind; setpoints without a valid one."""
    try:
        return find_kind(str(store.value(EXCITATION_KIND_KEY, EXCITATION_KINDS[0].name)))
    except WorkbenchError:  # written by another version or an editor
        return EXCITATION_KINDS[0]


def load_choice(store: QSettings, kind: ExcitationKind = EXCITATION_KINDS[0]) -> ExcitationChoice:
    """Return the stored choice of a kind; the default without a valid one."""
    default, group = first_choice(kind), _kind_settings_group(kind)
    try:
        axis = str(store.value(f"{group}/axis", default.axis))
        kind.find(axis)
        shape = Shape(str(store.value(f"{group}/shape", default.shape.value)))
        period = float(str(store.value(f"{group}/period", default.period)))
        sizes = tuple(
            float(str(store.value(f"{group}/amplitude_{row.name}", size)))
            for row, size in zip(kind.rows, default.amplitudes, strict=True)
        )
    except (ValueError, WorkbenchError):  # written by another version or an editor
        return default
    repeats = str(store.value(f"{group}/repeats", default.repeats)).lower() == "true"
    if not kind.shortest <= period <= PERIOD_LIMITS_S[1] or any(size == 0.0 for size in sizes):
        return default
    if shape not in kind.shapes:
        return default
    return ExcitationChoice(axis, shape, sizes, period, repeats, kind)


def save_choice(store: QSettings, choice: ExcitationChoice) -> None:
    """Store a choice, and its kind, for the next start."""
    group = _kind_settings_group(choice.kind)
    store.setValue(EXCITATION_KIND_KEY, choice.kind.name)
    store.setValue(f"{group}/axis", choice.axis)
    store.setValue(f"{group}/shape", choice.shape.value)
    store.setValue(f"{group}/period", choice.period)
    store.setValue(f"{group}/repeats", choice.repeats)
    for row, amplitude in zip(choice.kind.rows, choice.amplitudes, strict=True):
        store.setValue(f"{group}/amplitude_{row.name}", amplitude)


def _kind_settings_group(kind: ExcitationKind) -> str:
    """Return the settings group of a kind; that of setpoints has its original name."""
    return (
        EXCITATION_SETTINGS_GROUP
        if kind is EXCITATION_KINDS[0]
        else f"{EXCITATION_SETTINGS_GROUP}/{kind.name.lower()}"
    )
