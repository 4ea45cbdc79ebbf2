"""The banner, which keeps its place, and the list of notices behind it."""

import re
from dataclasses import replace
from pathlib import Path

import pytest
from PyQt6.QtCore import QPoint, Qt
from PyQt6.QtGui import QAction, QGuiApplication
from PyQt6.QtWidgets import QLabel, QVBoxLayout, QWidget

from workbench.control.controller_file import load_controller
from workbench.gui import flight_model
from workbench.gui.banner import NO_NOTICE_TEXT, Banner
from workbench.gui.labels import FixedLinesLabel
from workbench.gui.notice_list import MAX_LISTED_NOTICES, NoticeList
from workbench.gui.notices import NOTICE_DURATIONS_S, Notice, Severity
from workbench.gui.remedy_buttons import REMEDY_ACTIONS
from workbench.link.backplane import Published
from workbench.live.messages import Phase

NOTE, WARNING, FAILURE = Severity.INFORMATION, Severity.WARNING, Severity.FAILURE
LEFT = Qt.MouseButton.LeftButton


def note(what, severity=NOTE):
    return Notice(severity, what)


@pytest.fixture
def actions(qapp):
    names = [*(name for _, name in REMEDY_ACTIONS), "notices", "dismiss"]
    return {name: QAction(name) for name in names}


@pytest.fixture
def banner(qtbot, workspace, actions):
    """At the lower edge of a window, with space for the list above it."""
    window = QWidget()
    qtbot.addWidget(window)
    box = QVBoxLayout(window)
    made = Banner(workspace, actions)
    box.addStretch(1)
    box.addWidget(made)
    window.resize(1000, 500)
    window.show()
    qtbot.waitExposed(window)
    yield made  # the window lives as long


@pytest.fixture
def listed():
    """A list of notices, and its clock."""
    now = [100.0]
    made = NoticeList(lambda: now[0])
    made.clock = now
    return made


def told(notices):
    return [each.what for each in notices]


def test_the_same_sentence_is_counted(banner):
    for _ in range(500):
        banner.add(note("the disk is full", FAILURE))
    assert banner.accessibleName() == "Failure: The disk is full (×500)."
    assert banner.list_button.text() == "Notices: 1 ▴"
    banner.dismiss()
    assert banner.shown is None and banner.accessibleName() == NO_NOTICE_TEXT


def test_the_same_words_of_another_weight_are_another_notice(banner):
    banner.add(note("slow"))
    banner.add(note("slow", WARNING))
    assert banner.shown.severity is WARNING
    banner.dismiss()
    assert banner.shown.severity is NOTE


def test_an_old_failure_hides_nothing_and_stays(listed):
    """New ones come first by severity and age, then what stays, then the rest."""
    for what, severity in (("a", FAILURE), ("b", NOTE), ("c", WARNING), ("d", FAILURE)):
        listed.add(note(what, severity))
    assert told(listed.ordered) == ["d", "a", "c", "b"]
    listed.clock[0] += NOTICE_DURATIONS_S[FAILURE]
    assert told(listed.present) == ["d", "a"]
    listed.add(note("e"))
    assert told(listed.ordered) == ["e", "d", "a", "c", "b"]
    listed.clock[0] += NOTICE_DURATIONS_S[NOTE]
    assert told(listed.present) == ["d", "a"]


def test_an_alarm_stays_until_its_cause_ends(listed):
    listed.add(Notice(WARNING, "rotor 2 is at its largest thrust", of_flight=True))
    listed.clock[0] += 1e6
    assert told(listed.present) == ["rotor 2 is at its largest thrust"]
    listed.end(lambda notice: notice.what == "rotor 2 is at its largest thrust")
    assert listed.present == () and len(listed.ordered) == 1
    listed.add(Notice(WARNING, "rotor 2 is at its largest thrust", of_flight=True))
    assert listed.present[0].times == 2
    listed.clear()
    assert len(listed.ordered) == 1


def test_the_newest_of_equal_gravity_is_first_while_it_is_new(listed):
    listed.add(Notice(WARNING, "slower than real time", of_flight=True))
    listed.add(note("refused", WARNING))
    assert told(listed.present) == ["refused", "slower than real time"]
    listed.end(lambda notice: notice.of_flight)
    assert told(listed.present) == ["refused"]


