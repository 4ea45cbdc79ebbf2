"""Layouts: charts with their kinds and signals; presets, and files."""

import dataclasses
import json
from collections.abc import Container, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from workbench.common.errors import WorkbenchError, unknown_name
from workbench.common.yaml_files import YamlFile, check_schema, dump_changes, read_yaml
from workbench.gui.charts.chart_kind import (
    SPECTRUM_CHART,
    STEP_CHART,
    TIME_CHART,
    XY_CHART,
    chart_kinds,
)
from workbench.gui.visualization.derived_signals import OWN_TOPIC, DerivedSignal, true_signal
from workbench.logs.logged_signal import topic_signals
from workbench.logs.spectrum import WELCH_DETRENDS, WELCH_WINDOWS, WelchSettings

MAX_BOARD_CHARTS = 8
LAYOUT_VERSION = 1
"""Version of the files."""


@dataclass(frozen=True)
class ChartSpec:
    """A chart.

    Attributes:
        title: title above it.
        signals: names of its signals; of an x-y chart the first is x, of steps the command.
        kind: name of one of `chart_kinds`.
        log_x: whether the horizontal axis is logarithmic; a time axis never is.
        log_y: whether the value axes are logarithmic.
        equal: whether the axes of an x-y chart have the same scale.
        window: window of a spectrum's segments.
        averages: number of segments over which a spectrum is averaged.
        detrend: trend that is removed from each segment.
    """

    title: str = ""
    signals: tuple[str, ...] = ()
    kind: str = TIME_CHART
    log_x: bool = False
    log_y: bool = False
    equal: bool = False
    window: str = WelchSettings.window
    averages: int = WelchSettings.averages
    detrend: str = WelchSettings.detrend

    def of_kind(self, kind: str) -> "ChartSpec":
        """Return it as a chart of another kind; a spectrum gets logarithmic axes at first."""
        log = kind == SPECTRUM_CHART
        return dataclasses.replace(self, kind=kind, log_x=log, log_y=log)


Board = tuple[ChartSpec, ...]


_VELOCITY_CHART = ChartSpec(
    "Velocity and command",
    topic_signals("velocity_data", "v_x v_y v_z")
    + topic_signals("command_velocity", "v_x v_y v_z"),
)
_ATTITUDE_CHART = ChartSpec("Attitude", topic_signals("position_data", "roll pitch yaw"))
_THRUSTS_CHART = ChartSpec(
    "Rotor thrusts", topic_signals("rotors", "thrust.0 thrust.1 thrust.2 thrust.3")
)
_VELOCITY_ERROR_CHART = ChartSpec("Velocity error", topic_signals("error", "v_x v_y v_z"))


def _spectrum_chart(title: str, topic: str, fields: str) -> ChartSpec:
    return ChartSpec(title, topic_signals(topic, fields)).of_kind(SPECTRUM_CHART)


def _estimate_chart(title: str, field: str) -> ChartSpec:
    bounds = topic_signals("bound", f"{field}_low {field}_high")
    return ChartSpec(title, (true_signal(field), f"estimate.{field}", *bounds))


