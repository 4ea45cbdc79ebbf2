"""The report: what was wished, what came of it, the gains, the proof; as rows and as a page."""

import base64
import html
import io
from collections.abc import Sequence

from matplotlib.figure import Figure

from workbench.design.metrics import shown
from workbench.design.plots import write_png
from workbench.design.tune.case import NOMINAL
from workbench.design.tune.requirement import Requirement
from workbench.design.tune.tuning import Result, Tuning
from workbench.design.tune.wish import DEFAULT
from workbench.scenario.parameters import parameter_table

Rows = list[list[str]]

_PAGE = """<!DOCTYPE html>
<html lang="en"><head><meta charset="utf-8"><title>{title}</title><style>
body {{ font: 15px/1.5 system-ui, sans-serif; max-width: 62rem; margin: 2rem auto }}
table {{ border-collapse: collapse; margin: 0.5rem 0 1.5rem }}
th, td {{ padding: 0.15rem 0.9rem 0.15rem 0; text-align: left; border-bottom: 1px solid #ddd }}
img {{ max-width: 100% }}
.no {{ color: #c0392b; font-weight: bold }}
</style></head><body>
{body}
</body></html>
"""


def wish_rows(results: Sequence[Result], *, cases: bool = False) -> Rows:
    """Return a line for each wish: name, before, after, limit, whether met; and its corner."""
    rows = []
    for result in results:
        required = result.required
        metric = required.wish.metric
        row = [
            required.wish.name,
            shown(metric, result.before),
            shown(metric, result.after),
            _limit(required),
            _verdict(required, result.after),
        ]
        rows.append([*row, str(required.case)] if cases else row)
    return rows


def _verdict(required: Requirement, value: float) -> str:
    """Return how a wish fares; what is met only as it was widened says what it gave way from."""
    if not required.met(value):
        return "not ok"
    if required.widened is None or required.meets_unwidened(value):
        return "ok"
    return f"widened from {shown(required.wish.metric, required.widened)}"


def gain_rows(found: Tuning) -> Rows:
    """Return a line for each gain that was searched: name, before, after, unit."""
    table = parameter_table(found.controller)
    return [
        [name, f"{found.before[name]:.4g}", f"{value:.4g}", table.find(name).unit]
        for name, value in found.gains.items()
    ]


def proof_rows(found: Tuning) -> Rows:
    """Return a line for each number of the flights on the full diagram."""
    return [
        [
            required.wish.name,
            shown(required.wish.metric, value),
            _limit(required),
            _verdict(required, value),
            "" if required.case == NOMINAL else str(required.case),
        ]
        for required, value in (found.proof.values if found.proof else ())
    ]


def report_html(found: Tuning, figure: Figure) -> str:
    """Return the report as one page, its picture inside."""
    title = f"{found.vehicle}: tuned gains" if found.met else f"{found.vehicle}: wishes not met"
    parts = [f"<h1>{html.escape(title)}</h1>", _paragraphs(found), _image(figure)]
    parts += ["<h2>Wishes</h2>", _table(("", "before", "after", "wished", ""), _wished(found))]
    if found.in_corners:
        head = ("", "before", "after", "still wished", "", "corner")
        parts += ["<h2>In the worst corner of each</h2>"]
        parts += [_table(head, wish_rows(found.in_corners, cases=True))]
    if found.guarded:
        kept = ("", "before", "after", "kept", "")
        parts += ["<h2>Loops that no wish is about</h2>", _table(kept, wish_rows(found.guarded))]
    parts += ["<h2>Gains</h2>", _table(("", "before", "after", ""), gain_rows(found))]
    if found.proof and found.proof.values:
        flown = ("", "flown", "wished", "", "")
        parts += ["<h2>Flown on the full diagram</h2>", _table(flown, proof_rows(found))]
    return _PAGE.format(title=html.escape(title), body="\n".join(parts))


def _wished(found: Tuning) -> Rows:
    rows = wish_rows(found.as_described)
    for row, result in zip(rows, found.as_described, strict=True):
        if result.required.wish.origin == DEFAULT:
            row[3] += " (a default)"
    return rows


def _paragraphs(found: Tuning) -> str:
    worst = found.worst_corner
    lines = [str(conflict) for conflict in found.conflicts]
    lines += [*found.shortfalls, *found.remarks]
    if worst:
        name, value = worst.required.wish.name, shown(worst.required.wish.metric, worst.after)
        lines.append(f"Worst corner: {name} of {value} with {worst.required.case}.")
    return "\n".join(f"<p>{html.escape(line)}</p>" for line in lines)


def _limit(required: Requirement) -> str:
    sign = ">=" if required.wish.at_least else "<="
    return f"{sign} {shown(required.wish.metric, required.bound)}"


def _table(head: Sequence[str], rows: Rows) -> str:
    lines = ["".join(f"<th>{html.escape(text)}</th>" for text in head)]
    lines += ["".join(map(_cell, row)) for row in rows]
    return "<table>" + "\n".join(f"<tr>{line}</tr>" for line in lines) + "</table>"


def _cell(text: str) -> str:
    kind = ' class="no"' if text == "not ok" else ""
    return f"<td{kind}>{html.escape(text)}</td>"


def _image(figure: Figure) -> str:
    buffer = io.BytesIO()
    write_png(figure, buffer)
    data = base64.b64encode(buffer.getvalue()).decode("ascii")
    return f'<img alt="responses and margins, before and after" src="data:image/png;base64,{data}">'