def test_a_flood_pushes_no_failure_out(listed):
    listed.add(note("broken", FAILURE))
    listed.clock[0] += 100.0
    for number in range(1000):
        listed.add(note(f"note {number}"))
    assert len(listed.ordered) == MAX_LISTED_NOTICES
    assert "broken" in told(listed.ordered) and "note 999" in told(listed.ordered)


def test_a_notice_is_told_in_word_shape_and_sentence(banner, workspace):
    workspace.notices.warn("the port is in use", "Choose another.")
    assert not banner._shape.pixmap().isNull()
    assert banner._said.text() == "Warning: The port is in use. Choose another."
    assert banner.accessibleName() == banner._said.text()


def test_nothing_moves_whatever_is_told(banner, workspace, qtbot):
    """Its height, and the places of its own buttons, which are always there."""

    def places():
        qtbot.wait(1)
        parts = (banner.list_button, banner._close)
        return banner.geometry(), [part.mapTo(banner, QPoint()) for part in parts]

    before = places()
    workspace.notices.inform("short")
    assert places() == before
    workspace.notices.fail(
        "a sentence that fills more than two lines of a narrow window " * 5, "Reset it."
    )
    assert places() == before
    for _ in range(20):
        workspace.notices.warn("many times")
    banner.dismiss()
    banner.toggle_list()
    assert places() == before


def test_dismissing_shows_the_next_and_the_list_still_has_both(banner, workspace, qtbot):
    workspace.notices.inform("first")
    workspace.notices.fail("second")
    qtbot.mouseClick(banner._close, LEFT)
    assert banner.shown.what == "first"
    qtbot.mouseClick(banner._close, LEFT)
    assert banner.shown is None and not banner._close.isEnabled()
    qtbot.mouseClick(banner.list_button, LEFT)
    assert banner.panel.rows.count() == 2
    assert "Failure, over: Second." in banner.panel.rows.item(0).text()
    qtbot.mouseClick(banner.panel.clear, LEFT)
    assert banner.list_button.text() == "Notices: 0 ▴"


def test_each_in_the_list_is_clickable_with_what_to_do(banner, workspace, actions, qtbot):
    pressed = []
    actions["reset"].triggered.connect(lambda: pressed.append("reset"))
    workspace.notices.fail("the flight broke off", "Reset the flight (Ctrl+R) to fly again.")
    workspace.notices.fail("no such folder", "Choose another folder for logs in Settings.")
    qtbot.mouseClick(banner._said, LEFT)
    panel = banner.panel
    assert panel.isVisible() and panel.geometry().bottom() < banner.geometry().top() + 1
    assert [panel.rows.item(row).text()[10:] for row in range(2)] == [
        "Failure: No such folder. Choose another folder for logs in Settings.",
        "Failure: The flight broke off. Reset the flight (Ctrl+R) to fly again.",
    ]
    place = panel.rows.visualItemRect(panel.rows.item(1)).center()
    qtbot.mouseClick(panel.rows.viewport(), LEFT, pos=place)
    (reset,) = panel.remedies.buttons
    qtbot.waitUntil(reset.isEnabled)
    qtbot.mouseClick(reset, LEFT)
    assert pressed == ["reset"]
    qtbot.mouseClick(panel.dismiss, LEFT)
    assert [each.what for each in (banner.shown,)] == ["no such folder"]
    qtbot.keyClick(panel.rows, Qt.Key.Key_Escape)
    assert panel.isHidden()


def test_a_remedy_is_a_button_that_does_it_half_a_second_after_it_came(
    banner, workspace, actions, qtbot, guarded_clock
):
    pressed = []
    actions["reset"].triggered.connect(lambda: pressed.append("reset"))
    workspace.notices.fail("the flight broke off", "Reset the flight (Ctrl+R) to fly again.")
    (reset,) = banner.remedies.buttons
    assert reset.objectName() == "reset"
    qtbot.waitUntil(reset.isVisible)
    qtbot.mouseClick(reset, LEFT)
    assert pressed == []
    guarded_clock[0] += 0.5
    qtbot.mouseClick(reset, LEFT)
    assert pressed == ["reset"]


