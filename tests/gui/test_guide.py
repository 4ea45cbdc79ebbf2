"""The first minutes: each hint stays until what it says was done."""

from dataclasses import replace
from types import SimpleNamespace

import pytest
from PyQt6.QtCore import Qt

from workbench.control.mode import FlightMode
from workbench.gui.banner import DONE, END, STAGES, Guide
from workbench.gui.gains.gain_bar import GainBar
from workbench.scenario.excitation import Excitation, Exciting, Shape

FLOWN = Exciting(Excitation("x", Shape.STEP, 1.0, 4.0), 3.0, 1)


@pytest.fixture
def gains():
    return SimpleNamespace(tried=())


@pytest.fixture
def guide(workspace, gains, qtbot):
    store = workspace.preferences.store
    store.remove(DONE)
    guide = Guide(workspace.flight, workspace.notices, store, lambda: gains)
    qtbot.addWidget(guide)
    guide.begin()
    return guide


@pytest.fixture
def show(workspace, canned):
    def show_view(mode=FlightMode.HOVERING, **changes):
        snapshot = replace(canned.views[0].snapshot, mode=mode)
        workspace.flight.viewed.emit(replace(canned.views[0], snapshot=snapshot, **changes))

    return show_view


def stage(guide):
    return int(guide.accessibleName()[0]) if not guide.isHidden() else 0


def test_it_goes_on_once_each_was_done(guide, gains, workspace, show):
    said = []
    workspace.notices.told.connect(lambda notice: said.append(notice.what))
    assert guide.wanted and stage(guide) == 1
    show(FlightMode.OFF)
    show(FlightMode.TAKING_OFF)
    assert stage(guide) == 1
    show()
    assert stage(guide) == 2
    show(exciting=FLOWN)
    show(excitation_ended="a wall is too near")  # not flown to its end
    assert stage(guide) == 2
    show(exciting=FLOWN)
    show()
    assert stage(guide) == 3
    show()
    assert stage(guide) == 3
    gains.tried = ("kp_velocity_x",)
    show()
    assert stage(guide) == 4
    show()
    assert stage(guide) == 4
    gains.tried = ()
    show()
    assert stage(guide) == 0 and said == [END]
    assert not guide.wanted


def test_it_can_be_skipped_for_good(guide, show, qtbot):
    qtbot.mouseClick(guide.skip, Qt.MouseButton.LeftButton)
    assert guide.isHidden() and not guide.wanted
    show()
    assert guide.isHidden()


def test_it_begins_on_the_tuning_screen_and_names_keys_that_act(shared_window):
    shared_window.show_screen("home")
    shared_window.actions_by_name["guide"].trigger()
    assert shared_window.stack.name == "tuning" and stage(shared_window.guide) == 1
    bar = shared_window.stack.screen_of("tuning").findChild(GainBar)
    actions = (*shared_window.actions_by_name.values(), *bar.actions_by_name.values())
    keys = {action.shortcut().toString() for action in actions}
    hints = " ".join(how for _, how in STAGES)
    for name in ("F6", "F12", "Ctrl+K", "Ctrl+Shift+K"):
        assert name in hints and name in keys
    shared_window.guide.end()
