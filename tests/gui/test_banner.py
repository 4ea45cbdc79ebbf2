"""The banner and the queue behind it."""

import re
from dataclasses import replace
from pathlib import Path

import pytest
from PyQt6.QtCore import Qt
from PyQt6.QtGui import QAction, QGuiApplication

from workbench.control.controller import load_controller
from workbench.gui import flight_model
from workbench.gui.banner import MOST, REMEDIES, STAYS, Banner
from workbench.gui.notices import Notice, Severity
from workbench.live.messages import Phase

NOTE, WARNING, FAILURE = Severity.INFORMATION, Severity.WARNING, Severity.FAILURE


def note(what, severity=NOTE):
    return Notice(severity, what)


@pytest.fixture
def actions(qapp):
    return {name: QAction(name) for _, name in REMEDIES}


@pytest.fixture
def banner(qtbot, workspace, actions):
    made = Banner(workspace, actions)
    qtbot.addWidget(made)
    return made


def test_the_same_sentence_is_counted(banner):
    for _ in range(500):
        banner.add(note("the disk is full", FAILURE))
    assert banner.accessibleName() == "failure: the disk is full  (×500) "
    banner.dismiss()
    assert banner.isHidden()


def test_the_same_words_of_another_weight_are_another_notice(banner):
    banner.add(note("slow"))
    banner.add(note("slow", WARNING))
    assert banner.shown.severity is WARNING
    banner.dismiss()
    assert banner.shown.severity is NOTE


def test_failures_come_first_and_of_equals_the_newest(banner):
    for what, severity in (("a", FAILURE), ("b", NOTE), ("c", WARNING), ("d", FAILURE)):
        banner.add(note(what, severity))
    assert shown_in_turn(banner) == ["d", "a", "c", "b"]


def test_notes_and_warnings_go_by_themselves_failures_do_not(banner, monkeypatch):
    now = [100.0]
    monkeypatch.setattr("workbench.gui.banner.time.monotonic", lambda: now[0])
    for what, severity in (("a", NOTE), ("b", WARNING), ("c", FAILURE)):
        banner.add(note(what, severity))
    for time, waiting in ((STAYS[NOTE] - 0.1, 2), (STAYS[NOTE], 1), (1e9, 0)):
        now[0] = 100.0 + time
        banner._expire()
        assert banner._more.text() == (f"{waiting} more" if waiting else "")
    assert banner.shown.what == "c"


def test_a_flood_pushes_no_failure_out(banner):
    banner.add(note("broken", FAILURE))
    for number in range(1000):
        banner.add(note(f"note {number}"))
    seen = shown_in_turn(banner)
    assert len(seen) == MOST
    assert seen[0] == "broken"


def shown_in_turn(banner):
    """Return what is shown, and dismissed, until nothing is left."""
    seen = []
    while banner.shown:
        seen.append(banner.shown.what)
        banner.dismiss()
    return seen


def test_a_notice_is_told_in_word_shape_and_sentence(banner, workspace):
    assert not banner.isVisibleTo(None)
    workspace.notices.warn("the port is in use", "Choose another.")
    assert banner.isVisibleTo(None)
    assert banner._word.text() == "Warning"
    assert not banner._shape.pixmap().isNull()
    assert banner._what.text() == "The port is in use"
    assert banner._remedy.text() == "Choose another."
    assert banner.accessibleName() == "warning: the port is in use Choose another."


def test_dismissing_shows_the_next_and_then_nothing(banner, workspace, qtbot):
    workspace.notices.inform("first")
    workspace.notices.fail("second")
    assert banner._more.text() == "1 more"
    banner.show()
    qtbot.mouseClick(banner._close, Qt.MouseButton.LeftButton)
    assert banner.shown.what == "first"
    qtbot.mouseClick(banner._close, Qt.MouseButton.LeftButton)
    assert not banner.isVisible()


def test_a_repeated_notice_counts_up(banner, workspace):
    for _ in range(3):
        workspace.notices.fail("the disk is full")
    assert banner._what.text() == "The disk is full  (×3)"


def test_a_remedy_is_a_button_that_does_it(banner, workspace, actions, qtbot):
    pressed = []
    actions["reset"].triggered.connect(lambda: pressed.append("reset"))
    workspace.notices.fail("the flight broke off", "Reset the flight (Ctrl+R) to fly again.")
    assert [button.objectName() for button in banner.offers] == ["reset"]
    banner.show()
    qtbot.mouseClick(banner.offers[0], Qt.MouseButton.LeftButton)
    assert pressed == ["reset"]


def test_the_flight_s_own_remedies_have_buttons():
    source = Path(flight_model.__file__).read_text(encoding="utf-8")
    remedies = re.findall(r'"((?:Open|Reset)[^"]*)"', source)
    assert len(remedies) >= 2
    for remedy in remedies:
        assert any(words in remedy.lower() for words, _ in REMEDIES), remedy


def test_failures_go_once_another_flight_begins_and_not_with_a_pause(banner, workspace, canned):
    workspace.notices.fail("the flight broke off")
    workspace.notices.inform("a note")
    for phase in (Phase.PAUSED, Phase.FLYING):
        workspace.flight.phase_changed.emit(phase)
        assert banner.shown.what == "the flight broke off"
    workspace.flight.begun.emit(canned.views[0])
    assert banner.shown.what == "a note"


def test_only_a_fault_of_ours_has_details_to_copy(banner, workspace, qtbot):
    workspace.notices.fail("plain")
    banner.show()
    assert not banner._copy.isVisible()
    banner.dismiss()
    workspace.notices.told.emit(Notice(FAILURE, "oh", "", "Traceback: line 7"))
    qtbot.mouseClick(banner._copy, Qt.MouseButton.LeftButton)
    assert QGuiApplication.clipboard().text() == "Traceback: line 7"


def test_every_control_has_a_name(banner, workspace):
    workspace.notices.fail("broken", "Reset it.")
    assert "Ctrl+Shift+D" in banner._close.accessibleName()
    assert banner.offers[0].text()


def test_what_was_wrong_with_a_law_is_forgotten_once_its_text_flies(banner, workspace, canned):
    workspace.notices.warn("mine.py:34: is not valid Python")
    workspace.flight.taken_over.emit(replace(canned.views[0], controller=load_controller()))
    assert banner.shown == note("The controller pd has taken over.")
