"""Figures of a log: an overview, or requested fields over time or as spectra."""

import re
import shlex
from collections.abc import Mapping, Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from workbench.common.errors import WorkbenchError
from workbench.common.plain_text import plain_name
from workbench.design.plots import (
    PALETTE,
    RIGHT,
    curve_name,
    draw_command,
    label,
    legend,
    stacked,
    styled,
    widen,
)
from workbench.logs.expressions import Samples, parse_expression
from workbench.logs.flight_record import FlightRecord, Signal
from workbench.logs.record import LogRecord
from workbench.logs.spectrum import Welch, density_unit, power_spectrum
from workbench.logs.step_response import StepEstimate

MOST_CURVES = 16
"""Largest number of curves in a panel; more cannot be distinguished."""
TIME = "time [s]"
_LEAST_TIME = 0.1
"""Smallest span of the time axis [s]."""
_PER_CHARACTER = 0.075
"""Width of a character in a legend [inch]."""
_OVER = ("--", ":", "-.")
"""Style of the curves of other logs."""


def _parts(topic: str, fields: str) -> tuple[str, ...]:
    return tuple(f"{topic}.{field}" for field in fields.split())


_PANELS: tuple[tuple[str, tuple[tuple[str, ...], ...], tuple[str, ...], float], ...] = (
    (
        "position in W",
        (_parts("position_data", "x y z"), _parts("estimate", "x y z")),
        _parts("setpoint", "x y z"),
        0.5,
    ),
    (
        "velocity in W",
        (_parts("velocity_data", "v_x v_y v_z"), _parts("estimate", "v_x v_y v_z")),
        _parts("setpoint", "v_x v_y v_z"),
        0.2,
    ),
    (
        "attitude",
        (_parts("position_data", "roll pitch yaw"), _parts("estimate", "roll pitch yaw")),
        _parts("attitude_setpoint", "roll pitch yaw"),
        0.05,
    ),
    (
        "angular velocity in B",
        (_parts("imu", "angular_velocity.x angular_velocity.y angular_velocity.z"),),
        _parts("rate_setpoint", "w_x w_y w_z"),
        0.05,
    ),
    ("motor commands", (_parts("motors", " ".join(f"command_{i}" for i in range(1, 9))),), (), 0.2),
    ("battery", (_parts("battery", "voltage"),), (), 0.5),
)
"""Panels of an overview of an imported log: title, measured signals (the first available),
commands, and smallest span of the axis.
"""
_NAME = re.compile(r"/[\w./]+|[\w.]+")
_WITH_UNIT = re.compile(r"(.*?)\s*\[([^\]]*)\]\s*")
"""Pattern of an expression with its unit in brackets."""


@styled
def plot_overview(record: LogRecord) -> Figure:
    """Return the overview of a flight: position, velocities, attitude and thrusts, with commands.

    Raises:
        WorkbenchError: if the log has no such topics.
    """
    if not record.topics:
        raise WorkbenchError(f"{record.path}: has no messages, so there is nothing to draw")
    if record.imported:
        return _imported_overview(record)
    title = f"{record.vehicle}: {record.path.name}"
    figure, axes = stacked(title, 5, width=9.0, height=1.75)
    position, velocity, attitude, yaw, thrust = axes
    _draw(position, "position in W", [record.series(f"position_data.{x}") for x in "xyz"], 0.5)
    names = [f"v_{axis}" for axis in "xyz"]
    _draw(velocity, "velocity and command", _of(record, "velocity_data", names), 0.2)
    _draw_commands(velocity, _of(record, "command_velocity", names))
    angles = ["roll", "pitch", "yaw"]
    _draw(attitude, "attitude", _of(record, "position_data", angles), 0.05)
    _draw(yaw, "yaw rate and command", _of(record, "velocity_data", ["w_z"]), 0.05)
    _draw_commands(yaw, _of(record, "command_velocity", ["yaw_rate"]))
    _draw(thrust, "thrust of the rotors", record.several("rotors.thrust"), 0.2)
    _finish(record, axes)
    return figure


