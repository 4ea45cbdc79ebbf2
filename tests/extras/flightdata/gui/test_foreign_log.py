"""A table of an unknown kind, from its columns to curves, spectra and overlays."""

import math

import numpy as np
import pytest
from PyQt6.QtCore import Qt
from PyQt6.QtTest import QTest
from PyQt6.QtWidgets import QDialogButtonBox

from tests.gui.conftest import noted
from workbench.gui.charts.chart_kind import SPECTRUM_CHART
from workbench.gui.charts.curve import CurveStyle
from workbench.gui.visualization.column_dialog import NOT_READ, ColumnDialog
from workbench.logs.expressions import parse_expression
from workbench.logs.flight_reader import read_flight
from workbench.logs.readers.table_head import undescribed_table

pytestmark = pytest.mark.usefixtures("unheld")

LIMIT = 60_000
"""For a process to start and read [ms]."""
RATE_HZ, WAVE_HZ, GAP_S, END_S = 100, 8.0, (6.0, 7.0), 10.0
SIGNALS = {
    "roll [deg]": "estimate.roll",
    "roll_d [deg]": "attitude_setpoint.roll",
    "gx [deg/s]": "imu.angular_velocity.x",
    "m1": "motors.command_1",
}
MAPPING = (
    "time: {column: time_ms, unit: ms}\ncolumns:\n"
    "  'roll [deg]': {signal: estimate.roll, unit: deg}\n"
    "  'roll_d [deg]': {signal: attitude_setpoint.roll, unit: deg}\n"
    "  'gx [deg/s]': {signal: imu.angular_velocity.x, unit: deg/s}\n"
    "  m1: {signal: motors.command_1, unit: '1'}\n"
)


def write_table(path, starts=1.0):
    """Write a table whose motor starts at a time [s], with a gap."""
    time = np.arange(0.0, END_S + 1e-9, 1.0 / RATE_HZ)
    time = time[(time <= GAP_S[0]) | (time >= GAP_S[1])]
    wave = np.sin(2.0 * math.pi * WAVE_HZ * time)
    columns = [1000.0 * time, 10.0 * wave, 12.0 * wave, 90.0 * wave, 0.5 * (time >= starts)]
    head = ",".join(("time_ms", *SIGNALS))
    np.savetxt(path, np.column_stack(columns), "%.6f", ",", header=head, comments="")
    return path


@pytest.fixture
def table(tmp_path):
    return write_table(tmp_path / "flight.csv")


def asked(screen, qtbot):
    """Return the dialog that asks for columns."""
    qtbot.waitUntil(lambda: bool(screen.findChildren(ColumnDialog)), timeout=LIMIT)
    return screen.findChildren(ColumnDialog)[-1]


def press_open(dialog):
    QTest.mouseClick(
        dialog.buttons.button(QDialogButtonBox.StandardButton.Open), Qt.MouseButton.LeftButton
    )


def test_a_table_of_an_unknown_kind_is_mapped_in_a_dialog(begun, table, qtbot):
    before = begun.charts.board.board
    begun.open_log(table)
    dialog = asked(begun, qtbot)
    assert dialog.time.currentText() == "time_ms"
    assert [each.currentText() for each in dialog.signals][1:] == [
        "csv.roll",
        "csv.roll_d",
        "csv.gx",
        "csv.m1",
    ]
    assert [each.text() for each in dialog.units] == ["", "deg", "deg", "deg/s", ""]
    dialog.time_unit.setCurrentText("ms")
    for box, signal in zip(dialog.signals[1:], SIGNALS.values(), strict=True):
        box.setCurrentText(signal)
    dialog.signals[2].setCurrentText("estimate.roll")
    assert dialog.fault == "Two columns become estimate.roll: give one of them another name."
    assert not dialog.buttons.button(QDialogButtonBox.StandardButton.Open).isEnabled()
    dialog.signals[2].setCurrentText("attitude_setpoint.roll")
    press_open(dialog)
    qtbot.waitUntil(lambda: begun.shows_log, timeout=LIMIT)
    flight = read_flight(table)  # the choice is kept
    assert np.nanmax(flight["estimate.roll"].values) == pytest.approx(math.radians(10.0), rel=0.01)
    assert flight.end == pytest.approx(END_S)
    assert begun.charts.board.board != before
    begun.close_log()
    assert begun.charts.board.board == before


