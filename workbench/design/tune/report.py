"""The report on wishes, results, gains and proof, as rows, figure and page."""

import base64
import io
from collections.abc import Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from workbench.common.html_page import html_page, html_table
from workbench.common.plain_text import html_text
from workbench.design.plots import PALETTE, label_panel, styled, widen, write_png
from workbench.design.tune.case import NOMINAL_CASE
from workbench.design.tune.measure import Responses
from workbench.design.tune.requirement import Requirement
from workbench.design.tune.tuning import Tuning, WishResult
from workbench.design.tune.wish import DEFAULT_ORIGIN
from workbench.scenario.axes import find_axis

TableRows = list[list[str]]
NOT_MET_TEXT = "not ok"
BEFORE_TUNING = 0
AFTER_TUNING = 1
_CORNER_OPACITY = 0.3
"""Opacity of the curves of varied vehicles."""
_MAX_BAR_RESERVE = 1.5
"""Largest reserve, positive or negative, of a bar."""


def wish_rows(results: Sequence[WishResult], *, cases: bool = False) -> TableRows:
    """Return a row for each wish: name, before, after, limit, whether met; and its corner."""
    rows = []
    for result in results:
        required = result.required
        metric = required.wish.metric
        row = [
            required.wish.name,
            metric.text(result.before),
            metric.text(result.after),
            _limit_text(required),
            _wish_verdict(required, result.after),
        ]
        rows.append([*row, str(required.case)] if cases else row)
    return rows


def _wish_verdict(required: Requirement, value: float) -> str:
    """Return the verdict on a wish; if met only with a widened limit, it has the original one."""
    if not required.met(value):
        return NOT_MET_TEXT
    if required.widened is None or required.meets_unwidened(value):
        return "ok"
    return f"widened from {required.wish.metric.text(required.widened)}"


def gain_rows(found: Tuning) -> TableRows:
    """Return a row for each tuned gain: name, before, after, unit."""
    table = found.controller.table
    return [
        [name, f"{found.before[name]:.4g}", f"{value:.4g}", table.find(name).unit]
        for name, value in found.gains.items()
    ]


def proof_rows(found: Tuning) -> TableRows:
    """Return a row for each number of the flights on the full diagram."""
    return [
        [
            required.wish.name,
            required.wish.metric.text(value),
            _limit_text(required),
            _wish_verdict(required, value),
            "" if required.case == NOMINAL_CASE else str(required.case),
        ]
        for required, value in (found.proof.values if found.proof else ())
    ]


def report_html(found: Tuning, figure: Figure) -> str:
    """Return the report as one page, including its figure."""
    title = f"{found.vehicle}: tuned gains" if found.met else f"{found.vehicle}: wishes not met"
    parts = [_paragraphs(found), _image(figure)]
    parts += [_section("Wishes", ("", "before", "after", "wished", ""), _wished(found))]
    if found.in_corners:
        head = ("", "before", "after", "still wished", "", "corner")
        rows = wish_rows(found.in_corners, cases=True)
        parts += [_section("In the worst corner of each", head, rows)]
    if found.guarded:
        kept = ("", "before", "after", "kept", "")
        parts += [_section("Loops that no wish is about", kept, wish_rows(found.guarded))]
    parts += [_section("Gains", ("", "before", "after", ""), gain_rows(found))]
    if found.proof and found.proof.values:
        flown = ("", "flown", "wished", "", "")
        parts += [_section("Flown on the full diagram", flown, proof_rows(found))]
    return html_page(title, "\n".join(parts))


def _section(title: str, head: Sequence[str], rows: TableRows) -> str:
    return f"<h2>{title}</h2>\n{html_table(head, rows, failed=NOT_MET_TEXT)}"


def _wished(found: Tuning) -> TableRows:
    rows = wish_rows(found.as_described)
    for row, result in zip(rows, found.as_described, strict=True):
        if result.required.wish.origin == DEFAULT_ORIGIN:
            row[3] += " (a default)"
    return rows


def _paragraphs(found: Tuning) -> str:
    worst = found.worst_corner
    lines = [str(conflict) for conflict in found.conflicts]
    lines += [*found.shortfalls, *found.remarks]
    if worst:
        name, value = worst.required.wish.name, worst.required.wish.metric.text(worst.after)
        lines.append(f"Worst corner: {name} of {value} with {worst.required.case}.")
    return "\n".join(f"<p>{html_text(line)}</p>" for line in lines)


def _limit_text(required: Requirement) -> str:
    sign = ">=" if required.wish.at_least else "<="
    return f"{sign} {required.wish.metric.text(required.bound)}"


def _image(figure: Figure) -> str:
    buffer = io.BytesIO()
    write_png(figure, buffer)
    data = base64.b64encode(buffer.getvalue()).decode("ascii")
    return f'<img alt="responses and margins, before and after" src="data:image/png;base64,{data}">'


