"""Figures of a log: an overview, or requested fields over time or as spectra."""

import re
import shlex
from collections.abc import Mapping, Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from workbench.common.errors import WorkbenchError
from workbench.common.flight import Flight
from workbench.common.plain_text import plain_name
from workbench.common.series import Series, TimedValues
from workbench.design.plots import (
    PALETTE,
    RIGHT_MARGIN_IN,
    curve_name,
    draw_command,
    label_panel,
    legend,
    stacked,
    styled,
    widen,
)
from workbench.logs.expressions import parse_expression
from workbench.logs.logged_signal import topic_signals
from workbench.logs.logged_topic import short_topic_name
from workbench.logs.spectrum import WelchSettings, density_unit, power_spectrum
from workbench.logs.step_response import StepEstimate

MAX_PANEL_CURVES = 16
"""Largest number of curves in a panel; more cannot be distinguished."""
TIME_AXIS_LABEL = "time [s]"
_MIN_TIME_SPAN_S = 0.1
"""Smallest span of the time axis [s]."""
_CHARACTER_WIDTH_IN = 0.075
"""Width of a character in a legend [inch]."""
_OVERLAY_STYLES = ("--", ":", "-.")
"""Style of the curves of other logs."""


_OVERVIEW_PANELS: tuple[
    tuple[str, tuple[tuple[str, ...], ...], tuple[tuple[str, ...], ...], float], ...
] = (
    (
        "position in W",
        (topic_signals("position_data", "x y z"), topic_signals("estimate", "x y z")),
        (topic_signals("setpoint", "x y z"),),
        0.5,
    ),
    (
        "velocity in W",
        (topic_signals("velocity_data", "v_x v_y v_z"), topic_signals("estimate", "v_x v_y v_z")),
        (
            topic_signals("command_velocity", "v_x v_y v_z"),
            topic_signals("setpoint", "v_x v_y v_z"),
        ),
        0.2,
    ),
    (
        "attitude",
        (
            topic_signals("position_data", "roll pitch yaw"),
            topic_signals("estimate", "roll pitch yaw"),
        ),
        (topic_signals("attitude_setpoint", "roll pitch yaw"),),
        0.05,
    ),
    (
        "yaw rate",
        (topic_signals("velocity_data", "w_z"),),
        (topic_signals("command_velocity", "yaw_rate"),),
        0.05,
    ),
    (
        "angular velocity in B",
        (topic_signals("imu", "angular_velocity.x angular_velocity.y angular_velocity.z"),),
        (topic_signals("rate_setpoint", "w_x w_y w_z"),),
        0.05,
    ),
    (
        "motor commands",
        (topic_signals("motors", " ".join(f"command_{i}" for i in range(1, 9))),),
        (),
        0.2,
    ),
    (
        "thrust of the rotors",
        (topic_signals("rotors", " ".join(f"thrust.{i}" for i in range(8))),),
        (),
        0.2,
    ),
    ("battery", (topic_signals("battery", "voltage"),), (), 0.5),
)
"""Panels of an overview: title, measured signals and commands, of both the first available set, and
smallest span of the axis."""
_SERIES_NAME_PATTERN = re.compile(r"/[\w./]+|[\w.]+")
_EXPRESSION_UNIT_PATTERN = re.compile(r"(.*?)\s*\[([^\]]*)\]\s*")
"""Pattern of an expression with its unit in brackets."""


