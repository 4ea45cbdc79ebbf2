"""Layouts: charts with their kinds and signals; presets, and files."""

import dataclasses
import json
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from workbench.common.errors import WorkbenchError, unknown_name
from workbench.common.yaml_files import YamlFile, check_schema, dump_changes, read_yaml
from workbench.gui.visualization.derived_signals import OWN_TOPIC, Derived
from workbench.logs.spectrum import DETRENDS, WINDOWS, Welch

MOST_CHARTS = 8
VERSION = 1
"""Version of the files."""
TIME, SPECTRUM, XY, STEPS = "time", "spectrum", "x-y", "steps"
KINDS = (TIME, SPECTRUM, XY, STEPS)
"""Horizontal quantities of charts: time, frequency, another signal, time after steps of a
command."""


@dataclass(frozen=True)
class ChartSpec:
    """A chart.

    Attributes:
        title: title above it.
        signals: names of its signals; of an x-y chart the first is x, of steps the command.
        kind: one of `KINDS`.
        log_x: whether the horizontal axis is logarithmic; a time axis never is.
        log_y: whether the value axes are logarithmic.
        equal: whether the axes of an x-y chart have the same scale.
        window: window of a spectrum's segments.
        averages: number of segments over which a spectrum is averaged.
        detrend: trend that is removed from each segment.
    """

    title: str = ""
    signals: tuple[str, ...] = ()
    kind: str = TIME
    log_x: bool = False
    log_y: bool = False
    equal: bool = False
    window: str = Welch.window
    averages: int = Welch.averages
    detrend: str = Welch.detrend

    def of_kind(self, kind: str) -> "ChartSpec":
        """Return it as a chart of another kind; a spectrum gets logarithmic axes at first."""
        log = kind == SPECTRUM
        return dataclasses.replace(self, kind=kind, log_x=log, log_y=log)


Board = tuple[ChartSpec, ...]


def _names(topic: str, fields: str) -> tuple[str, ...]:
    return tuple(f"{topic}.{field}" for field in fields.split())


_VELOCITY = ChartSpec(
    "Velocity and command",
    _names("velocity_data", "v_x v_y v_z") + _names("command_velocity", "v_x v_y v_z"),
)
_ATTITUDE = ChartSpec("Attitude", _names("position_data", "roll pitch yaw"))
_THRUSTS = ChartSpec("Rotor thrusts", _names("rotors", "thrust.0 thrust.1 thrust.2 thrust.3"))
_VELOCITY_ERROR = ChartSpec("Velocity error", _names("error", "v_x v_y v_z"))


def _spectrum(title: str, topic: str, fields: str) -> ChartSpec:
    return ChartSpec(title, _names(topic, fields)).of_kind(SPECTRUM)


def _estimated(title: str, field: str) -> ChartSpec:
    bounds = _names("bound", f"{field}_low {field}_high")
    truth = "velocity_data" if field.startswith("v_") else "position_data"
    return ChartSpec(title, (f"{truth}.{field}", f"estimate.{field}", *bounds))


PRESETS: dict[str, Board] = {
    "Flight": (_VELOCITY, _ATTITUDE, _THRUSTS, _VELOCITY_ERROR),
    "Rotors": (
        _THRUSTS,
        ChartSpec("Rotor speeds", _names("rotors", "speed.0 speed.1 speed.2 speed.3")),
        ChartSpec("Torque", _names("force_torque_data", "torque_x torque_y torque_z")),
        ChartSpec("Turning rates", _names("velocity_data", "w_x w_y w_z")),
    ),
    "Errors": (
        _VELOCITY_ERROR,
        ChartSpec("Yaw rate error", _names("error", "yaw_rate")),
        _VELOCITY,
        ChartSpec(
            "Yaw rate and command",
            ("velocity_data.w_z", "command_velocity.yaw_rate"),
        ),
    ),
    "Sensors": (
        ChartSpec(
            "Specific force",
            _names("imu", "specific_force.0 specific_force.1 specific_force.2"),
        ),
        ChartSpec(
            "Gyroscope",
            _names("imu", "angular_velocity.0 angular_velocity.1 angular_velocity.2"),
        ),
        ChartSpec("GPS velocity", _names("gps", "velocity.0 velocity.1 velocity.2")),
        ChartSpec("Nearest lidar return", _names("lidar", "nearest")),
    ),
    "Spectra": (
        _spectrum("Gyroscope", "imu", "angular_velocity.0 angular_velocity.1 angular_velocity.2"),
        _spectrum("Specific force", "imu", "specific_force.0 specific_force.1 specific_force.2"),
        _spectrum("Rotor speeds", "rotors", "speed.0 speed.1 speed.2 speed.3"),
        _spectrum("Velocity error", "error", "v_x v_y v_z"),
    ),
    "Steps": (
        *(
            ChartSpec(
                f"Steps of {axis}", (f"command_velocity.{axis}", f"velocity_data.{axis}"), STEPS
            )
            for axis in ("v_x", "v_y", "v_z")
        ),
        ChartSpec(
            "Steps of the yaw rate", ("command_velocity.yaw_rate", "velocity_data.w_z"), STEPS
        ),
    ),
    "Path": (
        ChartSpec("From above", _names("position_data", "x y"), XY, equal=True),
        ChartSpec("From the side", _names("position_data", "x z"), XY, equal=True),
        ChartSpec("Speed", ("derived.speed",)),
        ChartSpec("Height", ("position_data.z",)),
    ),
    "Estimate": (
        _estimated("East: truth, estimate, 2 sigma", "x"),
        _estimated("North", "y"),
        _estimated("Height", "z"),
        _estimated("Roll", "roll"),
        _estimated("Pitch", "pitch"),
        _estimated("Yaw", "yaw"),
        _estimated("Velocity east", "v_x"),
        _estimated("Velocity north", "v_y"),
    ),
    "Autopilot's log": (
        ChartSpec(
            "Attitude and setpoint",
            _names("estimate", "roll pitch yaw") + _names("attitude_setpoint", "roll pitch yaw"),
        ),
        ChartSpec(
            "Gyroscope and setpoint",
            _names("imu", "angular_velocity.0 angular_velocity.1 angular_velocity.2")
            + _names("rate_setpoint", "w_x w_y w_z"),
        ),
        ChartSpec("Motor commands", _names("motors", "command_1 command_2 command_3 command_4")),
        ChartSpec("Place and setpoint", _names("estimate", "x y z") + _names("setpoint", "x y z")),
    ),
}
DEFAULT = "Flight"


