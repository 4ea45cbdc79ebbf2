"""Game pads' mapping, calibration and hand-over: by values worked out by hand, and by mouse."""

import pytest
from PyQt6.QtCore import Qt
from PyQt6.QtTest import QTest
from PyQt6.QtWidgets import QAbstractButton

from tests.gui.test_layout import faults
from workbench.gui.joystick.game_pad import PadReading
from workbench.gui.joystick.joystick_screen import JoystickScreen, game_pad_text
from workbench.gui.joystick.pad_dialog import PadDialog
from workbench.gui.joystick.pad_mapping import (
    DEFAULT_PAD_MAPPING,
    PadAxis,
    mapped_sticks,
    read_mapping,
)
from workbench.gui.joystick.piloting import CENTRED_STICKS

GUID = "03000000de280000ff11000001000000"
REST = (0.1, 0.0, 0.0, 0.0, 0.0, 0.0)
STILL = (0.0,) * 6


def pad(number, raw=REST, asks=False):
    sticks = mapped_sticks(DEFAULT_PAD_MAPPING, raw)
    return PadReading(f"pad {number}", sticks, (), number, GUID, raw, asks)


@pytest.fixture
def screen(workspace, qtbot, monkeypatch):
    """The screen with two pads in a stand-in for SDL, the first of which flies."""
    made = JoystickScreen(workspace)
    qtbot.addWidget(made)
    pads = made.pilot.pads
    monkeypatch.setattr(pads, "open", lambda: None)
    made.plug = lambda *readings: setattr(pads, "readings", readings) or made.pilot.look()
    monkeypatch.setattr(
        pads,
        "read",
        lambda: next((each for each in pads.readings if each.number == pads.flying), None),
    )
    monkeypatch.setattr(pads, "fly", lambda number: setattr(pads, "flying", number))
    pads.flying = 1
    made.show()
    made.pilot.listen_to_pads(True)
    yield made
    made.close_screen()


@pytest.fixture
def dialog(screen, qtbot):
    screen.plug(pad(1), pad(2))
    QTest.mouseClick(screen.pads_button, Qt.MouseButton.LeftButton)
    return screen.findChild(PadDialog)


def test_an_axis_is_shaped_between_its_own_ends(case):
    axis = PadAxis(0, dead_band=0.2, expo=0.5, low=-0.6, middle=0.1, high=0.9)
    half = 0.5 * 0.5 + 0.5 * 0.5**3  # at half of what is beyond the dead band
    rows = ((0.1, 0.0), (0.9, 1.0), (-0.6, -1.0), (1.0, 1.0), (0.1 + 0.6 * 0.8, half), (0.2, 0.0))
    for raw, asked in rows:
        with case(raw):
            assert axis.shaped((raw,)) == pytest.approx(asked)
    assert PadAxis(0, inverted=True).shaped((0.4,)) == pytest.approx(-0.4)


def test_an_untouched_pad_is_in_mode_2():
    sticks = mapped_sticks(DEFAULT_PAD_MAPPING, (0.5, -0.5, -0.9, 0.05, 0.0, 0.0))
    assert sticks == (0.5, 0.5, -0.9, -0.05)


def test_sticks_are_mapped_by_mouse_and_kept_for_that_pad(dialog, workspace):
    row = dialog.rows[0]
    row.axis.setFocus()
    QTest.keyClick(row.axis, Qt.Key.Key_End)
    QTest.mouseClick(row.inverted, Qt.MouseButton.LeftButton, pos=row.inverted.rect().center())
    row.inverted.setFocus()
    if not row.inverted.isChecked():
        QTest.keyClick(row.inverted, Qt.Key.Key_Space)
    row.dead_band.setFocus()
    QTest.keyClick(row.dead_band, Qt.Key.Key_Up)
    kept = read_mapping(workspace.preferences.store, GUID)
    assert kept[0] == PadAxis(5, inverted=True, dead_band=0.01)
    assert kept[1:] == DEFAULT_PAD_MAPPING[1:]
    QTest.mouseClick(dialog.defaults, Qt.MouseButton.LeftButton)
    assert read_mapping(workspace.preferences.store, GUID) == DEFAULT_PAD_MAPPING