@styled
def plot_overview(flight: Flight) -> Figure:
    """Return the overview of a flight: measured signals, with commands dashed.

    Raises:
        WorkbenchError: if the log has no such signals.
    """
    if not flight.signals:
        raise WorkbenchError(f"{flight.source}: has no messages, so there is nothing to draw")
    panels = []
    for title, measured, wanted, least in _OVERVIEW_PANELS:
        if shown := _first_known(flight, measured):
            panels.append((title, shown, _first_known(flight, wanted), least))
    if not panels:
        raise WorkbenchError(
            f"{flight.source}: has no field that an overview shows: name fields; "
            f"`workbench plot {shlex.quote(str(flight.source))} --list` lists them"
        )
    name = f"{flight.vehicle}: {flight.source.name}"
    figure, axes = stacked(name, len(panels), width=9.0, height=1.75)
    for panel, (title, shown, asked, least) in zip(axes, panels, strict=True):
        _draw_series(panel, title, shown, least)
        if asked:
            _draw_commands(panel, asked)
    _finish(flight, axes)
    return figure


def _first_known(flight: Flight, sets: Sequence[Sequence[str]]) -> list[Series]:
    """Return the signals with a number of the first set that has any."""
    for names in sets:
        found = [flight[name] for name in names if name in flight]
        if known := [each for each in found if np.isfinite(each.values).any()]:
            return known
    return []


@styled
def plot_fields(flight: Flight, names: list[str], over: Sequence[Flight] = ()) -> Figure:
    """Return a figure of fields over time, with a panel for each unit.

    Args:
        flight: the log.
        names: TOPIC.FIELD, TOPIC for all its fields, or an expression of fields, such as
            "sqrt(v_x**2 + v_y**2) [m/s]" with an optional unit in brackets.
        over: other logs, drawn over it in paler colours; fields that they lack are left out.

    Raises:
        WorkbenchError: if one is unknown or a text, or there are too many.
    """
    panels = _panels(flight, names)
    figure, axes = _stacked(flight, panels)
    others = [(other, _over(other, names)) for other in over]
    for panel, (unit, found) in zip(axes, panels.items(), strict=True):
        _draw_series(panel, "", [*found.values()], 0.0)
        for place, (other, shown) in enumerate(others):
            same = {name: series for name, series in shown.items() if series.unit == unit}
            _draw_over(
                panel,
                other.source.name,
                list(found),
                same,
                _OVERLAY_STYLES[place % len(_OVERLAY_STYLES)],
            )
    _finish(flight, axes)
    return figure


@styled
def plot_spectra(flight: Flight, names: list[str], welch: WelchSettings) -> Figure:
    """Return a figure of power spectral densities over frequency.

    Args:
        flight: the log.
        names: as for `plot_fields`.
        welch: how the spectra are made.

    Raises:
        WorkbenchError: as `plot_fields`, and if a signal's samples are too few or too uneven.
    """
    panels = _panels(flight, names)
    figure, axes = _stacked(flight, panels)
    for panel, (unit, found) in zip(axes, panels.items(), strict=True):
        for index, series in enumerate(found.values()):
            made = power_spectrum(series.time, series.values, welch, series.name)
            color = PALETTE.series[index % len(PALETTE.series)]
            dashes = "-" if index < len(PALETTE.series) else "--"
            frequency, density = made.frequency[1:], made.density[1:]
            name = curve_name(series.name)
            if made.part:
                name += f", {made.part[0]:.1f} to {made.part[1]:.1f} s"
            panel.loglog(frequency, density, dashes, color=color, label=name)
        label_panel(panel, "", f"[{density_unit(unit)}]" if unit else "")
        legend(panel)
    axes[-1].set_xlabel("frequency [Hz]")
    return figure


def _stacked(flight: Flight, panels: dict[str, dict[str, Series]]) -> tuple[Figure, list[Axes]]:
    """Return a figure with a panel for each unit, and space for legends."""
    longest = max(len(curve_name(name)) for found in panels.values() for name in found)
    right = max(RIGHT_MARGIN_IN, 0.6 + _CHARACTER_WIDTH_IN * longest)
    title = f"{flight.vehicle}: {flight.source.name}"
    return stacked(title, len(panels), width=6.6 + right, height=2.4, right=right)


