"""Results as files: a self-contained HTML page, and JUnit XML for CI."""

from collections.abc import Sequence
from itertools import groupby
from xml.etree import ElementTree

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from workbench.common.html_page import html_page
from workbench.common.plain_text import html_text, visible
from workbench.design.plots import PALETTE, inline_svg, legend, styled, widen
from workbench.design.regress.verdict import (
    CaseResult,
    CurveComparison,
    LimitCheck,
    results_summary,
    since_baseline,
    with_unit,
)

_SKIPPED = '<span class="note">skipped</span>'


def results_page(results: Sequence[CaseResult], title: str) -> str:
    """Return the page: a summary, then each case with curves, limits and values.

    Args:
        results: in any order; those that failed are shown first.
        title: of the page.
    """
    numbered = list(enumerate(results))
    numbered.sort(key=lambda pair: pair[1].passed)
    failed = not all(result.passed for result in results)
    verdict = results_summary(results)
    rows = "\n".join(_summary_row(number, result) for number, result in numbered)
    cases = "\n".join(_case(number, result) for number, result in numbered)
    body = f"""{_changes_section(results)}
<table>
<tr><th>spec</th><th>case</th><th></th><th>what</th></tr>
{rows}
</table>
{cases}"""
    shown = f'<span class="{"failed" if failed else "passed"}">{verdict}</span>'
    return html_page(f"{title}: {verdict}", body, f"{html_text(title)}: {shown}")


def _changes_section(results: Sequence[CaseResult]) -> str:
    """Return the differences from the baselines."""
    return "".join(f"<p>{html_text(changed)}</p>\n" for changed in since_baseline(results))


def _summary_row(number: int, result: CaseResult) -> str:
    reason = result.failures[0] if result.failures else ""
    if len(result.failures) > 1:
        reason += f" (and {len(result.failures) - 1} more)"
    return (
        f'<tr><td>{html_text(result.spec)}</td><td><a href="#case{number}">'
        f"{html_text(result.case)}</a></td><td>{_result_verdict(result)}</td>"
        f"<td>{html_text(reason or '; '.join(result.skips))}</td></tr>"
    )


def _case(number: int, result: CaseResult) -> str:
    """Return the section of a case, collapsed if it passed."""
    parts = [f'<p class="failed">{html_text(result.trouble)}</p>'] if result.trouble else []
    parts += [f'<p class="note">{html_text(result.absent)}</p>'] if result.absent else []
    if result.checks:
        rows = "\n".join(map(_check_row, result.checks))
        parts.append(
            '<table><tr><th>metric</th><th class="number">value</th>'
            '<th class="number">demanded</th><th></th></tr>\n'
            f"{rows}</table>"
        )
    parts += map(_curve_figure, result.curves)
    return (
        f'<h2 id="case{number}">{html_text(result.spec)}: {html_text(result.case)} '
        f"{_result_verdict(result)}</h2>\n"
        f"<details{'' if result.passed else ' open'}><summary>limits and curves</summary>\n"
        + "\n".join(parts)
        + "</details>"
    )


def _check_row(check: LimitCheck) -> str:
    doubt = f" ({check.doubt})" if check.doubt else ""
    beyond = "" if check.met else f" by {with_unit(check.excess, check.unit)}"
    verdict = _SKIPPED if check.skipped else _verdict_word(check.met)
    return (
        f"<tr><td>{html_text(check.name)}</td>"
        f'<td class="number">{html_text(with_unit(check.value, check.unit))}</td>'
        f'<td class="number">{html_text(check.demand)}</td>'
        f"<td>{verdict}{html_text(beyond + doubt)}</td>"
        "</tr>"
    )


def _curve_figure(curve: CurveComparison) -> str:
    """Return the figure of a curve with a sentence."""
    if not curve.met:
        said = f'<p class="failed">{html_text(curve.sentence)}</p>'
    elif curve.band is None:
        said = f'<p class="note">{html_text(curve.signal)}, without a baseline</p>'
    else:
        said = html_text(f"{curve.signal} uses {100 * curve.use:.0f} % of its band")
        said = f'<p class="note">{said}</p>'
    return said + (inline_svg(plot_curve(curve)) if len(curve.flown.time) else "")