def test_letters_of_other_languages_stay_in_names(begun, tmp_path, qtbot, case):
    """As a spreadsheet writes them: in the code of Windows, or with a mark of the byte order."""
    table = tmp_path / "flug.csv"
    rows = "".join(f"{0.1 * n:.1f};{n}\n" for n in range(20))
    text = f"Höhe über Grund [cm];Änderung\n{rows}"
    encodings = ("utf-8", "utf-8-sig", "cp1252")
    for encoding in encodings:
        with case(encoding):
            table.write_bytes(text.encode(encoding))
            assert undescribed_table(table).columns == ("Höhe über Grund [cm]", "Änderung")
    begun.open_log(table)
    dialog = asked(begun, qtbot)
    assert dialog.signals[0].currentText() == "csv.höhe_über_grund"
    dialog.time.setCurrentIndex(1)
    assert dialog.fault == ""
    press_open(dialog)
    qtbot.waitUntil(lambda: begun.shows_log, timeout=LIMIT)
    for encoding in encodings:
        with case(encoding):
            table.write_bytes(text.encode(encoding))
            assert len(read_flight(table)["csv.höhe_über_grund"].values) == 20
    assert parse_expression("csv.höhe_über_grund * 2").signals == ("csv.höhe_über_grund",)
    begun.close_log()


def test_an_empty_table_is_called_empty(begun, tmp_path, qtbot):
    table = tmp_path / "empty.csv"
    table.touch()
    notices = noted(begun.workspace)
    begun.open_log(table)
    qtbot.waitUntil(lambda: bool(notices), timeout=LIMIT)
    assert f"{table}: is empty: name a log" in notices[0].what


def test_a_choice_that_cannot_be_read_is_asked_again(begun, table, qtbot):
    begun.open_log(table)
    dialog = asked(begun, qtbot)
    dialog.time_unit.setCurrentText("ms")
    dialog.signals[3].setCurrentText("imu.angular_velocity.x")
    dialog.units[3].setText("m")
    dialog.signals[4].setCurrentText(NOT_READ)
    press_open(dialog)
    qtbot.waitUntil(lambda: asked(begun, qtbot) is not dialog, timeout=LIMIT)
    again = asked(begun, qtbot)
    assert "m is no unit of that" in again.said.text()
    assert not table.with_name("flight.mapping.yaml").exists()
    assert again.signals[3].currentText() == "imu.angular_velocity.x"
    again.close()


def test_a_foreign_log_is_seen_whole_with_cursors_spectrum_and_overlay(begun, table, qtbot):
    """Clicks after a file is chosen, here and in PlotJuggler 3.9, whose user drags each curve.

    The whole log: none; there one curve dragged for each chart. Cursors A and B: two keys; there a
    click for its one time tracker. A spectrum with a gap: right button, Show as, Spectrum (3);
    there Tools, FFT, a curve dragged, Calculate, the result dragged (5), over the gap. An overlay,
    aligned: Overlay, Overlay a log (2); there the prefix, OK, a curve dragged, Remove time offset
    (4), which aligns the starts of the files.
    """
    table.with_name("flight.mapping.yaml").write_text(MAPPING)
    begun.open_log(table)
    qtbot.waitUntil(lambda: begun.shows_log, timeout=LIMIT)
    page = begun.charts
    assert page.presets.currentText() == "Autopilot's log"
    attitude = page.board.panes[0]
    assert attitude.chart.window_ends == pytest.approx((0.0, END_S))
    roll, setpoint = (
        next(each for each in attitude.chart.curves if each.label == label)
        for label in ("roll", "roll setpoint")
    )
    assert (setpoint.style, setpoint.colour) == (CurveStyle.DASHED, roll.colour)

    attitude.chart.setFocus()
    QTest.keyClick(attitude.chart, Qt.Key.Key_A)
    begun.log_bar.slider.setValue(200)
    assert attitude.chart.cursor_time == pytest.approx(2.0)
    assert attitude.chart.window_ends == pytest.approx((0.0, END_S))
    page.board.set_marks({})

    show_as = next(each for each in page.board.panes[1].chart.extra_actions if each.menu())
    next(each for each in show_as.menu().actions() if each.text() == "Spectrum").trigger()
    chart = page.board.panes[1].chart
    assert page.board.panes[1].spec.kind == SPECTRUM_CHART
    qtbot.waitUntil(lambda: bool(chart.said.text()), timeout=LIMIT)
    assert chart.said.text().count("the longest part without gaps, 0.00 to 6.00 s") == 1
    (line,) = chart.canvas.content.lines
    assert line.time[np.nanargmax(line.values)] == pytest.approx(WAVE_HZ, abs=1.0)

    later = write_table(table.with_name("later.csv"), starts=2.5)
    later.with_name("later.mapping.yaml").write_text(MAPPING)
    begun.open_overlay(later)
    qtbot.waitUntil(lambda: len(page.overlays.overlays) == 1, timeout=LIMIT)
    assert page.overlays.overlays[0].shift == pytest.approx(-1.5, abs=0.011)