def _panels(flight: Flight, names: list[str]) -> dict[str, dict[str, Series]]:
    """Return the named series, by unit and name.

    Raises:
        WorkbenchError: if one is unknown or a text, or there are too many of a unit.
    """
    panels: dict[str, dict[str, Series]] = {}
    for name in names:
        plain = _SERIES_NAME_PATTERN.fullmatch(name)
        for series in _numeric_series(flight, name) if plain else [_derived(flight, name)]:
            panels.setdefault(series.unit, {})[series.name] = series
    for unit, found in panels.items():
        if len(found) > MAX_PANEL_CURVES:
            raise WorkbenchError(
                f"{len(found)} fields in {unit or 'one unit'} are too many for a panel: name "
                f"{MAX_PANEL_CURVES} at most; "
                f"`workbench plot {shlex.quote(str(flight.source))} --list` lists them"
            )
    return panels


def _derived(flight: Flight, text: str) -> Series:
    """Return the series of an expression."""
    stated = _EXPRESSION_UNIT_PATTERN.fullmatch(text)
    text, unit = stated.groups() if stated else (text, "")

    def read(name: str, since: float) -> TimedValues:
        time, values = flight.series(name, since)
        return time, np.asarray(values, dtype=float)

    numbers = [
        series.name for series in flight.signals.values() if series.values.dtype.kind in "biuf"
    ]
    expression = parse_expression(text)
    return Series(text, unit, *expression.series(read, expression.find(numbers)))


def _numeric_series(flight: Flight, name: str) -> list[Series]:
    """Return the numeric series of a name."""
    found = flight.several(short_topic_name(name))
    numbers = [series for series in found if series.values.dtype.kind in "biuf"]
    if not numbers:
        raise WorkbenchError(f"{name} is a text, which cannot be drawn: name a number")
    return numbers


def _over(flight: Flight, names: list[str]) -> dict[str, Series]:
    """Return those of the named series that a log has."""
    shown: dict[str, Series] = {}
    for name in names:
        try:
            shown |= {
                key: each for part in _panels(flight, [name]).values() for key, each in part.items()
            }
        except WorkbenchError:  # an imported log may lack series of this one
            continue
    if not shown:
        raise WorkbenchError(f"{flight.source}: has none of {', '.join(names)} to draw over it")
    return shown


def _draw_over(
    axes: Axes, whose: str, drawn: list[str], found: Mapping[str, Series], dashes: str
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


def _draw_series(axes: Axes, title: str, found: list[Series], least: float) -> None:
    """Draw series with one unit; the axis spans `least` or more."""
    for index, series in enumerate(found):
        color = PALETTE.series[index % len(PALETTE.series)]
        dashes = "-" if index < len(PALETTE.series) else "--"
        name = series.name.partition(".")[2] if title else series.name
        axes.plot(series.time, series.values, dashes, color=color, label=curve_name(name))
    widen(axes, *(series.values for series in found), least=least)
    unit = plain_name(found[0].unit)
    label_panel(axes, title, f"[{unit}]" if unit else "")


def _draw_commands(axes: Axes, found: list[Series]) -> None:
    """Draw commands dashed, in the colours of the responses."""
    for index, series in enumerate(found):
        name = f"{series.name.partition('.')[2]} command"
        draw_command(axes, series.time, series.values, color=PALETTE.series[index], label=name)
    drawn = [line.get_ydata() for line in axes.get_lines()]
    widen(axes, *(np.asarray(values, dtype=float) for values in drawn), least=0.05)


def _finish(flight: Flight, axes: list[Axes]) -> None:
    for panel in axes:
        legend(panel)
    axes[-1].set_xlabel(TIME_AXIS_LABEL)
    axes[-1].set_xlim(flight.begin, max(flight.end, flight.begin + _MIN_TIME_SPAN_S))


@styled
def plot_step_response(flight: Flight, estimate: StepEstimate) -> Figure:
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
    label_panel(axes, said if estimate.trusted else f"NOT RELIABLE, {said}", "[1]")
    legend(axes)
    axes.set_xlabel("time since the step [s]")
    return figure