def _result_verdict(result: CaseResult) -> str:
    return _SKIPPED if result.skipped else _verdict_word(result.passed)


def _verdict_word(good: bool) -> str:
    return '<span class="passed">passed</span>' if good else '<span class="failed">failed</span>'


def junit_xml(results: Sequence[CaseResult]) -> str:
    """Return XML text with a test suite for each spec and a test case for each case."""
    top = ElementTree.Element("testsuites", {"name": "workbench regress"} | _counts(results))
    for spec, group in groupby(results, key=lambda result: result.spec):
        cases = list(group)
        suite = ElementTree.SubElement(top, "testsuite", {"name": visible(spec)} | _counts(cases))
        for result in cases:
            case = ElementTree.SubElement(
                suite,
                "testcase",
                classname=visible(spec),
                name=visible(result.case),
                file=visible(str(result.path)),
                time=f"{result.seconds:.3f}",
            )
            if result.skipped:
                ElementTree.SubElement(case, "skipped", message=visible("; ".join(result.skips)))
            if not result.passed:
                failure = ElementTree.SubElement(
                    case, "failure", message=visible(result.failures[0]), type="regression"
                )
                failure.text = visible("\n".join(result.story))
    ElementTree.indent(top)
    return ElementTree.tostring(top, encoding="unicode", xml_declaration=True) + "\n"


def _counts(results: Sequence[CaseResult]) -> dict[str, str]:
    failed = sum(not result.passed for result in results)
    return {
        "tests": str(len(results)),
        "failures": str(failed),
        "errors": "0",
        "skipped": str(sum(result.skipped for result in results)),
        "time": f"{sum(result.seconds for result in results):.3f}",
    }


MIN_AXIS_SPAN = 1e-3
"""Smallest span of an axis, so that numerical noise does not fill a figure."""


@styled
def plot_curve(curve: CurveComparison) -> Figure:
    """Return the figure of a curve: the flown one, the baseline, the band, and violations of it.

    A second panel shows differences from the baseline, which makes a narrow band visible.
    """
    beside = curve.baseline is not None
    figure = Figure(figsize=(10.0 if beside else 6.2, 2.5), layout="constrained")
    panels = figure.subplots(1, 2 if beside else 1, squeeze=False)[0]
    _draw_band_curves(panels[0], curve, np.zeros(len(curve.flown.time)))
    panels[0].set_ylabel(f"{curve.signal} [{curve.unit}]")
    if curve.baseline is not None:
        middle = np.interp(curve.flown.time, curve.baseline.time, curve.baseline.values)
        _draw_band_curves(panels[1], curve, middle)
        panels[1].set_ylabel(f"difference [{curve.unit}]")
        legend(panels[1])
    return figure


def _draw_band_curves(axes: Axes, curve: CurveComparison, less: np.ndarray) -> None:
    """Draw all curves, minus some values at the flown times."""
    time, values = curve.flown.time, curve.flown.values - less
    shown = [values]
    if curve.band is not None and curve.baseline is not None:
        low, high = (edge - less for edge in curve.band)
        axes.fill_between(time, low, high, color=PALETTE.window, lw=0, label="allowed")
        baseline = np.interp(time, curve.baseline.time, curve.baseline.values) - less
        axes.plot(time, baseline, color=PALETTE.command, ls="--", lw=1.1, label="baseline")
        shown += [low, high]
    axes.plot(time, values, color=PALETTE.ours, label="flown")
    outside = curve.excesses > 0.0
    if outside.any():
        beyond = np.where(outside, values, np.nan)
        axes.plot(time, beyond, color=PALETTE.limit, lw=2.6, label="out of band")
    widen(axes, *shown, least=MIN_AXIS_SPAN)
    axes.set_xlim(time[0], time[-1])
    axes.set_xlabel("time since the edge [s]")