def _imported_overview(record: LogRecord) -> Figure:
    """Return the overview of an imported log: measured signals, with commands dashed."""
    known = {
        series.name: series
        for topic in record.topics.values()
        for series in topic.columns.values()
        if np.isfinite(np.asarray(series.values, dtype=float)).any()
    }
    panels = []
    for title, measured, wanted, least in _PANELS:
        shown = next((found for names in measured if (found := _known(known, names))), [])
        if shown:
            panels.append((title, shown, _known(known, wanted), least))
    if not panels:
        raise WorkbenchError(
            f"{record.path}: has no field that an overview shows: name fields; "
            f"`workbench plot {shlex.quote(str(record.path))} --list` lists them"
        )
    name = f"{record.vehicle}: {record.path.name}"
    figure, axes = stacked(name, len(panels), width=9.0, height=1.75)
    for panel, (title, shown, asked, least) in zip(axes, panels, strict=True):
        _draw(panel, title, shown, least)
        if asked:
            _draw_commands(panel, asked)
    _finish(record, axes)
    return figure


def _known(known: Mapping[str, Signal], names: Sequence[str]) -> list[Signal]:
    return [known[name] for name in names if name in known]


@styled
def plot_fields(record: LogRecord, names: list[str], over: Sequence[LogRecord] = ()) -> Figure:
    """Return a figure of fields over time, with a panel for each unit.

    Args:
        record: the log.
        names: TOPIC.FIELD, TOPIC for all its fields, or an expression of fields, such as
            "sqrt(v_x**2 + v_y**2) [m/s]" with an optional unit in brackets.
        over: other logs, drawn over it in paler colours; fields that they lack are left out.

    Raises:
        WorkbenchError: if one is unknown or a text, or there are too many.
    """
    panels = _panels(record, names)
    figure, axes = _stacked(record, panels)
    others = [(other, _over(other, names)) for other in over]
    for panel, (unit, found) in zip(axes, panels.items(), strict=True):
        _draw(panel, "", [*found.values()], 0.0)
        for place, (other, shown) in enumerate(others):
            same = {name: series for name, series in shown.items() if series.unit == unit}
            _draw_over(panel, other.path.name, list(found), same, _OVER[place % len(_OVER)])
    _finish(record, axes)
    return figure


@styled
def plot_spectra(record: LogRecord, names: list[str], welch: Welch) -> Figure:
    """Return a figure of power spectral densities over frequency.

    Args:
        record: the log.
        names: as for `plot_fields`.
        welch: how the spectra are made.

    Raises:
        WorkbenchError: as `plot_fields`, and if a signal's samples are too few or too uneven.
    """
    panels = _panels(record, names)
    figure, axes = _stacked(record, panels)
    for panel, (unit, found) in zip(axes, panels.items(), strict=True):
        for index, series in enumerate(found.values()):
            made = power_spectrum(series.time, series.values, welch, series.name)
            color = PALETTE.series[index % len(PALETTE.series)]
            dashes = "-" if index < len(PALETTE.series) else "--"
            frequency, density = made.frequency[1:], made.density[1:]
            name = curve_name(series.name)
            panel.loglog(frequency, density, dashes, color=color, label=name)
        label(panel, "", f"[{density_unit(unit)}]" if unit else "")
        legend(panel)
    axes[-1].set_xlabel("frequency [Hz]")
    return figure


def _stacked(record: LogRecord, panels: dict[str, dict[str, Signal]]) -> tuple[Figure, list[Axes]]:
    """Return a figure with a panel for each unit, and space for legends."""
    longest = max(len(curve_name(name)) for found in panels.values() for name in found)
    right = max(RIGHT, 0.6 + _PER_CHARACTER * longest)
    title = f"{record.vehicle}: {record.path.name}"
    return stacked(title, len(panels), width=6.6 + right, height=2.4, right=right)


def _panels(record: LogRecord, names: list[str]) -> dict[str, dict[str, Signal]]:
    """Return the named series, by unit and name.

    Raises:
        WorkbenchError: if one is unknown or a text, or there are too many of a unit.
    """
    panels: dict[str, dict[str, Signal]] = {}
    for name in names:
        plain = _NAME.fullmatch(name)
        for series in _numbers(record, name) if plain else [_derived(record, name)]:
            panels.setdefault(series.unit, {})[series.name] = series
    for unit, found in panels.items():
        if len(found) > MOST_CURVES:
            raise WorkbenchError(
                f"{len(found)} fields in {unit or 'one unit'} are too many for a panel: name "
                f"{MOST_CURVES} at most; "
                f"`workbench plot {shlex.quote(str(record.path))} --list` lists them"
            )
    return panels


def _derived(record: LogRecord, text: str) -> Signal:
    """Return the series of an expression."""
    stated = _WITH_UNIT.fullmatch(text)
    text, unit = stated.groups() if stated else (text, "")

    def read(name: str, since: float) -> Samples:
        series = record.series(name)
        first = int(np.searchsorted(series.time, since))
        return series.time[first:], np.asarray(series.values[first:], dtype=float)

    numbers = [
        series.name
        for topic in record.topics.values()
        for series in topic.columns.values()
        if series.values.dtype.kind in "biuf"
    ]
    expression = parse_expression(text)
    return Signal(text, unit, *expression.series(read, expression.find(numbers)))