def test_the_stops_are_found_by_moving_the_sticks_to_them(dialog, screen, workspace):
    screen.plug(pad(1, (0.5, 0.5, 0.5, 0.5, 0.0, 0.0)), pad(2))  # held as it begins
    QTest.mouseClick(dialog.calibrate, Qt.MouseButton.LeftButton)
    for way in (0.8, -0.7):
        screen.plug(pad(1, (way, way, way, way, 0.0, 0.0)), pad(2))
        dialog.look_at_pads()
    assert dialog.rows[0].raw.value() == -70
    screen.plug(pad(1), pad(2))
    QTest.mouseClick(dialog.calibrate, Qt.MouseButton.LeftButton)
    kept = read_mapping(workspace.preferences.store, GUID)
    assert [(each.low, each.middle, each.high) for each in kept] == [
        (-0.7, each, 0.8) for each in REST[:4]
    ]
    dialog.look_at_pads()
    assert dialog.rows[0].shaped.value() == 0


def test_a_stick_that_was_not_moved_changes_nothing(dialog, workspace):
    QTest.mouseClick(dialog.calibrate, Qt.MouseButton.LeftButton)
    QTest.mouseClick(dialog.calibrate, Qt.MouseButton.LeftButton)
    assert "did not go to both stops: left stick, x" in dialog.said.text()
    assert read_mapping(workspace.preferences.store, GUID) == DEFAULT_PAD_MAPPING


def test_what_an_editor_broke_counts_as_nothing(workspace, case):
    store = workspace.preferences.store
    for text in ("", "[]", "{", "[1,2,3,4]", '[{"axis": 9}, {"axis": 1}, {"axis": 2}, {"axis":3}]'):
        with case(text):
            store.setValue(f"pads/{GUID}", text)
            assert read_mapping(store, GUID) == DEFAULT_PAD_MAPPING


def test_another_pad_takes_over_by_its_button_once_its_sticks_are_centred(screen):
    pilot = screen.pilot
    pushed = (0.1, -0.9, 0.0, 0.0, 0.0, 0.0)
    screen.plug(pad(1, STILL), pad(2, pushed))
    assert pilot.pad_name == "pad 1" and pilot.sticks == CENTRED_STICKS
    screen.plug(pad(1, STILL), pad(2, pushed, asks=True))
    assert pilot.pad_name == "pad 1"
    assert screen._pad_line.text() == "pad 2 cannot take over: release its sticks first."
    screen.plug(pad(1, pushed), pad(2, STILL, asks=True))
    screen.plug(pad(1, pushed), pad(2, STILL))
    assert pilot.pad_name == "pad 2" and pilot.sticks == CENTRED_STICKS
    assert screen._pad_line.text().startswith("pad 2 flies, 1 waits: press Start on it")
    screen.plug(
        pad(1, STILL)
    )  # the one that flies is gone: the other does not fly of its own accord
    assert pilot.pad_name == "" and "to take over" in screen._pad_line.text()
    assert game_pad_text("", "") != screen._pad_line.text()


def test_the_page_lets_the_other_pad_fly_and_fits(dialog, screen, case, workspace, qapp):
    screen.plug(pad(1), pad(2, STILL))
    dialog.look_at_pads()
    dialog.pads.setFocus()
    QTest.keyClick(dialog.pads, Qt.Key.Key_Down)
    dialog.look_at_pads()
    for theme in ("light", "dark"):
        with case(theme):
            workspace.preferences.set("theme", theme)
            qapp.processEvents()
            assert list(faults(dialog)) == []
            assert dialog.width() <= 1024 and dialog.height() <= 640
    assert dialog.findChildren(QAbstractButton)
    QTest.mouseClick(dialog.fly, Qt.MouseButton.LeftButton)
    assert screen.pilot.pads.flying == 2