def test_what_was_hidden_elsewhere_is_not_shown_by_the_remedy_to_hide_it(
    banner, workspace, actions, qtbot
):
    actions["view_3d"].setCheckable(True)
    actions["view_3d"].setChecked(True)
    workspace.notices.warn("the flight is slow", "Hide the 3-D view (Ctrl+0).")
    (hide,) = banner.remedies.buttons
    assert hide.text() == "Hide 3-D view"
    qtbot.waitUntil(hide.isVisible)
    actions["view_3d"].setChecked(False)
    assert hide.isHidden()


def test_an_error_that_says_what_to_do_has_a_button_too(banner, workspace):
    workspace.notices.warn("nothing flies: open a scenario first")
    assert [each.objectName() for each in banner.remedies.buttons] == ["open_scenario"]
    workspace.notices.inform("wrote reset.png")
    banner.dismiss()
    assert banner.shown.severity is NOTE and not banner.remedies.buttons


def test_the_flight_s_own_remedies_have_buttons():
    source = Path(flight_model.__file__).read_text(encoding="utf-8")
    remedies = re.findall(r'"((?:Open|Reset)[^"]*)"', source)
    assert len(remedies) >= 2
    for remedy in remedies:
        assert any(words in remedy.lower() for words, _ in REMEDY_ACTIONS), remedy


def test_failures_and_alarms_end_once_another_flight_begins_and_not_with_a_pause(
    banner, workspace, canned
):
    workspace.notices.alarm("the drone has hit something")
    workspace.notices.fail("the flight broke off")
    workspace.notices.inform("a note")
    for phase in (Phase.PAUSED, Phase.FLYING):
        workspace.flight.phase_changed.emit(phase)
        assert banner.shown.what == "the flight broke off"
    workspace.flight.begun.emit(canned.views[0])
    assert banner.shown.what == "a note"
    assert told(banner._list.present) == ["a note"]


def test_an_alarm_of_the_flight_ends_with_its_cause(banner, workspace, canned):
    """It comes as an event, and the reports say how long its cause lasts."""
    from workbench.link.drone_topics import EVENTS_SIGNAL

    said = "rotor 2 is at its largest thrust"
    topic = next(each for each in canned.views[0].topics if each.id == EVENTS_SIGNAL.id)
    payload = topic.pack((1, f"{said}. Ask for less"))
    workspace.flight.streamed.emit([Published(0, 0, ((EVENTS_SIGNAL.id, payload),))])
    assert banner.shown == Notice(WARNING, said, "Ask for less.", of_flight=True)
    lasting = replace(canned.views[0], lasting=(said,))
    workspace.flight._show(lasting)
    workspace.notices.alarm(said, "Ask for less.")
    workspace.flight._show(replace(canned.views[1], lasting=(said,)))
    assert banner.shown.what == said
    workspace.flight._show(canned.views[2])
    assert banner.shown is None


def test_what_is_copied_has_the_details_of_a_fault_of_ours(banner, workspace, qtbot):
    workspace.notices.told.emit(Notice(FAILURE, "oh", "", "Traceback: line 7"))
    banner.toggle_list()
    qtbot.mouseClick(banner.panel.copy, LEFT)
    assert QGuiApplication.clipboard().text() == "oh\nTraceback: line 7"


def test_every_control_has_a_name(banner, workspace):
    workspace.notices.fail("broken", "Reset it.")
    assert banner._close.accessibleName()
    assert banner.remedies.buttons[0].text()
    banner.toggle_list()
    assert banner.panel._close.accessibleName()


def test_what_was_wrong_with_a_law_is_over_once_its_text_flies(banner, workspace, canned):
    workspace.notices.warn("mine.py:34: is not valid Python")
    workspace.flight.taken_over.emit(replace(canned.views[0], controller=load_controller()))
    assert banner.shown == note("The controller pd has taken over.")


def test_two_lines_of_a_notice_are_not_clipped_in_the_font_of_a_style(banner, qtbot):
    shown = banner.findChild(FixedLinesLabel)
    banner.window().setStyleSheet("QLabel { font-size: 17pt }")
    banner.add(note("a long notice " * 8))
    free = QLabel(shown.text())
    qtbot.addWidget(free)
    free.setFont(shown.font())
    two_lines = free.fontMetrics().boundingRect(0, 0, 9999, 9999, 0, "Ag\nAg").height()
    assert shown.height() == two_lines > 30
