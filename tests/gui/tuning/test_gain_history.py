"""The history of the gains with notes, and the report of a session."""

import re
from base64 import b64decode

import pytest
import yaml
from PyQt6.QtCore import Qt
from PyQt6.QtGui import QImage
from PyQt6.QtWidgets import QApplication

from tests.hostile_names import NAMES
from workbench.analysis.queries import Judge
from workbench.gains.gains import load_gains
from workbench.gui.tuning.history_dialog import HistoryDialog

LEFT = Qt.MouseButton.LeftButton


@pytest.fixture
def tuned(screen):
    """A screen on which two sets of gains were kept."""
    for value in (5.0, 6.0):
        screen.gains.propose("kp_velocity_x", value)
        screen.gains.apply()
        screen.gains.confirm()
        screen.gains._flown._confirm({"kp_velocity_x": value}, 1e9)
        screen.gains.keep()
    return screen


@pytest.fixture
def dialog(tuned, qtbot):
    made = HistoryDialog(
        tuned.gains, tuned.history, tuned.gain_files, tuned.workspace.notices, None
    )
    made.show()
    yield made
    made.close()


def texts(dialog, column):
    return [dialog.table.item(row, column).text() for row in range(dialog.table.rowCount())]


def test_kept_gains_are_listed_newest_first_and_can_be_proposed_again(tuned, dialog, qtbot):
    assert texts(dialog, 1) == ["kp_velocity_x 6", "kp_velocity_x 5", "–"]
    dialog.table.selectRow(1)
    qtbot.mouseClick(dialog.propose, LEFT)
    assert tuned.gains.proposed["kp_velocity_x"] == 5.0
    tuned.gains.undo()
    assert tuned.gains.proposed["kp_velocity_x"] == 6.0


def test_a_note_is_saved_with_the_gains_and_listed_from_their_file(tuned, dialog, qtbot, tmp_path):
    dialog.table.item(0, 2).setText("calmer in wind")
    assert tuned.history.entries[-1].note == "calmer in wind"
    path = tmp_path / "mine.yaml"
    tuned.gain_files.save(path)
    qtbot.waitUntil(path.is_file)
    qtbot.waitUntil(lambda: tuned.gain_files.file is not None)
    assert yaml.safe_load(path.read_text())["origin"].startswith("calmer in wind; tuned in flight")
    tuned.gains.propose("kp_velocity_x", 7.0)
    tuned.gains._flown._confirm({"kp_velocity_x": 7.0}, 1e9)
    tuned.gain_files.save(path)
    qtbot.waitUntil(lambda: len(load_gains(path).history) == 2)
    qtbot.waitUntil(lambda: len(tuned.gain_files.file.history) == 2)
    tuned.history.changed.emit()
    assert texts(dialog, 1)[-2:] == ["kp_velocity_x", "–"]
    dialog.table.selectRow(dialog.table.rowCount() - 1)
    qtbot.mouseClick(dialog.propose, LEFT)
    assert tuned.gains.proposed["kp_velocity_x"] == 6.0


def test_another_flight_begins_another_history(tuned, flying):
    import dataclasses

    other = dataclasses.replace(flying, vehicle=dataclasses.replace(flying.vehicle, name="other"))
    tuned.gains.begin(other)
    assert len(tuned.history.entries) == 1


def test_the_report_has_gains_notes_margins_and_pictures(tuned, judge, tmp_path, qtbot):
    note = "<b>bold</b> & " + NAMES[0][:20]
    tuned.history.set_note(2, note)
    tuned.workspace.preferences.set("log_folder", str(tmp_path / "reports"))
    analysis = tuned.workspace.analysis
    qtbot.waitUntil(lambda: bool(analysis.of(Judge)))
    analysis.tell(*judge(analysis.of(Judge)[-1].gains))
    QApplication.processEvents()
    tuned.write_report()
    qtbot.waitUntil(lambda: len([*tmp_path.glob("reports/tuning_*.html")]) == 1)
    (path,) = tmp_path.glob("reports/tuning_*.html")
    page = path.read_text(encoding="utf-8")
    assert "&lt;b&gt;bold&lt;/b&gt; &amp;" in page and "<b>bold" not in page
    assert "kp_velocity_x 6" in page and "dh_drone" in page
    row = re.search(r"<tr class=changed><td>kp_velocity_x</td>(.*?)</tr>", page)
    assert row and re.findall(r">([\d.]+)<", row[1]) == ["4.45", "6"]
    sources = re.findall(r'src="data:image/png;base64,([^"]+)"', page)
    pictures = [QImage.fromData(b64decode(source)) for source in sources]
    assert len(pictures) == 1 and pictures[0].width() > 200  # of no frequency response yet
    assert not tuned.frequency.curves.shown
    assert "<td>1/s²</td>" in page  # as on the screen
    (margins,) = re.findall(r"<h2>Margins</h2><table>(.*?)</table>", page)  # also if folded
    assert margins.count("<tr>") == len(tuned.margins.rows) + 1
    pitch = re.search(r"<td>pitch</td>(.*?)</tr>", margins)
    assert pitch and "60" in pitch[1]
    assert "http" not in page  # nothing is fetched