def _numbers(record: LogRecord, name: str) -> list[Signal]:
    """Return the numeric series of a name."""
    found = record.several(name)
    numbers = [series for series in found if series.values.dtype.kind in "biuf"]
    if not numbers:
        raise WorkbenchError(f"{name} is a text, which cannot be drawn: name a number")
    return numbers


def _of(record: LogRecord, topic: str, fields: list[str]) -> list[Signal]:
    return [record.series(f"{topic}.{field}") for field in fields]


def _over(record: LogRecord, names: list[str]) -> dict[str, Signal]:
    """Return those of the named series that a log has."""
    shown: dict[str, Signal] = {}
    for name in names:
        try:
            shown |= {
                key: each for part in _panels(record, [name]).values() for key, each in part.items()
            }
        except WorkbenchError:  # an imported log may lack series of this one
            continue
    if not shown:
        raise WorkbenchError(f"{record.path}: has none of {', '.join(names)} to draw over it")
    return shown


def _draw_over(
    axes: Axes, whose: str, drawn: list[str], found: Mapping[str, Signal], dashes: str
) -> None:
    """Draw the series of another log in paler colours."""
    for name, series in found.items():
        place = drawn.index(name) if name in drawn else len(drawn)
        color = PALETTE.series[place % len(PALETTE.series)]
        axes.plot(
            series.time,
            series.values,
            dashes,
            color=color,
            alpha=0.55,
            label=curve_name(f"{name}, {whose}"),
        )
    lines = [np.asarray(line.get_ydata(), dtype=float) for line in axes.get_lines()]
    widen(axes, *lines)


def _draw(axes: Axes, title: str, found: list[Signal], least: float) -> None:
    """Draw series with one unit; the axis spans `least` or more."""
    for index, series in enumerate(found):
        color = PALETTE.series[index % len(PALETTE.series)]
        dashes = "-" if index < len(PALETTE.series) else "--"
        name = series.name.partition(".")[2] if title else series.name
        axes.plot(series.time, series.values, dashes, color=color, label=curve_name(name))
    widen(axes, *(series.values for series in found), least=least)
    unit = plain_name(found[0].unit)
    label(axes, title, f"[{unit}]" if unit else "")


def _draw_commands(axes: Axes, found: list[Signal]) -> None:
    """Draw commands dashed, in the colours of the responses."""
    for index, series in enumerate(found):
        name = f"{series.name.partition('.')[2]} command"
        draw_command(axes, series.time, series.values, color=PALETTE.series[index], label=name)
    drawn = [line.get_ydata() for line in axes.get_lines()]
    widen(axes, *(np.asarray(values, dtype=float) for values in drawn), least=0.05)


def _finish(record: LogRecord, axes: list[Axes]) -> None:
    for panel in axes:
        legend(panel)
    axes[-1].set_xlabel(TIME)
    begin = min((topic.t_ns[0] for topic in record.topics.values()), default=0) * 1e-9
    axes[-1].set_xlim(begin, max(record.duration, begin + _LEAST_TIME))


@styled
def plot_step_response(flight: FlightRecord, estimate: StepEstimate) -> Figure:
    """Return a figure of a step response with its spread, and with reasons not to trust it."""
    title = f"{flight.name}: step response of {estimate.name}"
    figure, (axes,) = stacked(title, 1, width=8.0, height=3.6)
    color = PALETTE.series[0]
    axes.axhline(1.0, color=PALETTE.series[1], lw=1.0, ls="--", label=curve_name(estimate.setpoint))
    axes.fill_between(
        estimate.time, estimate.low, estimate.high, color=color, alpha=0.2, lw=0.0, label="95 %"
    )
    axes.plot(
        estimate.time,
        estimate.values,
        color=color,
        ls="-" if estimate.trusted else ":",
        label=curve_name(estimate.response),
    )
    top = max(float(estimate.high.max()), 1.1)
    axes.set_ylim(min(float(estimate.low.min()), -0.1), 1.05 * top)
    axes.set_xlim(float(estimate.time[0]), float(estimate.time[-1]))
    said = f"{estimate.windows} windows, coherence {estimate.coherence:.2f}"
    label(axes, said if estimate.trusted else f"NOT RELIABLE, {said}", "[1]")
    legend(axes)
    axes.set_xlabel("time since the step [s]")
    return figure