@styled
def plot_tuning(found: Tuning) -> Figure:
    """Return the figure of a tuning run."""
    axes = list(dict.fromkeys(axis for axis, _ in found.responses))
    shown = [*found.as_described, *found.in_corners]
    rows = max(1, len(axes))
    height = max(1.9 * rows, 0.17 * len(shown) + 1.0) + 0.6
    figure = Figure(figsize=(11.0, height), layout="constrained")
    figure.suptitle(_figure_title(found), x=0.01, ha="left", fontsize=11, fontweight="bold")
    left, right = figure.subfigures(1, 2, width_ratios=(1.25, 1.0), squeeze=False)[0]
    if axes:
        panels = left.subplots(len(axes), 1, squeeze=False)[:, 0]
        for panel, axis in zip(panels, axes, strict=True):
            _draw_responses(panel, found, axis)
        panels[-1].set_xlabel("time since the command's edge [s]")
        handles, labels = panels[0].get_legend_handles_labels()
        left.legend(handles, labels, loc="outside lower center", ncols=4)
    _draw_reserves(right.subplots(), shown)
    return figure


def _figure_title(found: Tuning) -> str:
    end = "all wishes met" if found.met else "wishes not met"
    if found.met and found.shortfalls:
        end = f"all wishes met, {len(found.shortfalls)} of them widened"
    return f"{found.vehicle}: tuned, {end}"


def _draw_responses(panel: Axes, found: Tuning, axis: str) -> None:
    """Draw the step of an axis, before and after, in all cases."""
    command = found.steps[axis].amplitude
    curves = {
        case: flown for (flown_axis, case), flown in found.responses.items() if flown_axis == axis
    }
    described = curves.pop(NOMINAL_CASE)
    panel.axhline(command, ls="--", color=PALETTE.command, lw=1.2, label="command")
    for index, flown in enumerate(curves.values()):
        name = "after, in corners" if index == 0 else None
        panel.plot(
            flown.time,
            flown.response[AFTER_TUNING],
            color=PALETTE.ours,
            alpha=_CORNER_OPACITY,
            lw=1.0,
            label=name,
        )
    panel.plot(
        described.time,
        described.response[BEFORE_TUNING],
        color=PALETTE.mean,
        ls=":",
        label="before",
    )
    panel.plot(described.time, described.response[AFTER_TUNING], color=PALETTE.ours, label="after")
    panel.set_xlim(0.0, _rest_time(described, command))
    widen(panel, np.clip(described.response, -0.3 * abs(command), 1.6 * abs(command)), command, 0.0)
    what = "yaw rate" if axis == "yaw" else f"velocity along {axis}"
    label_panel(
        panel, f"{what}, step of {command:g} {find_axis(axis).unit}", f"[{find_axis(axis).unit}]"
    )


def _rest_time(flown: Responses, command: float) -> float:
    """Return the time by which the response has been at rest for a while [s]."""
    away = np.abs(flown.response[AFTER_TUNING] - flown.response[AFTER_TUNING][-1]) > 0.02 * abs(
        command
    )
    settled = flown.time[np.flatnonzero(away)[-1]] if away.any() else flown.time[-1]
    return float(min(flown.time[-1], max(1.0, 1.6 * settled)))


def _draw_reserves(panel: Axes, results: list[WishResult]) -> None:
    """Draw the reserve of each wish, before and after."""
    places = np.arange(len(results))[::-1]
    before = [r.required.reserve(r.before) for r in results]
    after = [result.reserve for result in results]
    colors = [PALETTE.ours if result.met else PALETTE.limit for result in results]
    panel.barh(
        places,
        np.clip(after, -_MAX_BAR_RESERVE, _MAX_BAR_RESERVE),
        color=colors,
        height=0.7,
        label="after",
    )
    panel.plot(
        np.clip(before, -_MAX_BAR_RESERVE, _MAX_BAR_RESERVE),
        places,
        "|",
        color=PALETTE.mean,
        ms=9,
        mew=2,
        label="before",
    )
    panel.axvline(0.0, color=PALETTE.command, lw=1.0)
    panel.set_yticks(places, [_result_name(result) for result in results], fontsize=7)
    panel.set_ylim(-0.8, len(results) - 0.2)
    panel.set_xlabel("to spare, as a share of the limit")
    panel.set_title("wishes")
    panel.legend(loc="lower center", bbox_to_anchor=(0.5, 1.0), ncols=2)


def _result_name(result: WishResult) -> str:
    wish = result.required.wish
    corner = "" if result.required.case == NOMINAL_CASE else ", worst corner"
    return f"{wish.name}{corner}"