@dataclass(frozen=True)
class Layout:
    """Content of a layout file.

    Attributes:
        version: version of the file.
        charts: charts in order.
        signals: signals derived by the user's own expressions.
        marks: times of cursors A and B [s].
    """

    version: int = 0
    charts: Board = ()
    signals: tuple[Derived, ...] = ()
    marks: dict[str, float] = field(default_factory=dict)


def layout_text(layout: Layout) -> str:
    """Return a layout as a file's text."""
    return dump_changes(dataclasses.replace(layout, version=VERSION))


def read_layout(path: Path) -> Layout:
    """Read a layout.

    Raises:
        WorkbenchError: names file and line of an error.
    """
    return _layout_from(read_yaml(path))


def kept_text(layout: Layout) -> str:
    """Return a layout in one line, for storage between starts."""
    return json.dumps(dataclasses.asdict(dataclasses.replace(layout, version=VERSION)))


def read_kept(text: str) -> Layout | None:
    """Return the stored layout; None if the text is invalid."""
    try:
        data = json.loads(text)
        if isinstance(data, list):  # format of the app before it had layouts
            data = {"version": VERSION, "charts": data}
        layout = _layout_from(YamlFile(Path("kept layout"), text, data, {}))
    except (ValueError, WorkbenchError):  # written by another version or an editor
        return None
    return layout if layout.charts else None


def _layout_from(file: YamlFile) -> Layout:
    """Return the layout from a file's content.

    Raises:
        WorkbenchError: if it is invalid.
    """
    check_schema(file, Layout)
    data = file.data
    version = data.get("version", 0)
    if version != VERSION:
        raise WorkbenchError(
            f"{file.where('version')}this is version {version} of a layout, but the app reads "
            f"{VERSION}: begin the file with 'version: 1', or update the workbench"
        )
    charts = tuple(_made(ChartSpec, each) for each in data.get("charts", []))
    if len(charts) > MOST_CHARTS:
        raise WorkbenchError(
            f"{file.where('charts', MOST_CHARTS)}at most {MOST_CHARTS} charts are allowed: leave "
            "out the others"
        )
    for index, chart in enumerate(charts):
        for key, known in (("kind", KINDS), ("window", WINDOWS), ("detrend", DETRENDS)):
            if getattr(chart, key) not in known:
                where = file.where("charts", index, key)
                raise WorkbenchError(f"{where}{unknown_name(key, getattr(chart, key), known)}")
        if chart.averages < 1:
            where = file.where("charts", index, "averages")
            raise WorkbenchError(f"{where}averages is {chart.averages}: average over 1 at least")
    signals = tuple(_made(Derived, each) for each in data.get("signals", []))
    for index, signal in enumerate(signals):
        where = file.where("signals", index)
        if not signal.name.startswith(f"{OWN_TOPIC}."):
            raise WorkbenchError(f"{where}'{signal.name}' should begin with {OWN_TOPIC}.")
        try:
            signal.check()
        except WorkbenchError as error:
            raise WorkbenchError(f"{where}{error}") from error
    for name in data.get("marks", {}):
        if name not in ("A", "B"):
            raise WorkbenchError(f"{file.where('marks', name)}{unknown_name('mark', name, 'AB')}")
    return Layout(version, charts, signals, dict(data.get("marks", {})))


def _made(kind: Any, data: dict[str, Any]) -> Any:
    """Return a record from data that match its schema."""
    lists = {key: tuple(value) for key, value in data.items() if isinstance(value, list)}
    return kind(**(data | lists))