LAYOUT_PRESETS: dict[str, Board] = {
    "Flight": (_VELOCITY_CHART, _ATTITUDE_CHART, _THRUSTS_CHART, _VELOCITY_ERROR_CHART),
    "Rotors": (
        _THRUSTS_CHART,
        ChartSpec("Rotor speeds", topic_signals("rotors", "speed.0 speed.1 speed.2 speed.3")),
        ChartSpec("Torque", topic_signals("force_torque_data", "torque_x torque_y torque_z")),
        ChartSpec("Turning rates", topic_signals("velocity_data", "w_x w_y w_z")),
    ),
    "Errors": (
        _VELOCITY_ERROR_CHART,
        ChartSpec("Yaw rate error", topic_signals("error", "yaw_rate")),
        _VELOCITY_CHART,
        ChartSpec(
            "Yaw rate and command",
            ("velocity_data.w_z", "command_velocity.yaw_rate"),
        ),
    ),
    "Sensors": (
        ChartSpec(
            "Specific force",
            topic_signals("imu", "specific_force.0 specific_force.1 specific_force.2"),
        ),
        ChartSpec(
            "Gyroscope",
            topic_signals("imu", "angular_velocity.0 angular_velocity.1 angular_velocity.2"),
        ),
        ChartSpec("GPS velocity", topic_signals("gps", "velocity.0 velocity.1 velocity.2")),
        ChartSpec("Nearest lidar return", topic_signals("lidar", "nearest")),
    ),
    "Spectra": (
        _spectrum_chart(
            "Gyroscope", "imu", "angular_velocity.0 angular_velocity.1 angular_velocity.2"
        ),
        _spectrum_chart(
            "Specific force", "imu", "specific_force.0 specific_force.1 specific_force.2"
        ),
        _spectrum_chart("Rotor speeds", "rotors", "speed.0 speed.1 speed.2 speed.3"),
        _spectrum_chart("Velocity error", "error", "v_x v_y v_z"),
    ),
    "Steps": (
        *(
            ChartSpec(
                f"Steps of {axis}",
                (f"command_velocity.{axis}", f"velocity_data.{axis}"),
                STEP_CHART,
            )
            for axis in ("v_x", "v_y", "v_z")
        ),
        ChartSpec(
            "Steps of the yaw rate", ("command_velocity.yaw_rate", "velocity_data.w_z"), STEP_CHART
        ),
    ),
    "Path": (
        ChartSpec("From above", topic_signals("position_data", "x y"), XY_CHART, equal=True),
        ChartSpec("From the side", topic_signals("position_data", "x z"), XY_CHART, equal=True),
        ChartSpec("Speed", ("derived.speed",)),
        ChartSpec("Height", ("position_data.z",)),
    ),
    "Estimate": (
        _estimate_chart("East: truth, estimate, 2 sigma", "x"),
        _estimate_chart("North", "y"),
        _estimate_chart("Height", "z"),
        _estimate_chart("Roll", "roll"),
        _estimate_chart("Pitch", "pitch"),
        _estimate_chart("Yaw", "yaw"),
        _estimate_chart("Velocity east", "v_x"),
        _estimate_chart("Velocity north", "v_y"),
    ),
    "Autopilot's log": (
        ChartSpec(
            "Attitude and setpoint",
            topic_signals("estimate", "roll pitch yaw")
            + topic_signals("attitude_setpoint", "roll pitch yaw"),
        ),
        ChartSpec(
            "Gyroscope and setpoint",
            topic_signals("imu", "angular_velocity.0 angular_velocity.1 angular_velocity.2")
            + topic_signals("rate_setpoint", "w_x w_y w_z"),
        ),
        ChartSpec(
            "Motor commands", topic_signals("motors", "command_1 command_2 command_3 command_4")
        ),
        ChartSpec(
            "Place and setpoint",
            topic_signals("estimate", "x y z") + topic_signals("setpoint", "x y z"),
        ),
    ),
}
DEFAULT_PRESET = "Flight"
MIN_SHOWN_SHARE = 0.5
"""Share of the signals of charts below which other charts suit a log better."""
MAX_OWN_CHARTS = 4
MAX_OWN_CHART_SIGNALS = 6
DERIVED_TOPICS = ("derived", "error", "bound", OWN_TOPIC)
"""Topics of signals that are made from others."""


def fitting_board(board: Board, units: Mapping[str, str]) -> Board:
    """Return charts that suit a log; if no layout has any of its signals, the first of these.

    Args:
        board: charts that are shown now; they stay if the log has half of their signals.
        units: of the signals of the log, by name.
    """
    choices = (board, *LAYOUT_PRESETS.values())
    shares = [_shown_share(each, units) for each in choices]
    if shares[0] >= MIN_SHOWN_SHARE:
        return board
    return choices[shares.index(max(shares))] if any(shares) else _own_charts(units) or board


