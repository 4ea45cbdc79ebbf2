"""The report of a tuning session: one HTML page with its gains, notes and pictures."""

import time
from base64 import b64encode
from collections.abc import Mapping, Sequence
from itertools import pairwise

from PyQt6.QtCore import QBuffer, QIODevice
from PyQt6.QtWidgets import QWidget

from workbench.common.html_page import html_page, html_table
from workbench.common.plain_text import html_text
from workbench.gui.gains.gain_editor import GainEditor
from workbench.gui.gains.gain_history import GainHistory
from workbench.gui.tuning.designs import gain_differences_text
from workbench.gui.tuning.limits import MARGIN_LIMITS
from workbench.gui.tuning.number_row import NumberRow
from workbench.gui.units import gain_text, simulated_text, unit_symbol
from workbench.live.view import LiveView

MAX_REPORTED_GAINS = 100


def picture_of(widget: QWidget) -> str:
    """Return a picture of a widget as it is shown, for an `img` element."""
    buffer = QBuffer()
    buffer.open(QIODevice.OpenModeFlag.WriteOnly)
    widget.grab().save(buffer, "PNG")
    return f"data:image/png;base64,{b64encode(buffer.data().data()).decode()}"


def session_report(
    view: LiveView,
    editor: GainEditor,
    history: GainHistory,
    margins: Sequence[NumberRow],
    pictures: Mapping[str, str],
) -> str:
    """Return the page.

    Args:
        view: the present flight.
        editor: its gains.
        history: the gains that were kept.
        margins: of every loop, in the order of `MARGIN_LIMITS`; empty while unknown.
        pictures: by heading, see `picture_of`.
    """
    vehicle = view.vehicle.name if view.vehicle is not None else ""
    scenario = view.scenario.title if view.scenario is not None else ""
    facts = (
        ("Vehicle", vehicle),
        ("Scenario", scenario),
        ("Controller", editor.controller.name),
        ("Written", time.strftime("%Y-%m-%d %H:%M")),
    )
    entries = history.entries
    kept = [
        (entry.clock, simulated_text(entry.time), _changes(entry.gains, last.gains), entry.note)
        for last, entry in pairwise(entries)
    ]
    first = dict(entries[0].gains) if entries else {}
    units = {row.name: unit_symbol(row.unit) for row in editor.rows}
    rows = "".join(
        f"<tr{' class=changed' if first.get(name) != value else ''}><td>{html_text(name)}</td>"
        f'<td class="number">{gain_text(first.get(name, value))}</td>'
        f'<td class="number">{gain_text(value)}</td>'
        f"<td>{html_text(units.get(name, ''))}</td></tr>"
        for name, value in editor.ordered_gains.items()
    )
    loops = [(row.label, *(cell.text for cell in row.cells)) for row in margins]
    heads = ("Loop", *(f"{limit.short} {limit.unit}".strip() for limit in MARGIN_LIMITS))
    numbers = f"<h2>Margins</h2>{html_table(heads, loops)}" if loops else ""
    shown = "".join(
        f'<h2>{html_text(title)}</h2><img alt="{html_text(title)}" src="{source}">'
        for title, source in pictures.items()
    )
    changes = (
        html_table(("Time", "Flight", "Changed", "Note"), kept) if kept else "<p>None was kept.</p>"
    )
    return html_page(
        f"Tuning of {vehicle}",
        f"{html_table((), facts)}<h2>Kept gains</h2>{changes}<h2>Gains that fly</h2>"
        '<table><tr><th>Gain<th class="number">At the start<th class="number">Now<th></tr>'
        f"{rows}</table>{numbers}{shown}",
    )


def _changes(gains: Mapping[str, float], before: Mapping[str, float]) -> str:
    return gain_differences_text(gains, before, same="–", most=MAX_REPORTED_GAINS)