def _own_charts(units: Mapping[str, str]) -> Board:
    """Return charts of the first signals of a log, one for each topic and unit."""
    charts: dict[tuple[str, str], list[str]] = {}
    for name, unit in units.items():
        topic = name.partition(".")[0]
        if topic not in DERIVED_TOPICS:
            charts.setdefault((topic, unit), []).append(name)
    return tuple(
        ChartSpec(f"{topic} [{unit or '1'}]", tuple(names[:MAX_OWN_CHART_SIGNALS]))
        for (topic, unit), names in [*charts.items()][:MAX_OWN_CHARTS]
    )


def _shown_share(board: Board, names: Container[str]) -> float:
    """Return the share of the signals of charts that exist, of those that are logged."""
    every = [name for chart in board for name in chart.signals]
    wanted = [name for name in every if name.partition(".")[0] not in DERIVED_TOPICS]
    return sum(name in names for name in wanted) / max(1, len(wanted))


@dataclass(frozen=True)
class ChartLayout:
    """Content of a layout file.

    Attributes:
        version: version of the file.
        charts: charts in order.
        signals: signals derived by the user's own expressions.
        marks: times of cursors A and B [s].
    """

    version: int = 0
    charts: Board = ()
    signals: tuple[DerivedSignal, ...] = ()
    marks: dict[str, float] = field(default_factory=dict)


def layout_text(layout: ChartLayout) -> str:
    """Return a layout as a file's text."""
    return dump_changes(dataclasses.replace(layout, version=LAYOUT_VERSION))


def read_layout(path: Path) -> ChartLayout:
    """Read a layout.

    Raises:
        WorkbenchError: names file and line of an error.
    """
    return _layout_from(read_yaml(path))


def stored_layout_text(layout: ChartLayout) -> str:
    """Return a layout in one line, for storage between starts."""
    return json.dumps(dataclasses.asdict(dataclasses.replace(layout, version=LAYOUT_VERSION)))


def read_stored_layout(text: str) -> ChartLayout | None:
    """Return the stored layout; None if the text is invalid."""
    try:
        data = json.loads(text)
        if isinstance(data, list):  # format of the app before it had layouts
            data = {"version": LAYOUT_VERSION, "charts": data}
        layout = _layout_from(YamlFile(Path("kept layout"), text, data, {}))
    except (ValueError, WorkbenchError):  # written by another version or an editor
        return None
    return layout if layout.charts else None


def _layout_from(file: YamlFile) -> ChartLayout:
    """Return the layout from a file's content.

    Raises:
        WorkbenchError: if it is invalid.
    """
    check_schema(file, ChartLayout)
    data = file.data
    version = data.get("version", 0)
    if version != LAYOUT_VERSION:
        raise WorkbenchError(
            f"{file.where('version')}this is version {version} of a layout, but the app reads "
            f"{LAYOUT_VERSION}: begin the file with 'version: 1', or update the workbench"
        )
    charts = tuple(_layout_record(ChartSpec, each) for each in data.get("charts", []))
    if len(charts) > MAX_BOARD_CHARTS:
        raise WorkbenchError(
            f"{file.where('charts', MAX_BOARD_CHARTS)}at most {MAX_BOARD_CHARTS} charts are "
            "allowed: leave "
            "out the others"
        )
    for index, chart in enumerate(charts):
        for key, known in (
            ("kind", tuple(chart_kinds())),
            ("window", WELCH_WINDOWS),
            ("detrend", WELCH_DETRENDS),
        ):
            if getattr(chart, key) not in known:
                where = file.where("charts", index, key)
                raise WorkbenchError(f"{where}{unknown_name(key, getattr(chart, key), known)}")
        if chart.averages < 1:
            where = file.where("charts", index, "averages")
            raise WorkbenchError(f"{where}averages is {chart.averages}: average over 1 at least")
    signals = tuple(_layout_record(DerivedSignal, each) for each in data.get("signals", []))
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
    return ChartLayout(version, charts, signals, dict(data.get("marks", {})))


def _layout_record(kind: Any, data: dict[str, Any]) -> Any:
    """Return a record from data that match its schema."""
    lists = {key: tuple(value) for key, value in data.items() if isinstance(value, list)}
    return kind(**(data | lists))
